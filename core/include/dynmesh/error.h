// Machine-readable detail of an error status: the reason, the features and the edit to blame.
//
//   if (auto detail = dynmesh::GetErrorDetail(diff.status())) {
//     if (detail->reason == dynmesh::reason::kPointInUse) Remove(detail->features);
//   }
#ifndef DYNMESH_ERROR_H_
#define DYNMESH_ERROR_H_

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/feature.h"

namespace dynmesh {

// Reasons, as in google.rpc.ErrorInfo: UPPER_SNAKE, stable. The status code of each:
//   * INVALID_ARGUMENT: NOT_FINITE, OUTSIDE_BOX, BAD_ID, WRONG_KIND, DEGENERATE_SEGMENT,
//     BAD_POLYGON, BAD_SIZE, BAD_LABEL, BAD_OPTION, and TOO_CLOSE of a coordinate that is not 0 but
//     below 2^-200
//   * NOT_FOUND: UNKNOWN_FEATURE
//   * ALREADY_EXISTS: ID_IN_USE
//   * FAILED_PRECONDITION: UNKNOWN_END, POINT_IN_USE, DUPLICATE_POINT, DUPLICATE_SEGMENT,
//     DUPLICATE_POLYGON, POINT_ON_SEGMENT, POINT_ON_POLYGON, SEGMENTS_CROSS, SEGMENTS_OVERLAP,
//     SEGMENT_MEETS_POLYGON, POLYGONS_MEET, NON_PLANAR, QUALITY_TOO_LOW, SMALL_INPUT_ANGLE,
//     ID_COLLISION, and TOO_CLOSE of two features
//   * RESOURCE_EXHAUSTED: VERTEX_LIMIT, POLYGON_LIMIT, SIZE_LIMIT, DEPTH_LIMIT, WORK_LIMIT
//   * CANCELLED: CANCELLED
namespace reason {
inline constexpr char kNotFinite[] = "NOT_FINITE";    // a coordinate is infinite or NaN
inline constexpr char kOutsideBox[] = "OUTSIDE_BOX";  // a position outside MeshOptions::box
inline constexpr char kBadId[] = "BAD_ID";            // 0, reserved, or too large for a polygon
inline constexpr char kIdInUse[] = "ID_IN_USE";       // an edit adds a present id
// Two vertices, or two sets of polygons, would have the same id, which is a hash (mesh.h).
inline constexpr char kIdCollision[] = "ID_COLLISION";
inline constexpr char kUnknownFeature[] = "UNKNOWN_FEATURE";  // set, remove or move of an absent id
inline constexpr char kUnknownEnd[] = "UNKNOWN_END";  // an end or corner is not a point present
inline constexpr char kDegenerateSegment[] = "DEGENERATE_SEGMENT";  // both ends are the same point
inline constexpr char kPointInUse[] = "POINT_IN_USE";  // removed, but another feature needs it
inline constexpr char kDuplicatePoint[] = "DUPLICATE_POINT";      // two at one position
inline constexpr char kDuplicateSegment[] = "DUPLICATE_SEGMENT";  // two segments have the same ends
inline constexpr char kPointOnSegment[] = "POINT_ON_SEGMENT";     // in the segment, not at an end
inline constexpr char kSegmentsCross[] = "SEGMENTS_CROSS";        // at a position that is no point
inline constexpr char kSegmentsOverlap[] = "SEGMENTS_OVERLAP";    // in more than a point
inline constexpr char kQualityTooLow[] = "QUALITY_TOO_LOW";       // 3D: the mesh's, for polygons
inline constexpr char kNonPlanar[] = "NON_PLANAR";  // 3D: a corner is off the plane of the others
inline constexpr char kDuplicatePolygon[] = "DUPLICATE_POLYGON";  // 3D: two have the same edges
inline constexpr char kPointOnPolygon[] = "POINT_ON_POLYGON";     // 3D: in its inside
inline constexpr char kSegmentMeetsPolygon[] = "SEGMENT_MEETS_POLYGON";  // 3D: in its inside
inline constexpr char kPolygonsMeet[] = "POLYGONS_MEET";                 // 3D: their insides meet
inline constexpr char kSmallAngle[] = "SMALL_INPUT_ANGLE";  // between segments, in 3D also facets
inline constexpr char kTooClose[] = "TOO_CLOSE";            // nearer than the mesh's least distance
// 2D: in, or through, the circle over an edge that must stay whole (Feature::unsplit).
inline constexpr char kEncroached[] = "ENCROACHED";
inline constexpr char kBadUnsplit[] = "BAD_UNSPLIT";      // Feature::unsplit where it may not be
inline constexpr char kBadSize[] = "BAD_SIZE";            // shape or target of a sizing feature
inline constexpr char kBadLabel[] = "BAD_LABEL";          // the name of a label (label.h)
inline constexpr char kBadPolygon[] = "BAD_POLYGON";      // rings are empty or repeat
inline constexpr char kWrongKind[] = "WRONG_KIND";        // move of a segment, or an unknown kind
inline constexpr char kVertexLimit[] = "VERTEX_LIMIT";    // Limits::max_vertices
inline constexpr char kPolygonLimit[] = "POLYGON_LIMIT";  // too many at a position (mesh.h)
inline constexpr char kSizeLimit[] = "SIZE_LIMIT";  // more than indices can distinguish (options.h)
inline constexpr char kDepthLimit[] = "DEPTH_LIMIT";  // Limits::max_depth
inline constexpr char kWorkLimit[] = "WORK_LIMIT";    // ApplyOptions::max_operations
inline constexpr char kCancelled[] = "CANCELLED";     // by ApplyOptions::interrupted
inline constexpr char kBadOption[] = "BAD_OPTION";    // a field of MeshOptions
}  // namespace reason

// What a program can act on.
struct ErrorDetail {
  std::string reason;               // one of reason::k*
  std::vector<FeatureId> features;  // those involved, the one to blame first
  std::optional<std::size_t> edit;  // index in the batch of the edit to blame, if any
  friend bool operator==(const ErrorDetail&, const ErrorDetail&) = default;
};

// A status of `code` (not OK) with `detail` attached. The `message` says what to do.
absl::Status MakeError(absl::StatusCode code, std::string message, ErrorDetail detail);

// The detail of a `status` made by MakeError; nothing for any other status.
std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status);

}  // namespace dynmesh

#endif  // DYNMESH_ERROR_H_
