// Facets that meet other facets, or segments, at a small angle.
//
// Let v be on a facet F, and G another facet with a common edge. If v's Voronoi cell meets G, the
// place of G nearest to v is nearer to the edge than v is. A vertex there would make one on F that
// is nearer still, and so on towards the edge for ever. So G gets the *counterpart* of v instead: v
// turned about the edge into G.
// 1. Every place of G is nearer to the counterpart than to v. So v's cell no longer meets G.
// 2. v is the counterpart of its counterpart. So no new distances from the edge come up.
// If only a corner is common, the counterpart has v's distance from the corner, and the direction
// of the place nearest to v. Then 1. holds, too, and no new distances from the corner come up. On
// segments these are the shells of shells.h.
//
// The counterpart of a vertex of a segment is a tiny part of that distance nearer to the corner.
// Else two vertices of the segment and their counterparts would be the corners of a trapezoid: on a
// circle, so a flat tetrahedron. The part is so small beside the angle that 1. stays true. It is a
// function of the segment's vertex and of the direction, for counterparts of counterparts, too. So
// in the vertex's own direction there is the vertex, and 2. holds.
//
// An edge between vertices on two features that meet at a small angle is *seditious*, as between
// segments (shells.h), if their distances from what is common are equal: it is as short as the
// angle makes it.
//
// Where features meet at larger angles, there is neither. Everything is a function of the vertices
// and of the features that own them. Pure functions, thread-safe. O(corners).
#ifndef DYNMESH_CORE_MESHING_SHARP_FACETS_H_
#define DYNMESH_CORE_MESHING_SHARP_FACETS_H_

#include <array>
#include <optional>

#include "core/geometry/circumball.h"
#include "core/geometry/point.h"
#include "core/meshing/facet_field.h"

namespace dynmesh::meshing {

// A vertex inside a facet or a segment.
struct OwnedVertex {
  geometry::Point3 p = {};
  const Facet* facet = nullptr;  // null: it is on a segment,
  // which has these ends.
  std::array<VertexIndex, 2> ends = {kNil, kNil};
  std::array<geometry::Point3, 2> positions = {};
  // It is on a shell about this corner (shells.h), or a counterpart.
  VertexIndex apex = kNil;
  geometry::Point3 origin = {};  // the segment's vertex on that shell: p, or what p comes from
  bool is_counterpart = false;
};

struct Counterpart {
  geometry::Point3 p = {};
  Axis axis = kNoAxis;
};
// p, which is on the facet `own`, turned into the facet `to` about an edge that they have in common
// at a small angle, the nearest one. Nothing if there is none, or if it would be outside of `to`.
std::optional<Counterpart> TurnedInto(const Facet& to, const Facet& own, const geometry::Point3& p);
// The place of `to` as far from the nearest common corner as v, up to that part, in the direction
// of `nearest`, the place of `to` nearest to v. Nothing if the features meet at no small angle in a
// corner, or if it would be outside of `to`.
std::optional<Counterpart> MovedInto(const Facet& to, const OwnedVertex& v,
                                     const geometry::Point3& nearest);

// Each edge of a facet has a lattice in the facet's plane. Its rows are parallel to the edge, each
// 0.83 steps from the one before and half a step along it. A step is the edge's length times a
// power of two. So each lattice contains all coarser ones, and facets with a common edge have the
// same lattice, turned. (In squares and equilateral triangles points would be on the balls of
// subsegments of the edge, or four on a circle: ties that rounding decides.)
struct PlaceOnLattice {
  geometry::Point3 p = {};
  LatticeIndex at = {};
};
// The point nearest to x of the lattice with the widest step <= `step`. REQUIRES: `axis` is an edge
// of the facet. Nothing if the point is outside of the facet, or on the edge.
std::optional<PlaceOnLattice> OnLattice(const Facet& facet, const Axis& axis,
                                        const geometry::Point3& x, double step);
// The lattice's covering radius in steps: no point of its plane is farther from it. That is the
// circumradius of a triangle of two neighbours in a row and the point between them in the next.
inline constexpr double kFarthestOnLattice = 0.5657;

// Do the facets have an edge in common at which they meet at a small angle?
bool MeetSharply(const Facet& f, const Facet& g);
// Is a place of the facet near its corner nearer to the ray from there along `u` than to the
// facet's edges, at less than 70 degrees from it?
bool LeansOver(const geometry::Vector3& u, const Facet& facet, VertexIndex corner);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SHARP_FACETS_H_
