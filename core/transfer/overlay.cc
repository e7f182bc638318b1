#include "core/transfer/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/transfer/clip.h"

namespace dynmesh::transfer {
namespace {

template <std::size_t D>
PatchSimplex<D> Read(const SlotMesh& mesh, Slot slot, const Slot* vertices, RegionId region) {
  PatchSimplex<D> simplex;
  simplex.slot = slot;
  simplex.region = region;
  std::copy_n(vertices, D + 1, simplex.vertices.begin());
  simplex.corners = CornersOf<D>(mesh, vertices);
  simplex.measure = Measure<D>(simplex.corners);
  return simplex;
}

// Relative to `origin`, so that rounding is that of distances in the simplex.
template <std::size_t D>
Corners<D> Relative(const Corners<D>& corners, const Vec<D>& origin) {
  Corners<D> result;
  for (std::size_t k = 0; k <= D; ++k) result[k] = corners[k] - origin;
  return result;
}

// Are all corners outside of one of the half-spaces?
template <std::size_t D>
bool IsApart(const std::array<HalfSpace<D>, D + 1>& halves, const Corners<D>& corners) {
  for (const HalfSpace<D>& half : halves) {
    bool any_in = false;
    for (const Vec<D>& corner : corners) any_in |= half(corner) > 0;
    if (!any_in) return true;
  }
  return false;
}

// Coordinates in the old and in the new simplex.
template <std::size_t D>
struct TwoCoordinates {
  std::array<double, D + 1> old, own;
};

// Adds weight times the products of `c`.
template <std::size_t D>
void AddProducts(double weight, const TwoCoordinates<D>& c, double* mass, double* own) {
  constexpr std::size_t kCorners = D + 1;
  for (std::size_t a = 0; a < kCorners; ++a) {
    for (std::size_t b = 0; b < kCorners; ++b) {
      mass[a * kCorners + b] += weight * c.old[a] * c.own[b];
      own[a * kCorners + b] += weight * c.own[a] * c.own[b];
    }
  }
}

// A simplex as both sides of a pair are looked at.
template <std::size_t D>
using HalfSpacesOf = std::array<HalfSpace<D>, D + 1>;

// A new simplex, ready to clip old ones.
template <std::size_t D>
class Clipper {
 public:
  explicit Clipper(const PatchSimplex<D>& to)
      : places_(to.corners),
        origin_(to.corners[0]),
        corners_(Relative<D>(to.corners, origin_)),
        halves_(HalfSpaces(corners_)),
        coordinates_(corners_) {
    for (const Vec<D>& corner : corners_) {
      extent_ = std::max(extent_, GreatestCoordinate(corner));
    }
  }

  // False if they have nothing in common. Adds to `own` what the piece is of the new simplex.
  // `halves` are the old one's, where it is.
  bool Clip(const PatchSimplex<D>& from, const HalfSpacesOf<D>& halves, Piece<D>& piece,
            typename Overlay<D>::Mass& own) const {
    if (IsApart<D>(halves, places_)) return false;
    const Corners<D> old = Relative<D>(from.corners, origin_);
    if (IsApart<D>(halves_, old)) return false;
    double extent = extent_;
    for (const Vec<D>& corner : old) extent = std::max(extent, GreatestCoordinate(corner));
    Clipped<D> clipped(old);
    for (const HalfSpace<D>& half : halves_) {
      if (!clipped.By(half, half.Noise(extent))) return false;
    }
    // The integral of f g, both linear, over a simplex is its measure / ((D + 1) (D + 2)) times
    // (sum of f g at its corners + sum of f times sum of g). The first part is gathered by corner.
    constexpr double kShare = 1.0 / ((D + 1) * (D + 2));
    std::array<double, Clipped<D>::kMost> weights{};
    std::array<TwoCoordinates<D>, Clipped<D>::kMost> at;
    std::array<bool, Clipped<D>::kMost> is_known{};
    piece.mass.fill(0);
    bool any = false;
    clipped.ForEachSimplex([&](const std::array<std::size_t, D + 1>& corners) {
      Corners<D> places;
      for (std::size_t k = 0; k <= D; ++k) places[k] = clipped.corner(corners[k]).place;
      const double share = kShare * Measure<D>(places);
      if (share <= 0) return;
      any = true;
      TwoCoordinates<D> sum{};
      for (const std::size_t corner : corners) {
        if (!is_known[corner]) {
          is_known[corner] = true;
          at[corner] = {clipped.corner(corner).lambda, coordinates_(clipped.corner(corner).place)};
        }
        weights[corner] += share;
        for (std::size_t k = 0; k <= D; ++k) {
          sum.old[k] += at[corner].old[k], sum.own[k] += at[corner].own[k];
        }
      }
      AddProducts<D>(share, sum, piece.mass.data(), own.data());
    });
    for (std::size_t i = 0; i < clipped.size(); ++i) {
      if (is_known[i]) AddProducts<D>(weights[i], at[i], piece.mass.data(), own.data());
    }
    return any;
  }

 private:
  static double GreatestCoordinate(const Vec<D>& x) {
    double greatest = 0;
    for (const double c : x) greatest = std::max(greatest, std::abs(c));
    return greatest;
  }

  Corners<D> places_;
  Vec<D> origin_;
  Corners<D> corners_;  // relative to the origin
  double extent_ = 0;
  HalfSpacesOf<D> halves_;
  Barycentric<D> coordinates_;
};

}  // namespace

template <std::size_t D>
BoxTree<D> Overlay<D>::MakeTree() const {
  std::vector<Box<D>> boxes;
  boxes.reserve(from.size());
  for (const PatchSimplex<D>& simplex : from) boxes.push_back(Box<D>::Of(simplex.corners));
  return BoxTree<D>(std::move(boxes));
}

template <std::size_t D>
Overlay<D> Overlay<D>::Make(const SlotMesh& mesh) {
  const MeshPatch& patch = mesh.patch();
  Overlay overlay;
  overlay.from.reserve(patch.removed_simplices.size());
  for (std::size_t i = 0; i < patch.removed_simplices.size(); ++i) {
    overlay.from.push_back(Read<D>(mesh, patch.removed_simplices[i],
                                   &patch.removed_corners[i * (D + 1)], patch.removed_regions[i]));
  }
  overlay.to.reserve(patch.added_simplices.size());
  for (const Slot slot : patch.added_simplices) {
    overlay.to.push_back(
        Read<D>(mesh, slot, mesh.cells().data() + At(slot) * (D + 1), mesh.regions()[At(slot)]));
  }
  std::vector<HalfSpacesOf<D>> halves;
  halves.reserve(overlay.from.size());
  for (const PatchSimplex<D>& simplex : overlay.from) halves.push_back(HalfSpaces(simplex.corners));
  const BoxTree<D> tree = overlay.MakeTree();
  overlay.own.assign(overlay.to.size(), {});
  overlay.own_of_region.assign(overlay.to.size(), {});
  overlay.begins.reserve(overlay.to.size() + 1);
  std::vector<std::uint32_t> candidates;
  for (std::size_t j = 0; j < overlay.to.size(); ++j) {
    overlay.begins.push_back(static_cast<std::uint32_t>(overlay.pieces.size()));
    candidates.clear();
    tree.ForEachMeeting(Box<D>::Of(overlay.to[j].corners),
                        [&](std::uint32_t i) { candidates.push_back(i); });
    std::sort(candidates.begin(), candidates.end());
    const Clipper<D> clipper(overlay.to[j]);
    Piece<D> piece;
    piece.to = static_cast<std::uint32_t>(j);
    for (const std::uint32_t i : candidates) {
      piece.from = i;
      typename Overlay<D>::Mass own = {};
      if (!clipper.Clip(overlay.from[i], halves[i], piece, own)) continue;
      overlay.pieces.push_back(piece);
      const bool stays = overlay.from[i].region == overlay.to[j].region;
      for (std::size_t k = 0; k < own.size(); ++k) {
        overlay.own[j][k] += own[k];
        if (stays) overlay.own_of_region[j][k] += own[k];
      }
    }
  }
  overlay.begins.push_back(static_cast<std::uint32_t>(overlay.pieces.size()));
  return overlay;
}

template <std::size_t D>
typename Overlay<D>::Place Overlay<D>::Locate(const BoxTree<D>& tree, const Vec<D>& x) const {
  std::vector<std::uint32_t> candidates;
  tree.ForEachMeeting(Box<D>{x, x}, [&](std::uint32_t i) { candidates.push_back(i); });
  std::sort(candidates.begin(), candidates.end());
  Place best = {0, {1}};
  double best_least = -std::numeric_limits<double>::infinity();
  const auto look_at = [&](std::uint32_t i) {
    const Barycentric<D> coordinates(from[i].corners);
    if (coordinates.is_flat()) return;
    const auto lambda = coordinates(x);
    const double least = *std::min_element(lambda.begin(), lambda.end());
    if (least > best_least) best_least = least, best = {i, lambda};
  };
  for (const std::uint32_t i : candidates) look_at(i);
  // No box holds x: it lies on the cavity's border, but for rounding.
  if (best_least < -1e-6) {
    for (std::uint32_t i = 0; i < from.size(); ++i) look_at(i);
  }
  return best;
}

template struct Overlay<2>;
template struct Overlay<3>;

}  // namespace dynmesh::transfer
