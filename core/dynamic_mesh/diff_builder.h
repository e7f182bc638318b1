// From what refinement changed to what the client sees: keeps the Delaunay
// triangulation of the vertices present, their public ids and the hash of the mesh,
// and nets each propagation into a MeshDiff.
//
// The triangulation is a function of the vertex set, so it stands outside the trace:
// a propagation's few vertices are inserted and removed, O(degree) each. Cheaper by an
// order of magnitude than a star operation per vertex, and what a run from scratch
// reads its neighbourhoods off.
//
// An id may change while its vertex stays, if one that collides comes or goes
// (vertex_names.h). Such a vertex leaves under the old name and comes back under the
// new, and so does all that it is part of.
//
// Triangles carry the polygons that they lie in as labels (region_labels.h).
//
// Thread-compatible. Keeps its lists from call to call: an update allocates little but
// the diff.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
#define DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_

#include <array>
#include <compare>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "absl/status/status.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/region_labels.h"
#include "core/dynamic_mesh/vertex_names.h"
#include "core/mesh/delaunay_triangulation.h"
#include "core/meshing/refinement.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class DiffBuilder {
 public:
  explicit DiffBuilder(VertexNames::Hash vertex_hash = &VertexIdAt)
      : names_(vertex_hash), labels_(&triangulation_) {}
  DiffBuilder(const DiffBuilder&) = delete;
  DiffBuilder& operator=(const DiffBuilder&) = delete;

  mesh::DelaunayTriangulation& triangulation() { return triangulation_; }
  const mesh::DelaunayTriangulation& triangulation() const { return triangulation_; }
  // The bare domain, where refinement does not fill the triangulation itself. Its
  // first four vertices are the domain's corners.
  void ResetTriangulation(const meshing::PlanarRules& rules) {
    triangulation_.Reset(rules.lo(), rules.hi(), {0, 1, 2, 3});
  }

  // The first time: the whole mesh, of a run from scratch. Rows in no order, see mesh.h.
  template <class Refinement>
  Mesh Begin(Refinement& refinement, const FeatureTable& features);

  // What has changed since the last call. Rows sorted as Canonicalize does it. Work
  // counters are the caller's.
  template <class Refinement>
  MeshDiff Update(Refinement& refinement, const FeatureTable& features);

  // The whole mesh as it stood at the last Update. Rows in no order, see mesh.h.
  template <class Refinement>
  Mesh Snapshot(const Refinement& refinement, const FeatureTable& features) const;

  VertexId IdOf(meshing::VertexIndex v) const { return names_.at(v); }
  std::array<VertexId, 3> CanonicalIds(mesh::DelaunayTriangulation::TriangleIndex t) const;

  // RESOURCE_EXHAUSTED (POLYGON_LIMIT) if the last Begin or Update found a place in too many
  // polygons. What it returned is nothing then, and no more may be done with the builder.
  absl::Status RegionStatus() const;

  const MeshHash& hash() const { return hash_; }
  std::size_t subsegment_count() const { return subsegment_count_; }
  std::size_t bytes() const { return triangulation_.bytes() + names_.bytes() + labels_.bytes(); }
  // Do the labels agree with the walls? O(mesh).
  bool CheckLabels() { return labels_.Check(); }

 private:
  // Rows of the diff, as the client sees them.
  struct VertexRow {
    VertexId id;
    std::array<double, 2> coordinates;
    int dimension;
    FeatureId owner;
    friend auto operator<=>(const VertexRow&, const VertexRow&) = default;
  };
  struct SubsegmentRow {
    std::array<VertexId, 2> ends;  // the lesser first
    FeatureId owner;
    friend auto operator<=>(const SubsegmentRow&, const SubsegmentRow&) = default;
  };
  struct SimplexRow {
    std::array<VertexId, 3> ids;  // canonical order
    RegionId region;
    friend auto operator<=>(const SimplexRow&, const SimplexRow&) = default;
  };
  using Corners = std::array<meshing::VertexIndex, 3>;
  struct TriangleRow {
    Corners v;  // the least first
    RegionId region;
    friend auto operator<=>(const TriangleRow&, const TriangleRow&) = default;
  };
  // What leaves the mesh and what comes.
  template <class Row>
  struct Rows {
    std::vector<Row> gone, come;
    void Clear() { gone.clear(), come.clear(); }
    void Net();
  };
  struct Renamed {
    meshing::VertexIndex v;
    VertexId old_id;
  };

  // The steps of an update, in this order.
  template <class Refinement>
  void TakeChanges(Refinement& refinement);
  template <class Refinement>
  void UpdateNames(const Refinement& refinement);
  template <class Refinement>
  void UpdateTriangulation(const Refinement& refinement);
  template <class Refinement>
  void UpdateLabels(const Refinement& refinement, const FeatureTable& features);
  template <class Refinement>
  void ReportVertices(const Refinement& refinement, const FeatureTable& features, MeshDiff* diff);
  template <class Refinement>
  void ReportSubsegments(const Refinement& refinement, const FeatureTable& features,
                         MeshDiff* diff);
  void ReportSimplices(MeshDiff* diff);

  template <class Refinement>
  void InsertVertex(const Refinement& refinement, meshing::VertexIndex v);
  void RecordTriangles();
  void AddTrianglesOfRenamed();
  TriangleRow RowOf(mesh::DelaunayTriangulation::TriangleIndex t) const;

  // The id at the last call of a vertex that was in the mesh then.
  VertexId OldId(meshing::VertexIndex v) const {
    return renamed_.empty() ? names_.at(v) : OldIdOfRenamed(v);
  }
  VertexId OldIdOfRenamed(meshing::VertexIndex v) const;
  bool IsRenamed(meshing::VertexIndex v) const;
  static VertexRow RowOf(VertexId id, const meshing::Vertex<2>& v, const FeatureTable& features);
  static SubsegmentRow RowOf(VertexId a, VertexId b, FeatureId owner);
  // Appends a row to a mesh's or diff's columns, or gives its hash.
  static void Append(VertexColumns& to, const VertexRow& row);
  static void Append(SubsegmentColumns& to, const SubsegmentRow& row);
  void Append(const std::vector<SimplexRow>& rows, SimplexColumn* simplices, RegionColumn* regions);
  void NameRegions(std::initializer_list<RegionColumn*> columns,
                   std::vector<RegionSet>* sets) const;
  static MeshHash HashOf(const VertexRow& row);
  static MeshHash HashOf(const SimplexRow& row);
  static MeshHash HashOf(const SubsegmentRow& row);

  mesh::DelaunayTriangulation triangulation_;
  VertexNames names_;
  RegionLabels labels_;
  MeshHash hash_;
  std::size_t subsegment_count_ = 0;

  // Of the update under way.
  Rows<meshing::VertexIndex> vertices_;
  Rows<meshing::SubsegmentIndex> subsegments_;
  std::vector<Renamed> renamed_;                                   // were in the mesh; by index
  std::vector<mesh::DelaunayTriangulation::TriangleIndex> fresh_;  // finite ones just made
  Rows<TriangleRow> triangles_;                                    // finite ones
  std::vector<TriangleRow> stay_;
  Rows<VertexRow> vertex_rows_;
  Rows<SubsegmentRow> subsegment_rows_;
  Rows<SimplexRow> simplex_rows_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
