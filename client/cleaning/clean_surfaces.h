// Cleans 3D surfaces until their faces meet in common corners and edges only: merges points that
// nearly coincide, splits edges and faces at points nearly on them and where they cross, joins
// faces where they overlap, drops what has no area or is there twice, and cuts faces that are not
// flat into triangles. Repeats this until nothing changes. Orientations do not matter.
//
// Faces are triangles while they are cleaned. A polygon of more corners whose triangles nothing has
// changed is a polygon again in the end; of any other, the parts are triangles.
//
// With T the tolerance, in the result any two points are at least T apart; no point is nearer than
// T / 4 to an edge or a face that does not end there; edges that do not meet are T / 2 apart;
// no two edges cross, no edge passes through a face, and no two faces overlap. Each single change
// moves points, edges and faces by less than T. A result that is cleaned again is not changed.
// Angles are as small as the input makes them, or as `least_angle` says. With a length to contract
// changes may be as large as that is.
//
// Where repairs undo each other, at places some tolerances apart, all is done anew with T doubled,
// a few times; then with T doubled near these places only; if that is no help, everywhere.
//
// The result's coordinates and adjacency are functions of the input's, independent of ids, their
// order and orientations. Ids depend on ids; where faces overlap, the part is of that with the
// least id. Pure, thread-safe.
//
// Expected O(n lg n) per round for n features and their intersections; in practice a few rounds.
#ifndef DYNMESH_CLIENT_CLEANING_CLEAN_SURFACES_H_
#define DYNMESH_CLIENT_CLEANING_CLEAN_SURFACES_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// The default tolerance, in units of the distance below which a mesh refuses features as too close.
// Cleaning keeps a fourth of the tolerance from faces.
inline constexpr double kDefaultSurfaceLimits = 8;

struct SurfaceCleanOptions {
  double tolerance = 0;  // T, in the input's units; positive, at most 2^140
  int max_rounds = 100;  // for each tolerance
  // In degrees, 0 to 1: edges that meet in a corner at a lesser angle become one, and so do an edge
  // and a face that it leads over, however far apart their ends are.
  double least_angle = 0;
  // Where needles cross, cutting them may make ever more of them. If this is not 0, edges of faces
  // that are as thin as that become a point, up to this length, and edges cross only when they go
  // through all points on them.
  double most_contraction = 0;
  int max_doublings = 12;                 // of the tolerance, at any place
  int first_doublings = 3;                // of it everywhere, before it is doubled at some places
  std::size_t max_crossings = 8'000'000;  // in one round; bounds the memory
  // In all rounds, with all tolerances; 0: kLeastSteps, or kStepsForFeature for each feature if
  // that is more. A step takes about a microsecond (effort.h).
  std::uint64_t max_steps = 0;
  bool holes = true;  // polygons may keep several rings; else they become triangles
};

inline constexpr std::uint64_t kLeastSteps = 5'000'000, kStepsForFeature = 500;
// Of `max_steps`, for so many features.
std::uint64_t DefaultSteps(std::size_t features);

enum class SurfaceChangeKind : std::uint8_t {
  kPointMerged,       // point ids[0], at `from`, became point ids[1], at `to`
  kPointRounded,      // point ids[0] had a coordinate too near to 0; `to` has 0
  kFaceTriangulated,  // face ids[0], with a corner at `from`, is not flat, or crosses itself
  // Below, edges are those of segment or face ids[0], the least one of several.
  kEdgeSplit,     // the edge ids[0], near `from`, goes through point ids[1], at `to`
  kFaceSplit,     // face ids[0], near `from`, goes through point ids[1], at `to`
  kEdgesCrossed,  // edges of ids[0] and ids[1] crossed at `from`; point ids[2], at `to`, joins them
  kFaceCrossed,   // an edge of ids[0] passed through face ids[1] at `from`: point ids[2], at `to`
  kFaceDoubled,   // the part of face ids[0] with corners `from` and `to` is also one of ids[1]
  kFaceDropped,   // face ids[0], which had a corner at `from`, has no area left
  kSegmentDoubled,  // the part `from` - `to` of segment ids[0] is also one of ids[1]
  kSegmentDropped,  // segment ids[0], which began at `from`, has no length left
  // Of KeepFeatureEdges (feature_edges.h):
  kPointDropped,  // faces around point ids[0], at `from` and `to`, became larger ones without it
};
inline constexpr int kSurfaceChangeKinds = 12;

// "point merged", "faces crossed": for messages and JSON values.
const char* NameOf(SurfaceChangeKind kind);

struct SurfaceChange {
  SurfaceChangeKind kind = SurfaceChangeKind::kPointMerged;
  // The input's ids. Points made at crossings have ids above all of the input's.
  std::vector<FeatureId> ids;
  std::array<double, 3> from{};
  std::array<double, 3> to{};
};

struct SurfaceCleanResult {
  // Points, then segments, then polygons, each in the order of the input, then all others. New
  // points are last among points; parts of a segment or face follow the first part, which keeps the
  // id. A point that does not move keeps its id. Corners that no face has any more are dropped;
  // points that never were corners, or ends, stay.
  std::vector<Feature> features;
  // Of each part with a new id: the segment or face that it is a part of. By new ids, ascending.
  std::vector<std::pair<FeatureId, FeatureId>> parts;
  // Faces that an even number of the input's faces became: of closed surfaces they enclose nothing.
  std::vector<FeatureId> doubled;
  std::vector<SurfaceChange> changes;
  int rounds = 0;
  double tolerance = 0;  // that it took
};

// INVALID_ARGUMENT, with ErrorDetail (dynmesh/error.h), for ids that are not unique, for ends and
// corners that are no points, for coordinates that are not finite or above 2^140 in magnitude;
// INVALID_ARGUMENT for a tolerance below 2^-41 of the largest coordinate. RESOURCE_EXHAUSTED, with
// the remaining faults in the message, past a limit of `options`.
absl::StatusOr<SurfaceCleanResult> CleanSurfaces(const std::vector<Feature>& features,
                                                 const SurfaceCleanOptions& options);

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_CLEAN_SURFACES_H_
