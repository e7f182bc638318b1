// The rules of validation that a mutation test can switch off (base/mutation.h). With one switched
// off, input that breaks it is legal.
#ifndef DYNMESH_CORE_PLC_VALIDATION_TERMS_H_
#define DYNMESH_CORE_PLC_VALIDATION_TERMS_H_

#include "core/base/mutation.h"

namespace dynmesh::plc {

enum class ValidationTerm {
  // A feature by itself.
  kIsFinite,
  kIsInBox,
  kHasArea,
  kIsPlanar,
  kRingsAreSimple,
  kEndsExist,
  kPointsInUseStay,
  kQualityAllowsPolygons,
  kSizesAreSound,   // shape and position
  kTargetsAreKept,  // a length that can be kept
  // Two features.
  kPointsApart,
  kPointOffSegment,
  kPointFarFromSegment,
  kPointFarFromFacet,
  kSegmentsDoNotCross,
  kSegmentsDoNotOverlap,
  kSegmentsPassApart,  // 3D
  kAngleOfSegments2D,
  kAngleOfSegments3D,
  kSegmentNotInFacet,
  kSegmentNotThroughFacet,
  kAngleOfSegmentAndFacet,
  kFacetsDoNotOverlap,
  kFacetsDoNotMeet,  // along a line between common corners
  kFacetsDiffer,
  kAngleOfFacetsAtEdges,
  kAngleOfFacetsAtCorners,
  kCirclesAreEmpty,     // 2D: those over unsplit segments, of points
  kCirclesKeepEdges,    // ... also of points on both sides of the circle
  kNoneCrossesCircles,  // ... and of segments that may be split
  // A batch.
  kLoadsAreChecked,       // many points at once are tested for their distances
  kRemovedIsGone,         // what the batch removes is in the way of nothing
  kSizesNeedFewVertices,  // no more vertices are needed than there may be: for regions
  kSegmentGapsSmall,      // ... between segments
  kFacetGapsSmall,        // ... between facets
  kCount,
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_VALIDATION_TERMS_H_
