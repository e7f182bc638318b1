// Random solids come back as their faces, whatever the numbers of the file and the order in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/coplanar/join_flat.h"
#include "core/plc/conflicts.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"
#include "tests/core/coplanar/rounded_solids.h"
#include "tests/support/seed.h"

namespace dynmesh::coplanar::join_flat_property_test {
namespace {

using rounded::Below;
using rounded::Numbers;
using rounded::Place;
using rounded::Random;
using rounded::Solid;
using rounded::Soup;

MeshOptions OptionsOf(const std::vector<Feature>& features) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  bool is_first = true;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPoint) continue;
    for (std::size_t k = 0; k < 3; ++k) {
      double &lo = options.box.lo[k], &hi = options.box.hi[k];
      lo = is_first ? f.position[k] : std::min(lo, f.position[k]);
      hi = is_first ? f.position[k] : std::max(hi, f.position[k]);
    }
    is_first = false;
  }
  return options;
}

std::size_t CountConflicts(const std::vector<Feature>& features) {
  std::size_t count = 0;
  plc::FindConflicts(
      OptionsOf(features), features, [](FeatureId) { return true; }, [](FeatureId) { return true; },
      [&](FeatureId) { ++count; });
  return count;
}

JoinedFaces Joined(const std::vector<Feature>& features, const io::NumberRounding& rounding,
                   bool join = true) {
  JoinOptions options;
  options.rounding = [&](double x) { return rounding.Of(x); };
  options.join = join;
  options.conflicts = [](const std::vector<Feature>& all,
                         const std::function<bool(FeatureId)>& is_looked_at,
                         const std::function<bool(FeatureId)>& is_new,
                         const std::function<void(FeatureId)>& found) {
    plc::FindConflicts(OptionsOf(all), all, is_looked_at, is_new, found);
  };
  return JoinFlat(features, options);
}

// By the points' numbers in the solid: where they are, and the corners of polygons, ring by ring.
struct Result {
  std::map<int, std::array<double, 3>> points;
  std::set<std::set<std::vector<int>>> polygons;
  bool operator==(const Result&) const = default;
};

std::vector<int> Sorted(std::vector<int> corners) {
  std::sort(corners.begin(), corners.end());
  return corners;
}

Result ResultOf(const JoinedFaces& joined, const Soup& soup) {
  std::map<FeatureId, int> number;
  for (std::size_t i = 0; i < soup.id_of.size(); ++i) number[soup.id_of[i]] = static_cast<int>(i);
  Result result;
  for (const Feature& f : joined.features) {
    if (f.kind == FeatureKind::kPoint) result.points[number.at(f.id)] = f.position;
    if (f.kind != FeatureKind::kPolygon) continue;
    std::set<std::vector<int>> rings;
    for (const auto& ring : f.rings) {
      std::vector<int> corners;
      for (const FeatureId id : ring) corners.push_back(number.at(id));
      rings.insert(Sorted(corners));
    }
    EXPECT_TRUE(result.polygons.insert(rings).second);
  }
  return result;
}

Result Wanted(const Solid& solid) {
  Result result;
  for (const auto& face : solid.faces) {
    std::set<std::vector<int>> rings;
    for (const auto& ring : face) {
      rings.insert(Sorted(ring));
      for (const int c : ring) result.points[c] = {};
    }
    result.polygons.insert(rings);
  }
  return result;
}

std::string TextOf(const Solid& solid) {
  std::string text = "OFF\n" + std::to_string(solid.points.size()) + " " +
                     std::to_string(solid.triangles.size()) + " 0\n";
  for (const Place& p : solid.points) {
    char line[100];
    std::snprintf(line, sizeof(line), "%.17g %.17g %.17g\n", static_cast<double>(p[0]),
                  static_cast<double>(p[1]), static_cast<double>(p[2]));
    text += line;
  }
  for (const auto& t : solid.triangles) {
    text += "3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) +
            "\n";
  }
  return text;
}

constexpr Numbers kAllNumbers[] = {Numbers::kFloats, Numbers::kSixDigits, Numbers::kSixDecimals,
                                   Numbers::kDoubles};

TEST(JoinFlatProperties, SolidsComeBackAsTheirFaces) {
  Random random(static_cast<Random::result_type>(test::NewSeed()));
  for (int run = 0; run < 400 && !::testing::Test::HasFailure(); ++run) {
    const Numbers numbers = kAllNumbers[run % 4];
    Solid solid = rounded::AnySolid(random);
    const Solid before = solid;
    do {  // six decimals of a small solid are too few
      solid = before;
      rounded::Put(random, solid);
    } while (numbers == Numbers::kSixDecimals && std::abs(solid.points[0][0]) < 1);
    const io::NumberRounding rounding = rounded::Round(numbers, solid);
    const Soup soup = rounded::Shuffled(random, solid);
    const JoinedFaces joined = Joined(soup.features, rounding);
    const Result result = ResultOf(joined, soup);
    Result wanted = Wanted(solid);
    for (auto& [c, position] : wanted.points) {
      ASSERT_TRUE(result.points.contains(c)) << "run " << run << ", point " << c << "\n"
                                             << TextOf(solid);
      position = result.points.at(c);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto given = static_cast<double>(solid.points[static_cast<std::size_t>(c)][k]);
        EXPECT_LE(std::abs(position[k] - given), 4.001 * rounding.Of(given));
      }
    }
    EXPECT_EQ(result.polygons, wanted.polygons) << "run " << run << "\n" << TextOf(solid);
    EXPECT_EQ(result.points, wanted.points);
    EXPECT_EQ(CountConflicts(joined.features), 0U) << "run " << run << "\n" << TextOf(solid);
    // The order does not matter.
    const Soup other = rounded::Shuffled(random, solid);
    EXPECT_EQ(ResultOf(Joined(other.features, rounding), other), result) << "run " << run << "\n"
                                                                         << TextOf(solid);
  }
}

// Points are off by more than the rounding, and moved to others' edges and faces.
TEST(JoinFlatProperties, WhatIsAcceptedAsItComesIsAcceptedJoined) {
  Random random(static_cast<Random::result_type>(test::NewSeed()));
  int accepted = 0, joined_some = 0;
  for (int run = 0; run < 400 && !::testing::Test::HasFailure(); ++run) {
    Solid solid = rounded::AnySolid(random);
    rounded::Put(random, solid);
    const Solid exact = solid;
    const io::NumberRounding rounding = rounded::Round(kAllNumbers[run % 4], solid);
    const double noise = std::pow(10, rounded::Uniform(random, -1, 3));
    for (Place& p : solid.points) {
      if (Below(random, 3) != 0) continue;
      for (rounded::Real& x : p) {
        x += noise * rounding.Of(static_cast<double>(x)) * rounded::Uniform(random, -1, 1);
      }
    }
    // A triangle is thin: a corner near the edge of the others, on either side.
    for (int k = 0; k < 2; ++k) {
      const rounded::Loop cut = solid.triangles[Below(random, solid.triangles.size())];
      const double share = rounded::Uniform(random, 0.2, 0.8);
      Place middle{};
      for (std::size_t x = 0; x < 3; ++x) {
        const rounded::Real a = solid.points[static_cast<std::size_t>(cut[0])][x],
                            b = solid.points[static_cast<std::size_t>(cut[1])][x],
                            c = solid.points[static_cast<std::size_t>(cut[2])][x];
        middle[x] = a + share * (b - a) + std::pow(10, rounded::Uniform(random, -8, -2)) * (c - a) +
                    rounding.Of(static_cast<double>(a)) * rounded::Uniform(random, -2, 2);
      }
      const int m = static_cast<int>(solid.points.size());
      solid.points.push_back(middle);
      const auto old = std::find(solid.triangles.begin(), solid.triangles.end(), cut);
      solid.triangles.erase(old);
      solid.triangles.push_back({cut[0], cut[1], m});
      solid.triangles.push_back({cut[1], cut[2], m});
      solid.triangles.push_back({cut[2], cut[0], m});
    }
    const Soup soup = rounded::Shuffled(random, solid);
    const JoinedFaces kept = Joined(soup.features, rounding, false);
    const JoinedFaces joined = Joined(soup.features, rounding);
    const Soup other = rounded::Shuffled(random, solid);
    EXPECT_EQ(ResultOf(Joined(other.features, rounding), other), ResultOf(joined, soup))
        << "run " << run << "\n"
        << TextOf(solid);
    if (CountConflicts(kept.features) != 0) continue;
    ++accepted;
    if (joined.joined > 0) ++joined_some;
    EXPECT_EQ(CountConflicts(joined.features), 0U) << "run " << run << "\n" << TextOf(solid);
  }
  EXPECT_GT(accepted, 40);
  EXPECT_GT(joined_some, 20);
}

}  // namespace
}  // namespace dynmesh::coplanar::join_flat_property_test
