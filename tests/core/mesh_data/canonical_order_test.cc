#include "core/mesh_data/canonical_order.h"

#include <algorithm>
#include <array>
#include <numeric>

#include "core/geometry/space_predicates.h"
#include "gtest/gtest.h"
#include "tests/core/mesh_data/made_up_mesh.h"

namespace dynmesh::mesh_data {
namespace {

template <std::size_t N>
bool IsEven(const std::array<int, N>& permutation) {
  bool even = true;
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t k = 0; k < i; ++k) even ^= permutation[k] > permutation[i];
  }
  return even;
}

// All orders of ids in ascending order: the even ones come to that order, the odd ones to the
// other one with the least first (and the next least second).
template <std::size_t N>
void CheckAllOrders(const std::array<std::uint64_t, N>& ids) {
  std::array<std::uint64_t, N> other = ids;
  std::swap(other[N - 1], other[N - 2]);
  std::array<int, N> order;
  std::iota(order.begin(), order.end(), 0);
  int even = 0, odd = 0;
  do {
    std::array<std::uint64_t, N> given;
    for (std::size_t i = 0; i < N; ++i) given[i] = ids[static_cast<std::size_t>(order[i])];
    ++(IsEven(order) ? even : odd);
    EXPECT_EQ(InCanonicalOrder(given), IsEven(order) ? ids : other);
  } while (std::next_permutation(order.begin(), order.end()));
  EXPECT_EQ(even, odd);
  EXPECT_EQ(even, N == 3 ? 3 : 12);
}

TEST(CanonicalOrder, IsOneForAllEvenOrdersAndTheOtherForOddOnes) {
  CheckAllOrders<3>({1, 5, ~0ULL});
  CheckAllOrders<4>({1, 5, 6, ~0ULL});
}

TEST(CanonicalOrder, KeepsOrientation) {
  auto random = testing::MakeRandom();
  std::uniform_real_distribution<double> coordinate(0, 1);
  for (int round = 0; round < 200; ++round) {
    std::array<geometry::Point3, 4> p;
    for (auto& q : p) q = {{coordinate(random), coordinate(random), coordinate(random)}};
    const auto c = InCanonicalOrder(p);
    EXPECT_EQ(geometry::Orientation(c[0], c[1], c[2], c[3]),
              geometry::Orientation(p[0], p[1], p[2], p[3]));
    EXPECT_LT(c[0], c[1]);
    EXPECT_LT(c[1], std::min(c[2], c[3]));
  }
}

}  // namespace
}  // namespace dynmesh::mesh_data
