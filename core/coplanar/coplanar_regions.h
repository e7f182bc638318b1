// Finds connected coplanar faces, and the rings around them: the algorithm of merge_coplanar.h.
//
// Two faces are joined across an edge if:
//   * they and no others have the edge;
//   * they lie on either side of it and in the plane of the region's largest face;
//   * the region's inside then contains no edge or corner at which a face of another plane, or a
//     `Kept` item, ends, and no edge over which a segment leans.
// A face that would enclose such an item, in any order of growth, is left out. So a region is flat
// as a whole, however many small steps its faces make. Regions grow from the largest face down;
// coordinates break ties. The result does not depend on the order of faces and corners.
//
// Pure, thread-safe. O(n lg n) for n corners. With a tolerance, faces at the border of several
// regions are checked several times.
#ifndef DYNMESH_CORE_COPLANAR_COPLANAR_REGIONS_H_
#define DYNMESH_CORE_COPLANAR_COPLANAR_REGIONS_H_

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

// The index of a position in the lexicographic order of all positions: the order of corners is that
// of coordinates.
using Corner = std::uint32_t;
using CornerRing = std::vector<Corner>;
using FaceRings = std::vector<CornerRing>;
using CornerPair = std::pair<Corner, Corner>;  // first < second

// Each ring starts at its least corner and goes to the lesser neighbour; the rings are sorted.
FaceRings Canonical(FaceRings rings);

// Edges and corners that are needed for other reasons than faces.
struct Kept {
  std::vector<CornerPair> edges;  // segments, ascending
  std::vector<bool> corners;      // by corner: an end of such an edge or of another feature
};

// The allowed thickness of a region joined with a tolerance, as a function of its extent along the
// axes.
using Thickness = std::function<double(double extent)>;

struct FlatRegion {
  std::vector<std::size_t> faces;  // two or more
  // Canonical. Edges with the region on both sides are in none.
  FaceRings rings;
};

struct FlatRegions {
  std::vector<FlatRegion> regions;
  std::size_t too_thick = 0;  // regions not joined for that reason
};

// The regions of more than one face. A region that the tolerance would make thicker than `most` is
// joined only where it is exactly flat. Regions with overlapping faces are left out: joining would
// hide the overlap. REQUIRES: `positions` are in lexicographic order; `faces` are canonical, with
// rings of at least three corners.
FlatRegions FindFlatRegions(const std::vector<geometry::Point3>& positions,
                            const std::vector<FaceRings>& faces, const Kept& kept, double tolerance,
                            const Thickness& most);

// The same for positions that were rounded by up to `roundings`, along each axis. A region has all
// its corners within kBand roundings of its own plane, that of least squares. It grows from its
// largest face in turns, each with the plane of what there is. Faces that `stay` are in none; those
// of a region are of one group. Each face is a ring, which may be empty: then it stays.
inline constexpr double kBand = 4;
std::vector<FlatRegion> FindRoundedRegions(const std::vector<geometry::Point3>& positions,
                                           const std::vector<geometry::Vector3>& roundings,
                                           const std::vector<CornerRing>& faces, const Kept& kept,
                                           const std::vector<std::size_t>& groups,
                                           const std::vector<bool>& stay);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_COPLANAR_REGIONS_H_
