// 3D meshes that `verify` must accept, made independently of the mesher: CGAL's Delaunay
// triangulation of points in a box. A segment and a polygon are sampled so finely that their
// subsegments are edges and faces.
#ifndef DYNMESH_TESTS_CORE_IO_MESHES_GOOD_SPACE_MESH_H_
#define DYNMESH_TESTS_CORE_IO_MESHES_GOOD_SPACE_MESH_H_

#include <cstdint>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::testing {

struct GoodSpaceMesh {
  Mesh mesh;
  std::vector<Feature> features;
};

// In the box [0, 8]^3: `count` random points, of which two of three are input. Features: kPole, a
// segment in eleven subsegments; kPlate, a square with a square hole, on a plane askew or, if
// `tilted` is false, across z; kRim, a segment that is one of the plate's edges.
inline constexpr FeatureId kPole = 5001, kPlate = 6001, kRim = 5002;
GoodSpaceMesh MakeGoodSpaceMesh(std::uint64_t seed, int count, bool tilted = true);

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_IO_MESHES_GOOD_SPACE_MESH_H_
