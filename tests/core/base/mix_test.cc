#include "core/base/mix.h"

#include <gtest/gtest.h>

namespace dynmesh {
namespace {

// The first numbers of the generator that is seeded with 0, by its author's program.
TEST(Mix, IsSplitMix64) {
  EXPECT_EQ(Mix(0), 0xe220a8397b1dcdafULL);
  EXPECT_EQ(Mix(0x9e3779b97f4a7c15ULL), 0x6e789e6aa1b965f4ULL);
  EXPECT_EQ(Mix(2 * 0x9e3779b97f4a7c15ULL), 0x06c45d188009454fULL);
}

TEST(Mix, TheFinalizerHasNoIncrement) {
  EXPECT_EQ(MixBits(0), 0u);
  EXPECT_EQ(MixBits(0x9e3779b97f4a7c15ULL), Mix(0));
}

}  // namespace
}  // namespace dynmesh
