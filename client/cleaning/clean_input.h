// Makes messy plane input into input that a mesh accepts: merges points that are nearly
// one, splits segments at points that lie nearly on them and where they cross, drops what
// has no length or stands twice, and lays segments on each other that meet at a smaller
// angle than a mesh takes; again and again, until nothing is left to do.
//
// Edges of polygons take part in that like segments, and rings follow: an edge that is split is
// the chain of its pieces, one that a polygon uses an even number of times goes, and where a
// ring comes to a place twice it is cut. So what is inside a polygon stays inside, but for
// places as near to its edges as these move. A polygon without a ring left is dropped. Edges
// of polygons become no segment features; segments on them stay. Sizing polygons follow their
// points; their edges may cross what they like.
//
// With T the tolerance, in the result any two points are at least T apart, no point is
// nearer than T / 2 to a segment that does not end there, no two segments cross or overlap,
// and segments with a common end meet at 0.001 degrees or more. Each single change moves
// points and segments by less than T, but for segments at a small
// angle, where it is up to 2e-5 times the shorter one's length. Input that is like that
// already is not changed.
//
// Coordinates of the result, and who is joined to whom, are functions of the input's:
// neither ids nor their order make a difference. Which ids what is merged keeps depends on
// the ids alone. Pure, thread-safe.
//
// Expected O(n lg n) a round for n features and the places where they meet, a round being
// a handful in practice; see round.h for why they end.
#ifndef DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_
#define DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

struct CleanOptions {
  double tolerance = 0;  // T, in the input's units; positive, at most 2^200
  int max_rounds = 1000;
  std::size_t max_crossings = 4'000'000;  // in one round: a bound on memory
};

enum class ChangeKind : std::uint8_t {
  kPointMerged,   // point ids[0], at `from`, became point ids[1], at `to`
  kPointRounded,  // point ids[0] had a coordinate too near to 0; `to` has 0
  // Segments in what follows are edges of polygons, too: then the id is the polygon's, of
  // several the least.
  kSegmentSplit,     // segment ids[0], near `from`, goes through point ids[1], at `to`
  kSegmentsCrossed,  // segments ids[0], ids[1] crossed at `from`; point ids[2], at `to`, joins them
  kSmallAngle,       // segment ids[0] goes through point ids[2], the far end of ids[1]
  kZeroLength,       // the ends of segment ids[0] are one point, at `to`
  kDoubled,          // the piece `from` - `to` of segment ids[0] is one of ids[1] too; no polygons
  kCancelled,        // polygon ids[0] had the piece `from` - `to` twice, and has neither
  kRingCut,          // changed rings of polygon ids[0] go through point ids[1] twice: cut there
  kPolygonDropped,   // polygon ids[0], which began at `from`, has no ring left
};
inline constexpr int kChangeKinds = 10;

// "point merged", "segments crossed": for messages and as values in JSON.
const char* NameOf(ChangeKind kind);

struct Change {
  ChangeKind kind = ChangeKind::kPointMerged;
  // The input's, but for points that were made where segments cross: these have ids above
  // all of the input's.
  std::vector<FeatureId> ids;
  std::array<double, 2> from{};
  std::array<double, 2> to{};
};

struct CleanResult {
  // Points, then segments, then all others, each by the order of the input; what is new
  // comes after what it is a piece of (segments) or last (points). A point that stays where it is
  // keeps its id; of a segment the first piece does; of a polygon, rings that were not changed
  // are as they were. If nothing was changed: the input's.
  std::vector<Feature> features;
  std::vector<Change> changes;
  int rounds = 0;
};

// INVALID_ARGUMENT, with ErrorDetail (dynmesh/error.h), for ids that are not unique, for ends
// and corners that are no points, for coordinates that are not finite or above 2^200 in magnitude;
// INVALID_ARGUMENT for a tolerance below 2^-41 of the largest coordinate;
// RESOURCE_EXHAUSTED, saying what is left, past a limit of `options`.
absl::StatusOr<CleanResult> CleanInput(const std::vector<Feature>& features,
                                       const CleanOptions& options);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_CLEAN_INPUT_H_
