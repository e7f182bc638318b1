// From changes of a mesher to a MeshDiff. Keeps the Delaunay triangulation of the vertices
// present, their public ids and the hash of the mesh. Nets each propagation into a diff.
//
// The triangulation is a function of the vertices, or of vertices and subsegments (MeshKind), so it
// is outside the trace: the few vertices
// of a propagation are inserted and removed, O(degree) each. That is cheaper by an order of
// magnitude than a star operation per vertex. A run from scratch reads its neighbourhoods from it.
//
// A vertex's id may change while the vertex stays, if another with the same unsalted id is added or
// removed (vertex_names.h). The diff then removes the vertex under the old id and adds it under the
// new one, with everything that it is part of.
//
// Labels of simplices are their regions (region_labels.h). In 3D, faces of tetrahedra on facets are
// subfacets (subfacet_table.h).
//
// Thread-compatible. Keeps its lists between calls: an update allocates little but the diff.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
#define DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_

#include <array>
#include <compare>
#include <cstdint>
#include <initializer_list>
#include <type_traits>
#include <vector>

#include "absl/status/status.h"
#include "core/base/steps.h"
#include "core/delaunay/constrained_triangulation.h"
#include "core/delaunay/triangulation_of.h"
#include "core/dynamic_mesh/diff_rows.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/renamed_vertices.h"
#include "core/dynamic_mesh/subfacet_table.h"
#include "core/dynamic_mesh/vertex_names.h"
#include "core/mesh_data/canonical_order.h"
#include "core/meshing/mesh_source.h"
#include "core/regions/region_labels.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

template <int D>
class DiffBuilder {
 public:
  using Source = meshing::MeshSource<D>;
  using Elements = meshing::ElementStore<D>;
  // Without segments the constrained one is the Delaunay triangulation.
  using Triangulation =
      std::conditional_t<D == 2, delaunay::ConstrainedTriangulation, delaunay::TriangulationOf<D>>;
  using Labels = RegionLabels<D>;
  using Simplex = typename Triangulation::SimplexIndex;

  // `kind`: kDelaunay, whose subsegments are edges of the Delaunay triangulation; or
  // kTriangulation, whose subsegments constrain it.
  explicit DiffBuilder(MeshKind kind = MeshKind::kDelaunay, VertexHash vertex_hash = &VertexIdAt)
      : is_constrained_(kind == MeshKind::kTriangulation),
        names_(vertex_hash),
        labels_(&triangulation_) {}
  DiffBuilder(const DiffBuilder&) = delete;
  DiffBuilder& operator=(const DiffBuilder&) = delete;

  Triangulation& triangulation() { return triangulation_; }
  const Triangulation& triangulation() const { return triangulation_; }
  // The first call, for a run from scratch: returns the whole mesh. Rows are unordered, see mesh.h.
  // If `steps` stop, the result is unspecified and the builder unusable.
  Mesh Begin(Source& mesher, const FeatureTable<D>& features, Steps& steps);
  Mesh Begin(Source& mesher, const FeatureTable<D>& features) {
    AllSteps all;
    return Begin(mesher, features, all);
  }

  // The diff since the last call. Rows are sorted as by Canonicalize. The caller sets the work
  // counters.
  MeshDiff Update(Source& mesher, const FeatureTable<D>& features);

  // The whole mesh of the last Update, even if the mesher has been changed since, or is being run.
  // Rows are unordered, see mesh.h.
  Mesh Snapshot(const Source& mesher, const FeatureTable<D>& features, Steps& steps) const;
  Mesh Snapshot(const Source& mesher, const FeatureTable<D>& features) const {
    AllSteps all;
    return Snapshot(mesher, features, all);
  }

  VertexId IdOf(meshing::VertexIndex v) const { return names_.at(v); }
  std::array<VertexId, D + 1> CanonicalIds(Simplex t) const {
    return mesh_data::InCanonicalOrder(NewIds(triangulation_.vertices(t)));
  }

  // RESOURCE_EXHAUSTED if the last Begin or Update filled the triangulation (SIZE_LIMIT) or found a
  // position in too many polygons (POLYGON_LIMIT). FAILED_PRECONDITION (ID_COLLISION) if two sets
  // of polygons have the same id; after an Update these sets may be former ones. After an error its
  // result is invalid and the builder unusable.
  absl::Status RegionStatus() const;
  // FAILED_PRECONDITION (ID_COLLISION) if two vertices have the same id after the last Begin or
  // Update. Then its result is invalid, but a further Update may be valid.
  absl::Status NameStatus(const Source& mesher, const FeatureTable<D>& features) const;

  const MeshHash& hash() const { return hash_; }
  std::size_t subsegment_count() const { return subsegment_count_; }
  std::size_t subfacet_count() const { return subfacets_.size(); }
  std::size_t bytes() const {
    return triangulation_.bytes() + names_.bytes() + labels_.bytes() + subfacets_.bytes();
  }
  // Do the labels agree with the walls? O(mesh).
  bool CheckLabels() { return labels_.Check(); }

 private:
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  using Point = geometry::Point<D>;
  using Corners = std::array<meshing::VertexIndex, D + 1>;
  // A simplex by its vertices, canonically ordered by their indices.
  struct IndexRow {
    Corners v;
    RegionId region;
    friend auto operator<=>(const IndexRow&, const IndexRow&) = default;
  };

  // The steps of an update, in this order. Those that report are in diff_report.cc.
  void TakeChanges(Source& mesher);
  void UpdateNames(const Elements& elements);
  void FillTriangulation(const Elements& elements, std::vector<meshing::VertexIndex>& missing,
                         Steps& steps);
  void ConstrainTriangulation(const Elements& elements, Steps& steps);
  void UpdateTriangulation(const Source& mesher);
  void UpdateSubfacets(const Source& mesher, const FeatureTable<D>& features);
  void UpdateWalls(const Elements& elements, const FeatureTable<D>& features);
  void UpdateLabels(const Elements& elements, const FeatureTable<D>& features);
  void ReportVertices(const Elements& elements, const FeatureTable<D>& features, MeshDiff* diff);
  void ReportSubsegments(const Elements& elements, const FeatureTable<D>& features, MeshDiff* diff);
  void ReportSubfacets(const FeatureTable<D>& features, MeshDiff* diff);
  void ReportSimplices(MeshDiff* diff);

  void InsertVertex(const Source& mesher, meshing::VertexIndex v);
  void RecordSimplices();
  template <class F>
  void ForEachRenamed(F f) const;
  void AddSimplicesOfRenamed();
  IndexRow RowOf(Simplex t) const;

  // The id, at the last call, of a vertex that was in the mesh then.
  VertexId OldId(meshing::VertexIndex v) const {
    const auto* const renamed = renamed_.empty() ? nullptr : renamed_.Find(v);
    return renamed != nullptr ? renamed->old_id : names_.at(v);
  }
  template <std::size_t N>
  std::array<VertexId, N> OldIds(const std::array<meshing::VertexIndex, N>& v) const {
    std::array<VertexId, N> ids;
    for (std::size_t i = 0; i < N; ++i) ids[i] = OldId(v[i]);
    return ids;
  }
  template <std::size_t N>
  std::array<VertexId, N> NewIds(const std::array<meshing::VertexIndex, N>& v) const {
    std::array<VertexId, N> ids;
    for (std::size_t i = 0; i < N; ++i) ids[i] = names_.at(v[i]);
    return ids;
  }
  static VertexRow<D> RowOf(VertexId id, const Vertex& v, const FeatureTable<D>& features);
  void AppendAll(const std::vector<SimplexRow<D>>& rows, SimplexColumn* simplices,
                 RegionColumn* regions);
  // If there is a wall in that slot.
  void AddWall(const typename Labels::Side& side, meshing::FeatureSlot slot,
               const FeatureTable<D>& features);
  void NameRegions(std::initializer_list<RegionColumn*> columns,
                   std::vector<RegionSet>* sets) const;

  const bool is_constrained_;
  Triangulation triangulation_;
  VertexNames<D> names_;
  Labels labels_;
  SubfacetTable subfacets_;  // 3D only
  MeshHash hash_;
  std::size_t subsegment_count_ = 0;

  // Of the current update.
  Rows<meshing::VertexIndex> vertices_;
  Rows<meshing::SubsegmentIndex> subsegments_;
  RenamedVertices renamed_;     // were in the mesh
  std::vector<Simplex> fresh_;  // new finite ones
  Rows<IndexRow> simplices_;    // finite ones
  std::vector<IndexRow> stay_;
  Rows<VertexRow<D>> vertex_rows_;
  Rows<ConstraintRow<2>> subsegment_rows_;
  Rows<ConstraintRow<3>> subfacet_rows_;
  Rows<SimplexRow<D>> simplex_rows_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
