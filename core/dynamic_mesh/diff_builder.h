// From what refinement changed to what the client sees: keeps the Delaunay
// triangulation of the vertices present, their public ids and the hash of the mesh,
// and nets each propagation into a MeshDiff.
//
// The triangulation is a function of the vertex set, so it stands outside the trace:
// a propagation's few vertices are inserted and removed, O(degree) each. Cheaper by an
// order of magnitude than a star operation per vertex, and what a run from scratch
// reads its neighbourhoods off. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
#define DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_

#include <array>
#include <cstdint>
#include <vector>

#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/vertex_names.h"
#include "core/mesh/delaunay_triangulation.h"
#include "core/meshing/refinement.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class DiffBuilder {
 public:
  explicit DiffBuilder(VertexNames::Hash vertex_hash = &VertexIdAt) : names_(vertex_hash) {}

  mesh::DelaunayTriangulation& triangulation() { return triangulation_; }
  const mesh::DelaunayTriangulation& triangulation() const { return triangulation_; }
  // The bare domain, where refinement does not fill the triangulation itself. Its
  // first four vertices are the domain's corners.
  void ResetTriangulation(const meshing::Rules& rules) {
    triangulation_.Reset(rules.lo(), rules.hi(), {0, 1, 2, 3});
  }

  // The first time: the whole mesh, of a run from scratch. Rows in no order, see mesh.h.
  template <class Refinement>
  Mesh Begin(Refinement& refinement, const FeatureTable& features);

  // What has changed since the last call. Work counters are the caller's.
  template <class Refinement>
  MeshDiff Update(Refinement& refinement, const FeatureTable& features);

  // The whole mesh as it stood at the last Update. Rows in no order, see mesh.h.
  template <class Refinement>
  Mesh Snapshot(const Refinement& refinement, const FeatureTable& features) const;

  VertexId IdOf(meshing::VertexIndex v) const { return names_.at(v); }
  std::array<VertexId, 3> CanonicalIds(mesh::DelaunayTriangulation::TriangleIndex t) const {
    return CanonicalIds(triangulation_.vertices(t));
  }

  const MeshHash& hash() const { return hash_; }
  std::size_t subsegment_count() const { return subsegment_count_; }
  std::size_t bytes() const { return triangulation_.bytes() + names_.bytes(); }

 private:
  using Simplex = std::array<VertexId, 3>;

  Simplex CanonicalIds(const std::array<meshing::VertexIndex, 3>& v) const;
  void RecordCreated();
  void RecordDeleted();
  template <class Refinement>
  void InsertVertex(const Refinement& refinement, meshing::VertexIndex v);
  static void Net(std::vector<Simplex>& removed, std::vector<Simplex>& added);

  mesh::DelaunayTriangulation triangulation_;
  VertexNames names_;
  MeshHash hash_;
  std::size_t subsegment_count_ = 0;

  std::vector<Simplex> removed_, added_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_DIFF_BUILDER_H_
