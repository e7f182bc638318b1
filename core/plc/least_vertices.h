// Lower bounds of the number of vertices that some features cause: known at once, while meshing
// would take minutes to find that there are too many.
//
// The bounds follow from the guarantees of a finished mesh, whatever other features there are: an
// input that can be meshed is never refused. They are not sharp: a half of the truth for large
// regions in 2D, a fifth in 3D, a fiftieth for two lines, a few hundredths to a thousandth for
// close features in 3D.
//
// *Regions* with a target length h. Every simplex that meets the region has a circumradius R <= h /
// sqrt 2.
//   2D: such a triangle has at most the area of the equilateral one, 3 sqrt 3 / 4 R^2, and by
//   Euler a triangulation has at least half as many vertices as triangles.
//   3D: every position is nearer than R to a corner of its simplex, so balls of radius R about
//   the vertices cover the region.
//   Where regions overlap, the largest demand counts (a sum over disjoint cells).
//
// *Two close segments*, 2D. Let e be a subsegment of one, l its length, and let the other segment
// pass over it at a height <= g. The triangle at e on that side cannot cross the other segment, so
// its third corner has a height <= g, and its angle at one end of e has a sine <= 2 g / l. So
// circumradius / shortest edge >= l / 4g, hence l <= 4 rho g. This holds for triangles with the
// quality bound; at sharp input angles there is none (the caller checks that).
//
// *A segment close to another one*, 3D. Let p be an end of its subsegment e of length l. A part of
// the mesh's input is at y, 3g ahead and at most g beside. The tetrahedron at p towards y ends
// before y, at y' = sum w_i p_i, with its corners p_i. Let c be its centre, relative to p, and s
// its shortest edge. |p_i|^2 = 2 p_i c, so |y'| R >= y' c >= s^2 / 2. With R <= rho s and |y'| <=
// 4g follows R <= 8 rho^2 g. The ball with diameter e is empty: R >= 0.94 l / 2. Hence l <= 17.1
// rho^2 g.
//
// *A facet* with another facet over all of it at a height <= g. Let d be the distance of a position
// x of it from the nearest vertex w, which is on the facet. The ray from w that rises at 45 degrees
// towards x meets the other facet after sqrt 2 g. As before, R <= 2 sqrt 2 rho^2 g for the
// tetrahedron at w along that ray. The ball of radius d about x is empty, so R >= d / sqrt 2. Hence
// discs of radius 4 rho^2 g about its vertices cover the facet.
//
// Pure functions of the features, thread-safe; for segments the same to the bit for both orders of
// the ends.
#ifndef DYNMESH_CORE_PLC_LEAST_VERTICES_H_
#define DYNMESH_CORE_PLC_LEAST_VERTICES_H_

#include <span>

#include "core/plc/delta.h"
#include "core/plc/facet.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Of the region of a sizing feature, within the domain. O(1); for a polygon O(corners).
template <int D>
double LeastVerticesIn(const SizeFeature<D>& size, const Box& domain);

// Of all these regions together: less than the sum where they overlap or lie across each other.
// Expected O(n).
template <int D>
double LeastVerticesIn(std::span<const SizeFeature<D>> sizes, const Box& domain);

// The target length at which the region's bound is `most`.
template <int D>
double TargetFor(const SizeFeature<D>& size, const Box& domain, double most);

// The region of max_edge.
template <int D>
SizeFeature<D> RegionOfMaxEdge(const MeshOptions& options);

// On segment s, because of t near it. REQUIRES: they do not meet; `limit` as in rules.h. O(1).
template <int D>
double LeastVerticesOn(const SegmentFeature<D>& s, const SegmentFeature<D>& t, double quality,
                       double limit);
// The distance of a neighbour of s that causes so many vertices.
template <int D>
double DistanceFor(const SegmentFeature<D>& s, double vertices, double quality);

// On facet f, because g is over all of it; 0 if it is not, or is not convex. O(corners of f times
// corners of g).
double LeastVerticesOn(const Facet& f, const Facet& g, double quality, double limit);
double DistanceFor(const Facet& f, double vertices, double quality);

// The distance of a position from a segment; the least distance of positions along s from t. The
// same to the bit for both orders of the ends.
template <int D>
double DistanceOf(const SegmentFeature<D>& t, const geometry::Point<D>& p);
template <int D>
double LeastDistance(const SegmentFeature<D>& s, const SegmentFeature<D>& t);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_LEAST_VERTICES_H_
