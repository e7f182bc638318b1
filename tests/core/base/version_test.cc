#include "dynmesh/version.h"

#include <gtest/gtest.h>

#include <string>

namespace dynmesh {
namespace {

// The version check of a program before it uses newer features.
#if DYNMESH_VERSION < DYNMESH_MAKE_VERSION(0, 1, 0)
#error "the preprocessor cannot compare versions"
#endif
static_assert(DYNMESH_MAKE_VERSION(0, 999, 999) < DYNMESH_MAKE_VERSION(1, 0, 0));
static_assert(DYNMESH_MAKE_VERSION(1, 2, 999) < DYNMESH_MAKE_VERSION(1, 3, 0));
static_assert(DYNMESH_VERSION == DYNMESH_MAKE_VERSION(kVersionMajor, kVersionMinor, kVersionPatch));

TEST(Version, TheLibrarysIsThatOfItsHeaders) {
  EXPECT_STREQ(LinkedVersion(), kVersion);
  EXPECT_EQ(LinkedVersionNumber(), DYNMESH_VERSION);
  EXPECT_EQ(std::string(LinkedVersion()), std::to_string(kVersionMajor) + "." +
                                              std::to_string(kVersionMinor) + "." +
                                              std::to_string(kVersionPatch));
}

}  // namespace
}  // namespace dynmesh
