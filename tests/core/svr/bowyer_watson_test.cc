// The Delaunay triangulation of any dimension: that of the fast kernels in 2D and 3D, Delaunay in
// 4D.
#include "tests/core/svr/variants/bowyer_watson.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "core/delaunay/triangulation_of.h"

namespace dynmesh::delaunay::bowyer_watson_test {
namespace {

constexpr std::uint64_t kSeed = 5;

// Distinct points of the closed unit box without its corners: on a lattice, or any.
template <int D>
std::vector<geometry::Point<D>> PointsOf(int n, bool lattice, std::mt19937_64& random) {
  std::set<geometry::Point<D>> points;
  while (static_cast<int>(points.size()) < n) {
    geometry::Point<D> p;
    bool is_corner = true;
    for (double& x : p.c) {
      x = lattice ? static_cast<double>(random() % 5) / 4
                  : std::uniform_real_distribution<double>(0, 1)(random);
      is_corner = is_corner && (x == 0 || x == 1);
    }
    if (!is_corner) points.insert(p);
  }
  std::vector<geometry::Point<D>> all(points.begin(), points.end());
  std::shuffle(all.begin(), all.end(), random);
  return all;
}

template <int D>
constexpr std::array<std::uint32_t, std::size_t{1} << D> Corners() {
  std::array<std::uint32_t, std::size_t{1} << D> corners;
  for (std::uint32_t i = 0; i < corners.size(); ++i) corners[i] = i;
  return corners;
}
template <int D>
geometry::Point<D> AllOf(double x) {
  geometry::Point<D> p;
  p.c.fill(x);
  return p;
}

// Its simplices, each by the sorted positions of its corners.
template <class Triangulation>
auto SimplicesOf(const Triangulation& triangulation) {
  std::set<std::vector<std::vector<double>>> simplices;
  triangulation.ForEachSimplex([&](std::uint32_t s) {
    std::vector<std::vector<double>> corners;
    for (const std::uint32_t v : triangulation.vertices(s)) {
      const auto& p = triangulation.position(v);
      corners.emplace_back(p.c.begin(), p.c.end());
    }
    std::sort(corners.begin(), corners.end());
    simplices.insert(corners);
  });
  return simplices;
}

template <int D>
void ExpectThatOfTheFastKernel() {
  std::mt19937_64 random(kSeed);
  for (int round = 0; round < 20; ++round) {
    const auto points = PointsOf<D>(D == 2 ? 15 : 40, round % 2 == 0, random);
    BowyerWatson<D> slow;
    slow.Reset(AllOf<D>(0), AllOf<D>(1), Corners<D>());
    TriangulationOf<D> fast;
    auto corners = Corners<D>();
    if constexpr (D == 2) corners = {0, 1, 3, 2};  // counter-clockwise
    fast.Reset(AllOf<D>(0), AllOf<D>(1), corners);
    std::uint32_t v = 1u << D;
    for (const auto& p : points) {
      slow.Insert(v, p, v - 1);
      fast.Insert(v, p, v - 1);
      ++v;
      std::string why;
      ASSERT_TRUE(slow.Check(&why)) << why;
    }
    ASSERT_EQ(slow.simplex_count(), fast.simplex_count());
    ASSERT_EQ(SimplicesOf(slow), SimplicesOf(fast));
  }
}

TEST(BowyerWatson, IsTheTriangulationOf2D) { ExpectThatOfTheFastKernel<2>(); }
TEST(BowyerWatson, IsTheTriangulationOf3D) { ExpectThatOfTheFastKernel<3>(); }

TEST(BowyerWatson, DoesNotDependOnTheOrderIn4D) {
  std::mt19937_64 random(kSeed);
  for (const bool lattice : {true, false}) {
    auto points = PointsOf<4>(80, lattice, random);
    std::set<std::vector<std::vector<double>>> first;
    for (int round = 0; round < 3; ++round) {
      BowyerWatson<4> triangulation;
      triangulation.Reset(AllOf<4>(0), AllOf<4>(1), Corners<4>());
      std::uint32_t v = 16;
      for (const auto& p : points) triangulation.Insert(v, p, v - 1), ++v;
      std::string why;
      ASSERT_TRUE(triangulation.Check(&why)) << why;
      if (round == 0) first = SimplicesOf(triangulation);
      ASSERT_EQ(SimplicesOf(triangulation), first);
      std::shuffle(points.begin(), points.end(), random);
    }
  }
}

// Simplices around a vertex are those with it; balls pass through their corners.
TEST(BowyerWatson, StarsAndBallsAreRight) {
  std::mt19937_64 random(kSeed);
  BowyerWatson<4> triangulation;
  triangulation.Reset(AllOf<4>(0), AllOf<4>(1), Corners<4>());
  std::uint32_t v = 16;
  for (const auto& p : PointsOf<4>(60, false, random)) triangulation.Insert(v, p, v - 1), ++v;
  for (std::uint32_t u = 0; u < v; u += 7) {
    std::set<std::uint32_t> around, expected;
    triangulation.ForEachSimplexAround(u, [&](std::uint32_t s) {
      if (!triangulation.IsInfinite(s)) around.insert(s);
    });
    triangulation.ForEachSimplex([&](std::uint32_t s) {
      if (std::ranges::count(triangulation.vertices(s), u) > 0) expected.insert(s);
    });
    EXPECT_EQ(around, expected);
  }
  triangulation.ForEachSimplex([&](std::uint32_t s) {
    const auto ball = triangulation.BallOf(s);
    for (const std::uint32_t corner : triangulation.vertices(s)) {
      EXPECT_NEAR(geometry::SquaredDistance(triangulation.position(corner), ball.centre), ball.r2,
                  1e-6 * ball.r2);
    }
  });
}

}  // namespace
}  // namespace dynmesh::delaunay::bowyer_watson_test
