#include "client/preparation/winding.h"

#include <array>
#include <vector>

#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"

namespace dynmesh::preparation {
namespace {

using test::BoxSolid;
using test::Solid;

constexpr std::array<double, 3> kPlaces[] = {{0.5, 0.5, 0.5}, {0.1, 0.2, 0.3}, {2, 0.5, 0.5}};

TEST(WindingNumbers, AreOneInsideAndZeroOutside) {
  const auto numbers = WindingNumbers(BoxSolid({0, 0, 0}, {1, 1, 1}).Features(), kPlaces);
  ASSERT_TRUE(numbers);
  EXPECT_NEAR((*numbers)[0], 1, 1e-12);
  EXPECT_NEAR((*numbers)[1], 1, 1e-12);
  EXPECT_NEAR((*numbers)[2], 0, 1e-12);
}

TEST(WindingNumbers, AreZeroInACavity) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1}), cavity = BoxSolid({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6});
  cavity.TurnInsideOut();
  solid.Add(cavity);
  const auto numbers = WindingNumbers(solid.Features(), kPlaces);
  ASSERT_TRUE(numbers);
  EXPECT_NEAR((*numbers)[0], 0, 1e-12);
  EXPECT_NEAR((*numbers)[1], 1, 1e-12);
}

TEST(WindingNumbers, MeanNothingIfFacesAreOrientedAgainstEachOther) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  std::swap(solid.faces[3][0], solid.faces[3][1]);
  EXPECT_FALSE(WindingNumbers(solid.Features(), kPlaces));
}

}  // namespace
}  // namespace dynmesh::preparation
