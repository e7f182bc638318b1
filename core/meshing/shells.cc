#include "core/meshing/shells.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "core/base/rounding.h"
#include "core/geometry/angles.h"
#include "core/geometry/vectors.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {
namespace {

using geometry::Dot;
using geometry::Minus;
using geometry::Point;

template <int D>
using Vector = std::array<double, D>;

// |u x w|. The same for w, u.
double Across(const Vector<2>& u, const Vector<2>& w) {
  return std::fabs(u[0] * w[1] - u[1] * w[0]);
}
double Across(const Vector<3>& u, const Vector<3>& w) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const double minor = u[i] * w[j] - u[j] * w[i];
    sum += minor * minor;
  }
  return std::sqrt(sum);
}

// Calls f(i, j) for the pairs of segments that may be neighbours.
template <class F>
void ForEachPair(const Point<2>& apex, std::span<const Point<2>> others, F f) {
  const std::size_t n = others.size();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return geometry::PrecedesInAngle(apex, others[i], others[j]);
  });
  for (std::size_t i = 0; i < n; ++i) f(order[i], order[i + 1 == n ? 0 : i + 1]);
}
template <class F>
void ForEachPair(const Point<3>&, std::span<const Point<3>> others, F f) {
  for (std::size_t i = 0; i < others.size(); ++i) {
    for (std::size_t j = i + 1; j < others.size(); ++j) f(i, j);
  }
}

}  // namespace

template <int D>
std::vector<WedgeEnd> FindWedges(const Point<D>& apex, std::span<const Point<D>> others) {
  std::vector<WedgeEnd> ends(others.size());
  if (others.size() < 2 || !IsOn(RefinementTerm::kSharpOnShells)) return ends;
  ForEachPair(apex, others, [&](std::size_t s, std::size_t t) {
    if (!geometry::IsSmallAngle(apex, others[s], others[t])) return;
    const Vector<D> u = Minus(others[s], apex), w = Minus(others[t], apex);
    const double dot = Dot(u, w);
    const double lu = std::sqrt(Dot(u, u)), lw = std::sqrt(Dot(w, w));
    const double sine = Across(u, w) / (lu * lw);
    const auto meet = [sine](WedgeEnd& end, double reach) {
      end.acute = true;
      end.sine = std::min(end.sine, sine);
      end.reach = std::max(end.reach, reach);
    };
    meet(ends[s], std::min(lu, dot / lu));
    meet(ends[t], std::min(lw, dot / lw));
  });
  return ends;
}

template std::vector<WedgeEnd> FindWedges(const Point<2>&, std::span<const Point<2>>);
template std::vector<WedgeEnd> FindWedges(const Point<3>&, std::span<const Point<3>>);

namespace {

// Let two segments meet at an angle of sine s. Beside the subsegment of one between two shells, the
// vertex of the other on such a shell is outside of the ball unless it is off by s^2 / 2 of the
// subsegment. It is off by its skew and that of the subsegment's end. Each is at most 2^-e of the
// subsegment whose split made it, which was at most four times as long. So 2^-e = s^2 / 16 would
// do; this is an eighth of that, and at most a millionth. It is a power of two, so that it seldom
// changes with s.
constexpr int kLeastExponent = 20, kMostExponent = 40;
int SkewExponent(double squared_sine) { return 7 - std::ilogb(squared_sine * kNarrower); }
std::uint8_t SkewExponent(const WedgeEnd& end) {
  if (!end.acute || !IsOn(RefinementTerm::kSkewedShells)) return 0;
  return static_cast<std::uint8_t>(
      std::clamp(SkewExponent(end.sine * end.sine), kLeastExponent, kMostExponent));
}

}  // namespace

// The handover is where both wedges are equally wide, if that is beyond the neighbours' shadows or
// in between them. Else it is the end of the nearer shadow, moved a little to the side: exactly at
// that foot the neighbour's end would lie on the balls of both parts.
//
// In 3D it is the middle if that is nearly the same. Half of a square's diagonal encroaches on
// nothing, a little more does on the square's sides: flat faces in triangles have up to 40 % fewer
// vertices.
template <int D>
SegmentShape ShapeOf(double length, const WedgeEnd& a, const WedgeEnd& b) {
  constexpr double kNearMiddle = 1.0 / 64;
  SegmentShape shape{a.acute, b.acute, 0};
  if constexpr (D == 3) {
    shape.skew_at_a = SkewExponent(a);
    shape.skew_at_b = SkewExponent(b);
  }
  if (!a.acute || !b.acute) return shape;
  const double balance = length * b.sine / (a.sine + b.sine);
  const double from_a = a.reach, to_b = length - b.reach;
  const auto [lo, hi] = std::minmax(from_a, to_b);
  const double ideal = std::clamp(balance, lo, hi);
  if (D == 3 && std::fabs(ideal - length / 2) < kNearMiddle * length) {
    shape.handover = length / 2;
  } else if (from_a < ideal && ideal < to_b) {
    const double width = std::min(ideal, length - ideal) / 4;
    shape.handover = Coarsest(std::max(from_a, ideal - width), std::min(to_b, ideal + width));
  } else {
    shape.handover =
        ideal - std::min(ideal * (a.sine * a.sine), (length - ideal) * (b.sine * b.sine)) / 16;
  }
  return shape;
}

template SegmentShape ShapeOf<2>(double, const WedgeEnd&, const WedgeEnd&);
template SegmentShape ShapeOf<3>(double, const WedgeEnd&, const WedgeEnd&);

// Where both are normal numbers of one power of two, the order of doubles is that of their words:
// the last bits of a number may be 0 from the first one on in which it differs from what is below
// lo.
double Coarsest(double lo, double hi) {
  constexpr int kFraction = 52;
  const auto below = std::bit_cast<std::uint64_t>(lo) - 1, most = std::bit_cast<std::uint64_t>(hi);
  if (lo > 0x1p-900 && lo <= hi && hi < 0x1p900) {
    const std::uint64_t tail = std::bit_floor(below ^ most) - 1;
    return std::bit_cast<double>(most & ~std::min(tail, (std::uint64_t{1} << kFraction) - 1));
  }
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
  SplitRule rule{Kind::kHalve, false, shape.skew_at_a, shape.skew_at_b};
  if (shape.unsplit) {
    rule.kind = Kind::kUnsplit;
  } else if (shape.acute_at_a && shape.acute_at_b) {
    rule.kind = Kind::kHandOver;
    rule.at_b = shape.handover;
  } else if (shape.acute_at_a || shape.acute_at_b) {
    rule.kind = Kind::kShells;
    rule.from_b = shape.acute_at_b;
    (rule.from_b ? rule.at_a : rule.at_b) = length;
  }
  return rule;
}

// A triangle wave: libm's sine may have other bits elsewhere. The numbers have nothing in common.
double WaveOf(const std::array<double, 3>& u) {
  constexpr std::array<double, 3> kWaves = {1021.3762, 1453.0917, 1279.6481};
  const double at = Dot(u, kWaves);
  return 4 * std::fabs(at - std::nearbyint(at)) - 1;
}

// It is constant over ranges of the angle, so that two counterparts in nearly one direction mostly
// have the same. Else it differs: two pairs of counterparts would be a trapezoid as well.
double SkewOfCounterpart(double squared_sine) {
  constexpr double kLeastCounted = 0x1p-33;
  if (!(squared_sine > kLeastCounted) || !IsOn(RefinementTerm::kSkewedShells)) return 0;
  int exponent = 0;
  const int eighths = static_cast<int>(8 * std::frexp(squared_sine * kNarrower, &exponent));
  const double most = std::ldexp(eighths, exponent - 3 - 7);  // s^2 / 128, as above
  // A millionth at most. From s^2 = 2^-13 to 1 there are 52 ranges; here they are numbered from 1.
  const int steps = eighths - 3 + 4 * (exponent + 12);
  return steps <= 0 ? most : std::ldexp(1 - steps / 64.0, -kLeastExponent);
}

double SplitDistance(const SplitRule& rule) {
  if (rule.kind == SplitRule::Kind::kHandOver) return rule.at_b;
  const double near = std::min(rule.at_a, rule.at_b), far = std::max(rule.at_a, rule.at_b);
  const double quarter = (far - near) / 4;
  return Coarsest(near + quarter, far - quarter);
}

std::array<SplitRule, 2> RulesOfParts(const SplitRule& rule, double length) {
  const double at = SplitDistance(rule);
  std::array<SplitRule, 2> parts = {rule, rule};
  if (rule.kind == SplitRule::Kind::kHandOver) {
    parts[0].kind = parts[1].kind = SplitRule::Kind::kShells;
    parts[0].at_b = at;
    parts[1].from_b = true;
    parts[1].at_a = length - at;
    parts[1].at_b = 0;
  } else {
    parts[0].at_b = at;
    parts[1].at_a = at;
  }
  return parts;
}

}  // namespace dynmesh::meshing
