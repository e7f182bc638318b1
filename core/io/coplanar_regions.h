// Which faces lie in one plane and hang together, and the rings around them: what
// merge_coplanar.h is made of.
//
// Faces are joined across an edge that they and no others use, if they lie on either side of it
// and in the plane of the region's largest face, and if nothing else needs what the region would
// have in its inside then: an edge or a corner where a face of another plane, or what is `Kept`,
// ends, or an edge over which a segment leans. A face that would enclose one, however the region
// came around it, is left out. So a region is flat as a whole, however many small steps its faces
// make. Regions are grown from the largest face down, ties broken by coordinates; what is left of
// the order of faces and corners is nothing.
//
// Pure, thread-safe. O(n lg n) for n corners, and with a tolerance what faces at the rim of
// several regions cost more than once.
#ifndef DYNMESH_CORE_IO_COPLANAR_REGIONS_H_
#define DYNMESH_CORE_IO_COPLANAR_REGIONS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "core/geometry/point.h"

namespace dynmesh::io {

// A corner is the number of a place in the lexicographic order of all places, so what orders
// corners orders coordinates.
using Corner = std::uint32_t;
using CornerRing = std::vector<Corner>;
using FaceRings = std::vector<CornerRing>;
using CornerPair = std::pair<Corner, Corner>;  // first < second

// Each ring from its least corner towards the lesser neighbour, and the rings sorted.
FaceRings Canonical(FaceRings rings);

// What is there for other reasons than faces.
struct Kept {
  std::vector<CornerPair> edges;  // segments, ascending
  std::vector<bool> corners;      // by corner: an end of one of them or of anything else
};

// How thick a region may be that a tolerance has joined, by its extent along the axes.
using Thickness = std::function<double(double extent)>;

struct FlatRegion {
  std::vector<std::size_t> faces;  // two or more
  // Canonical. Edges that the region has on both sides are on none.
  FaceRings rings;
};

struct FlatRegions {
  std::vector<FlatRegion> regions;
  std::size_t too_thick = 0;  // that were not joined for that reason
};

// The regions of more than one face. What a tolerance would make thicker than `most` allows is
// joined where it is exactly flat only. Those whose faces overlap in the plane are left out:
// joining them would hide it. `places` in lexicographic order; `faces` canonical, of rings of three
// corners and more.
FlatRegions FindFlatRegions(const std::vector<geometry::Point3>& places,
                            const std::vector<FaceRings>& faces, const Kept& kept, double tolerance,
                            const Thickness& most);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COPLANAR_REGIONS_H_
