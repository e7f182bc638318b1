// The terms of the notification filters: each is a reason why a change makes an operation stale.
// With any of them switched off (base/mutation.h) the differential tests must fail.
#ifndef DYNMESH_CORE_MESHING_FILTER_TERMS_H_
#define DYNMESH_CORE_MESHING_FILTER_TERMS_H_

#include "core/base/mutation.h"

namespace dynmesh::meshing {

enum class FilterTerm {
  kAppearsInCorner,       // a vertex appears inside a ball that a Complete read
  kVanishesFromRing,      // a neighbour that a Complete read vanishes
  kAppearsNearer,         // a vertex appears nearer than the nearest
  kNearestVanishes,       // the nearest vertex vanishes
  kAppearsInBall,         // a vertex appears in a clean subsegment's ball
  kWitnessVanishes,       // the vertex that encroached vanishes
  kOverSteinerPoint,      // a subsegment with an inserted point in its ball changes
  kOverYieldedCandidate,  // ... or may hold a candidate that yielded
  kOverMidpoint,          // ... or holds the midpoint that a split made
  kDeathOfSubsegment,     // a subsegment dies earlier or later than before
  kOverSize,              // a sizing region comes or goes that a ball read is too large for
  kFeatureTooNear,        // a point or segment comes too near to a subsegment
  kFeatureNearer,         // ... or nearer than the nearest such feature
  kTooNearVanishes,       // the nearest such feature vanishes
  kOverFacet,             // a facet comes or goes that meets the balls read
  kNearCure,              // a vertex appears or vanishes in the balls that a Cure read
  kCount,
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FILTER_TERMS_H_
