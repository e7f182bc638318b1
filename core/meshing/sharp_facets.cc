#include "core/meshing/sharp_facets.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"
#include "core/meshing/shells.h"

namespace dynmesh::meshing {
namespace {

using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

// sin(20 degrees), plus a millionth: at 70 degrees or more no angle is small.
constexpr double kMostCosine = 0.3420201433256687 * kWider;

// Of a lattice's rows, in steps.
constexpr double kRowHeight = 0.83;

Vector3 Along(const Point3& from, const Point3& to) {
  Vector3 d = Difference(to.c, from.c);
  const double length = std::sqrt(Dot(d, d));
  for (double& x : d) x /= length;
  return d;
}
Vector3 Along(const Facet& facet, const Facet::Edge& edge) {
  return Along(facet.PositionOf(edge.first), facet.PositionOf(edge.second));
}

// Edges are sorted by the indices of their ends, which depend on former edits. What is computed
// from an edge begins at the end with the lesser position: the same for all facets that have it.
Facet::Edge FromTheLesserEnd(const Facet& facet, Facet::Edge edge) {
  if (facet.PositionOf(edge.second) < facet.PositionOf(edge.first)) {
    std::swap(edge.first, edge.second);
  }
  return edge;
}

// From the edge over the facet's inside.
Vector3 InwardOf(const Facet& facet, const Facet::Edge& edge) {
  constexpr double kBeside = 0x1p-20;  // in lengths of the edge
  const Facet::Edge from = FromTheLesserEnd(facet, edge);
  const Point3 &p = facet.PositionOf(from.first), &q = facet.PositionOf(from.second);
  Vector3 inward = geometry::Cross(facet.plane().normal, Along(p, q));
  const double aside = kBeside * std::sqrt(geometry::SquaredDistance(p, q));
  Point3 beside = geometry::Midpoint(p, q);
  for (int k = 0; k < 3; ++k) beside[k] += aside * inward[static_cast<std::size_t>(k)];
  if (!facet.IsInside(beside)) {
    for (double& x : inward) x = -x;
  }
  return inward;
}

// Calls f(edge) for the edges that the facets have in common until f returns true. Returns whether
// it did.
template <class F>
bool AnyCommonEdge(const Facet& a, const Facet& b, F f) {
  const bool fewer = a.edges().size() <= b.edges().size();
  const Facet &least = fewer ? a : b, &most = fewer ? b : a;
  return std::ranges::any_of(least.edges(), [&](const Facet::Edge& edge) {
    return edge.first < edge.second && most.HasEdge(edge.first, edge.second) && f(edge);
  });
}

// Do the facets meet at a small angle at this edge, which is of both?
bool MeetSharply(const Facet& f, const Facet& g, const Facet::Edge& edge) {
  return Dot(InwardOf(f, edge), InwardOf(g, edge)) > kMostCosine;
}

// Calls f(corner) for the corners that the facet and the feature of v have in common.
template <class F>
void ForEachCommonCorner(const OwnedVertex& v, const Facet& g, F f) {
  const auto visit = [&](const auto& corners, const Facet& other) {
    for (const VertexIndex c : corners) {
      if (other.HasCorner(c)) f(c);
    }
  };
  if (v.facet == nullptr) {
    visit(v.ends, g);
  } else if (v.facet->corners().size() <= g.corners().size()) {
    visit(v.facet->corners(), g);
  } else {
    visit(g.corners(), *v.facet);
  }
}

bool AnyLeansOver(const Facet& f, const Facet& g, VertexIndex corner) {
  return std::ranges::any_of(f.EdgesAt(corner), [&](const Facet::Edge& edge) {
    return !g.HasEdge(edge.first, edge.second) && LeansOver(Along(f, edge), g, corner);
  });
}

// Of the places inside a facet, that with the nearest axis; of several the least place, then the
// axis with the least ends. Near a corner that is the axis that counts: about another one, places
// would come up that are near a shell, but not on it.
class ByNearestAxis {
 public:
  explicit ByNearestAxis(const Facet& facet) : facet_(facet) {}
  // `d2`: the squared distance from the axis.
  void Offer(Counterpart x, double d2) {
    x.p = facet_.plane().Foot(x.p);
    if (d2 > least_ || (d2 == least_ && !IsLess(x, *found_)) || !facet_.IsInside(x.p)) return;
    found_ = x;
    least_ = d2;
  }
  const std::optional<Counterpart>& found() const { return found_; }

 private:
  bool IsLess(const Counterpart& x, const Counterpart& y) const {
    if (!(x.p == y.p)) return x.p < y.p;
    return EndsOf(x.axis) < EndsOf(y.axis);
  }
  std::pair<Point3, Point3> EndsOf(const Axis& axis) const {
    return std::minmax(facet_.PositionOf(axis[0]), facet_.PositionOf(axis[1]));
  }

  const Facet& facet_;
  std::optional<Counterpart> found_;
  double least_ = INFINITY;
};

// The square of the sine of the angle between them.
double SquaredSine(const Vector3& u, const Vector3& w) {
  const Vector3 across = geometry::Cross(u, w);
  return Dot(across, across) / (Dot(u, u) * Dot(w, w));
}

// How far from the corner a counterpart of v is, in direction w; v is in direction u, on a shell
// about the corner. REQUIRES: `length` is that of u.
//
// Two counterparts of one vertex may be in directions much nearer to each other than to the vertex,
// and differ in their parts by too much for that: then v's distance is copied.
double DistanceOnShell(const OwnedVertex& v, const Point3& corner, const Vector3& u,
                       const Vector3& w, double length) {
  constexpr double kMostOff = 1.0 / 32;  // 1/2 would do
  const Vector3 from = Difference(v.origin.c, corner.c);
  const double skew = SkewOfCounterpart(SquaredSine(from, w));
  const double distance = std::sqrt(Dot(from, from)) * (1 - skew);
  return std::fabs(distance - length) <= kMostOff * SquaredSine(u, w) * length ? distance : length;
}

bool IsSharpAt(const OwnedVertex& v, const Facet& g, VertexIndex corner) {
  if (v.is_counterpart || v.apex == corner) return true;
  if (v.facet == nullptr) {
    const std::size_t i = v.ends[0] == corner ? 0 : 1;
    return LeansOver(Along(v.positions[i], v.positions[1 - i]), g, corner);
  }
  const Facet& f = *v.facet;
  return AnyLeansOver(f, g, corner) || AnyLeansOver(g, f, corner) ||
         std::ranges::any_of(f.EdgesAt(corner), [&](const Facet::Edge& edge) {
           return g.HasEdge(edge.first, edge.second) && MeetSharply(f, g, edge);
         });
}

}  // namespace

bool MeetSharply(const Facet& f, const Facet& g) {
  return AnyCommonEdge(f, g, [&](const Facet::Edge& edge) { return MeetSharply(f, g, edge); });
}

// Let d and e be the edges of the facet on either side, and w a direction between them:
// w = x d + y e. It is nearer to u than to d and e iff w.(u - d) > 0 and w.(u - e) > 0.
bool LeansOver(const Vector3& u, const Facet& facet, VertexIndex corner) {
  const double up = Dot(u, facet.plane().normal);
  if (!(1 - up * up > kMostCosine * kMostCosine)) return false;
  const Point3& at = facet.PositionOf(corner);
  const std::span<const Facet::Edge> edges = facet.EdgesAt(corner);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Vector3 d = Along(facet, edges[i]), e = Along(facet, edges[j]);
      const double between = Dot(d, e), to_d = Dot(u, d), to_e = Dot(u, e);
      Vector3 middle;
      for (std::size_t k = 0; k < 3; ++k) middle[k] = d[k] + e[k];
      if (facet.OpensTo(at, middle)) {
        if (to_d > between && to_e > between &&
            (to_d - between) * (to_e - between) > kNarrower * ((1 - to_d) * (1 - to_e))) {
          return true;
        }
      } else {
        Vector3 foot;
        for (std::size_t k = 0; k < 3; ++k) foot[k] = u[k] - up * facet.plane().normal[k];
        if (facet.OpensTo(at, foot) && Dot(foot, u) > std::max(Dot(foot, d), Dot(foot, e)))
          return true;
      }
    }
  }
  return false;
}

std::optional<Counterpart> TurnedInto(const Facet& to, const Facet& own, const Point3& p) {
  ByNearestAxis best(to);
  AnyCommonEdge(own, to, [&](const Facet::Edge& edge) {
    const Vector3 inward = InwardOf(to, edge);
    if (!(Dot(InwardOf(own, edge), inward) > kMostCosine)) return false;
    const Facet::Edge from = FromTheLesserEnd(to, edge);
    const Point3& end = to.PositionOf(from.first);
    const Vector3 d = Along(to, from);
    Vector3 off = Difference(p.c, end.c);
    const double along = Dot(off, d);
    for (std::size_t k = 0; k < 3; ++k) off[k] -= along * d[k];
    const double distance = std::sqrt(Dot(off, off));
    Counterpart x{{}, {edge.first, edge.second}};
    for (std::size_t k = 0; k < 3; ++k) x.p.c[k] = end.c[k] + along * d[k] + distance * inward[k];
    best.Offer(x, distance * distance);
    return false;
  });
  return best.found();
}

std::optional<PlaceOnLattice> OnLattice(const Facet& facet, const Axis& axis, const Point3& x,
                                        double step) {
  const Facet::Edge edge = FromTheLesserEnd(facet, {axis[0], axis[1]});
  const Point3& end = facet.PositionOf(edge.first);
  const double length = std::sqrt(geometry::SquaredDistance(end, facet.PositionOf(edge.second)));
  const Vector3 d = Along(facet, edge), inward = InwardOf(facet, edge);
  const Vector3 off = Difference(x.c, end.c);
  const int halvings = -std::ilogb(step / length);
  const double u = std::ldexp(Dot(off, d) / length, halvings);
  const double v = std::ldexp(Dot(off, inward) / length, halvings) / kRowHeight;
  double i = 0, j = 0, least = INFINITY;
  for (const double row : {std::floor(v), std::ceil(v)}) {
    const double at = std::nearbyint(u - 0.5 * row);
    const double aside = u - 0.5 * row - at, off_row = kRowHeight * (v - row);
    const double d2 = aside * aside + off_row * off_row;
    if (d2 < least) least = d2, i = at, j = row;
  }
  if (!(j > 0)) return std::nullopt;
  PlaceOnLattice place;
  const double along = std::ldexp(i + 0.5 * j, -halvings) * length;
  const double distance = std::ldexp(kRowHeight * j, -halvings) * length;
  for (std::size_t k = 0; k < 3; ++k) {
    place.p.c[k] = end.c[k] + along * d[k] + distance * inward[k];
  }
  place.p = facet.plane().Foot(place.p);
  if (!facet.IsInside(place.p)) return std::nullopt;
  place.at = {halvings, static_cast<std::int64_t>(i), static_cast<std::int64_t>(j)};
  while (((place.at.i | place.at.j) & 1) == 0) {
    --place.at.halvings;
    place.at.i /= 2;
    place.at.j /= 2;
  }
  return place;
}

std::optional<Counterpart> MovedInto(const Facet& to, const OwnedVertex& v, const Point3& nearest) {
  ByNearestAxis best(to);
  ForEachCommonCorner(v, to, [&](VertexIndex corner) {
    const Point3& at = to.PositionOf(corner);
    const Vector3 u = Difference(v.p.c, at.c), w = Difference(nearest.c, at.c);
    const double u2 = Dot(u, u), w2 = Dot(w, w);
    double scale = std::sqrt(u2 / w2);
    if (!(Dot(u, w) * scale > kMostCosine * u2) || !IsSharpAt(v, to, corner)) return;
    if (v.apex == corner) scale = DistanceOnShell(v, at, u, w, std::sqrt(u2)) / std::sqrt(w2);
    Counterpart x{{}, {corner, corner}};
    for (int k = 0; k < 3; ++k) x.p[k] = at[k] + scale * w[static_cast<std::size_t>(k)];
    best.Offer(x, u2);
  });
  return best.found();
}

}  // namespace dynmesh::meshing
