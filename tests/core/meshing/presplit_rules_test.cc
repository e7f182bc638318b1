// When a subsegment is too long or has a feature too near, against all features, regions
// and facets.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/meshing/presplit.h"
#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::presplit_rules_test {
namespace {

constexpr std::uint64_t kSeed = 20261127;

template <int D>
struct Scene {
  using Feature = InputFeature<D>;

  Scene(Layout layout, int count, test::Random& from) : rules(lone.complex), random(from) {
    const auto places = DistinctPlaces<D>(layout, count, random);
    for (const auto& p : places) points.push_back(lone.Add(p));
    for (int i = 0; i < count / 3; ++i) AddSegment();
    for (const VertexIndex v : points) features.push_back(lone.complex.FeatureOf(v, v));
  }
  VertexIndex AnyPoint() { return points[random.Below(static_cast<int>(points.size()))]; }
  bool IsOnLine(const Feature& f, VertexIndex v) const {
    double uu = 0, uw = 0, ww = 0;
    for (int k = 0; k < D; ++k) {
      const double u = f.q[k] - f.p[k], w = lone.complex.vertex(v).p[k] - f.p[k];
      uu += u * u, uw += u * w, ww += w * w;
    }
    return uu * ww - uw * uw <= 1e-12 * uu * ww;
  }
  void AddSegment() {
    const VertexIndex a = AnyPoint(), b = AnyPoint();
    if (a == b || std::ranges::any_of(features, [&](const Feature& f) {
          return f.a != f.b && IsOnLine(f, a) && IsOnLine(f, b);
        })) {
      return;  // segments of the input do not overlap
    }
    segments.push_back(lone.input.AddSegment(a, b, 1));
    const Subsegment<D>& s = lone.complex.subsegment(segments.back());
    features.push_back(lone.complex.FeatureOf(s.a, s.b));
  }
  // Of a segment, from some part of it to another.
  Subsegment<D> AnySubsegment() {
    const Subsegment<D> whole =
        lone.complex.subsegment(segments[random.Below(static_cast<int>(segments.size()))]);
    Subsegment<D> part = whole;
    if (random.OneIn(4)) return part;
    const int parts = 1 << random.Below(7), first = random.Below(parts);
    const auto at = [&](int i) {
      const auto &p = lone.complex.vertex(whole.a).p, &q = lone.complex.vertex(whole.b).p;
      geometry::Point<D> x;
      for (int k = 0; k < D; ++k) x[k] = p[k] + (q[k] - p[k]) * i / parts;
      return lone.Add(x, 1);  // of a split: no feature
    };
    if (first > 0) part.a = at(first);
    if (first + 1 < parts) part.b = at(first + 1);
    return part;
  }

  LoneComplex<D> lone;
  PresplitRules<D, test::RecordingEngine> rules;
  test::Random& random;
  std::vector<VertexIndex> points;
  std::vector<SubsegmentIndex> segments;
  std::vector<Feature> features;
};

template <int D, class F>
void ForSubsegments(int rounds, int count, F f) {
  test::Random random(kSeed);
  for (const Layout layout : kLayouts) {
    for (int round = 0; round < rounds; ++round) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", layout " +
                   std::to_string(static_cast<int>(layout)) + ", round " + std::to_string(round));
      Scene<D> scene(layout, 6 + random.Below(120), random);
      if (scene.segments.empty()) continue;
      for (int i = 0; i < count; ++i) f(scene, scene.AnySubsegment());
      if (testing::Test::HasFailure()) return;
    }
  }
}

template <class Dimension>
class PresplitRulesTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(PresplitRulesTest, Dimensions);

TYPED_TEST(PresplitRulesTest, TheNearestFeatureTooNearIsThatOfAll) {
  constexpr int D = TypeParam();
  int near = 0, far = 0;
  ForSubsegments<D>(30, 30, [&](Scene<D>& scene, const Subsegment<D>& s) {
    auto& complex = scene.lone.complex;
    // Features come and go.
    if (scene.random.OneIn(3)) scene.AddSegment();
    if (scene.random.OneIn(3) && scene.segments.size() > 2) {
      const auto gone = complex.subsegment(scene.segments.back());
      const auto feature = complex.FeatureOf(gone.a, gone.b);
      scene.features.erase(std::ranges::find(scene.features, feature));
      scene.lone.input.RemoveSegment(scene.segments.back());
      scene.segments.pop_back();
    }
    const auto &a = complex.vertex(s.a).p, &b = complex.vertex(s.b).p;
    const auto middle = geometry::Midpoint(a, b);
    const double length2 = geometry::SquaredDistance(a, b);
    double least2 = INFINITY;
    for (const InputFeature<D>& f : scene.features) {
      if (f.a == s.whole_a || f.a == s.whole_b || f.b == s.whole_a || f.b == s.whole_b) continue;
      const double d2 = geometry::SquaredDistance(middle, f.p, f.q);
      const bool in_ball = d2 < length2 / 4,
                 beside = geometry::SquaredDistance(a, b, f.p, f.q) < length2 / 64;
      EXPECT_EQ(scene.rules.IsTooNear(s, f, d2), in_ball || beside);
      if (in_ball || beside) least2 = std::min(least2, d2);
    }
    double d2 = 0;
    const auto found = scene.rules.NearestTooNear(s, &d2);
    ASSERT_EQ(found.has_value(), least2 < INFINITY);
    if (found) {
      EXPECT_EQ(d2, least2);
      EXPECT_EQ(geometry::SquaredDistance(middle, found->p, found->q), least2);
    }
    ++(found ? near : far);
  });
  EXPECT_GT(near, 100);
  EXPECT_GT(far, 50);
}

TYPED_TEST(PresplitRulesTest, ASubsegmentIsTooLongIfItIsForAnyRegion) {
  constexpr int D = TypeParam();
  int too_long = 0, fine = 0;
  ForSubsegments<D>(20, 30, [&](Scene<D>& scene, const Subsegment<D>& s) {
    auto& complex = scene.lone.complex;
    test::Random& random = scene.random;
    std::vector<SizingRegion<D>> regions;
    std::vector<typename SizingField<D>::Index> indices;
    for (int i = random.Below(5); i > 0; --i) {
      SizingRegion<D> region;
      const auto p = RandomPlace<D>(Layout::kRandom, random);
      for (int k = 0; k < D; ++k) {
        region.lo[k] = p[k];
        region.hi[k] = p[k] + 0.2 * random.Unit();
      }
      region.radius = random.OneIn(2) ? 0 : 0.2 * random.Unit();
      region.target = 0.02 + 0.3 * random.Unit();
      regions.push_back(region);
      indices.push_back(scene.lone.input.AddSizing(region));
    }
    const auto &a = complex.vertex(s.a).p, &b = complex.vertex(s.b).p;
    const double length = std::sqrt(geometry::SquaredDistance(a, b));
    bool naive = false;
    for (const auto& region : regions) {
      const double most = (D == 2 ? 1.1 : 1.3) * region.target;
      naive |= length > most && region.Meets(geometry::Midpoint(a, b), length / 2);
    }
    ASSERT_EQ(scene.rules.IsTooLong(s), naive);
    ++(naive ? too_long : fine);
    for (const auto index : indices) scene.lone.input.RemoveSizing(index);
  });
  EXPECT_GT(too_long, 100);
  EXPECT_GT(fine, 100);
}

TEST(PresplitRules, TheNearestFacetIsThatOfAll) {
  int near = 0, far = 0, nearer_than_feature = 0;
  ForSubsegments<3>(40, 20, [&](Scene<3>& scene, const Subsegment<3>& s) {
    auto& complex = scene.lone.complex;
    std::vector<FacetIndex> facets;
    for (int i = scene.random.Below(5); i > 0; --i) {
      const std::array corners = {scene.AnyPoint(), scene.AnyPoint(), scene.AnyPoint()};
      const auto [p, q, r] = std::array{complex.vertex(corners[0]).p, complex.vertex(corners[1]).p,
                                        complex.vertex(corners[2]).p};
      const auto normal =
          geometry::Cross(geometry::Difference(q.c, p.c), geometry::Difference(r.c, p.c));
      if (geometry::Dot(normal, normal) < 1e-4) continue;
      const std::vector<std::vector<VertexIndex>> rings = {{corners.begin(), corners.end()}};
      facets.push_back(scene.lone.input.AddFacet(rings, 1000 + facets.size()));
    }
    const auto middle = geometry::Midpoint(complex.vertex(s.a).p, complex.vertex(s.b).p);
    for (const bool with_feature : {false, true}) {
      const double given2 = complex.SquaredLength(s) * 0.1 * scene.random.Unit();
      double least2 = complex.SquaredLength(s) / 8;
      if (with_feature) least2 = std::min(least2, given2);
      const double limit2 = least2;
      for (const FacetIndex f : facets) {
        const Facet& facet = complex.facets[f];
        if (facet.HasCorner(s.whole_a) || facet.HasCorner(s.whole_b)) continue;
        if (!facet.IsInside(facet.plane().Foot(middle))) continue;
        const double height = facet.plane().Height(middle);
        least2 = std::min(least2, height * height);
      }
      double d2 = given2;
      const bool found = scene.rules.IsFacetTooNear(s, with_feature, &d2);
      ASSERT_EQ(found, least2 < limit2);
      EXPECT_EQ(d2, found ? least2 : given2);
      ++(found ? near : far);
      nearer_than_feature += found && with_feature;
    }
    for (const FacetIndex f : facets) scene.lone.input.RemoveFacet(f);
  });
  EXPECT_GT(near, 20);
  EXPECT_GT(far, 100);
  EXPECT_GT(nearer_than_feature, 5);
}

}  // namespace
}  // namespace dynmesh::meshing::presplit_rules_test
