// Which regions the simplices of a mesh lie in: a label in each simplex's tag, the id of the set
// of polygons in the plane, of closed surfaces in space.
//
// A label is a function of the input at a place; two neighbours' differ by the owners of the
// *wall* between them: in the plane an edge of polygons, in space a subfacet on closed surfaces.
// So a simplex just made takes its label from a neighbour that stays, and an edit that changes
// no wall of the input costs its own simplices only.
//
// Where walls of the input change, so may labels of simplices that stay: whole parts of the mesh
// change sides without a wall near them. How a place's label changes is found once, at a
// vertex, by counting the changed walls that a ray from there crosses (wall.h); from there truth
// is spread over all that the change has touched, and further as long as labels disagree with
// it: O(changed walls + simplices touched or relabelled), for each connected part of what
// was touched.
//
// No label stands for more than kMostPolygonsAtAPlace owners: then labels are left half made,
// and what is there has to be thrown away.
//
// Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_

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
#include "core/dynamic_mesh/region_sets.h"
#include "core/dynamic_mesh/wall.h"
#include "core/mesh/delaunay_tetrahedralization.h"
#include "core/mesh/delaunay_triangulation.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

template <int D>
class RegionLabels {
 public:
  using Triangulation =
      std::conditional_t<D == 2, mesh::DelaunayTriangulation, mesh::DelaunayTetrahedralization>;
  using Simplex = typename Triangulation::SimplexIndex;
  using Vertex = typename Triangulation::VertexIndex;
  using Side = std::array<Vertex, D>;  // of a simplex, ascending

  static constexpr RegionId kPending = RegionSets::kPending;

  explicit RegionLabels(Triangulation* triangulation) : triangulation_(*triangulation) {}

  // A side of simplices that is a wall, with its owners, comes; one that may be a wall goes.
  void AddWall(const Side& side, std::span<const FeatureId> owners);
  void RemoveWall(const Side& side);

  // Is there nothing to label, every label 0?
  bool empty() const { return walls_.empty() && !labelled_; }

  // A simplex that stays, and the label that it had.
  struct Relabelled {
    Simplex simplex;
    RegionId before;
  };
  // Labels `fresh`, all pending simplices there are, and simplices that stay whose label
  // `toggled` walls (FeatureTable) changed: the result, in no order, valid until the next
  // call. is_rounded(v): does v lie inside a segment or a facet?
  const std::vector<Relabelled>& Update(std::span<const Simplex> fresh,
                                        std::span<const Wall<D>> toggled,
                                        absl::FunctionRef<bool(Vertex)> is_rounded);
  // Labels every simplex. O(mesh). Where `steps` are stopped, so is this: then labels are of no
  // use.
  void LabelAll(Steps& steps);
  void LabelAll() {
    AllSteps all;
    LabelAll(all);
  }
  // The owners that a place lies inside of that has too many; empty if there is none. After
  // LabelAll, of the places where there are too many for those who come from outside and pass
  // none such: the first by its owners. A function of the input.
  std::span<const FeatureId> overfull() const { return sets_.overfull(); }
  // Sets of owners that have one id: of labels and walls, and since the last LabelAll of some that
  // were. After LabelAll a function of the input.
  std::optional<RegionSets::Collision> collision() const { return sets_.collision(); }
  // Forgets sets of owners that were here once, if there are many. Call when no label
  // from before an update is of interest any more. O(mesh), amortised O(1) a new set.
  void Collect();

  RegionId at(Simplex t) const { return triangulation_.tag(t); }
  // RegionSets::SetsOf.
  std::vector<RegionSet> SetsOf(std::vector<RegionId>* ids) const { return sets_.SetsOf(ids); }
  // Do neighbours' labels agree with the walls, and is the outside in no region? O(mesh).
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
  RegionSets sets_;  // those of walls and labels, and some that were
  absl::flat_hash_map<Side, RegionId> walls_;
  absl::flat_hash_set<Vertex> wall_ends_;  // of walls that came or went since the last Update
  bool labelled_ = false;                  // a label may be other than 0
  std::size_t collect_at_ = 1024;          // sets known

  // Of the update under way.
  std::span<const Wall<D>> toggled_;
  absl::flat_hash_set<Simplex> settled_, looked_at_;
  std::vector<Simplex> queue_, stack_;
  std::vector<Relabelled> relabelled_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_
