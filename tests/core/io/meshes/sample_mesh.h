// A small mesh with one of everything: an input segment in two subsegments, a free vertex,
// box corners and a vertex that refinement put on the box's side. Built by hand; it
// need not be Delaunay.
//
//   4-----------3       1..4: corners of the box, 5: on its lower side
//   |\         /|       6, 7: input points 10 and 20, ends of segment 30
//   | 6---8---7 |       8: on that segment; 9: free
//   |  \ /  9   |
//   1---5-------2
#ifndef DYNMESH_TESTS_CORE_IO_MESHES_SAMPLE_MESH_H_
#define DYNMESH_TESTS_CORE_IO_MESHES_SAMPLE_MESH_H_

#include <algorithm>
#include <array>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::testing {

inline Mesh SampleMesh() {
  Mesh mesh;
  const auto vertex = [&mesh](double x, double y, int dimension, FeatureId owner) {
    const double c[2] = {x, y};
    const VertexId id = VertexIdAt(c, 2);
    mesh.vertices.ids.push_back(id);
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), {x, y});
    mesh.vertices.containing_dimensions.push_back(static_cast<std::uint8_t>(dimension));
    mesh.vertices.owners.push_back(owner);
    return id;
  };
  const VertexId v1 = vertex(0, 0, 0, kBoxFeature);
  const VertexId v2 = vertex(12, 0, 0, kBoxFeature);
  const VertexId v3 = vertex(12, 6, 0, kBoxFeature);
  const VertexId v4 = vertex(0, 6, 0, kBoxFeature);
  const VertexId v5 = vertex(4, 0, 1, kBoxFeature);
  const VertexId v6 = vertex(2, 3.1, 0, 10);
  const VertexId v7 = vertex(10, 3.1, 0, 20);
  const VertexId v8 = vertex(6, 3.1, 1, 30);
  const VertexId v9 = vertex(8, 1.0 / 3, 2, kNoFeature);
  const auto triangle = [&mesh](VertexId a, VertexId b, VertexId c) {
    std::array<VertexId, 3> t = {a, b, c};
    std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
    mesh.simplices.insert(mesh.simplices.end(), t.begin(), t.end());
  };
  triangle(v1, v5, v6);
  triangle(v1, v6, v4);
  triangle(v5, v8, v6);
  triangle(v5, v9, v8);
  triangle(v5, v2, v9);
  triangle(v9, v7, v8);
  triangle(v9, v2, v7);
  triangle(v2, v3, v7);
  triangle(v7, v3, v8);
  triangle(v8, v3, v4);
  triangle(v8, v4, v6);
  const auto subsegment = [&mesh](VertexId a, VertexId b, FeatureId owner) {
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), {std::min(a, b), std::max(a, b)});
    mesh.subsegments.owners.push_back(owner);
  };
  subsegment(v6, v8, 30);
  subsegment(v8, v7, 30);
  subsegment(v1, v5, kBoxFeature);
  subsegment(v5, v2, kBoxFeature);
  subsegment(v2, v3, kBoxFeature);
  subsegment(v3, v4, kBoxFeature);
  subsegment(v4, v1, kBoxFeature);
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

inline constexpr FeatureId kLargePolygon = kBoxFeature - 1;

// The same with labels: the triangles around vertex 9 are in polygons 12 and 40, that left of
// them in 12, that right of them in 40, that on top of vertex 8 between 3 and 7 in 40 and
// kLargePolygon; the rest in none.
inline Mesh SampleMeshWithRegions() {
  Mesh mesh = SampleMesh();
  const std::vector<FeatureId> both = {12, 40};
  const std::vector<FeatureId> large = {40, kLargePolygon};
  mesh.region_sets = {{RegionIdOf(both), both}, {RegionIdOf(large), large}};
  std::sort(mesh.region_sets.begin(), mesh.region_sets.end(),
            [](const RegionSet& a, const RegionSet& b) { return a.id < b.id; });
  const RegionId in_both = RegionIdOf(both);
  mesh.regions = {0, 0, 12, in_both, in_both, in_both, in_both, 40, RegionIdOf(large), 0, 0};
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_MESHES_SAMPLE_MESH_H_
