#include "core/transfer/stencil.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "absl/container/flat_hash_map.h"
#include "core/transfer/bounds.h"
#include "core/transfer/least_squares.h"

namespace dynmesh::transfer {
namespace {

// Two rings, or up to five while a direction is undetermined, as in corners of the mesh.
constexpr int kRings = 2, kMostRings = 5;
constexpr double kStrong = 0.01;
constexpr std::size_t kMostNeighbours = kMostRows;

template <std::size_t D>
using FaceKey = std::array<Slot, D>;

template <std::size_t D>
FaceKey<D> FaceOf(const Slot* corners, std::size_t k) {
  FaceKey<D> face;
  std::size_t count = 0;
  for (std::size_t j = 0; j <= D; ++j) {
    if (j != k) face[count++] = corners[j];
  }
  std::sort(face.begin(), face.end());
  return face;
}

// The simplices of the mesh before the patch and their neighbours: old ones by their index in the
// overlay, kept ones by slot.
template <std::size_t D>
class OldMesh {
 public:
  struct Name {
    std::uint32_t old = kNone;
    Slot kept = kNoSlot;
    bool is_there() const { return old != kNone || kept != kNoSlot; }
  };
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  OldMesh(const SlotMesh& mesh, const Overlay<D>& overlay) : mesh_(mesh), overlay_(overlay) {
    faces_.reserve(overlay.from.size() * (D + 1));
    for (std::uint32_t i = 0; i < overlay.from.size(); ++i) {
      for (std::size_t k = 0; k <= D; ++k) {
        auto& both = faces_[FaceOf<D>(overlay.from[i].vertices.data(), k)];
        (both[0] == kNone ? both[0] : both[1]) = i;
      }
    }
    for (const auto& simplex : overlay.to) came_[simplex.slot] = true;
    // The cavity's border is also that of the new simplices; these know their neighbours outside.
    for (const auto& simplex : overlay.to) {
      for (std::size_t k = 0; k <= D; ++k) {
        const Slot other = mesh.neighbours()[At(simplex.slot) * (D + 1) + k];
        if (other == kNoSlot || came_.contains(other)) continue;
        outside_[FaceOf<D>(simplex.vertices.data(), k)] = other;
      }
    }
  }

  Name Across(const Name& name, std::size_t k) const {
    if (name.old != kNone) {
      const FaceKey<D> face = FaceOf<D>(overlay_.from[name.old].vertices.data(), k);
      const auto& both = faces_.at(face);
      if (both[1] != kNone) return {both[0] == name.old ? both[1] : both[0], kNoSlot};
      const auto outside = outside_.find(face);
      return {kNone, outside == outside_.end() ? kNoSlot : outside->second};
    }
    const std::size_t row = At(name.kept) * (D + 1);
    const Slot other = mesh_.neighbours()[row + k];
    if (other == kNoSlot || !came_.contains(other)) return {kNone, other};
    const auto old = faces_.find(FaceOf<D>(mesh_.cells().data() + row, k));
    return {old == faces_.end() ? kNone : old->second[0], kNoSlot};
  }

 private:
  const SlotMesh& mesh_;
  const Overlay<D>& overlay_;
  struct Both : std::array<std::uint32_t, 2> {
    Both() : std::array<std::uint32_t, 2>{kNone, kNone} {}
  };
  absl::flat_hash_map<FaceKey<D>, Both> faces_;
  absl::flat_hash_map<FaceKey<D>, Slot> outside_;
  absl::flat_hash_map<Slot, bool> came_;
};

// The growth of the field to other positions, per length: near and far ones have equal weight.
template <std::size_t D>
struct Steps {
  std::array<Vec<D>, kMostNeighbours> rows;
  std::array<double, kMostNeighbours> growths;
  std::size_t count = 0;
  void Add(const Vec<D>& step, double growth) {
    const double length = std::sqrt(Dot(step, step));
    if (length == 0) return;
    for (std::size_t k = 0; k < D; ++k) rows[count][k] = step[k] / length;
    growths[count++] = growth / length;
  }
  LinearFit<D> Fit() { return LeastSquares<D>({rows.data(), count}, {growths.data(), count}); }
};

}  // namespace

template <std::size_t D>
Stencil<D>::Stencil(const SlotMesh& mesh, const Overlay<D>& overlay)
    : neighbours_(overlay.from.size()), overlay_(overlay) {
  using Name = typename OldMesh<D>::Name;
  const OldMesh<D> old(mesh, overlay);
  absl::flat_hash_map<Slot, std::uint32_t> indices;
  const auto index_of = [&](const Name& name) {
    if (name.old != OldMesh<D>::kNone) return name.old;
    const auto [it, is_new] = indices.try_emplace(
        name.kept, static_cast<std::uint32_t>(overlay.from.size() + kept_.size()));
    if (is_new) {
      kept_.push_back(name.kept);
      centroids_.push_back(
          Centroid<D>(CornersOf<D>(mesh, mesh.cells().data() + At(name.kept) * (D + 1))));
    }
    return it->second;
  };
  absl::flat_hash_map<Slot, RegionId> former;
  const MeshPatch& patch = mesh.patch();
  for (std::size_t r = 0; r < patch.relabelled_simplices.size(); ++r) {
    former.emplace(patch.relabelled_simplices[r], patch.former_regions[r]);
  }
  const auto region_of = [&](const Name& name) {
    if (name.old != OldMesh<D>::kNone) return overlay.from[name.old].region;
    const auto it = former.find(name.kept);
    return it != former.end() ? it->second : mesh.regions()[At(name.kept)];
  };
  for (const auto& simplex : overlay.from) {
    centroids_.push_back(Centroid<D>(simplex.corners));
  }
  std::vector<Name> reached;
  for (std::uint32_t i = 0; i < overlay.from.size(); ++i) {
    auto& list = neighbours_[i];
    reached.assign(1, {i, kNoSlot});
    std::size_t begin = 0;
    for (int ring = 1; ring <= kMostRings; ++ring) {
      const std::size_t end = reached.size();
      for (; begin < end; ++begin) {
        for (std::size_t k = 0; k <= D && list.size() < kMostNeighbours; ++k) {
          const Name next = old.Across(reached[begin], k);
          if (!next.is_there() || region_of(next) != overlay.from[i].region) continue;
          const std::uint32_t index = index_of(next);
          if (index == i || std::find(list.begin(), list.end(), index) != list.end()) continue;
          list.push_back(index), reached.push_back(next);
        }
      }
      if (ring < kRings) continue;
      Steps<D> steps;
      for (const std::uint32_t other : list) steps.Add(centroids_[other] - centroids_[i], 0);
      if (steps.Fit().strength > kStrong) break;
    }
  }
}

template <std::size_t D>
Vec<D> Stencil<D>::Gradient(std::size_t i, std::span<const double> values) const {
  const auto& neighbours = neighbours_[i];
  Steps<D> steps;
  Range range;
  range.Hold(0);
  double spread = 0;
  for (const std::uint32_t other : neighbours) {
    const double growth = values[other] - values[i];
    range.Hold(growth);
    spread = std::max(spread, std::abs(growth));
    steps.Add(centroids_[other] - centroids_[i], growth);
  }
  if (spread == 0) return {};
  Vec<D> g = steps.Fit().solution;

  // The deviation of the means from linear, relative to their spread.
  double off = 0;
  for (const std::uint32_t other : neighbours) {
    const double predicted = Dot(g, centroids_[other] - centroids_[i]);
    off = std::max(off, std::abs(values[other] - values[i] - predicted));
  }
  constexpr double kSmooth = 0.1, kRough = 0.3;
  const double smooth = std::clamp((kRough - off / spread) / (kRough - kSmooth), 0.0, 1.0);
  // Where they are not smooth: the share of the gradient that keeps the corners within the means.
  double limit = 1;
  for (const Vec<D>& corner : overlay_.from[i].corners) {
    const double growth = Dot(g, corner - centroids_[i]);
    if (growth > range.high) limit = std::min(limit, range.high / growth);
    if (growth < range.low) limit = std::min(limit, range.low / growth);
  }
  const double part = std::max(limit, smooth);
  for (double& x : g) x *= part;
  return g;
}

template class Stencil<2>;
template class Stencil<3>;

}  // namespace dynmesh::transfer
