// The star of a vertex in 3D against all triples of the points and ghosts, by definition.
#include "core/meshing/space_star.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/meshing/corner_towards.h"
#include "tests/support/seed.h"

namespace dynmesh::meshing::space_star_test {
namespace {

using geometry::Point3;
using Triangle = std::array<Point3, 3>;

// Positively oriented, seen from v; begins with the least.
Triangle Turned(Triangle t) {
  std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
  return t;
}

std::set<Triangle> LinkOf(const SpaceStar& star) {
  std::set<Triangle> link;
  for (const SpaceStar::Corner& c : star.corners()) {
    const auto at = [&](int k) { return star.neighbours()[c.n[k]].p; };
    EXPECT_TRUE(link.insert(Turned({at(0), at(1), at(2)})).second);
  }
  return link;
}

// By definition: no point is inside the ball of v and the three.
std::set<Triangle> LinkByDefinition(const std::vector<Point3>& others, const Point3& v) {
  std::set<Triangle> link;
  const std::size_t n = others.size();
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      for (std::size_t k = j + 1; k < n; ++k) {
        Triangle t = {others[i], others[j], others[k]};
        const int side = geometry::Orientation(v, t[0], t[1], t[2]);
        if (side == 0) continue;
        if (side < 0) std::swap(t[1], t[2]);
        const bool empty = std::ranges::all_of(others, [&](const Point3& e) {
          return e == t[0] || e == t[1] || e == t[2] || !geometry::InSphere(v, t[0], t[1], t[2], e);
        });
        if (empty) link.insert(Turned(t));
      }
    }
  }
  return link;
}

void ExpectSound(const SpaceStar& star) {
  const auto& corners = star.corners();
  const auto& neighbours = star.neighbours();
  std::vector<int> degree(neighbours.size());
  for (int i = 0; i < static_cast<int>(corners.size()); ++i) {
    for (int k = 0; k < 3; ++k) {
      const int slot = corners[i].n[k];
      ++degree[slot];
      // The edge opposite to k, the other way round, in the corner across.
      const auto& other = corners[corners[i].across[k]];
      const auto back = std::find(other.across.begin(), other.across.end(), i);
      ASSERT_NE(back, other.across.end());
      const auto m = static_cast<std::size_t>(back - other.across.begin());
      EXPECT_EQ(other.n[(m + 1) % 3], corners[i].n[(k + 2) % 3]);
      EXPECT_EQ(other.n[(m + 2) % 3], corners[i].n[(k + 1) % 3]);
      // Around the neighbour it comes back, after as many as there are.
      int at = i, index = k, count = 0;
      do {
        std::tie(at, index) = star.NextAround(at, index);
        EXPECT_EQ(corners[at].n[index], slot);
      } while (++count <= 100 && at != i);
      EXPECT_EQ(count, neighbours[slot].degree);
    }
  }
  int vertices = 0;
  for (std::size_t s = 0; s < neighbours.size(); ++s) {
    EXPECT_EQ(neighbours[s].degree, degree[s]);
    vertices += degree[s] > 0;
  }
  EXPECT_EQ(static_cast<int>(corners.size()), 2 * vertices - 4);  // a sphere, by Euler
}

// Of the corner's four points: equal distances in long doubles, as near as the error says.
void ExpectCentresRight(const SpaceStar& star) {
  for (const SpaceStar::Corner& c : star.corners()) {
    if (!(c.error < 1e-3 * star.reach())) continue;
    for (const int slot : c.n) {
      const auto& n = star.neighbours()[slot];
      // The plane halfway between v and n: w . d = d^2 / 2.
      long double power = 0, size = 0;
      for (int k = 0; k < 3; ++k) {
        const long double d = static_cast<long double>(n.p[k]) - star.position()[k];
        power += d * d / 2 - d * c.w[k];
        size += std::fabs(d);
      }
      EXPECT_LE(std::fabs(power), size * c.error);
    }
  }
}

enum class Kind { kUniform, kGrid, kCospherical, kFlat, kLineAndCircle, kScales };

class Source {
 public:
  Source(Kind kind, std::uint64_t seed) : kind_(kind), random_(seed) {}
  Point3 Next() {
    switch (kind_) {
      case Kind::kUniform:
        return {{Unit(), Unit(), Unit()}};
      case Kind::kGrid:
        return {{double(Below(3)), double(Below(3)), double(Below(3))}};
      case Kind::kCospherical: {  // x^2 + y^2 + z^2 = 9
        static constexpr int kPlaces[][3] = {{3, 0, 0}, {0, 3, 0}, {0, 0, 3},
                                             {1, 2, 2}, {2, 1, 2}, {2, 2, 1}};
        const auto& place = kPlaces[Below(6)];
        Point3 p;
        for (int k = 0; k < 3; ++k) p[k] = Below(2) == 0 ? place[k] : -place[k];
        return Below(8) == 0 ? Point3{{0, 0, 0}} : p;
      }
      case Kind::kFlat:
        return {{double(Below(5)), double(Below(5)), Below(4) == 0 ? 1.0 : 0.0}};
      case Kind::kLineAndCircle:
        if (Below(2) == 0) return {{0, 0, double(Below(17) - 8)}};
        return {{std::cos(Below(12) * 0.5), std::sin(Below(12) * 0.5), 0}};
      default: {
        const double scale = std::exp2(-Below(40));
        return {{scale * Unit(), scale * Unit(), scale * Unit()}};
      }
    }
  }
  int Below(int n) { return static_cast<int>(random_() % static_cast<unsigned>(n)); }
  double Unit() { return std::uniform_real_distribution<double>()(random_); }
  std::mt19937_64& engine() { return random_; }

 private:
  Kind kind_;
  std::mt19937_64 random_;
};

class SpaceStarTest : public testing::TestWithParam<Kind> {};

TEST_P(SpaceStarTest, IsThatOfTheTetrahedralisationOfPointsAndGhosts) {
  const std::uint64_t base = test::NewSeed();
  int with_ghosts = 0, without = 0, errors_known = 0;
  SpaceStar star, other;
  for (std::uint64_t round = 0; round < 60; ++round) {
    SCOPED_TRACE("seed " + std::to_string(base) + " round " + std::to_string(round));
    Source source(GetParam(), base + round);
    std::set<Point3> set;
    const int count = 3 + source.Below(14);
    for (int i = 0; i < count; ++i) set.insert(source.Next());
    std::vector<Point3> points(set.begin(), set.end());
    std::shuffle(points.begin(), points.end(), source.engine());
    const Point3 v = points.back();
    points.pop_back();
    double reach = 0.3 * std::exp2(source.Below(8));
    const auto is_taken = [&](const Point3& q) { return set.contains(q); };
    for (int k = 0; k < 6; ++k) {
      if (is_taken(SpaceStar::Ghost(v, reach, k))) reach *= 1.01;
    }
    star.Begin(99, v, reach);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const bool has = star.Insert(static_cast<SpaceStar::Id>(i), points[i]);
      EXPECT_EQ(has, star.Has(static_cast<SpaceStar::Id>(i)));
      ExpectSound(star);
    }
    ExpectCentresRight(star);
    std::vector<Point3> all = points;
    for (int k = 0; k < 6; ++k) all.push_back(SpaceStar::Ghost(v, reach, k));
    const std::set<Triangle> link = LinkOf(star);
    EXPECT_EQ(link, LinkByDefinition(all, v));
    bool ghosts = false;
    for (const auto& n : star.neighbours()) ghosts |= n.degree > 0 && SpaceStar::IsGhost(n.id);
    ++(ghosts ? with_ghosts : without);
    for (const auto& c : star.corners()) errors_known += c.error < 1e-6;
    // In another order: the same link, and the same centres to the bit.
    std::vector<std::size_t> order(points.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::shuffle(order.begin(), order.end(), source.engine());
    other.Begin(99, v, reach);
    for (const std::size_t i : order) other.Insert(static_cast<SpaceStar::Id>(i), points[i]);
    EXPECT_EQ(LinkOf(other), link);
    const auto centres = [](const SpaceStar& s) {
      std::multiset<std::array<double, 3>> set_of_centres;
      for (const auto& c : s.corners()) set_of_centres.insert(c.w);
      return set_of_centres;
    };
    EXPECT_EQ(centres(other), centres(star));
  }
  EXPECT_GT(with_ghosts, 0);
  EXPECT_GT(errors_known, 0);
}

// An operation stores its reads as neighbours and triangles.
SpaceStar Rejoined(const SpaceStar& star) {
  SpaceStar joined;
  joined.BeginLink(star.vertex(), star.position(), star.reach());
  std::vector<int> slots(static_cast<std::size_t>(star.slot_count()), -1);
  for (int slot = 0; slot < star.slot_count(); ++slot) {
    if (SpaceStar::IsUsed(star[slot])) {
      slots[slot] = joined.AddNeighbour(star[slot].id, star[slot].p);
    }
  }
  for (const auto& c : star.corners()) {
    joined.AddCorner({slots[c.n[0]], slots[c.n[1]], slots[c.n[2]]});
  }
  joined.JoinCorners();
  joined.Close();
  return joined;
}

// A few at a time, against a star of those that stay.
TEST_P(SpaceStarTest, LosesNeighboursAsIfTheyHadNotBeenThere) {
  const std::uint64_t base = test::NewSeed();
  int removed = 0, refused = 0;
  for (std::uint64_t round = 0; round < 200; ++round) {
    SCOPED_TRACE("seed " + std::to_string(base) + " round " + std::to_string(round));
    Source source(GetParam(), base + round);
    std::set<Point3> set;
    const int count = 8 + source.Below(40);
    for (int i = 0; i < count; ++i) set.insert(source.Next());
    std::vector<Point3> points(set.begin(), set.end());
    std::shuffle(points.begin(), points.end(), source.engine());
    const Point3 v = points.back();
    points.pop_back();
    const double reach = 1.3 * std::exp2(source.Below(4));
    SpaceStar whole;
    whole.Begin(99, v, reach);
    for (std::size_t i = 0; i < points.size(); ++i) {
      whole.Insert(static_cast<SpaceStar::Id>(i), points[i]);
    }
    SpaceStar star = Rejoined(whole);
    ExpectSound(star);
    EXPECT_EQ(LinkOf(star), LinkOf(whole));
    SpaceStar wanted;
    wanted.Begin(99, v, reach);
    bool done = true;
    for (int slot = 0, slots = star.slot_count(); slot < slots && done; ++slot) {
      if (SpaceStar::IsGhost(star[slot].id)) continue;
      if (source.Below(4) == 0) {
        done = star.Remove(slot);
        ++(done ? removed : refused);
      } else {
        wanted.Insert(star[slot].id, star[slot].p);
      }
    }
    if (!done) continue;
    star.InsertGhosts();
    ExpectSound(star);
    EXPECT_EQ(LinkOf(star), LinkOf(wanted));
    ExpectCentresRight(star);
    // It can be used for later points like any other.
    for (int i = 0; i < 5; ++i) {
      const Point3 q = source.Next();
      if (set.insert(q).second) {
        EXPECT_EQ(star.Insert(1000 + i, q), wanted.Insert(1000 + i, q));
        ExpectSound(star);
      }
    }
    EXPECT_EQ(LinkOf(star), LinkOf(wanted));
  }
  EXPECT_GT(removed, 0);
}

TEST_P(SpaceStarTest, TheCornerTowardsAPointDecidesWhetherThePointIsANeighbour) {
  const std::uint64_t base = test::NewSeed();
  int yes = 0, no = 0;
  for (std::uint64_t round = 0; round < 100; ++round) {
    SCOPED_TRACE("seed " + std::to_string(base) + " round " + std::to_string(round));
    Source source(GetParam(), base + round);
    std::set<Point3> set;
    for (int i = 0; i < 20; ++i) set.insert(source.Next());
    std::vector<Point3> points(set.begin(), set.end());
    std::shuffle(points.begin(), points.end(), source.engine());
    const Point3 v = points.back();
    points.pop_back();
    SpaceStar star;
    star.Begin(99, v, 4);
    for (std::size_t i = 0; i < points.size(); ++i) {
      star.Insert(static_cast<SpaceStar::Id>(i), points[i]);
    }
    std::vector<std::array<double, 3>> directions;
    for (const auto& n : star.neighbours()) directions.push_back(n.d);
    for (int j = 0; j < 40; ++j) {
      // Among them, around them, and beside one that is there.
      Point3 q = source.Next();
      if (j % 2 == 0) {
        for (int k = 0; k < 3; ++k) q[k] += (source.Unit() - 0.5) * std::exp2(-source.Below(30));
      }
      if (set.contains(q)) continue;
      const int i =
          CornerTowards(directions, star.corner_count(), [&](int c) { return star.corner(c).n; },
                        {q[0] - v[0], q[1] - v[1], q[2] - v[2]});
      if (i < 0) continue;
      bool any = false;
      for (int c = 0; c < star.corner_count(); ++c) any = any || star.Conflicts(c, q);
      EXPECT_EQ(star.Conflicts(i, q), any);
      ++(any ? yes : no);
    }
  }
  EXPECT_GT(yes, 0);
  EXPECT_GT(no, 0);
}

INSTANTIATE_TEST_SUITE_P(All, SpaceStarTest,
                         testing::Values(Kind::kUniform, Kind::kGrid, Kind::kCospherical,
                                         Kind::kFlat, Kind::kLineAndCircle, Kind::kScales));

TEST(SpaceStar, AloneItIsACube) {
  SpaceStar star;
  star.Begin(1, {{5, 6, 7}}, 2);
  EXPECT_EQ(star.corners().size(), 8U);
  ExpectSound(star);
  for (const auto& c : star.corners()) {
    for (const double w : c.w) EXPECT_EQ(std::fabs(w), 2);
    EXPECT_EQ(c.r2, 12);
    EXPECT_FALSE(c.verified);
  }
}

// A Voronoi vertex without other points in its ball stays unchanged, verified or not.
TEST(SpaceStar, WhatIsVerifiedStaysSo) {
  SpaceStar star;
  star.Begin(1, {{0, 0, 0}}, 2);
  for (int i = 0; i < 8; ++i) star.MarkVerified(i);
  ASSERT_TRUE(star.Insert(2, {{1, 1, 1}}));
  int verified = 0;
  for (const auto& c : star.corners()) {
    verified += c.verified;
    EXPECT_EQ(c.verified,
              std::ranges::none_of(c.n, [&](int s) { return star.neighbours()[s].id == 2; }));
  }
  EXPECT_GT(verified, 0);
}

}  // namespace
}  // namespace dynmesh::meshing::space_star_test
