// The regions of the simplices of a mesh. The tag of each simplex is its label: the id of a set of
// polygons (2D) or of closed surfaces (3D).
//
// The label is a function of the input at a position. Labels of neighbours differ by the owners of
// the *wall* between them: an edge of polygons (2D) or a subfacet on closed surfaces (3D). So a new
// simplex gets its label from a neighbour that stays, and an edit that changes no wall of the input
// costs its own simplices only.
//
// If walls of the input change, labels of simplices that stay may change: whole parts of the mesh,
// with no changed wall near them. Per connected part of touched simplices, the change is computed
// once, at a vertex, by counting the changed walls that a ray from it crosses (wall.h). From there
// the correct labels spread over all touched simplices, and further while labels disagree:
// O(changed walls + simplices touched or relabelled).
//
// A label stands for at most kMostPolygonsAtAPlace owners. If one would have more, labels are left
// incomplete, and the state must be discarded.
//
// Thread-compatible.
#ifndef DYNMESH_CORE_REGIONS_REGION_LABELS_H_
#define DYNMESH_CORE_REGIONS_REGION_LABELS_H_

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/functional/function_ref.h"
#include "core/base/steps.h"
#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/delaunay/delaunay_triangulation.h"
#include "core/regions/region_sets.h"
#include "core/regions/wall.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

template <int D>
class RegionLabels {
 public:
  using Triangulation = std::conditional_t<D == 2, delaunay::DelaunayTriangulation,
                                           delaunay::DelaunayTetrahedralization>;
  using Simplex = typename Triangulation::SimplexIndex;
  using Vertex = typename Triangulation::VertexIndex;
  using Side = std::array<Vertex, D>;  // of a simplex, ascending

  static constexpr RegionId kPending = RegionSets::kPending;

  explicit RegionLabels(Triangulation* triangulation) : triangulation_(*triangulation) {}

  // AddWall: a side of simplices becomes a wall with these owners. RemoveWall: a side that may be a
  // wall is removed.
  void AddWall(const Side& side, std::span<const FeatureId> owners);
  void RemoveWall(const Side& side);

  // Is there nothing to label (every label 0)?
  bool empty() const { return walls_.empty() && !labelled_; }

  // A simplex that stays, and its former label.
  struct Relabelled {
    Simplex simplex;
    RegionId before;
  };
  // Labels `fresh`, all pending simplices, and the kept simplices with a label changed by the
  // `toggled` walls (FeatureTable). Returns the latter, unordered, valid until the next call.
  // is_rounded(v): does v lie inside a segment or a facet?
  const std::vector<Relabelled>& Update(std::span<const Simplex> fresh,
                                        std::span<const Wall<D>> toggled,
                                        absl::FunctionRef<bool(Vertex)> is_rounded);
  // Labels every simplex. O(mesh). If `steps` stop, labels are unspecified.
  void LabelAll(Steps& steps);
  void LabelAll() {
    AllSteps all;
    LabelAll(all);
  }
  // The owners around a position that has too many; empty if there is none. After LabelAll a
  // function of the input: of the positions that a path from outside enters as the first ones with
  // too many owners, the first by its owners.
  std::span<const FeatureId> overfull() const { return sets_.overfull(); }
  // Two sets of owners with the same id: of labels and walls, and of some former ones since the
  // last LabelAll. After LabelAll a function of the input.
  std::optional<RegionSets::Collision> collision() const { return sets_.collision(); }
  // Drops former sets of owners, if there are many. Call when labels from before an update are not
  // needed any more. O(mesh), amortised O(1) per new set.
  void Collect();

  RegionId at(Simplex t) const { return triangulation_.tag(t); }
  // RegionSets::SetsOf.
  std::vector<RegionSet> SetsOf(std::vector<RegionId>* ids) const { return sets_.SetsOf(ids); }
  // Do labels of neighbours agree with the walls, and has the outside no region? O(mesh).
  bool Check();
  std::size_t bytes() const { return walls_.capacity() * (sizeof(Side) + sizeof(RegionId) + 1); }

 private:
  using Point = geometry::Point<D>;
  RegionId WallAcross(Simplex t, int corner) const;
  bool IsAtHull(Simplex t) const;
  bool IsTouched(Simplex t) const;
  std::optional<std::vector<FeatureId>> CrossedBy(int ray, const Point& p) const;
  std::optional<RegionId> ChangeAt(const Point& p);
  std::optional<RegionId> TruthAt(Simplex t, absl::FunctionRef<bool(Vertex)> is_rounded);
  void SettleFrom(Simplex start, absl::FunctionRef<bool(Vertex)> is_rounded);
  void Settle(Simplex t, RegionId label);
  void Spread(Simplex from);

  Triangulation& triangulation_;
  RegionSets sets_;  // of walls and labels, and some former ones
  absl::flat_hash_map<Side, RegionId> walls_;
  absl::flat_hash_set<Vertex> wall_ends_;  // of walls added or removed since the last Update
  bool labelled_ = false;                  // some label may not be 0
  std::size_t collect_at_ = 1024;          // number of sets

  // Of the current update.
  std::span<const Wall<D>> toggled_;
  absl::flat_hash_set<Simplex> settled_, looked_at_;
  std::vector<Simplex> queue_, stack_;
  std::vector<Relabelled> relabelled_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_REGION_LABELS_H_
