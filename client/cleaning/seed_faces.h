// Faces of the planar straight-line graph of segments, and point location in them. Converts holes
// and regions that a file marks by one inner point (seed) into polygons.
//
// The segments must not cross or overlap; otherwise the result is some rings along them. Exact
// decisions. Pure, thread-safe. O(n lg n + c n + k n) for n segments in c connected parts and k
// seeds.
#ifndef DYNMESH_CLIENT_CLEANING_SEED_FACES_H_
#define DYNMESH_CLIENT_CLEANING_SEED_FACES_H_

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "client/cleaning/node_table.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

struct SeedFace {
  // The boundary: edges with the face on exactly one side, cut into rings that pass no point twice.
  // Each starts at the point that the earliest segment of the input names first. Empty if the seed
  // is in the unbounded face, in the face of an earlier seed, or on a segment.
  Rings rings;
  std::optional<std::size_t> same_as;  // the first seed in this face, unless it is this one
  FeatureId on = kNoFeature;           // the segment through the seed
};

// One result per seed. Ignores features that are neither points nor segments, and segments of
// length 0 or with unknown ends.
std::vector<SeedFace> FindSeedFaces(const std::vector<Feature>& features,
                                    std::span<const Point> seeds);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_SEED_FACES_H_
