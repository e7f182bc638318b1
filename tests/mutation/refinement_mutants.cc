// Mutants of refinement. Oracles, in this order of preference: exact quality and input of whole
// meshes (MeshQuality), the judge (PolygonHistory), runs from scratch (History), the tests of a
// rule or of a part of the mesher, and recorded bits (Golden), for rules that choose one of several
// good meshes.
#include "core/meshing/refinement_terms.h"
#include "tests/mutation/mutants.h"

namespace dynmesh::test {
namespace {

using meshing::RefinementTerm;

constexpr char kSegments[] =
    "All/MeshQuality.*/SegmentsAxisRho2:All/MeshQuality.*/DiagonalsRho2:"
    "All/MeshQuality.*/WedgesRho2:All/MeshQuality.*/DiagonalsThesisRhoSqrt2";
constexpr char kSolids[] =
    "Cases/Golden.*/solids_NestedBoxes_rho2:Cases/Golden.*/solids_Plates_rho2";
constexpr char kCures[] = "Cases/Golden.*/TurnedGridEdges_rho2_cured10";

}  // namespace

std::span<const Mutant> Mutants() {
#define R(NAME, TESTS) DYNMESH_MUTANT(RefinementTerm, NAME, TESTS)
  static const Mutant kAll[] = {
      R(kSlackIsTiny, "All/MeshQuality.*/UniformRho2"),
      R(kYoungerOwns, "All/MeshQuality.*/UniformRho2"),
      R(kOlderDoesNot, "CriteriaTest/*"),
      R(kBothSides, "All/MeshQuality.*/UniformRho2"),
      R(kLeftFirst, "Cases/Golden.*/Uniform_rho1p414"),
      R(kNearerCenter, "All/MeshQuality.*/UniformRho1"),
      R(kOffCenter, "All/MeshQuality.*/TwoScaleRho1"),
      R(kPointFits, "Rules.BeginsBeyond*"),
      R(kShorterFirst, "CriteriaTest/*"),
      R(kShortestFirst, "Cases/Golden.*/Uniform_rho1p414"),
      R(kTiesByPosition, "All/History.*/UniformRho1"),
      R(kMostClearance, "Cases/Golden.*/SpaceUniform_rho2"),
      R(kSeditiousIsExempt, "All/MeshQuality.*/WedgesRho2"),
      R(kSizesCount, "All/MeshQuality.*/SizedRho2"),
      R(kOrderByHash, "All/History.*/UniformRho1"),
      R(kYields, kSegments),
      R(kRunsAgain, kSegments),
      R(kGuardEnds, "TerminationGuard.StarsAroundAPoint"),
      R(kSurfaceCounts, kSegments),
      R(kSurfaceRechecks, "EncroachmentTest/*"),
      R(kUnsplitKeepsOut, "Unsplit.*"),
      R(kAnchorsKeepOut, "Unsplit.*"),
      R(kInsideSplits, kSegments),
      R(kHidingSplits, kSegments),
      R(kCascades, kSegments),
      R(kDepthEnds, "Limit/*.OfDepth*"),
      R(kSharpOnShells, kSegments),
      R(kSkewedShells, "Dihedral.ShellsOfOneFacet*"),
      R(kNearSplits, "PresplitRulesTest/*"),
      R(kNearFacetSplits, "PresplitRules.*"),
      R(kTooLongSplits, "PresplitRulesTest/*"),
      R(kFacetsCovered, "SpaceFacets.AreCovered*"),
      R(kTouchingIsNoCut, kSolids),
      R(kFacetIsNear, kSolids),
      R(kCureKeepsQuality, "All/PolygonHistory.*/MixtureCured10"),
      R(kCureKeepsAngles, "Dihedral.NoTetrahedron*"),
      R(kCureKeepsFacets, "All/PolygonHistory.*/MixtureCured10"),
      R(kCureKeepsSegments, kCures),
      R(kExemptAreCured, "Dihedral.SliversAtSmallAngles*"),
      R(kFacetsEnclose, "OnlyInside.NoSliverStaysInside"),
  };
#undef R
  return kAll;
}

}  // namespace dynmesh::test
