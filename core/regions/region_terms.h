// The rules of regions that a mutation test can switch off (base/mutation.h). The name is what
// holds; the comment, what happens instead.
#ifndef DYNMESH_CORE_REGIONS_REGION_TERMS_H_
#define DYNMESH_CORE_REGIONS_REGION_TERMS_H_

#include "core/base/mutation.h"

namespace dynmesh {

enum class RegionTerm {
  // Labels of simplices.
  kWallsSeparate,        // an update carries labels across walls
  kWallsSeparateAll,     // LabelAll does
  kFlipsPropagate,       // simplices that stay keep their labels though a wall changed
  kWallEndsAreSearched,  // changed walls settle nothing where no simplex is new
  kTwiceIsOutside,       // a changed wall that a ray crosses twice counts
  kHolesAreOutside,      // a hole is filled: edges toggle no polygon that is there
  // Closed surfaces.
  kHolesOfWalls,        // a ray crosses the hole of a wall
  kOpenIsPeeled,        // a polygon with a free edge belongs to a surface
  kApartIsNone,         // so does one that falls apart
  kCrowdedIsSearched,   // surfaces that share an edge are one
  kChambersHaveVolume,  // the outside is a chamber
  kOthersFollow,        // polygons that an edit of others makes part of a surface are no wall
  kCount,
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_REGIONS_REGION_TERMS_H_
