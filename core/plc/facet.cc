#include "core/plc/facet.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/geometry/constructions.h"

namespace dynmesh::plc {

using geometry::Difference;
using geometry::Dot;
using geometry::Point2;
using geometry::Point3;
using geometry::Vector3;

namespace {

double Cross2(const Point2& u, const Point2& w) { return u[0] * w[1] - u[1] * w[0]; }

// Is v between u and w, counter-clockwise from u?
bool IsBetween(const Point2& u, const Point2& v, const Point2& w) {
  const double turn = Cross2(u, w), from = Cross2(u, v), to = Cross2(v, w);
  return turn > 0 ? from > 0 && to > 0 : from > 0 || to > 0;
}

}  // namespace

Facet::Facet(FacetFeature feature)
    : feature_(std::move(feature)),
      plane_(geometry::PlaneOf(feature_.places)),
      bounds_(geometry::BoundsOf(feature_.places, plane_)) {
  const auto& places = feature_.places;
  for (std::size_t r = 0; r < places.size(); ++r) {
    double area = 0;  // twice that of the shadow
    for (std::size_t i = 0; i < places[r].size(); ++i) {
      corners_.push_back({feature_.rings[r][i], r, i});
      if (i < 2) continue;
      area += geometry::Cross(Shadow(places[r][i - 1]), Shadow(places[r][i]), Shadow(places[r][0]));
    }
    counter_clockwise_.push_back(area > 0);
    area_ = std::max(area_, std::abs(area) / 2);
  }
  area_ /= plane_.normal[plane_.axis];
  std::sort(corners_.begin(), corners_.end());
  for (std::size_t r = 0; r < places.size(); ++r) {
    const Point3 middle = geometry::Midpoint(places[r][0], places[r][1]);
    bool in_others = false;
    for (std::size_t q = 0; q < places.size(); ++q) in_others ^= q != r && IsIn(q, middle);
    inside_left_.push_back(counter_clockwise_[r] != in_others);
  }
}

double Facet::Extent() const {
  return std::max({hi()[0] - lo()[0], hi()[1] - lo()[1], hi()[2] - lo()[2]});
}

std::span<const Facet::Corner> Facet::At(FeatureId point) const {
  const auto first = std::lower_bound(corners_.begin(), corners_.end(), Corner{point, 0, 0});
  auto last = first;
  while (last != corners_.end() && last->id == point) ++last;
  return {corners_.data() + (first - corners_.begin()), static_cast<std::size_t>(last - first)};
}

Facet::Corner Facet::Beside(const Corner& c, bool next) const {
  const auto& ring = feature_.rings[c.ring];
  const std::size_t at = (c.at + (next ? 1 : ring.size() - 1)) % ring.size();
  return {ring[at], c.ring, at};
}

bool Facet::HasEdge(FeatureId p, FeatureId q) const {
  const auto at_p = At(p);
  return std::any_of(at_p.begin(), at_p.end(), [&](const Corner& c) {
    return Beside(c, true).id == q || Beside(c, false).id == q;
  });
}

bool Facet::IsIn(std::size_t ring, const Point3& p) const {
  return geometry::IsInside(std::span(feature_.places).subspan(ring, 1), plane_, p);
}

// Rings that do not come here are around the corner or not; of those that do, the wedge counts.
bool Facet::OpensTo(FeatureId point, const Vector3& direction) const {
  const auto visits = At(point);
  if (visits.empty()) return false;
  const Vector3 d = Difference(direction, [&] {
    Vector3 across = plane_.normal;
    for (double& x : across) x *= Dot(direction, plane_.normal);
    return across;
  }());
  const Point2 to = Shadow({d});
  const Point3& apex = PlaceOf(visits.front());
  bool inside = false;
  for (std::size_t r = 0; r < feature_.rings.size(); ++r) {
    const auto is_of_ring = [&](const Corner& c) { return c.ring == r; };
    if (std::none_of(visits.begin(), visits.end(), is_of_ring)) {
      inside ^= IsIn(r, apex);
    }
  }
  for (const Corner& c : visits) {
    const auto along = [&](bool next) {
      return Shadow({Difference(PlaceOf(Beside(c, next)).c, apex.c)});
    };
    const bool ccw = counter_clockwise_[c.ring];
    inside ^= IsBetween(along(ccw), to, along(!ccw));
  }
  return inside;
}

Vector3 Facet::InwardOf(const Corner& c) const {
  const Vector3 edge = Difference(PlaceOf(Beside(c, true)).c, PlaceOf(c).c);
  Vector3 inward = geometry::Cross(plane_.normal, edge);  // to the left
  const double length = std::sqrt(Dot(inward, inward));
  for (double& x : inward) x *= (inside_left_[c.ring] ? 1 : -1) / length;
  return inward;
}

}  // namespace dynmesh::plc
