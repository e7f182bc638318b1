// Meshes that `verify` must accept, made independently of the mesher: CGAL's Delaunay triangulation
// of random points in a box, with some segments.
#ifndef DYNMESH_TESTS_CLIENT_VERIFY_GOOD_MESH_H_
#define DYNMESH_TESTS_CLIENT_VERIFY_GOOD_MESH_H_

#include <cstdint>
#include <vector>

#include "core/io/meshes/mesh_files.h"
#include "dynmesh/feature.h"

namespace dynmesh::testing {

struct GoodMesh {
  io::MeshFiles files;
  std::vector<Feature> features;
};

// `count` input points in [1, 5]^2 of the box [0, 6]^2, a few free vertices, and two
// segments of several subsegments each. Edge lengths are no smaller than about 1e-3.
GoodMesh MakeGoodMesh(std::uint64_t seed, int count);

// Six polygons among free vertices, by their ids below: a square ring, in its hole a square that
// shares the hole's edges, one inside that, a triangle on the right side of the ring, one polygon
// of two parts that lies in the ring below and above, and one in the innermost square with its
// three corners. One edge of the hole is a segment too (20).
inline constexpr FeatureId kRing = 9, kFilling = 5, kNested = 7, kRoof = 3, kParts = 12, kTip = 40;
inline constexpr FeatureId kHoleSegment = 20;
GoodMesh MakePolygonMesh(std::uint64_t seed, int count);

// The points of an n x n integer grid: every circle has four points on it.
GoodMesh MakeGridMesh(int n);

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CLIENT_VERIFY_GOOD_MESH_H_
