// Lower bounds of the number of vertices that some features cause: known at once, while meshing
// would take minutes to find that there are too many.
//
// The bounds follow from the guarantees of a finished mesh and from the splits of segments by near
// features, whatever other features there are: an input that can be meshed is never refused. They
// are not sharp: a half of the truth for large regions in 2D, a fifth in 3D, a fourth for lines, a
// few hundredths to a thousandth for close facets.
//
// *Regions* with a target length h. Every simplex that meets the region has a circumradius R <= h /
// sqrt 2.
//   2D: such a triangle has at most the area of the equilateral one, 3 sqrt 3 / 4 R^2, and by
//   Euler a triangulation has at least half as many vertices as triangles.
//   3D: every position is nearer than R to a corner of its simplex, so balls of radius R about
//   the vertices cover the region.
//   Where regions overlap, the largest demand counts (a sum over disjoint cells).
//   Thin regions: the balls of radius R about the vertices cover the region, so each covers at most
//   2R of a length in it.
//
// *A segment* s near others without a common end. A subsegment of s is split while another segment
// meets the open ball about the subsegment's middle (presplit.h, IsTooNear). So a subsegment whose
// middle is at a distance g from another segment is no longer than 2g. Cut s into stretches. On a
// stretch of length l the distance is at most G: that from one segment is convex along s, so it is
// greatest at an end of the stretch. Subsegments with the middle in the stretch are no longer than
// 2G. They cover it but for what two others cover at its ends. One of those, with its middle x
// beyond the end, at a distance g(x) from the other segment, is no longer than 2g(x) <= 2(G + the
// distance of x from the end), and so covers at most G of the stretch. Hence at least l / 2G - 1
// subsegments have their middle in it. The stretches begin and end where others do, and are halved
// while the distance changes much along them.
//
// *A facet* with another facet over all of it at a height <= g. Let d be the distance of a position
// x of it from the nearest vertex w, which is on the facet. The ray from w that rises at 45 degrees
// towards x meets the other facet after sqrt 2 g. As before, R <= 2 sqrt 2 rho^2 g for the
// tetrahedron at w along that ray. The ball of radius d about x is empty, so R >= d / sqrt 2. Hence
// discs of radius 4 rho^2 g about its vertices cover the facet. There is no bound if one of the
// facets has a sharp corner: the quality is not promised there.
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
SizeFeature<D> SizeOfMaxEdge(const MeshOptions& options);

template <int D>
bool HaveCommonEnd(const SegmentFeature<D>& s, const SegmentFeature<D>& t) {
  return s.p_id == t.p_id || s.p_id == t.q_id || s.q_id == t.p_id || s.q_id == t.q_id;
}

// Inside segment s, because of those near it; segments with an end in common with s do not count.
// REQUIRES: they do not meet s elsewhere; `limits.max_depth` and `limit` as in rules.h. O(n) for n
// segments that run along s, at most O(n^2).
template <int D>
double LeastVerticesOn(const SegmentFeature<D>& s, std::span<const SegmentFeature<D>> near,
                       const Limits& limits, double limit);
// The distance of a neighbour of s that causes so many vertices.
template <int D>
double DistanceFor(const SegmentFeature<D>& s, double vertices);

// On facet f, because g is over all of it; 0 if it is not, or is not convex. O(corners of f times
// corners of g).
double LeastVerticesOn(const Facet& f, const Facet& g, double quality, double limit);
double DistanceFor(const Facet& f, double vertices, double quality);

// The distance of a position from a segment; the same to the bit for both orders of the ends.
template <int D>
double DistanceOf(const SegmentFeature<D>& t, const geometry::Point<D>& p);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_LEAST_VERTICES_H_
