#include "core/meshing/shells.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/geometry/angles.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {
namespace {

using geometry::Point2;

struct Vector {
  double x, y;
  double squared() const { return x * x + y * y; }
};
Vector Minus(const Point2& p, const Point2& q) { return {p[0] - q[0], p[1] - q[1]}; }
double Dot(const Vector& u, const Vector& w) { return u.x * w.x + u.y * w.y; }

}  // namespace

std::vector<WedgeEnd> FindWedges(const Point2& apex, std::span<const Point2> others) {
  const std::size_t n = others.size();
  std::vector<WedgeEnd> ends(n);
  if (n < 2) return ends;
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return geometry::PrecedesInAngle(apex, others[i], others[j]);
  });
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t s = order[i], t = order[i + 1 == n ? 0 : i + 1];
    if (!Counts(RefinementTerm::kSharpOnShells)) continue;
    if (!geometry::IsSmallAngle(apex, others[s], others[t])) continue;
    const Vector u = Minus(others[s], apex), w = Minus(others[t], apex);
    const double dot = Dot(u, w);
    const double lu = std::sqrt(u.squared()), lw = std::sqrt(w.squared());
    const double sine = std::fabs(u.x * w.y - u.y * w.x) / (lu * lw);
    const auto meet = [sine](WedgeEnd& end, double reach) {
      end.acute = true;
      end.sine = std::min(end.sine, sine);
      end.reach = std::max(end.reach, reach);
    };
    meet(ends[s], std::min(lu, dot / lu));
    meet(ends[t], std::min(lw, dot / lw));
  }
  return ends;
}

// The handover is where both wedges are equally wide, if that is beyond the neighbours' shadows or
// in between them. Else it is the end of the nearer shadow, moved a little to the side: exactly at
// that foot the neighbour's end would lie on the balls of both parts.
SegmentShape ShapeOf(double length, const WedgeEnd& a, const WedgeEnd& b) {
  SegmentShape shape{a.acute, b.acute, 0};
  if (!a.acute || !b.acute) return shape;
  const double balance = length * b.sine / (a.sine + b.sine);
  const double from_a = a.reach, to_b = length - b.reach;
  const auto [lo, hi] = std::minmax(from_a, to_b);
  const double ideal = std::clamp(balance, lo, hi);
  if (from_a < ideal && ideal < to_b) {
    const double width = std::min(ideal, length - ideal) / 4;
    shape.handover = Coarsest(std::max(from_a, ideal - width), std::min(to_b, ideal + width));
  } else {
    shape.handover =
        ideal - std::min(ideal * (a.sine * a.sine), (length - ideal) * (b.sine * b.sine)) / 16;
  }
  return shape;
}

double Coarsest(double lo, double hi) {
  int exponent = 0;
  std::frexp(hi, &exponent);  // hi < 2^exponent
  for (; exponent > -1070; --exponent) {
    const double unit = std::ldexp(1.0, exponent);
    const double multiple = std::ceil(lo / unit) * unit;
    if (multiple <= hi) return multiple;
  }
  return hi;
}

SplitRule SplitRule::Whole(const SegmentShape& shape, double length) {
  if (shape.acute_at_a && shape.acute_at_b) return {Kind::kHandOver, false, 0, shape.handover};
  if (shape.acute_at_a) return {Kind::kShells, false, 0, length};
  if (shape.acute_at_b) return {Kind::kShells, true, length, 0};
  return {};
}

double SplitDistance(const SplitRule& rule) {
  if (rule.kind == SplitRule::Kind::kHandOver) return rule.at_b;
  const double near = std::min(rule.at_a, rule.at_b), far = std::max(rule.at_a, rule.at_b);
  const double quarter = (far - near) / 4;
  return Coarsest(near + quarter, far - quarter);
}

std::array<SplitRule, 2> RulesOfParts(const SplitRule& rule, double length) {
  using Kind = SplitRule::Kind;
  const double at = SplitDistance(rule);
  if (rule.kind == Kind::kHandOver) {
    return {SplitRule{Kind::kShells, false, 0, at}, SplitRule{Kind::kShells, true, length - at, 0}};
  }
  return {SplitRule{Kind::kShells, rule.from_b, rule.at_a, at},
          SplitRule{Kind::kShells, rule.from_b, at, rule.at_b}};
}

Point2 PointAt(const Point2& a, const Point2& b, double length, double distance) {
  const double fraction = distance / length;
  Point2 p;
  for (int i = 0; i < 2; ++i) p[i] = a[i] == b[i] ? a[i] : a[i] + fraction * (b[i] - a[i]);
  return p;
}

double LengthOf(const Point2& a, const Point2& b) {
  return std::sqrt(geometry::SquaredDistance(a, b));
}

}  // namespace dynmesh::meshing
