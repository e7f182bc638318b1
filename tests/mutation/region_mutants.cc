// Mutants of regions and limits, noticed by the oracles of regions and by tests of limits.
#include "core/dynamic_mesh/limit_terms.h"
#include "core/regions/region_terms.h"
#include "tests/mutation/mutants.h"

namespace dynmesh::test {

std::span<const Mutant> Mutants() {
#define L(NAME, TESTS) DYNMESH_MUTANT(LimitTerm, NAME, TESTS)
#define R(NAME, TESTS) DYNMESH_MUTANT(RegionTerm, NAME, TESTS)
  static const Mutant kAll[] = {
      R(kWallsSeparate, "RegionLabels.AreThoseOfEveryPlace*"),
      R(kWallsSeparateAll, "SpaceRegions.OfBoxesThatShare*"),
      R(kFlipsPropagate, "RegionLabels.AreThoseOfEveryPlace*"),
      R(kWallEndsAreSearched, "RegionLabels.AreThoseOfEveryPlace*"),
      R(kTwiceIsOutside, "RegionLabels.AreThoseOfEveryPlace*"),
      R(kHolesAreOutside, "RegionLabels.AreThoseOfEveryPlace*"),
      R(kHolesOfWalls, "Wall.*"),
      R(kOpenIsPeeled, "SurfaceTable.*"),
      R(kApartIsNone, "SurfaceTable.*"),
      R(kCrowdedIsSearched, "SurfaceTable.*"),
      R(kChambersHaveVolume, "SurfaceTable.*"),
      R(kOthersFollow, "SpaceRegions.ComeWithTheLastFace*"),
      L(kVerticesEnd, "Limit/*.OfVertices*"),
      L(kDepthRefuses, "Limit/*.OfDepth*"),
  };
#undef R
#undef L
  return kAll;
}

}  // namespace dynmesh::test
