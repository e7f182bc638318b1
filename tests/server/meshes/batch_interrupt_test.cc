#include "server/meshes/batch_interrupt.h"

#include <gtest/gtest.h>

#include <atomic>

namespace dynmesh::server {
namespace {

TEST(BatchInterrupt, IsTrueOnceAFlagIsSet) {
  std::atomic<bool> cancelled{false}, full{false};
  const auto both = BatchInterrupt(&cancelled, &full);
  EXPECT_FALSE(both());
  full = true;
  EXPECT_TRUE(both());
  full = false;
  cancelled = true;
  EXPECT_TRUE(both());
  EXPECT_TRUE(BatchInterrupt(&cancelled, nullptr)());
  EXPECT_FALSE(BatchInterrupt(nullptr, &full)());
  EXPECT_FALSE(BatchInterrupt(nullptr, nullptr)());
}

}  // namespace
}  // namespace dynmesh::server
