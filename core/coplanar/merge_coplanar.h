// Joins coplanar faces that share edges into polygons with holes: the triangles of a surface file
// become the faces from which they were cut.
//
//   * Faces are joined across an edge that exactly two faces have, if they lie on either side of it
//     and all their corners are in the plane of the region's largest face: exactly, or with a
//     tolerance > 0 at most that far from it.
//   * Features that end on the inside of a flat wall keep their edges and corners on rings. A face
//     is not joined if an edge or a corner of a segment, or of a face in another plane, would then
//     lie inside the polygon, nor across an edge over which a segment leans. So joining does not
//     make a valid input invalid, with one exception: a face that shares only a corner, with an
//     edge at less than 0.001 degrees just over a removed edge. Walls cut into triangles have many
//     such faces, and these are joined themselves.
//   * A region of several faces becomes one polygon, with the least of their ids. Its rings are its
//     boundary, cut where it returns to a point: rings touch there. Each starts at its least corner
//     by coordinates and goes to the lesser neighbour. The ring with the least corner of all comes
//     first: the outer one, unless a hole touches it there.
//   * A corner is dropped if all its rings go straight through it, between the same two points
//     (exactly straight, whatever the tolerance), and no segment or sizing polygon names it. Faces
//     that were not joined lose such corners, too.
//   * A point that was named only by polygons, and is not named any more, is removed. Others stay,
//     under their ids.
//   * Faces of a region that overlap, are no planar rings, or have no area stay as they are.
//
// The polygons are a function of the faces and their coordinates, not of the order of faces,
// corners and features, nor of the faces' orientation. Only ids depend on ids.
//
// Thread-safe. O(n lg n) for n corners, if faces have few rings; slightly more with a tolerance.
#ifndef DYNMESH_CORE_COPLANAR_MERGE_COPLANAR_H_
#define DYNMESH_CORE_COPLANAR_MERGE_COPLANAR_H_

#include <cstddef>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::coplanar {

// Features keep their order. INVALID_ARGUMENT if a polygon has a ring of fewer than three corners,
// or a corner that is no point of `features` or invalid for the predicates (above 2^200, nearer to
// 0 than 2^-200): the detail (dynmesh/error.h) has what is to blame. Or if the tolerance is below 0
// or NaN.
absl::StatusOr<std::vector<Feature>> MergeCoplanar(const std::vector<Feature>& features,
                                                   double tolerance = 0);

// The same for meshes, which need flatter polygons than a tolerance may allow: `most` returns the
// allowed thickness for an extent. Regions that would be thicker are joined only where exactly
// flat, and counted.
struct MergedFaces {
  std::vector<Feature> features;
  std::size_t too_thick = 0;
};
absl::StatusOr<MergedFaces> MergeCoplanar(const std::vector<Feature>& features, double tolerance,
                                          const std::function<double(double extent)>& most);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_MERGE_COPLANAR_H_
