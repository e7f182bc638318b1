// Values between bounds that keep sums: of made-up parts that share vertices, where it is known
// that there are such values, or that there are none.
#include "core/transfer/region_bounds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/core/geometry/random_points.h"

namespace dynmesh::transfer {
namespace {

struct Problem {
  Range range;
  std::vector<PartShare> shares;
  std::size_t part_count = 0;
  std::vector<double> weights, values;

  std::vector<double> Sums(const std::vector<double>& of) const {
    std::vector<double> sums(part_count, 0);
    for (const PartShare& share : shares) sums[share.part] += share.amount * of[share.vertex];
    return sums;
  }
  double Size() const {
    double size = 0;
    for (const double weight : weights) size += weight;
    return size;
  }
};

Problem Shares(std::mt19937_64& random, std::size_t part_count, std::size_t vertex_count) {
  std::uniform_real_distribution<double> draw(0, 1);
  std::uniform_int_distribution<std::uint32_t> part(0, static_cast<std::uint32_t>(part_count - 1));
  Problem problem;
  problem.range.Hold(0), problem.range.Hold(1);
  problem.part_count = part_count;
  for (std::uint32_t v = 0; v < vertex_count; ++v) {
    // The first vertices join each part to the next one.
    const bool joins = v + 1 < part_count;
    const std::uint32_t first = joins ? v : part(random), second = joins ? v + 1 : part(random);
    problem.shares.push_back({v, std::min(first, second), std::pow(10, -draw(random))});
    double weight = problem.shares.back().amount;
    if (first != second) {  // on a wall
      problem.shares.push_back({v, std::max(first, second), std::pow(10, -draw(random))});
      weight += problem.shares.back().amount;
    }
    problem.weights.push_back(weight);
  }
  return problem;
}

// Values at the bounds mostly, as of a front, are changed by what no part notices. (Where shares differ
// by a factor of a thousand, one problem in two thousand misses some 1e-9 of the whole, and says so.).
TEST(RegionBounds, KeepAllSumsWhereValuesInTheBoundsDo) {
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(-1, 2);
  for (int round = 0; round < 400; ++round) {
    const std::size_t part_count = 2 + random() % 5,
                      vertex_count = part_count * (3 + random() % 30);
    Problem problem = Shares(random, part_count, vertex_count);
    for (std::size_t v = 0; v < vertex_count; ++v) {
      problem.values.push_back(std::clamp(draw(random), 0.0, 1.0));
    }
    const std::vector<double> wanted = problem.Sums(problem.values);
    // Two vertices with the same parts: what one gets the other loses.
    std::vector<double>& u = problem.values;
    for (std::size_t a = 0, s = 0; a < vertex_count; ++a) {
      std::vector<PartShare> of_a;
      for (; s < problem.shares.size() && problem.shares[s].vertex == a; ++s) {
        of_a.push_back(problem.shares[s]);
      }
      if (of_a.size() != 1) continue;
      for (const PartShare& other : problem.shares) {
        if (other.vertex <= a || other.part != of_a[0].part) continue;
        if (problem.weights[other.vertex] != other.amount) continue;
        const double mass = 0.2 * draw(random) * std::min(other.amount, of_a[0].amount);
        u[a] += mass / of_a[0].amount, u[other.vertex] -= mass / other.amount;
        break;
      }
    }
    const auto flows = ClampInParts(problem.range, problem.shares, part_count, problem.weights, u);
    EXPECT_TRUE(flows.empty()) << "round " << round << ": " << flows[0].amount;
    for (const double value : u) ASSERT_TRUE(value >= 0 && value <= 1) << value;
    const std::vector<double> sums = problem.Sums(u);
    for (std::size_t p = 0; p < part_count; ++p) {
      ASSERT_NEAR(sums[p], wanted[p], 1e-13 * problem.Size()) << "round " << round;
    }
  }
}

TEST(RegionBounds, TellWhatFlowsWhereNoValuesDo) {
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(-0.6, 1.6);
  int with_flows = 0;
  for (int round = 0; round < 400; ++round) {
    const std::size_t part_count = 2 + random() % 4, vertex_count = part_count * (2 + random() % 6);
    Problem problem = Shares(random, part_count, vertex_count);
    for (std::size_t v = 0; v < vertex_count; ++v) problem.values.push_back(draw(random));
    const std::vector<double> wanted = problem.Sums(problem.values);
    const auto flows =
        ClampInParts(problem.range, problem.shares, part_count, problem.weights, problem.values);
    with_flows += !flows.empty();
    for (const double value : problem.values) ASSERT_TRUE(value >= 0 && value <= 1) << value;
    std::vector<double> sums = problem.Sums(problem.values);
    double total = 0, total_wanted = 0;
    for (std::size_t p = 0; p < part_count; ++p) total += sums[p], total_wanted += wanted[p];
    if (total_wanted < 0 || total_wanted > problem.Size()) continue;
    ASSERT_NEAR(total, total_wanted, 1e-14 * problem.Size()) << "round " << round;
    for (const PartFlow& flow : flows) {
      EXPECT_GT(flow.amount, 0);
      sums[flow.from] += flow.amount, sums[flow.to] -= flow.amount;
    }
    for (std::size_t p = 0; p < part_count; ++p) {
      ASSERT_NEAR(sums[p], wanted[p], 1e-13 * problem.Size()) << "round " << round;
    }
  }
  EXPECT_GT(with_flows, 10);
}

// Two parts, all vertices on the wall between them: one wants all of it, the other nothing.
TEST(RegionBounds, MoveTheLeast) {
  Problem problem;
  problem.range.Hold(0), problem.range.Hold(1);
  problem.part_count = 2;
  problem.shares = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}, {1, 1, 1}, {2, 0, 1}, {3, 1, 1}};
  problem.weights = {2, 2, 1, 1};
  problem.values = {1.5, 0.5, 1, -0.25};
  // Part 0 wants 3, so all of its vertices at 1; part 1 wants 1.75, and has 2 then.
  const auto flows = ClampInParts(problem.range, problem.shares, problem.part_count,
                                  problem.weights, problem.values);
  ASSERT_EQ(flows.size(), 1U);
  EXPECT_EQ(flows[0].from, 0U);
  EXPECT_EQ(flows[0].to, 1U);
  const std::vector<double> sums = problem.Sums(problem.values);
  EXPECT_NEAR(sums[0] + sums[1], 4.75, 1e-13);
  EXPECT_NEAR(sums[0], 3 - flows[0].amount, 1e-13);
  EXPECT_NEAR(flows[0].amount, 0.125, 1e-6);
}

}  // namespace
}  // namespace dynmesh::transfer
