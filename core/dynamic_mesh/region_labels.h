// Which polygons each triangle lies in: a label in the triangle's tag, the id of the set.
//
// A label is a function of the input at a place; two neighbours' differ by the polygons that
// have an edge between them, a *wall*. So a triangle just made takes its label from a
// neighbour that stays, and an edit that changes no polygon costs its own triangles only.
//
// Where polygons change, so may labels of triangles that stay: whole parts of the mesh
// change sides without a wall near them. How a place's label changes is found once, at a
// vertex, by counting the changed walls that a ray from there crosses; from there truth is
// spread over all that the change has touched, and further as long as labels disagree with
// it: O(changed walls + triangles touched or relabelled), for each connected part of what
// was touched.
//
// No label stands for more than kMostPolygonsAtAPlace polygons: then labels are left half made,
// and what is there has to be thrown away.
//
// Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/functional/function_ref.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/region_sets.h"
#include "core/mesh/delaunay_triangulation.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class RegionLabels {
 public:
  using Triangulation = mesh::DelaunayTriangulation;
  using Triangle = Triangulation::SimplexIndex;
  using Vertex = Triangulation::VertexIndex;

  using Wall = FeatureTable<2>::Wall;

  static constexpr RegionId kPending = RegionSets::kPending;

  explicit RegionLabels(Triangulation* triangulation) : triangulation_(*triangulation) {}

  // An edge of the mesh with those polygons on it comes, or goes.
  void AddWall(Vertex a, Vertex b, std::span<const FeatureId> polygons);
  void RemoveWall(Vertex a, Vertex b);

  // Is there nothing to label, every label 0?
  bool empty() const { return walls_.empty() && !labelled_; }

  // A triangle that stays, and the label that it had.
  struct Relabelled {
    Triangle triangle;
    RegionId before;
  };
  // Labels `fresh`, all pending triangles there are, and triangles that stay whose label
  // `toggled` walls (FeatureTable) changed: the result, in no order, valid until the next
  // call. on_segment(v): does v lie inside a segment?
  const std::vector<Relabelled>& Update(std::span<const Triangle> fresh,
                                        std::span<const Wall> toggled,
                                        absl::FunctionRef<bool(Vertex)> on_segment);
  // Labels every triangle. O(mesh).
  void LabelAll();
  // The polygons that a place lies in that lies in too many; empty if there is none. After
  // LabelAll, of the places where there are too many for those who come from outside and pass
  // none such: the first by its polygons. A function of the input.
  std::span<const FeatureId> overfull() const { return sets_.overfull(); }
  // Forgets sets of polygons that were here once, if there are many. Call when no label
  // from before an update is of interest any more. O(mesh), amortised O(1) a new set.
  void Collect();

  RegionId at(Triangle t) const { return triangulation_.tag(t); }
  // RegionSets::SetsOf.
  std::vector<RegionSet> SetsOf(std::vector<RegionId>* ids) const { return sets_.SetsOf(ids); }
  // Do neighbours' labels agree with the walls, and is the outside in no polygon? O(mesh).
  bool Check();
  std::size_t bytes() const { return walls_.capacity() * (sizeof(Edge) + sizeof(RegionId) + 1); }

 private:
  using Edge = std::pair<Vertex, Vertex>;  // the lesser first
  RegionId WallBetween(Vertex a, Vertex b) const;
  RegionId WallAcross(Triangle t, int corner) const;
  bool IsAtHull(Triangle t) const;
  bool IsTouched(Triangle t) const;
  std::optional<RegionId> ChangeAt(const geometry::Point2& p);
  std::optional<RegionId> TruthAt(Triangle t, absl::FunctionRef<bool(Vertex)> on_segment);
  void SettleFrom(Triangle start, absl::FunctionRef<bool(Vertex)> on_segment);
  void Settle(Triangle t, RegionId label);
  void Spread(Triangle from);

  Triangulation& triangulation_;
  RegionSets sets_;  // those of walls and labels, and some that were
  absl::flat_hash_map<Edge, RegionId> walls_;
  absl::flat_hash_set<Vertex> wall_ends_;  // of walls that came or went since the last Update
  bool labelled_ = false;                  // a label may be other than 0
  std::size_t collect_at_ = 1024;          // sets known

  // Of the update under way.
  std::span<const Wall> toggled_;
  absl::flat_hash_set<Triangle> settled_, looked_at_;
  std::vector<Triangle> queue_, stack_;
  std::vector<Relabelled> relabelled_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_REGION_LABELS_H_
