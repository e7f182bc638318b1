#include "core/plc/facet.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/circumball.h"

namespace dynmesh::plc {

using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

namespace {

// How far aside of an edge its left side is looked for, in lengths along the edge, unless another
// edge is nearer.
constexpr double kAside = 0.25;

Vector3 Sum(const Vector3& u, double factor, const Vector3& w) {
  return {u[0] + factor * w[0], u[1] + factor * w[1], u[2] + factor * w[2]};
}

}  // namespace

Facet::Facet(FacetFeature feature)
    : feature_(std::move(feature)),
      plane_(geometry::PlaneOf(feature_.positions)),
      interior_(feature_.positions, plane_),
      bounds_(geometry::BoundsOf(feature_.positions, plane_)) {
  for (std::size_t r = 0; r < feature_.positions.size(); ++r) {
    const geometry::Ring3& positions = feature_.positions[r];
    Vector3 area = {0, 0, 0};  // twice
    for (std::size_t i = 0; i < positions.size(); ++i) {
      corners_.push_back({feature_.rings[r][i], r, i});
      if (i < 2) continue;
      area = Sum(area, 1,
                 geometry::Cross(Difference(positions[i - 1].c, positions[0].c),
                                 Difference(positions[i].c, positions[0].c)));
    }
    area_ = std::max(area_, std::abs(Dot(area, plane_.normal)) / 2);
  }
  std::sort(corners_.begin(), corners_.end());
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

bool Facet::OpensTo(FeatureId point, const Vector3& direction) const {
  const auto visits = At(point);
  if (visits.empty()) return false;
  const Vector3 to = Sum(direction, -Dot(direction, plane_.normal), plane_.normal);
  for (const Corner& c : visits) {
    for (const bool next : {false, true}) {
      const Vector3 edge = Difference(PositionOf(Beside(c, next)).c, PositionOf(c).c);
      // Projected along the axis, as the interior is.
      if (geometry::Cross(edge, to)[static_cast<std::size_t>(plane_.axis)] == 0 &&
          Dot(edge, to) > 0) {
        return false;
      }
    }
  }
  return interior_.OpensTo(PositionOf(visits.front()), to);
}

Vector3 Facet::LeftOf(const Corner& c) const {
  return geometry::Cross(plane_.normal, Difference(PositionOf(Beside(c, true)).c, PositionOf(c).c));
}

bool Facet::IsInsideLeftOf(const Corner& c) const {
  const Vector3 along = Difference(PositionOf(Beside(c, true)).c, PositionOf(c).c);
  const Vector3 left = LeftOf(c);
  double aside = kAside;
  for (const Corner& visit : At(c.id)) {
    for (const bool next : {false, true}) {
      const Vector3 edge = Difference(PositionOf(Beside(visit, next)).c, PositionOf(visit).c);
      const double ahead = Dot(edge, along), across = Dot(edge, left);
      const bool is_same = visit.ring == c.ring && visit.at == c.at && next;
      if (!is_same && ahead > 0 && across > 0) aside = std::min(aside, across / ahead / 2);
    }
  }
  return interior_.OpensTo(PositionOf(c), Sum(along, aside, left));
}

Vector3 Facet::InwardOf(const Corner& c) const {
  Vector3 inward = LeftOf(c);
  const double length = std::sqrt(Dot(inward, inward));
  const double sign = IsInsideLeftOf(c) ? 1 : -1;
  for (double& x : inward) x *= sign / length;
  return inward;
}

}  // namespace dynmesh::plc
