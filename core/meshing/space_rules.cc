#include "core/meshing/space_rules.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/inlined_vector.h"
#include "core/geometry/circumball.h"
#include "core/meshing/directions.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

Vector3 Unit(const Vector3& a) {
  const double length = std::sqrt(Dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}

}  // namespace

// The Voronoi face between the star's vertex, at the origin, and its neighbour u.
class SpaceRules::Face {
 public:
  Face(const SpaceRules& rules, const SpaceStar& star, int slot)
      : rules_(rules),
        star_(star),
        u_(star.neighbours()[slot]),
        slot_(slot),
        cap_(kCap * rules.quality_ * std::sqrt(u_.d2)) {}

  bool HasGap() {
    const auto& corners = star_.corners();
    int i = 0, k = -1;
    while (k < 0) {
      const auto& n = corners[i].n;
      k = n[0] == slot_ ? 0 : n[1] == slot_ ? 1 : n[2] == slot_ ? 2 : -1;
      if (k < 0) ++i;
    }
    first_ = i, first_index_ = k;
    bool has = false;
    ForEachCorner([&](const SpaceStar::Corner& c, int) {
      if (rules_.IsTooFar(c.r2, u_.d2)) has = true;
    });
    return has;
  }

  std::optional<Point3> PointInDirection() const {
    // The frame does not depend on which end's star this is.
    const Vector3 axis = u_.p < star_.position() ? Difference({0, 0, 0}, u_.d) : u_.d;
    int least = 0;
    for (int k = 1; k < 3; ++k) {
      if (std::fabs(axis[k]) < std::fabs(axis[least])) least = k;
    }
    Vector3 unit = {0, 0, 0};
    unit[least] = 1;
    const Vector3 f = Unit(Cross(axis, unit)), g = Unit(Cross(axis, f));
    const double height = std::sqrt(std::max(0.0, cap_ * cap_ - 0.25 * u_.d2));
    const double enough = kEnough * std::sqrt(u_.d2);
    const double slack = -1e-9 * enough;
    const SideList sides = Sides();
    std::optional<Point3> best;
    double best_clearance = 0;
    constexpr int kFirstStep = kDirections / 8;
    for (int step = kFirstStep; step > 0; step /= 2) {
      // Those of the step before had no clearance.
      const bool is_first = step == kFirstStep;
      for (int k = is_first ? 0 : step; k < kDirections; k += is_first ? step : 2 * step) {
        Vector3 c;
        for (int a = 0; a < 3; ++a) {
          c[a] = 0.5 * u_.d[a] + height * (CosineOf(k) * f[a] + SineOf(k) * g[a]);
        }
        const Point3 x = At(c);
        if (!IsInDomain(x)) continue;
        const double clearance =
            std::min(Clearance(sides, c, best ? best_clearance : slack), enough);
        if (clearance < slack || (best && !(clearance > best_clearance))) continue;
        best = x;
        best_clearance = clearance;
        if (!IsOn(RefinementTerm::kMostClearance)) return best;
        if (clearance == enough) return best;  // no point has more
      }
      if (best) break;
    }
    return best;
  }

  std::optional<Point3> PointOnBorder() const {
    std::optional<Point3> best;
    double best_r2 = 0;
    const auto offer = [&](const Vector3& c, double r2) {
      const Point3 x = At(c);
      if (!IsInDomain(x) || (best && (r2 < best_r2 || (r2 == best_r2 && *best < x)))) return;
      best = x;
      best_r2 = r2;
    };
    const double cap2 = cap_ * cap_;
    ForEachCorner([&](const SpaceStar::Corner& corner, int next) {
      if (corner.r2 <= cap2 && rules_.IsTooFar(corner.r2, u_.d2)) offer(corner.w, corner.r2);
      const SpaceStar::Corner& end = star_.corners()[next];
      if (corner.error == INFINITY || end.error == INFINITY) return;
      OfferCrossings(corner, end, cap2, offer);
    });
    return best;
  }

 private:
  // Calls f(corner, the next one's index) around u.
  template <class F>
  void ForEachCorner(F f) const {
    int i = first_, k = first_index_;
    do {
      const auto [next, index] = star_.NextAround(i, k);
      f(star_.corners()[i], next);
      i = next, k = index;
    } while (i != first_);
  }

  // A side of the face: in the plane midway to a third vertex.
  struct Side {
    Vector3 d;
    double d2;
    double twice_across;  // twice its distance from the edge's line; 1 if that is 0
  };
  using SideList = absl::InlinedVector<Side, 24>;
  SideList Sides() const {
    SideList sides;
    ForEachCorner([&](const SpaceStar::Corner& corner, int) {
      // Each side of the face once: the neighbour after u in the corner.
      const int k = corner.n[0] == slot_ ? 1 : corner.n[1] == slot_ ? 2 : 0;
      const SpaceStar::Neighbour& w = star_.neighbours()[corner.n[k]];
      if (SpaceStar::IsGhost(w.id)) return;
      const double along = Dot(w.d, u_.d);
      const double across2 = w.d2 - along * along / u_.d2;
      sides.push_back({w.d, w.d2, across2 > 0 ? 2 * std::sqrt(across2) : 1});
    });
    return sides;
  }

  // How far c, in the plane of the face, is inside the face's border; negative outside. If that is
  // less than `enough_less`, the result is any lesser number.
  static double Clearance(const SideList& sides, const Vector3& c, double enough_less) {
    double least = INFINITY;
    for (const Side& side : sides) {
      least = std::min(least, (side.d2 - 2 * Dot(c, side.d)) / side.twice_across);
      if (least < enough_less) break;
    }
    return least;
  }

  // Offers the points where the face's edge from `corner` to `end` leaves the ball of radius c. The
  // edge lies on a line through the centre of the circle of v, u and the third vertex, w.
  template <class Offer>
  void OfferCrossings(const SpaceStar::Corner& corner, const SpaceStar::Corner& end, double cap2,
                      Offer offer) const {
    int shared = -1;
    for (const int n : corner.n) {
      if (n != slot_ && std::find(end.n.begin(), end.n.end(), n) != end.n.end()) shared = n;
    }
    const SpaceStar::Neighbour& w = star_.neighbours()[shared];
    if (SpaceStar::IsGhost(w.id)) return;
    const Vector3 normal = Cross(u_.d, w.d);
    const double n2 = Dot(normal, normal);
    if (!(n2 > 0)) return;
    const Vector3 from_w = Cross(w.d, normal), from_u = Cross(normal, u_.d);
    Vector3 centre;
    for (int k = 0; k < 3; ++k) {
      centre[k] = (u_.d2 * from_w[k] + w.d2 * from_u[k]) * (0.5 / n2);
    }
    const double r2 = Dot(centre, centre);
    if (!(r2 < cap2)) return;
    const double t = std::sqrt((cap2 - r2) / n2);
    const double at = Dot(Difference(corner.w, centre), normal) / n2;
    const double at_end = Dot(Difference(end.w, centre), normal) / n2;
    const double lo = std::min(at, at_end), hi = std::max(at, at_end);
    const auto offer_at = [&](double s) {
      offer(
          Vector3{centre[0] + s * normal[0], centre[1] + s * normal[1], centre[2] + s * normal[2]},
          cap2);
    };
    if (lo <= t && t < hi) offer_at(t);
    if (lo < -t && -t <= hi) offer_at(-t);
  }

  Point3 At(const Vector3& c) const {
    const Point3& p = star_.position();
    return {{p[0] + c[0], p[1] + c[1], p[2] + c[2]}};
  }
  bool IsInDomain(const Point3& x) const {
    for (int k = 0; k < 3; ++k) {
      if (!(rules_.lo()[k] <= x[k] && x[k] <= rules_.hi()[k])) return false;
    }
    return true;
  }

  const SpaceRules& rules_;
  const SpaceStar& star_;
  const SpaceStar::Neighbour& u_;
  int slot_;
  double cap_;
  int first_ = 0, first_index_ = 0;
};

std::optional<Point3> SpaceRules::PointInGap(const SpaceStar& star, int slot) const {
  if (star.neighbours()[slot].d2 < least_squared_length()) return std::nullopt;
  Face face(*this, star, slot);
  if (!face.HasGap()) return std::nullopt;
  if (const auto x = face.PointInDirection()) return x;
  return face.PointOnBorder();
}

}  // namespace dynmesh::meshing
