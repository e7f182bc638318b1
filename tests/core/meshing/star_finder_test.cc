// The star of a vertex as of a time, found locally, from any seed, from a former star, and read off
// a triangulation: each is the star of all vertices seen, inserted one by one.
#include "core/meshing/star_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::star_finder_test {
namespace {

constexpr std::uint64_t kSeed = 20261125;

template <int D>
using Corners = std::vector<std::array<std::uint32_t, D>>;

template <int D>
std::array<std::uint32_t, D> Turned(std::array<std::uint32_t, D> ids) {
  if (D == 3) std::ranges::rotate(ids, std::ranges::min_element(ids));
  return ids;
}
template <int D>
Corners<D> CornersOf(const Star<D>& star) {
  Corners<D> corners;
  for (int i = 0; i < star.corner_count(); ++i) corners.push_back(Turned<D>(star.IdsOf(i)));
  std::ranges::sort(corners);
  return corners;
}
template <int D>
Corners<D> CornersIn(std::span<const std::uint32_t> words) {
  Corners<D> corners;
  ForEachCornerIn<D>(words, [&](const auto& ids) {
    corners.push_back(Turned<D>(ids));
    return true;
  });
  std::ranges::sort(corners);
  return corners;
}

template <int D>
class Scene {
 public:
  using Lone = LoneComplex<D>;
  using Context = typename Lone::Context;
  using Finder = StarFinder<D, test::RecordingEngine>;

  Scene(Layout layout, int count, test::Random& random) : random_(random) {
    for (const auto& p : DistinctPlaces<D>(layout, count, random)) {
      lone.Add(p, random.OneIn(2) ? 0 : 1 + random.Below(kTimes));
    }
    // On a side of the domain or near it.
    const auto &lo = lone.complex.rules.lo(), &hi = lone.complex.rules.hi();
    for (int i = random.Below(20); i > 0; --i) {
      typename Lone::Point p;
      for (int k = 0; k < D; ++k) p[k] = lo[k] + (hi[k] - lo[k]) * (0.01 + 0.98 * random.Unit());
      const int axis = random.Below(D);
      const double away = random.OneIn(3) ? 0 : std::ldexp(0.1, -random.Below(8));
      p[axis] = random.OneIn(2) ? lo[axis] + away : hi[axis] - away;
      lone.Add(p, random.OneIn(2) ? 0 : 1 + random.Below(kTimes));
    }
  }
  // After 0 to kTimes - 1 of the births.
  sac::Stamp AnyTime() { return 1 + random_.Below(kTimes + 1); }
  VertexIndex AnySeenAt(sac::Stamp now) {
    const auto seen = lone.SeenAt(now);
    return seen[random_.Below(static_cast<int>(seen.size()))];
  }
  // Less than the distance of the nearest vertex, or up to a multiple of it.
  double AnyReach(VertexIndex v, sac::Stamp now) {
    double near2 = INFINITY;
    for (const VertexIndex u : lone.SeenAt(now)) {
      const double d2 =
          geometry::SquaredDistance(lone.complex.vertex(u).p, lone.complex.vertex(v).p);
      if (u != v) near2 = std::min(near2, d2);
    }
    return lone.complex.rules.Reach(BucketOf(near2) - 16 + random_.Below(56));
  }
  Star<D> Naive(VertexIndex v, double reach, sac::Stamp now) {
    Star<D> star;
    star.Begin(v, lone.complex.vertex(v).p, reach);
    for (const VertexIndex u : lone.SeenAt(now)) {
      if (u != v) star.Insert(u, lone.complex.vertex(u).p);
    }
    return star;
  }
  // What a Complete of v records.
  Context Found(VertexIndex v, double reach, sac::Stamp now,
                const std::vector<std::uint32_t>& former = {}, Payload<D> kept = {}) {
    Context context = lone.At(now, v);
    context.former_reads = former;
    context.kept = kept;
    Finder finder(lone.complex);
    const Star<D>& star = finder.Find(context, v, reach, finder.FindLink(v));
    EXPECT_EQ(CornersOf<D>(star), CornersIn<D>(context.reads));
    return context;
  }
  int Below(int n) { return random_.Below(n); }

  Lone lone;

 private:
  static constexpr int kTimes = 4;
  test::Random& random_;
};

template <int D, class F>
void ForScenes(int rounds, F f) {
  test::Random random(kSeed);
  for (const Layout layout : kLayouts) {
    for (int round = 0; round < rounds; ++round) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", layout " +
                   std::to_string(static_cast<int>(layout)) + ", round " + std::to_string(round));
      Scene<D> scene(layout, 3 + random.Below(D == 2 ? 120 : 80), random);
      f(scene);
      if (testing::Test::HasFailure()) return;
    }
  }
}

template <class Dimension>
class StarFinderTest : public testing::Test {};
using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(StarFinderTest, Dimensions);

TYPED_TEST(StarFinderTest, LocalAndReadOffAreTheStarOfAllVerticesSeen) {
  constexpr int D = TypeParam();
  int with_ghosts = 0, without = 0;
  ForScenes<D>(12, [&](Scene<D>& scene) {
    const sac::Stamp now = scene.AnyTime();
    auto triangulation = scene.lone.TriangulationAt(now);
    for (int i = 0; i < 15; ++i) {
      const VertexIndex v = scene.AnySeenAt(now);
      const double reach = scene.AnyReach(v, now);
      const Star<D> naive = scene.Naive(v, reach, now);
      const auto local = scene.Found(v, reach, now);
      ASSERT_EQ(CornersIn<D>(local.reads), CornersOf<D>(naive)) << "vertex " << v;
      scene.lone.complex.run.Record(&triangulation);
      const auto read_off = scene.Found(v, reach, now);
      scene.lone.complex.run.LeaveTriangulation();
      ASSERT_EQ(CornersIn<D>(read_off.reads), CornersOf<D>(naive)) << "vertex " << v;
      EXPECT_EQ(read_off.kept.radius2, local.kept.radius2);
      EXPECT_EQ(read_off.kept.cover(), local.kept.cover());
      bool ghosts = false;
      naive.ForEachNeighbour([&](const auto& u) { ghosts |= Star<D>::IsGhost(u.id); });
      ++(ghosts ? with_ghosts : without);
    }
  });
  EXPECT_GT(with_ghosts, 100);
  EXPECT_GT(without, 30);
}

TYPED_TEST(StarFinderTest, TheVerifierCompletesAnySeed) {
  constexpr int D = TypeParam();
  ForScenes<D>(12, [&](Scene<D>& scene) {
    StarVerifier<D, test::RecordingEngine> verifier(scene.lone.complex);
    for (int i = 0; i < 15; ++i) {
      const sac::Stamp now = scene.AnyTime();
      const VertexIndex v = scene.AnySeenAt(now);
      const double reach = scene.AnyReach(v, now);
      const Star<D> naive = scene.Naive(v, reach, now);
      for (const int one_in : {0, 1, 2, 8}) {  // 0: the seed is empty
        Star<D> star;
        star.Begin(v, scene.lone.complex.vertex(v).p, reach);
        for (const VertexIndex u : scene.lone.SeenAt(now)) {
          if (u == v || one_in == 0 || scene.Below(one_in) != 0) continue;
          star.Insert(u, scene.lone.complex.vertex(u).p);
        }
        verifier.Run(scene.lone.At(now, v), star);
        ASSERT_EQ(CornersOf<D>(star), CornersOf<D>(naive)) << "vertex " << v << ", 1/" << one_in;
      }
    }
  });
}

// Between two executions vertices come and go, in the star and elsewhere.
TYPED_TEST(StarFinderTest, TheFormerStarIsBroughtUpToDate) {
  constexpr int D = TypeParam();
  int changed = 0, kept = 0;
  ForScenes<D>(12, [&](Scene<D>& scene) {
    auto& complex = scene.lone.complex;
    for (int i = 0; i < 8; ++i) {
      const sac::Stamp now = scene.AnyTime();
      const VertexIndex v = scene.AnySeenAt(now);
      const double reach = scene.AnyReach(v, now);
      complex.appeared.clear();
      const auto former = scene.Found(v, reach, now);
      for (int k = scene.Below(4); k > 0; --k) {
        const auto ring = NeighboursIn<D>(former.reads);
        VertexIndex gone = ring[scene.Below(static_cast<int>(ring.size()))];
        if (Star<D>::IsGhost(gone) || scene.Below(3) == 0) gone = scene.AnySeenAt(now);
        const bool is_there = complex.vertex(gone).present;
        if (gone == v || !is_there || complex.vertex(gone).feature == 0) continue;
        const auto p = complex.vertex(gone).p;
        scene.lone.Remove(gone);
        if (scene.Below(2) == 0) scene.lone.Add(p, 1 + scene.Below(5));  // another, at another time
      }
      test::Random random(static_cast<std::uint64_t>(i));
      for (int k = scene.Below(4); k > 0; --k) {
        auto p = complex.vertex(v).p;
        const double scale = scene.Below(2) == 0 ? 0.01 : 0.3;
        for (int axis = 0; axis < D; ++axis) p[axis] += scale * (random.Unit() - 0.5);
        scene.lone.Add(p, 1 + scene.Below(5));
      }
      const auto found = scene.Found(v, reach, now, former.reads, former.kept);
      ASSERT_EQ(CornersIn<D>(found.reads), CornersOf<D>(scene.Naive(v, reach, now)));
      ++(CornersIn<D>(found.reads) == CornersIn<D>(former.reads) ? kept : changed);
    }
  });
  EXPECT_GT(changed, 30);
  EXPECT_GT(kept, 30);
}

// The cells subscribed to hold each ball about a corner, and the payload admits each vertex in it.
TYPED_TEST(StarFinderTest, ReadsAreWithinWhatIsSubscribedAndKept) {
  constexpr int D = TypeParam();
  ForScenes<D>(6, [&](Scene<D>& scene) {
    auto& complex = scene.lone.complex;
    for (int i = 0; i < 10; ++i) {
      const sac::Stamp now = scene.AnyTime();
      const VertexIndex v = scene.AnySeenAt(now);
      const double reach = scene.AnyReach(v, now);
      const auto found = scene.Found(v, reach, now);
      const Star<D> star = scene.Naive(v, reach, now);
      test::Random random(static_cast<std::uint64_t>(i));
      for (int k = 0; k < 60; ++k) {
        const int corner = random.Below(star.corner_count());
        auto x = CentreOf(star, corner);
        const double r = std::sqrt(star.corner(corner).r2);
        for (int axis = 0; axis < D; ++axis) x[axis] += r * (2 * random.Unit() - 1);
        if (!complex.InDomain(x) || !star.Conflicts(corner, x)) continue;
        EXPECT_TRUE(found.kept.CoverMayHold(star.position(), x));
        bool reached = false;
        complex.tree.VisitPath(x, [&](sac::Place place, sac::Parts part) {
          for (const auto& [subscribed, parts] : found.subscriptions) {
            reached |= subscribed == place && (parts & part) == part;
          }
        });
        EXPECT_TRUE(reached);
      }
    }
  });
}

}  // namespace
}  // namespace dynmesh::meshing::star_finder_test
