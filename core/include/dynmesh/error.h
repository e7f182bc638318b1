// Machine-readable detail of an error status: which features, and why.
#ifndef DYNMESH_ERROR_H_
#define DYNMESH_ERROR_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh {

// Reasons, as they stand in google.rpc.ErrorInfo. UPPER_SNAKE, stable.
namespace reason {
inline constexpr char kNotFinite[] = "NOT_FINITE";    // a coordinate is infinite or no number
inline constexpr char kOutsideBox[] = "OUTSIDE_BOX";  // a place outside of MeshOptions::box
inline constexpr char kBadId[] = "BAD_ID";            // 0, reserved, not of a polygon
inline constexpr char kIdInUse[] = "ID_IN_USE";       // add of a present id
// Vertices or sets of polygons would have the same id, a hash (mesh.h).
inline constexpr char kIdCollision[] = "ID_COLLISION";
inline constexpr char kUnknownFeature[] = "UNKNOWN_FEATURE";  // set, remove, move of an absent id
inline constexpr char kUnknownEnd[] = "UNKNOWN_END";  // an end or corner is no point present
inline constexpr char kDegenerateSegment[] = "DEGENERATE_SEGMENT";  // both ends the same point
inline constexpr char kPointInUse[] = "POINT_IN_USE";         // removed, another feature needs it
inline constexpr char kDuplicatePoint[] = "DUPLICATE_POINT";  // two at one place
inline constexpr char kDuplicateSegment[] = "DUPLICATE_SEGMENT";  // two with the same ends
inline constexpr char kPointOnSegment[] = "POINT_ON_SEGMENT";     // not one of its ends
inline constexpr char kSegmentsCross[] = "SEGMENTS_CROSS";        // where no point is
inline constexpr char kSegmentsOverlap[] = "SEGMENTS_OVERLAP";    // on more than a point
inline constexpr char kQualityTooLow[] = "QUALITY_TOO_LOW";  // the mesh's, for polygons in space
inline constexpr char kNonPlanar[] = "NON_PLANAR";  // in space: a corner off the others' plane
inline constexpr char kDuplicatePolygon[] = "DUPLICATE_POLYGON";         // in space: the same twice
inline constexpr char kPointOnPolygon[] = "POINT_ON_POLYGON";            // in space: in its inside
inline constexpr char kSegmentMeetsPolygon[] = "SEGMENT_MEETS_POLYGON";  // in space: its inside
inline constexpr char kPolygonsMeet[] = "POLYGONS_MEET";                 // in space: their insides
inline constexpr char kSmallAngle[] = "SMALL_INPUT_ANGLE";  // in space: of segments or facets
inline constexpr char kTooClose[] = "TOO_CLOSE";      // nearer than the least distance in this mesh
inline constexpr char kBadSize[] = "BAD_SIZE";        // a sizing feature's shape or target
inline constexpr char kBadPolygon[] = "BAD_POLYGON";  // rings that enclose nothing or repeat
inline constexpr char kWrongKind[] = "WRONG_KIND";    // move of a segment, unknown kind
inline constexpr char kVertexLimit[] = "VERTEX_LIMIT";    // Limits::max_vertices
inline constexpr char kPolygonLimit[] = "POLYGON_LIMIT";  // a place in too many (mesh.h)
inline constexpr char kSizeLimit[] = "SIZE_LIMIT";    // more than indices tell apart (options.h)
inline constexpr char kDepthLimit[] = "DEPTH_LIMIT";  // Limits::max_depth
inline constexpr char kWorkLimit[] = "WORK_LIMIT";    // more operations than the batch may execute
inline constexpr char kCancelled[] = "CANCELLED";     // by ApplyOptions::cancelled or stopped
inline constexpr char kBadOption[] = "BAD_OPTION";    // of MeshOptions
}  // namespace reason

// What a program can act on.
struct ErrorDetail {
  std::string reason;               // one of reason::k*
  std::vector<FeatureId> features;  // those involved, the offender first
  std::optional<std::size_t> edit;  // index in the batch of the edit to blame, if one is
  friend bool operator==(const ErrorDetail&, const ErrorDetail&) = default;
};

// A status of `code`, which is not OK, with `detail` attached. The `message` says what to do.
absl::Status MakeError(absl::StatusCode code, std::string message, ErrorDetail detail);

// The detail of a `status` made by MakeError, else nothing.
std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status);

}  // namespace dynmesh

#endif  // DYNMESH_ERROR_H_
