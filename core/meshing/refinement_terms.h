// The rules of refinement that a mutation test can switch off (base/mutation.h): gaps, yielding,
// segments, facets, cures. The name is what holds; the comment, what happens instead.
#ifndef DYNMESH_CORE_MESHING_REFINEMENT_TERMS_H_
#define DYNMESH_CORE_MESHING_REFINEMENT_TERMS_H_

#include "core/base/mutation.h"

namespace dynmesh::meshing {

enum class RefinementTerm {
  // Gaps of edges.
  kSlackIsTiny,        // the quality test has a slack of 1 %
  kYoungerOwns,        // the older end of an edge deals with its gaps
  kOlderDoesNot,       // both ends do
  kBothSides,          // only one side of an edge is tested
  kLeftFirst,          // the right side comes first
  kNearerCenter,       // an off-center even if the circumcenter is nearer
  kOffCenter,          // a circumcenter even if the off-center is nearer
  kPointFits,          // a gap counts even if its point would not lie on the Voronoi edge
  kShorterFirst,       // edges of later buckets are treated, too
  kShortestFirst,      // a star's gaps are filled in the order of its neighbours
  kTiesByPosition,     // ... which decides only between edges of equal length
  kMostClearance,      // 3D: the first direction with room
  kSeditiousIsExempt,  // edges as short as a small input angle makes them count
  kSizesCount,         // triangles too large for a sizing region have no gap
  kOrderByHash,        // operations of one epoch are in the order of indices
  // Yielding.
  kYields,           // a point that encroaches is inserted all the same
  kRunsAgain,        // a vertex that yielded does not run again
  kGuardEnds,        // the termination guard is ignored
  kSurfaceCounts,    // a point on the surface of a ball does not encroach
  kSurfaceRechecks,  // ... or splits the subsegment at once
  kUnsplitKeepsOut,  // a point that encroaches on an unsplit segment is a limit that is hit
  kAnchorsKeepOut,   // anchors lie in the balls of such segments
  // Segments.
  kInsideSplits,     // a vertex inside the ball does not split the subsegment
  kHidingSplits,     // vertices on the surface that hide it do not
  kCascades,         // a split does not split what its vertex encroaches on
  kDepthEnds,        // subsegments are split more often than max_depth
  kSharpOnShells,    // segments at a sharp angle are halved
  kSkewedShells,     // 3D: vertices are on their shells exactly
  kNearSplits,       // features near a segment do not split it beforehand
  kNearFacetSplits,  // facets do not
  kTooLongSplits,    // sizing regions do not
  // Facets.
  kFacetsCovered,    // a cell may meet a facet
  kTouchingIsNoCut,  // a cell that touches a facet gets a point there
  kFacetIsNear,      // the distance from a vertex to a facet is not counted
  // Cures.
  kCureKeepsQuality,   // tetrahedra around the point may be over rho
  kCureKeepsAngles,    // ... or have a small dihedral angle
  kCureKeepsFacets,    // a facet may be broken
  kCureKeepsSegments,  // a subsegment may be encroached on
  kExemptAreCured,     // slivers at small angles of the input stay
  kFacetsEnclose,      // facets enclose nothing, if only what they enclose counts
  kCount,
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_REFINEMENT_TERMS_H_
