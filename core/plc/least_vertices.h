// How many vertices a mesh has at least, for the sake of some of its features: known at once, where
// making the mesh would take minutes to find out that there are too many.
//
// These are lower bounds, from what a finished mesh guarantees, whatever else is there. They are
// certainly low rather than sharp: of large regions they are a half of the truth in 2D and a fifth in
// 3D, of two lines a fiftieth, of things near each other in 3D a few hundredths to a thousandth. An input that would succeed never has one above what it
// comes to.
//
// *Regions* with a target length h. Whatever simplex meets one has a circumradius R <= h / sqrt 2.
//   In the plane no such triangle is larger than the equilateral one, 3 sqrt 3 / 4 R^2, and by
//   Euler a triangulation has half as many vertices as triangles or more.
//   In space a place is nearer than R to a corner of its simplex, so balls of radius R about the
//   vertices cover the region.
//   Where regions overlap, the one that asks for most counts (a sum over disjoint cells).
//
// *Two segments* near each other, in the plane. Let e be a subsegment of one, l its length, and let
//   the other segment pass over it at a height of g or less. The triangle at e on that side cannot
//   cross what passes over it, so its third corner is no higher than g, and its angle at one end of
//   e has a sine of 2 g / l at most: circumradius / shortest edge is l / 4g or more. So l <= 4 rho
//   g. That holds of triangles that the quality is promised for; at sharp angles of the input it is
//   not (the caller asks for that).
//
// *A segment in space* near another one. Let p be an end of its subsegment e of length l. Something
//   of the mesh is at y, 3g ahead and at most g beside. The tetrahedron at p towards y ends there
//   at the latest, at a place y' = sum w_i p_i of its corners. With c its centre seen from p,
//   |p_i|^2 = 2 p_i c; so |y'| R >= y' c >= s^2 / 2 for its shortest edge s, and since R <= rho s
//   and |y'| <= 4g, R <= 8 rho^2 g. And the ball on e as diameter is empty: R >= 0.94 l / 2. So l
//   <= 17.1 rho^2 g.
//
// *A facet* all of which has another facet over it at a height of g or less. Let d be the distance
//   of a place x of it from the nearest vertex w, which is one of the facet's. The ray from w that
//   rises at 45 degrees towards x meets the other facet after sqrt 2 g. As before, R <= 2 sqrt 2
//   rho^2 g for the tetrahedron at w along that ray; and the ball of radius d about x is empty, so
//   R >= d / sqrt 2. Hence discs of radius 4 rho^2 g about its vertices cover the facet.
//
// Pure functions of the features, thread-safe; of segments to the bit whichever end is first.
#ifndef DYNMESH_CORE_PLC_LEAST_VERTICES_H_
#define DYNMESH_CORE_PLC_LEAST_VERTICES_H_

#include <span>

#include "core/plc/delta.h"
#include "core/plc/facet.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

// Of the region of a sizing feature, as far as it lies in the domain. O(1); of a polygon
// O(corners).
template <int D>
double LeastVerticesIn(const SizeFeature<D>& size, const Box& domain);

// Of all these regions together: less than the sum where they overlap, and where they lie across
// each other. Expected O(n).
template <int D>
double LeastVerticesIn(std::span<const SizeFeature<D>> sizes, const Box& domain);

// The target length that region would have to have for a bound of `most`.
template <int D>
double TargetFor(const SizeFeature<D>& size, const Box& domain, double most);

// Of max_edge, as a region.
template <int D>
SizeFeature<D> RegionOfMaxEdge(const MeshOptions& options);

// On segment s, because t is near it. REQUIRES: they do not meet; `limit` as in rules.h. O(1).
template <int D>
double LeastVerticesOn(const SegmentFeature<D>& s, const SegmentFeature<D>& t, double quality,
                       double limit);
// How near t has to be to s, for so many.
template <int D>
double DistanceFor(const SegmentFeature<D>& s, double vertices, double quality);

// On facet f, because g is over all of it; 0 if it is not, or is not convex. O(corners of f times
// corners of g).
double LeastVerticesOn(const Facet& f, const Facet& g, double quality, double limit);
double DistanceFor(const Facet& f, double vertices, double quality);

// Of a place from a segment; the least of places along s from t. To the bit whichever end is first.
template <int D>
double DistanceOf(const SegmentFeature<D>& t, const geometry::Point<D>& p);
template <int D>
double LeastDistance(const SegmentFeature<D>& s, const SegmentFeature<D>& t);

}  // namespace dynmesh::plc

#endif  // DYNMESH_CORE_PLC_LEAST_VERTICES_H_
