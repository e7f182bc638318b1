#include "client/preparation/winding.h"

#include <array>
#include <vector>

#include "core/io/formats/geometry.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::preparation {
namespace {

using test::BoxSolid;
using test::Solid;

std::vector<Feature> FeaturesOf(const Solid& solid) {
  const test::TempFolder folder;
  io::GeometryOptions options;
  options.faces = io::FaceRules::kAsTheyCome;
  return io::ReadGeometry(folder.Write("s.off", solid.Off()), options)->features;
}

constexpr std::array<double, 3> kPlaces[] = {{0.5, 0.5, 0.5}, {0.1, 0.2, 0.3}, {2, 0.5, 0.5}};

TEST(WindingNumbers, AreOneInsideAndZeroOutside) {
  const auto numbers = WindingNumbers(FeaturesOf(BoxSolid({0, 0, 0}, {1, 1, 1})), kPlaces);
  ASSERT_TRUE(numbers);
  EXPECT_NEAR((*numbers)[0], 1, 1e-12);
  EXPECT_NEAR((*numbers)[1], 1, 1e-12);
  EXPECT_NEAR((*numbers)[2], 0, 1e-12);
}

TEST(WindingNumbers, AreZeroInACavity) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1}), cavity = BoxSolid({0.4, 0.4, 0.4}, {0.6, 0.6, 0.6});
  cavity.TurnInsideOut();
  solid.Add(cavity);
  const auto numbers = WindingNumbers(FeaturesOf(solid), kPlaces);
  ASSERT_TRUE(numbers);
  EXPECT_NEAR((*numbers)[0], 0, 1e-12);
  EXPECT_NEAR((*numbers)[1], 1, 1e-12);
}

TEST(WindingNumbers, MeanNothingIfFacesAreOrientedAgainstEachOther) {
  Solid solid = BoxSolid({0, 0, 0}, {1, 1, 1});
  std::swap(solid.faces[3][0], solid.faces[3][1]);
  EXPECT_FALSE(WindingNumbers(FeaturesOf(solid), kPlaces));
}

}  // namespace
}  // namespace dynmesh::preparation
