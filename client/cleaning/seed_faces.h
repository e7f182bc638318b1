// Faces of the straight-line graph that segments form, and which of them a place lies in: so a
// hole or a region that a file marks by one point inside becomes a polygon.
//
// The segments must not cross or overlap; if they do, what comes back is some rings along
// them. Decided exactly. Pure, thread-safe. O(n lg n + c n + k n) for n segments in c connected
// parts and k seeds.
#ifndef DYNMESH_CLIENT_CLEANING_SEED_FACES_H_
#define DYNMESH_CLIENT_CLEANING_SEED_FACES_H_

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "client/cleaning/point_places.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

struct SeedFace {
  // The boundary: edges that have the face on one side only, cut into rings that go through no
  // point twice; each starts at the point that a segment of the input names first. Empty if the
  // seed is in the unbounded face, in that of a seed before it, or on a segment.
  Rings rings;
  std::optional<std::size_t> same_as;  // the first seed in this face, if it is another
  FeatureId on = kNoFeature;           // the segment that the seed is on
};

// One for each seed. Features that are no points or segments do not count, nor do segments
// without length or known ends.
std::vector<SeedFace> FindSeedFaces(const std::vector<Feature>& features,
                                    std::span<const Point> seeds);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SEED_FACES_H_
