#include "core/meshing/corner_set.h"

#include <gtest/gtest.h>

#include <array>
#include <set>
#include <string>

#include "tests/support/workload.h"

namespace dynmesh::meshing::corner_set_test {
namespace {

template <int D>
std::array<std::uint32_t, D> RandomCorner(test::Random& random, int ids) {
  std::array<std::uint32_t, D> corner;
  for (std::uint32_t& id : corner) id = static_cast<std::uint32_t>(random.Below(ids));
  if (random.OneIn(5)) corner[D - 1] = ~std::uint32_t{0};  // a ghost
  return corner;
}

// Few and many, with corners that share all ids but one.
template <int D>
void CheckAgainstSet(std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  test::Random random(seed);
  CornerSet<D> corners;
  for (int round = 0; round < 200; ++round) {
    const int count = random.OneIn(3) ? random.Below(200) : 28 + random.Below(8);
    const int ids = 2 + random.Below(20);
    std::set<std::array<std::uint32_t, D>> model;
    corners.Clear();
    for (int i = 0; i < count; ++i) {
      const auto corner = RandomCorner<D>(random, ids);
      corners.Add(corner);
      model.insert(corner);
    }
    corners.Close();
    for (const auto& corner : model) ASSERT_TRUE(corners.Has(corner)) << "of " << count;
    for (int i = 0; i < 50; ++i) {
      const auto corner = RandomCorner<D>(random, ids);
      ASSERT_EQ(corners.Has(corner), model.contains(corner)) << "of " << count;
    }
  }
}

TEST(CornerSet, IsASetOfCorners) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) CheckAgainstSet<2>(seed);
}

TEST(CornerSet, IsASetOfCornersInSpace) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) CheckAgainstSet<3>(seed);
}

}  // namespace
}  // namespace dynmesh::meshing::corner_set_test
