// What stands in space for RegionLabels: no tetrahedron lies in a region yet. Thread-compatible.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_NO_LABELS_H_
#define DYNMESH_CORE_DYNAMIC_MESH_NO_LABELS_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamic_mesh/region_sets.h"
#include "core/mesh/delaunay_tetrahedralization.h"
#include "dynmesh/mesh.h"

namespace dynmesh {

class NoLabels {
 public:
  using Triangulation = mesh::DelaunayTetrahedralization;
  using Simplex = Triangulation::SimplexIndex;
  using Vertex = Triangulation::VertexIndex;
  struct Relabelled {
    Simplex simplex;
    RegionId before;
  };

  static constexpr RegionId kPending = RegionSets::kPending;

  explicit NoLabels(Triangulation* triangulation) : triangulation_(*triangulation) {}

  void AddWall(Vertex, Vertex, std::span<const FeatureId>) {}
  void RemoveWall(Vertex, Vertex) {}
  bool empty() const { return true; }
  template <class Walls, class OnSegment>
  std::array<Relabelled, 0> Update(std::span<const Simplex> fresh, const Walls&, OnSegment) {
    for (const Simplex t : fresh) triangulation_.set_tag(t, kNoRegion);
    return {};
  }
  void LabelAll() {}
  std::span<const FeatureId> overfull() const { return {}; }
  void Collect() {}
  RegionId at(Simplex) const { return kNoRegion; }
  std::vector<RegionSet> SetsOf(std::vector<RegionId>*) const { return {}; }
  bool Check() const { return true; }
  std::size_t bytes() const { return 0; }

 private:
  Triangulation& triangulation_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_NO_LABELS_H_
