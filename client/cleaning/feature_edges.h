// Keeps of a surface its sharp edges and corners, but not its triangulation: nearly flat patches
// get fewer and larger triangles.
//
// Sharp is an edge of one face, of three or more, of faces of different groups, of faces with
// normals that deviate by more than the angle, and one that is a segment. A corner is a point with
// one sharp edge or at least three, with two that turn by more than the angle, one where faces meet
// in the point only, and an end of a segment. Corners and points without faces stay. Other points
// may go; those that stay do not move. So each face has corners of the input.
//
// With D the distance and A the angle:
// * each point of the result is within D of a point of the input, and each of the input of one of
//   the result, up to rounding; of chains of sharp edges likewise. Distances do not add up;
// * what was closed stays closed, and a manifold one: edges have as many faces as before;
// * normals of faces at an edge that is not sharp deviate by at most A, and no single step turns a
//   face by more than A / 2;
// * angles of faces, and between faces at a sharp edge, get below 20 degrees only where some nearby
//   were, and those of faces in one plane below 10; no face that is not in a plane gets an angle
//   above 125 degrees where none was;
// * faces have corners and edges in common only, decided exactly. What does not meet is a tolerance
//   apart, and nothing changes sides.
//
// Points are dropped, those first whose hole gets the smallest circumscribed circles, until no
// other one may be (after W. Schroeder and others, Decimation of triangle meshes, 1992). Which
// points of a patch remain depends on the whole patch.
//
// The result's coordinates and faces are functions of the input's coordinates and groups,
// independent of ids, order and orientations. Ids depend on ids: parts of a face keep its id,
// marker and orientation. Pure, thread-safe. Expected O(n lg n) for n triangles, 0.2 to 0.4 ms
// each.
#ifndef DYNMESH_CLIENT_CLEANING_FEATURE_EDGES_H_
#define DYNMESH_CLIENT_CLEANING_FEATURE_EDGES_H_

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cleaning/clean_surfaces.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

inline constexpr double kLeastFeatureAngle = 0.1;  // in degrees
inline constexpr double kMostFeatureAngle = 89;

struct FeatureEdgeOptions {
  double angle = 0;      // A, in degrees, kLeastFeatureAngle to kMostFeatureAngle
  double within = 0;     // D, in the input's units; positive, finite
  double tolerance = 0;  // of the cleaning; positive
  // Of a polygon: between different numbers edges stay. May be null.
  std::function<std::size_t(FeatureId)> group = {};
  bool holes = true;  // polygons may keep several rings; else they become triangles
};

struct FeatureEdgeResult {
  // As in SurfaceCleanResult. A polygon of more corners that nothing has changed stays one.
  std::vector<Feature> features;
  std::vector<std::pair<FeatureId, FeatureId>> parts;
  std::vector<SurfaceChange> changes;               // all kPointDropped
  std::size_t triangles_before = 0, triangles = 0;  // of all polygons, given and in the result
  std::size_t sharp_edges = 0;                      // of the result
  std::size_t corners = 0;                          // with faces
};

// A thousandth of the diagonal of the box of all polygons' corners; 0 if there are none.
double DefaultWithin(const std::vector<Feature>& features);

// REQUIRES: `features` are what CleanSurfaces made with this tolerance, or what a mesh accepts:
// then what was nearer than the tolerance may stay so. INVALID_ARGUMENT for an angle or a distance
// out of its range.
absl::StatusOr<FeatureEdgeResult> KeepFeatureEdges(const std::vector<Feature>& features,
                                                   const FeatureEdgeOptions& options);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_FEATURE_EDGES_H_
