// Presplit: a subsegment is split if a feature disjoint from the segment is too near:
//   a point or segment that meets the open ball about the subsegment's middle, or is nearer to the
//   subsegment than an eighth of its length; a facet at squared distance < FacetReach2 from the
//   subsegment's middle.
// This is Disencroach (Fig. 5.5) by features instead of by the cells of BuildQT: remaining
// subsegments are no longer than 8 times the local feature size. Features far away have no
// influence on a segment, so an edit changes only the subsegments near it. No ball of a subsegment
// holds a vertex of a disjoint feature, so splits of one segment do not cause splits of others.
// The eighth is in four places: 64 in IsTooNear; 5/8, the farthest that such a feature is from the
// middle, and 0.125 in NearestTooNear; 0.625 in Run, for what is subscribed to.
#ifndef DYNMESH_CORE_MESHING_PRESPLIT_H_
#define DYNMESH_CORE_MESHING_PRESPLIT_H_

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/complex.h"
#include "core/meshing/emitter.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/splits.h"

namespace dynmesh::meshing {

// The rules. Functions of coordinates to the bit.
template <int D, template <class> class E>
class PresplitRules {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Subsegment = meshing::Subsegment<D>;

  // In 2D, with 1.0 changes are as small, but walls have 1 % more vertices, and one that moves
  // takes 5 % more operations. With 1.3 the worst of 700 random walls changes 61 vertices, with 1.1
  // it changes 32. In 3D the narrow seam (anchors.h) is enough.
  static constexpr double kMostInTargets = D == 2 ? 1.1 : 1.3;

  explicit PresplitRules(const Complex<D, E>& complex) : complex_(complex) {}

  // True if s is too long for a sizing region that its ball meets: longer than kMostInTargets.
  //
  // A triangle that is too large for a target h encroaches on no subsegment of length <= h. Its
  // empty ball has a radius of more than h / sqrt 2, and each point in the diametral ball is at
  // most that far from an end of the subsegment. Slightly longer ones are rarely encroached upon.
  // So sizes split hardly any subsegment after the beginning. Such splits passed on along a wall,
  // one after the other.
  bool IsTooLong(const Subsegment& s) const;
  bool IsTooLong(const Subsegment& s, const SizingRegion<D>& region) const;
  // d2: the feature's squared distance from the middle of s.
  bool IsTooNear(const Subsegment& s, const InputFeature<D>& feature, double d2) const;
  // The feature nearest to the middle of s, of those too near. *d2: its squared distance from the
  // middle. By packing, one feature is the nearest of only a few subsegments of a given length.
  std::optional<InputFeature<D>> NearestTooNear(const Subsegment& s, double* d2) const;
  // A facet farther than this from the middle leaves s whole, though it may meet the ball of s: a
  // vertex in the ball is then an anchor of the facet. Using the whole ball, 125 boxes have 4 %
  // more vertices.
  double FacetReach2(const Subsegment& s) const { return 0.125 * complex_.SquaredLength(s); }
  // True if the inside of a disjoint facet is nearer to the middle of s than FacetReach2 and, if
  // is_near, than *d2. Then *d2 becomes its squared distance. (The facet's edges are features of
  // their own.)
  bool IsFacetTooNear(const Subsegment& s, bool is_near, double* d2) const;

 private:
  const Complex<D, E>& complex_;
};

// The procedure kPresplit.
template <int D, template <class> class E>
class PresplitWork {
 public:
  PresplitWork(const Complex<D, E>& complex, Emitter<D, E>& emitter)
      : complex_(complex), emitter_(emitter), rules_(complex) {}
  void Run(ContextOf<D, E>& context);

 private:
  const Complex<D, E>& complex_;
  Emitter<D, E>& emitter_;
  PresplitRules<D, E> rules_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool PresplitRules<D, E>::IsTooLong(const Subsegment& s, const SizingRegion<D>& region) const {
  const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
  const double length = std::sqrt(geometry::SquaredDistance(a, b));
  return length > kMostInTargets * region.target &&
         region.Meets(geometry::Midpoint(a, b), 0.5 * length);
}

template <int D, template <class> class E>
bool PresplitRules<D, E>::IsTooLong(const Subsegment& s) const {
  if (complex_.sizing.empty() || !IsOn(RefinementTerm::kTooLongSplits)) return false;
  const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
  return complex_.sizing.Any(geometry::Midpoint(a, b),
                             0.5 * std::sqrt(geometry::SquaredDistance(a, b)),
                             [&](const SizingRegion<D>& region) { return IsTooLong(s, region); });
}

template <int D, template <class> class E>
bool PresplitRules<D, E>::IsTooNear(const Subsegment& s, const InputFeature<D>& feature,
                                    double d2) const {
  const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
  const double length2 = geometry::SquaredDistance(a, b);
  if (!IsOn(RefinementTerm::kNearSplits)) return false;
  return 4 * d2 < length2 || 64 * geometry::SquaredDistance(a, b, feature.p, feature.q) < length2;
}

template <int D, template <class> class E>
std::optional<InputFeature<D>> PresplitRules<D, E>::NearestTooNear(const Subsegment& s,
                                                                   double* d2) const {
  const Point &a = complex_.vertex(s.a).p, &b = complex_.vertex(s.b).p;
  const Point middle = geometry::Midpoint(a, b);
  const double length = std::sqrt(geometry::SquaredDistance(a, b));
  std::optional<InputFeature<D>> nearest;
  double least2 = 0.391 * length * length;  // (5/8)^2, rounded up
  complex_.features.VisitNear(
      middle, least2, {s.whole_a, s.whole_b},
      [&](const Point& centre, double half) {
        const double reach = half * std::sqrt(double{D}) * kWider + complex_.rules.ulp();
        const double in_ball = 0.5 * length + reach, near = 0.125 * length + reach;
        return geometry::SquaredDistance(centre, middle) < in_ball * in_ball ||
               geometry::SquaredDistance(centre, a, b) < near * near;
      },
      [&](const InputFeature<D>& f) {
        if (!f.IsDisjoint(s.whole_a, s.whole_b)) return;
        const double f2 = geometry::SquaredDistance(middle, f.p, f.q);
        if (!(f2 < least2) || !IsTooNear(s, f, f2)) return;
        nearest = f;
        least2 = f2;
      });
  *d2 = least2;
  return nearest;
}

template <int D, template <class> class E>
bool PresplitRules<D, E>::IsFacetTooNear(const Subsegment& s, bool is_near, double* d2) const {
  bool found = false;
  if constexpr (D == 3) {
    if (complex_.facets.empty() || !IsOn(RefinementTerm::kNearFacetSplits)) return false;
    const Point middle = geometry::Midpoint(complex_.vertex(s.a).p, complex_.vertex(s.b).p);
    double least2 = FacetReach2(s);
    if (is_near) least2 = std::min(least2, *d2);
    complex_.facets.ForEachNear(middle, std::sqrt(least2), [&](const Facet& facet) {
      if (facet.HasCorner(s.whole_a) || facet.HasCorner(s.whole_b)) return;
      const double h = facet.plane().Height(middle), h2 = h * h;
      if (!(h2 < least2) || !facet.IsInside(facet.plane().Foot(middle))) return;
      least2 = h2;
      found = true;
    });
    if (found) *d2 = least2;
  }
  return found;
}

template <int D, template <class> class E>
void PresplitWork<D, E>::Run(ContextOf<D, E>& context) {
  const SubsegmentIndex s = context.item;
  const Subsegment<D>& sub = complex_.subsegment(s);
  double d2 = 0;
  const auto feature = rules_.NearestTooNear(sub, &d2);
  const bool facet_is_nearer = rules_.IsFacetTooNear(sub, feature.has_value(), &d2),
             is_too_near = feature.has_value() || facet_is_nearer;
  context.payload().flag = is_too_near;
  context.payload().radius2 = is_too_near ? RoundedUp(d2) : 0;
  if constexpr (kIsTraced<D, E>) {
    const auto &a = complex_.vertex(sub.a).p, &b = complex_.vertex(sub.b).p;
    const double reach =
        is_too_near ? std::sqrt(d2) : 0.625 * std::sqrt(geometry::SquaredDistance(a, b));
    Extent<D> box = Extent<D>::Nothing();
    box.AddBall(geometry::Midpoint(a, b), reach * kWider + 2 * complex_.rules.ulp());
    complex_.Subscribe(context, box);
    if (feature && !facet_is_nearer) context.Read(feature->a), context.Read(feature->b);
  }
  if (!(is_too_near || rules_.IsTooLong(sub)) || !CanSplit(complex_, sub)) {
    return context.Request(kCheck, s, FirstCheckEpoch());
  }
  const auto [v, halves] = emitter_.EmitHalves(context, s);
  const sac::Epoch next = PresplitEpoch(complex_.subsegment(halves[0]).depth);
  for (const SubsegmentIndex half : halves) context.Request(kPresplit, half, next);
  context.Request(kNearest, v, NearestEpoch());
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PRESPLIT_H_
