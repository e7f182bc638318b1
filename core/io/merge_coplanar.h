// Joins faces that lie in one plane and share edges into polygons with holes, so that the
// triangles of a surface file become the faces that they were cut from.
//
// * Faces are joined across an edge that exactly two faces have, if they lie on either side of it
//   and all their corners are in the plane of the region's largest face: exactly, or with a
//   tolerance > 0 no farther from it than that.
// * What stands on the inside of a flat wall keeps its edges and corners on rings: a face is not
//   joined where an edge or a corner of a segment, or of a face in another plane, would come to lie
//   in the inside of the polygon, nor across an edge that a segment leans over. So what a mesh
//   accepts without joining it accepts with it. (But for a face with only a corner in common, of
//   which an edge stands at 60 to 70 degrees just over one that goes: on walls cut into triangles
//   there are many such, which are joined themselves.)
// * A region of several faces becomes one polygon, under the least of their ids. Its rings are its
//   boundary, cut where it comes to a point again: rings touch there. Each starts at its least
//   corner by coordinates and goes to the lesser neighbour; the one with the least corner of all
//   comes first, which is the outer one unless a hole touches it there.
// * A corner is dropped if all rings that have it go straight through it, from the same point to
//   the same point (exactly straight, whatever the tolerance), and no segment or sizing polygon
//   names it. Faces that were not joined lose such corners as well.
// * A point that only polygons named and none names any more goes. Others stay, under their ids.
// * Faces of a region that overlap, that are no planar rings, or of no area, stay as they are.
//
// The polygons are a function of the faces and their coordinates, whatever the order of faces,
// corners and features, and the side from which a face is seen; only ids come from ids.
//
// Thread-safe. O(n lg n) for n corners, if faces have few rings; with a tolerance a little more.
#ifndef DYNMESH_CORE_IO_MERGE_COPLANAR_H_
#define DYNMESH_CORE_IO_MERGE_COPLANAR_H_

#include <cstddef>
#include <functional>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// Features keep their order. INVALID_ARGUMENT if a polygon has a ring of
// fewer than three corners, or a corner that is no point of `features` or that the predicates
// cannot compute with (above 2^200, nearer to 0 than 2^-200); or a tolerance that is negative or no
// number.
absl::StatusOr<std::vector<Feature>> MergeCoplanar(const std::vector<Feature>& features,
                                                   double tolerance = 0);

// The same for meshes, which want polygons flatter than a tolerance may be: `most` says how thick
// one may be, by its extent. What would be thicker is joined where it is exactly flat only, and
// counted.
struct MergedFaces {
  std::vector<Feature> features;
  std::size_t too_thick = 0;
};
absl::StatusOr<MergedFaces> MergeCoplanar(const std::vector<Feature>& features, double tolerance,
                                          const std::function<double(double extent)>& most);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_MERGE_COPLANAR_H_
