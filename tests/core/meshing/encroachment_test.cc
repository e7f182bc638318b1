// Encroachment against all vertices and all subsegments, by definition; ties by the triangulation
// of all vertices.
#include "core/meshing/encroachment.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::encroachment_test {
namespace {

constexpr std::uint64_t kSeed = 20261126;
constexpr int kTimes = 4;

template <int D>
bool IsEdge(const TriangulationOf<D>& triangulation, VertexIndex a, VertexIndex b) {
  bool found = false;
  triangulation.ForEachSimplexAround(a, [&](auto t) {
    found =
        found || std::ranges::find(triangulation.vertices(t), b) != triangulation.vertices(t).end();
  });
  return found;
}

template <int D>
struct Scene {
  using Search = EncroachmentSearch<D, test::RecordingEngine>;

  Scene(Layout layout, int points, int segments, test::Random& random) : search(lone.complex) {
    for (const auto& p : DistinctPlaces<D>(layout, points, random)) {
      lone.Add(p, random.OneIn(2) ? 0 : AnyTime(random));
    }
    // Vertices that are never seen, so that cells are small; the test may remove them.
    for (int i = random.Below(200); i > 0; --i) {
      const Layout where = random.OneIn(2) ? Layout::kRandom : Layout::kClustered;
      unseen.push_back(lone.Add(RandomPlace<D>(where, random), kTimes + 1));
    }
    const auto all = lone.SeenAt(kTimes + 1);
    const auto any = [&] { return all[random.Below(static_cast<int>(all.size()))]; };
    while (segments-- > 0) {
      const VertexIndex a = any();
      VertexIndex b = any();
      const auto length2 = [&](VertexIndex v) {
        return geometry::SquaredDistance(lone.complex.vertex(a).p, lone.complex.vertex(v).p);
      };
      for (int tries = random.Below(60); tries > 0; --tries) {  // some are short
        const VertexIndex c = any();
        if (c != a && (b == a || length2(c) < length2(b))) b = c;
      }
      if (a == b) continue;
      const sac::Stamp exposed = random.Below(kTimes);
      subsegments.push_back(lone.AddSubsegment(
          a, b, exposed, random.OneIn(2) ? sac::kNoStamp : exposed + 1 + random.Below(2)));
    }
  }
  static sac::Stamp AnyTime(test::Random& random) { return 1 + random.Below(kTimes); }
  int Sign(const Subsegment<D>& s, const geometry::Point<D>& x) const {
    const auto &a = lone.complex.vertex(s.a).p, &b = lone.complex.vertex(s.b).p;
    return DiametralBallSign(a, b, x);
  }

  LoneComplex<D> lone;
  Search search;
  std::vector<SubsegmentIndex> subsegments;
  std::vector<VertexIndex> unseen;
};

template <int D, class F>
void ForScenes(int rounds, F f) {
  test::Random random(kSeed);
  for (const Layout layout : kLayouts) {
    for (int round = 0; round < rounds; ++round) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", layout " +
                   std::to_string(static_cast<int>(layout)) + ", round " + std::to_string(round));
      const int points = 3 + random.Below(60);
      Scene<D> scene(layout, points, 60, random);
      f(scene, layout, random);
      if (testing::Test::HasFailure()) return;
    }
  }
}

template <class Dimension>
class EncroachmentTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(EncroachmentTest, Dimensions);

TYPED_TEST(EncroachmentTest, WitnessesKeepTheSubsegmentOutOfTheTriangulation) {
  constexpr int D = TypeParam();
  int inside = 0, hidden = 0, clean = 0, clean_ties = 0;
  ForScenes<D>(D == 2 ? 120 : 30, [&](Scene<D>& scene, Layout, test::Random& random) {
    auto& complex = scene.lone.complex;
    const sac::Stamp now = Scene<D>::AnyTime(random);
    const auto triangulation = scene.lone.TriangulationAt(now);
    const auto seen = scene.lone.SeenAt(now);
    for (const SubsegmentIndex s : scene.subsegments) {
      const Subsegment<D> sub = complex.subsegment(s);
      if (!triangulation.Contains(sub.a) || !triangulation.Contains(sub.b)) continue;
      int within = 0, on_surface = 0;
      for (const VertexIndex v : seen) {
        if (v == sub.a || v == sub.b) continue;
        const int sign = scene.Sign(sub, complex.vertex(v).p);
        within += sign < 0;
        on_surface += sign == 0;
      }
      const bool is_edge = IsEdge<D>(triangulation, sub.a, sub.b);
      const auto witnesses = scene.search.WitnessesOf(scene.lone.At(now), s);
      ASSERT_EQ(witnesses.has_value(), within > 0 || !is_edge) << "subsegment " << s;
      if (!witnesses) {
        ++(on_surface > 0 ? clean_ties : clean);
        continue;
      }
      ASSERT_FALSE(witnesses->empty());
      for (const VertexIndex w : *witnesses) {
        EXPECT_NE(std::ranges::find(seen, w), seen.end());
        EXPECT_EQ(scene.Sign(sub, complex.vertex(w).p), within > 0 ? -1 : 0);
      }
      if (within > 0) {
        EXPECT_EQ(witnesses->size(), 1u);
        ++inside;
        continue;
      }
      ++hidden;
      // They alone keep it out.
      TriangulationOf<D> few;
      complex.ResetToDomain(&few);
      std::vector<VertexIndex> all(witnesses->begin(), witnesses->end());
      all.insert(all.end(), {sub.a, sub.b});
      for (const VertexIndex v : all) {
        if (!few.Contains(v)) few.Insert(v, complex.vertex(v).p, 0);
      }
      EXPECT_FALSE(IsEdge<D>(few, sub.a, sub.b));
    }
  });
  EXPECT_GT(inside, 100);
  EXPECT_GT(hidden, 5);
  EXPECT_GT(clean, 5);
  EXPECT_GT(clean_ties, 5);
}

TYPED_TEST(EncroachmentTest, APointEncroachesOnTheVisibleSubsegmentsWithItInTheirBalls) {
  constexpr int D = TypeParam();
  int strictly = 0, on_surface = 0;
  ForScenes<D>(30, [&](Scene<D>& scene, Layout layout, test::Random& random) {
    auto& complex = scene.lone.complex;
    for (int i = 0; i < 40; ++i) {
      // As vertices come and go, cells are cut and merged.
      if (random.OneIn(8)) {
        scene.unseen.push_back(
            scene.lone.Add(RandomPlace<D>(Layout::kClustered, random), kTimes + 1));
      }
      for (int k = random.Below(10); k > 0 && !scene.unseen.empty(); --k) {
        scene.lone.Remove(scene.unseen.back());
        scene.unseen.pop_back();
      }
      const sac::Stamp now = Scene<D>::AnyTime(random);
      const geometry::Point<D> x = RandomPlace<D>(layout, random);
      std::vector<std::pair<SubsegmentIndex, bool>> naive, found;
      for (const SubsegmentIndex s : scene.subsegments) {
        const Subsegment<D>& sub = complex.subsegment(s);
        const bool is_dead = sub.death != sac::kNoStamp && sub.death < now;
        const int sign = scene.Sign(sub, x);
        if (sub.exposed < now && !is_dead && sign <= 0) naive.emplace_back(s, sign < 0);
        on_surface += sign == 0;
        strictly += sign < 0;
      }
      for (const auto& e : scene.search.EncroachedBy(scene.lone.At(now), x)) {
        found.emplace_back(e.s, e.strictly);
      }
      std::ranges::sort(naive);
      std::ranges::sort(found);
      ASSERT_EQ(found, naive);
    }
  });
  EXPECT_GT(strictly, 500);
  EXPECT_GT(on_surface, 50);
}

// With the domain's sides alone, points in the middle are answered without a search.
TEST(Encroachment, OnTheSidesOfTheDomain) {
  LoneComplex<2> lone;
  auto& complex = lone.complex;
  std::vector<Subsegment<2>> sides;
  for (VertexIndex a = 0; a < complex.elements.vertex_end(); ++a) {
    for (VertexIndex b = 0; b < a; ++b) {
      const double d2 = geometry::SquaredDistance(complex.vertex(a).p, complex.vertex(b).p);
      if (d2 > 1.01 * complex.rules.grid_spacing() * complex.rules.grid_spacing()) continue;
      sides.push_back(complex.subsegment(lone.AddSubsegment(a, b)));
    }
  }
  ASSERT_EQ(sides.size(), 24u);
  complex.border_only = true;
  EncroachmentSearch<2, test::RecordingEngine> search(complex);
  test::Random random(kSeed);
  const auto &lo = complex.rules.lo(), &hi = complex.rules.hi();
  int found = 0;
  for (int i = 0; i < 3000; ++i) {
    geometry::Point2 x;
    for (int k = 0; k < 2; ++k) x[k] = lo[k] + (hi[k] - lo[k]) * random.Unit();
    const auto naive = std::ranges::count_if(sides, [&](const Subsegment<2>& s) {
      return DiametralBallSign(complex.vertex(s.a).p, complex.vertex(s.b).p, x) <= 0;
    });
    ASSERT_EQ(search.EncroachedBy(lone.At(1), x).size(), static_cast<std::size_t>(naive));
    found += naive > 0;
  }
  EXPECT_GT(found, 100);
}

}  // namespace
}  // namespace dynmesh::meshing::encroachment_test
