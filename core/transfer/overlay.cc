#include "core/transfer/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/mesh_data/face_links.h"
#include "core/transfer/clipper.h"

namespace dynmesh::transfer {
namespace {

using boxes::Box;
using boxes::BoxTree;

// About the number in 3D.
constexpr std::size_t kPiecesOfOne = 16;

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

// A search structure for the old simplices of an overlay.
template <std::size_t D>
class OldSimplices {
 public:
  explicit OldSimplices(const Overlay<D>& overlay)
      : tree_(overlay.tree), neighbours_(overlay.from.size() * (D + 1), kNoSlot) {
    mesh_data::FaceLinks faces;
    for (std::size_t i = 0; i < overlay.from.size(); ++i) {
      halves_.push_back(HalfSpaces(overlay.from[i].corners));
      for (std::size_t k = 0; k <= D; ++k) {
        faces.Add(overlay.from[i].vertices.data(), D + 1, k, static_cast<Slot>(i), k);
      }
    }
    faces.Link(neighbours_.data(), D + 1);
  }

  // The simplex across face k of old simplex i, or kNoSlot.
  std::int32_t Across(std::uint32_t i, std::size_t k) const {
    return neighbours_[std::size_t{i} * (D + 1) + k];
  }

  // The first one that contains x, border included; kNone if by rounding there is none.
  std::uint32_t Holding(const Vec<D>& x) const {
    std::uint32_t found = kNone;
    tree_.ForEachMeeting({x, x}, [&](std::uint32_t i) {
      bool inside = i < found;
      for (std::size_t k = 0; inside && k <= D; ++k) inside = halves_[i][k](x) >= 0;
      if (inside) found = i;
    });
    return found;
  }

  // The simplices with boxes that meet that of `corners`, ascending.
  void NearTo(const Corners<D>& corners, std::vector<std::uint32_t>& found) const {
    found.clear();
    tree_.ForEachMeeting(Box<D>::Of(corners), [&](std::uint32_t i) { found.push_back(i); });
    std::sort(found.begin(), found.end());
  }

  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

 private:
  const BoxTree<D>& tree_;
  std::vector<std::array<HalfSpace<D>, D + 1>> halves_;
  std::vector<std::int32_t> neighbours_;
};

}  // namespace

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
  std::vector<Box<D>> boxes;
  boxes.reserve(overlay.from.size());
  for (const auto& simplex : overlay.from) boxes.push_back(Box<D>::Of(simplex.corners));
  overlay.tree = BoxTree<D>(std::move(boxes));
  const auto is_other = [&](const auto& simplex) {
    return simplex.region != overlay.from[0].region;
  };
  overlay.has_regions = std::any_of(overlay.from.begin(), overlay.from.end(), is_other) ||
                        std::any_of(overlay.to.begin(), overlay.to.end(), is_other);
  overlay.FindPieces();
  return overlay;
}

// A new simplex is convex, so the old ones that it meets are connected. They are found across
// faces, from the one at its centroid. If their pieces do not fill it, up to rounding, all near
// ones are clipped. So a face that rounding hides costs only time.
template <std::size_t D>
void Overlay<D>::FindPieces() {
  constexpr double kWhole = 1e-12;
  const OldSimplices<D> old(*this);
  own.assign(to.size(), {});
  if (has_regions) own_of_region.assign(to.size(), {});
  begins.reserve(to.size() + 1);
  pieces.reserve(kPiecesOfOne * to.size());
  std::vector<std::uint32_t> asked(from.size(),
                                   OldSimplices<D>::kNone);  // last new simplex that used it
  std::vector<std::uint32_t> queue;
  for (std::uint32_t j = 0; j < to.size(); ++j) {
    begins.push_back(static_cast<std::uint32_t>(pieces.size()));
    const Clipper<D> clipper(to[j]);
    const auto clip = [&](std::uint32_t i, std::uint32_t& open) {
      Piece<D>& piece = pieces.emplace_back();
      piece.from = i, piece.to = j;
      Mass mass;
      if (!clipper.Clip(from[i], piece, mass, open)) return pieces.pop_back(), false;
      const auto add_to = [&mass](Mass& sum) {
        for (std::size_t k = 0; k < mass.size(); ++k) sum[k] += mass[k];
      };
      add_to(own[j]);
      if (has_regions && from[i].region == to[j].region) add_to(own_of_region[j]);
      return true;
    };
    queue.clear();
    if (const std::uint32_t first = old.Holding(Centroid<D>(to[j].corners)); first != old.kNone) {
      queue.push_back(first), asked[first] = j;
    }
    std::uint32_t open = 0;
    for (std::size_t q = 0; q < queue.size(); ++q) {
      const std::uint32_t i = queue[q];
      if (!clip(i, open)) continue;
      ForEachBit(open, [&](std::size_t k) {
        const std::int32_t next = old.Across(i, k);
        if (next == kNoSlot || asked[At(next)] == j) return;
        queue.push_back(static_cast<std::uint32_t>(next)), asked[At(next)] = j;
      });
    }
    if (std::abs(Total(own[j]) - to[j].measure) <= kWhole * to[j].measure) continue;
    pieces.resize(begins.back());
    own[j] = {};
    if (has_regions) own_of_region[j] = {};
    old.NearTo(to[j].corners, queue);
    for (const std::uint32_t i : queue) clip(i, open);
  }
  begins.push_back(static_cast<std::uint32_t>(pieces.size()));
}

template <std::size_t D>
typename Overlay<D>::Location Overlay<D>::Locate(const Vec<D>& x) const {
  std::vector<std::uint32_t> candidates;
  tree.ForEachMeeting(Box<D>{x, x}, [&](std::uint32_t i) { candidates.push_back(i); });
  std::sort(candidates.begin(), candidates.end());
  Location best = {0, {1}};
  double best_least = -std::numeric_limits<double>::infinity();
  const auto look_at = [&](std::uint32_t i) {
    const Barycentric<D> coordinates(from[i].corners);
    if (coordinates.is_flat()) return;
    const auto lambda = coordinates(x);
    const double least = *std::min_element(lambda.begin(), lambda.end());
    if (least > best_least) best_least = least, best = {i, lambda};
  };
  for (const std::uint32_t i : candidates) look_at(i);
  // No box contains x: it is on the cavity's border, up to rounding.
  if (best_least < -1e-6) {
    for (std::uint32_t i = 0; i < from.size(); ++i) look_at(i);
  }
  return best;
}

template struct Overlay<2>;
template struct Overlay<3>;

}  // namespace dynmesh::transfer
