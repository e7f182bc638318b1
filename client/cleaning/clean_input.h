// Cleans 2D input until a mesh accepts it: merges points that nearly coincide, splits segments at
// points nearly on them and at crossings, drops segments of length 0 and duplicates, and merges
// segments that meet at too small an angle. Repeats this until nothing changes.
//
// Edges of polygons are processed like segments, and rings follow: a split edge becomes the chain
// of its parts, an edge that a polygon uses an even number of times is dropped, and a ring that
// passes a point twice is cut there. So the inside of a polygon stays the inside, except as close
// to its edges as these move. A polygon without any ring left is dropped. Edges of polygons do not
// become segment features; segments on them stay. Sizing polygons follow their points; their edges
// may cross anything.
//
// With T the tolerance, in the result any two points are at least T apart, no point is nearer than
// T / 2 to a segment that does not end there, no two segments cross or overlap, and segments with a
// common end meet at 0.001 degrees or more. Each single change moves points and segments by less
// than T, except segments at a small angle: those move by up to 2e-5 times the length of the
// shorter one. Input that satisfies this already is not changed.
//
// The result's coordinates and adjacency are functions of the input's, independent of ids and their
// order. Which ids merged features keep depends on the ids alone. Pure, thread-safe.
//
// Expected O(n lg n) per round for n features and their intersections; in practice a few rounds.
// See round.h for why they end.
#ifndef DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_
#define DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// The default tolerance, in units of the distance below which a mesh refuses features as too close.
// Cleaning keeps half the tolerance from a segment: so this leaves a factor of 2 for rounding and a
// smaller box.
inline constexpr double kDefaultCloseLimits = 4;

struct CleanOptions {
  double tolerance = 0;  // T, in the input's units; positive, at most 2^200
  int max_rounds = 1000;
  std::size_t max_crossings = 4'000'000;  // in one round; bounds the memory
};

enum class ChangeKind : std::uint8_t {
  kPointMerged,   // point ids[0], at `from`, became point ids[1], at `to`
  kPointRounded,  // point ids[0] had a coordinate too near to 0; `to` has 0
  // Below, segments may be edges of polygons: then the id is the polygon's, the least one of
  // several.
  kSegmentSplit,     // segment ids[0], near `from`, goes through point ids[1], at `to`
  kSegmentsCrossed,  // segments ids[0], ids[1] crossed at `from`; point ids[2], at `to`, joins them
  kSmallAngle,       // segment ids[0] goes through point ids[2], the far end of ids[1]
  kZeroLength,       // the ends of segment ids[0] are one point, at `to`
  kDoubled,         // the part `from` - `to` of segment ids[0] is also one of ids[1]; segments only
  kCancelled,       // polygon ids[0] had the part `from` - `to` twice, and has neither
  kRingCut,         // changed rings of polygon ids[0] go through point ids[1] twice: cut there
  kPolygonDropped,  // polygon ids[0], which began at `from`, has no ring left
};
inline constexpr int kChangeKinds = 10;

// "point merged", "segments crossed": for messages and JSON values.
const char* NameOf(ChangeKind kind);

struct Change {
  ChangeKind kind = ChangeKind::kPointMerged;
  // The input's ids. Points made at crossings have ids above all of the input's.
  std::vector<FeatureId> ids;
  std::array<double, 2> from{};
  std::array<double, 2> to{};
};

struct CleanResult {
  // Points, then segments, then all others, each in the order of the input. New segments follow the
  // segment of which they are a part; new points are last. Ids: a point that does not move keeps
  // its id; the first part of a segment keeps the segment's id. Unchanged rings of a polygon stay
  // as they were. If nothing was changed: the input's features.
  std::vector<Feature> features;
  std::vector<Change> changes;
  int rounds = 0;
};

// INVALID_ARGUMENT, with ErrorDetail (dynmesh/error.h), for ids that are not unique, for ends and
// corners that are no points, for coordinates that are not finite or above 2^200 in magnitude;
// INVALID_ARGUMENT for a tolerance below 2^-41 of the largest coordinate. RESOURCE_EXHAUSTED, with
// the remaining faults in the message, past a limit of `options`.
absl::StatusOr<CleanResult> CleanInput(const std::vector<Feature>& features,
                                       const CleanOptions& options);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_
