// Mutants of validation, noticed by the oracles of core/plc and by its refusals.
#include "core/plc/validation_terms.h"
#include "tests/mutation/mutants.h"

namespace dynmesh::test {

using plc::ValidationTerm;

std::span<const Mutant> Mutants() {
#define V(NAME, TESTS) DYNMESH_MUTANT(ValidationTerm, NAME, TESTS)
  static const Mutant kAll[] = {
      V(kIsFinite, "PlcRefusals.CoordinatesThatAreNotFinite"),
      V(kIsInBox, "PlcRefusals.PointsOutsideTheBox"),
      V(kHasArea, "SpacePlc.PolygonsHaveAnArea"),
      V(kIsPlanar, "SpacePlc.PolygonsAreFlat"),
      V(kRingsAreSimple, "PlcRefusals.Polygons"),
      V(kEndsExist, "PlcRefusals.*"),
      V(kPointsInUseStay, "PlcRefusals.*"),
      V(kQualityAllowsPolygons, "SpacePlc.PolygonsWantAQuality*"),
      V(kSizesAreSound, "PlcRefusals.*"),
      V(kTargetsAreKept, "PlcRefusals.*"),
      V(kPointsApart, "PlcProperty.*NearMisses*"),
      V(kPointOffSegment, "PlcProperty.CoarseGrid*"),
      V(kPointFarFromSegment, "PlcProperty.*NearMisses*"),
      V(kPointFarFromFacet, "SpacePlc.*"),
      V(kSegmentsDoNotCross, "PlcProperty.CoarseGrid*"),
      V(kSegmentsDoNotOverlap, "PlcProperty.CoarseGrid*"),
      V(kSegmentsPassApart, "SpacePlc.*"),
      V(kAngleOfSegments2D, "PlcProperty.*NearMisses*"),
      V(kAngleOfSegments3D, "SpacePlc.*"),
      V(kSegmentNotInFacet, "SpacePlc.*"),
      V(kSegmentNotThroughFacet, "SpacePlc.*"),
      V(kAngleOfSegmentAndFacet, "SpacePlc.*"),
      V(kFacetsDoNotOverlap, "SpacePlc.*"),
      V(kFacetsDoNotMeet, "SpacePlc.*"),
      V(kFacetsDiffer, "SpacePlc.*"),
      V(kAngleOfFacetsAtEdges, "SpacePlc.*"),
      V(kAngleOfFacetsAtCorners, "SpacePlc.*"),
      V(kCirclesAreEmpty, "UnsplitRefusals.*"),
      V(kCirclesKeepEdges, "UnsplitRefusals.OnePointOnTheCircle*"),
      V(kNoneCrossesCircles, "UnsplitRefusals.*"),
      V(kLoadsAreChecked, "PlcProperty.CoarseGrid*"),
      V(kRemovedIsGone, "PlcProperty.CoarseGrid*"),
      V(kSizesNeedFewVertices, "LeastVertices.ManyRegions*"),
      V(kSegmentGapsSmall, "LeastVertices.LinesTooNear*"),
      V(kFacetGapsSmall, "LeastVertices.ThinSlabs*"),
  };
#undef V
  return kAll;
}

}  // namespace dynmesh::test
