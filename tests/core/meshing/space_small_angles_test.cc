// Small angles between segments in 3D, swept: every run ends, the judge finds no fault, every
// tetrahedron over rho or with a small dihedral angle has the excuse of a small input angle, and
// the number of vertices grows only with the logarithm of one over the angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quality.h"
#include "tests/support/judged.h"
#include "tests/support/workload.h"

namespace dynmesh::space_small_angles_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kQualities[] = {kDefaultQuality3D, 1.4143};
constexpr std::uint64_t kSeed = 27;

using Place = std::array<double, 3>;

// Features around the middle of the unit cube, turned at random.
class Input {
 public:
  explicit Input(test::Random& random) {
    double length = 0;
    for (double& x : turn_) x = random.Unit() - 0.5, length += x * x;
    for (double& x : turn_) x /= std::sqrt(length);
  }
  FeatureId Point(const Place& p) {
    const auto [w, x, y, z] = turn_;
    const Place at = {
        (1 - 2 * (y * y + z * z)) * p[0] + 2 * (x * y - w * z) * p[1] + 2 * (x * z + w * y) * p[2],
        2 * (x * y + w * z) * p[0] + (1 - 2 * (x * x + z * z)) * p[1] + 2 * (y * z - w * x) * p[2],
        2 * (x * z - w * y) * p[0] + 2 * (y * z + w * x) * p[1] + (1 - 2 * (x * x + y * y)) * p[2]};
    features_.push_back(Feature::Point(next_, 0.5 + at[0], 0.5 + at[1], 0.5 + at[2]));
    return next_++;
  }
  void Segment(FeatureId p, FeatureId q) { features_.push_back(Feature::Segment(next_++, p, q)); }
  void Triangle(FeatureId p, FeatureId q, FeatureId r) {
    features_.push_back(Feature::Polygon(next_++, {{p, q, r}}));
  }
  void Polygon(const std::vector<FeatureId>& corners) {
    features_.push_back(Feature::Polygon(next_++, {corners}));
  }
  const std::vector<Feature>& features() const { return features_; }

 private:
  std::array<double, 4> turn_;
  std::vector<Feature> features_;
  FeatureId next_ = 1;
};

constexpr std::size_t kBorder = 386;  // vertices on the border of the domain, at rho 2

// The mesh's number of vertices.
std::size_t MeshAndJudge(const Input& input, double quality, double min_dihedral = 0) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = quality;
  options.min_dihedral = min_dihedral;
  options.limits.max_vertices = 200'000;
  const auto mesh = BuildMesh(input.features(), options);
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  if (!mesh.ok()) return 0;
  const QualityReport report = MeasureQuality(*mesh, options);
  EXPECT_EQ(report.over_rho, report.exempt);
  EXPECT_EQ(test::Judged(*mesh, quality, input.features()), "");
  return mesh->vertices.size();
}

TEST(SpaceSmallAngles, TwoSegments) {
  test::Random random(kSeed);
  for (const double quality : kQualities) {
    for (const double angle : {.001, .01, .1, 1., 3., 10., 30., 45., 59., 60., 75.}) {
      for (const double length : {.4, .39, .1, .01}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", rho " + std::to_string(quality) + ", " +
                     std::to_string(angle) + " degrees, lengths .4 and " + std::to_string(length));
        Input input(random);
        const FeatureId apex = input.Point({0, 0, 0});
        input.Segment(apex, input.Point({.4, 0, 0}));
        input.Segment(apex, input.Point({length * std::cos(angle * kDegree),
                                         length * std::sin(angle * kDegree), 0}));
        const std::size_t most =
            quality == 2 ? kBorder + 90 + static_cast<std::size_t>(60 * -std::log10(angle / 100))
                         : 4000;
        EXPECT_LE(MeshAndJudge(input, quality), most);
      }
    }
  }
}

// Many segments in a cone: all of them are neighbours.
TEST(SpaceSmallAngles, Forks) {
  test::Random random(kSeed);
  for (const double quality : kQualities) {
    for (const int prongs : {3, 10, 30}) {
      for (const double wide : {2., 20., 60., 180.}) {
        if (prongs == 30 && wide == 2) continue;  // for its time
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", rho " + std::to_string(quality) + ", " +
                     std::to_string(prongs) + " prongs within " + std::to_string(wide));
        Input input(random);
        const FeatureId apex = input.Point({0, 0, 0});
        for (int i = 0; i < prongs; ++i) {
          const double aside = wide * kDegree * std::sqrt(random.Unit());
          const double turn = 2 * std::numbers::pi * random.Unit();
          const double length = random.OneIn(3) ? .3 : .3 * std::pow(.02, random.Unit());
          input.Segment(apex, input.Point({length * std::sin(aside) * std::cos(turn),
                                           length * std::sin(aside) * std::sin(turn),
                                           length * std::cos(aside)}));
        }
        MeshAndJudge(input, quality);
      }
    }
  }
}

// Single facets: needles, and triangles with small angles at two ends.
TEST(SpaceSmallAngles, Triangles) {
  test::Random random(kSeed);
  for (const double quality : {kDefaultQuality3D, 1.4143}) {
    for (const double a : {.1, 1., 5., 20., 45.}) {
      for (const double b : {.1, 1., 5., 20., 45., 80., 90., 100.}) {
        if (b > 90 && a > 20) continue;  // out of the cube
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", rho " + std::to_string(quality) +
                     ", angles " + std::to_string(a) + " and " + std::to_string(b));
        Input input(random);
        const double c = (180 - a - b) * kDegree, side = .5 * std::sin(b * kDegree) / std::sin(c);
        input.Triangle(
            input.Point({-.25, 0, 0}), input.Point({.25, 0, 0}),
            input.Point({-.25 + side * std::cos(a * kDegree), side * std::sin(a * kDegree), 0}));
        MeshAndJudge(input, quality);
      }
    }
  }
}

// Triangles around a common corner, flat or as a cone.
TEST(SpaceSmallAngles, Fans) {
  test::Random random(kSeed);
  for (const int n : {5, 8, 24, 40}) {
    for (const double height : {0., .2}) {
      for (const bool equal : {true, false}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(n) + " at height " +
                     std::to_string(height) + (equal ? "" : ", unequal"));
        Input input(random);
        const FeatureId apex = input.Point({0, 0, height});
        std::vector<FeatureId> rim;
        for (int i = 0; i < n; ++i) {
          const double turn = 2 * std::numbers::pi * (i + (equal ? 0 : .7 * random.Unit())) / n;
          const double r = equal || height > 0 ? .35 : .25 + .15 * random.Unit();
          rim.push_back(input.Point({r * std::cos(turn), r * std::sin(turn), 0}));
        }
        for (std::size_t i = 0; i < rim.size(); ++i) {
          input.Triangle(apex, rim[i], rim[(i + 1) % rim.size()]);
        }
        MeshAndJudge(input, kDefaultQuality3D, 10);
      }
    }
  }
}

// A torus of n by m cells, each cut in two; `jitter`: how far vertices are off, in cells.
Input Torus(int n, int m, double jitter, test::Random& random) {
  Input input(random);
  std::vector<FeatureId> at;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const double a = 2 * std::numbers::pi * (i + jitter * (random.Unit() - .5)) / n;
      const double b = 2 * std::numbers::pi * (j + jitter * (random.Unit() - .5)) / m;
      const double r = .3 + .12 * std::cos(b);
      at.push_back(input.Point({r * std::cos(a), r * std::sin(a), .12 * std::sin(b)}));
    }
  }
  const auto id = [&](int i, int j) { return at[static_cast<std::size_t>(i % n * m + j % m)]; };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      input.Triangle(id(i, j), id(i + 1, j), id(i + 1, j + 1));
      input.Triangle(id(i, j), id(i + 1, j + 1), id(i, j + 1));
    }
  }
  return input;
}

TEST(SpaceSmallAngles, Surfaces) {
  test::Random random(kSeed);
  for (const auto& [n, m] : {std::pair(12, 8), {24, 8}, {8, 24}}) {
    for (const double jitter : {0., .1, .5}) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(n) + " by " +
                   std::to_string(m) + ", jitter " + std::to_string(jitter));
      MeshAndJudge(Torus(n, m, jitter, random), kDefaultQuality3D, 10);
    }
  }
}

// Sheets on a common edge: as many as there is room for at `angle`, of different widths.
TEST(SpaceSmallAngles, Sheets) {
  test::Random random(kSeed);
  for (const double angle : {.0501, .2, 1., 5., 21., 31., 45., 69.}) {
    for (const int n : {2, 3, std::min(24, static_cast<int>(360 / angle))}) {
      if (n > 3 && angle < 20) continue;  // for its time
      for (const double narrow : {1., .3}) {
        // The outer edges are that near to each other, or to a sheet.
        if (angle < 1 && (n > 2 || narrow < 1)) continue;
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(n) + " at " +
                     std::to_string(angle) + " degrees, widths .35 and " +
                     std::to_string(.35 * narrow));
        Input input(random);
        const FeatureId a = input.Point({0, 0, -.3}), b = input.Point({0, 0, .3});
        for (int i = 0; i < n; ++i) {
          const double turn = i * angle * kDegree, r = i % 2 == 0 ? .35 : .35 * narrow;
          const Place low = {r * std::cos(turn), r * std::sin(turn), -.3};
          const FeatureId c = input.Point(low), d = input.Point({low[0], low[1], .3});
          input.Polygon({a, b, d, c});
        }
        // The outer edge of a narrow sheet is 0.002 from the wide one, at 1 degree.
        const auto each = static_cast<unsigned>(angle > 20 ? 100 : 2'500 / std::min(angle, 1.));
        EXPECT_LE(MeshAndJudge(input, kDefaultQuality3D),
                  kBorder + each * static_cast<unsigned>(n));
      }
    }
  }
}

// Two triangles with a corner in common; an edge of one rises over the other.
TEST(SpaceSmallAngles, AFacetOverAnotherAtACorner) {
  test::Random random(kSeed);
  for (const double angle : {.00101, .01, .1, .5, 2., 20.}) {
    for (const double length : {.4, .1}) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", " + std::to_string(angle) +
                   " degrees, lengths .4 and " + std::to_string(length));
      Input input(random);
      const FeatureId apex = input.Point({0, 0, 0});
      input.Triangle(apex, input.Point({.4, -.2, 0}), input.Point({.4, .2, 0}));
      const FeatureId over = input.Point(
          {length * std::cos(angle * kDegree), .01, length * std::sin(angle * kDegree)});
      input.Triangle(apex, over, input.Point({length, 0, .3}));
      EXPECT_LE(MeshAndJudge(input, kDefaultQuality3D, 10), kBorder + 1'500);
    }
  }
}

// As many sheets as there is room for, of three widths, in several positions. Some of these once
// had thousands of vertices, most of them in one place.
TEST(SpaceSmallAngles, FullCirclesOfSheets) {
  test::Random random(kSeed + 1);
  for (int round = 0; round < 8; ++round) {
    SCOPED_TRACE("seed " + std::to_string(kSeed + 1) + ", round " + std::to_string(round));
    Input input(random);
    const double shift = 0.05 * random.Unit();
    const FeatureId a = input.Point({shift, 0, -.2}), b = input.Point({shift, 0, .2});
    constexpr double kWidths[] = {.4, .2, .12};
    for (int i = 0; i < 17; ++i) {
      const double turn = i * 21 * kDegree, r = kWidths[i % 3];
      const double x = shift + r * std::cos(turn), y = r * std::sin(turn);
      const FeatureId c = input.Point({x, y, -.2}), d = input.Point({x, y, .2});
      input.Polygon({a, b, d, c});
    }
    EXPECT_LE(MeshAndJudge(input, kDefaultQuality3D), 2'000u);
  }
}

// Solids with sharp edges and corners: prisms of a triangle, pyramids, cones.
TEST(SpaceSmallAngles, Solids) {
  test::Random random(kSeed);
  for (const int n : {3, 4, 6, 12}) {
    for (const double height : {.25, .3, .5}) {
      SCOPED_TRACE("seed " + std::to_string(kSeed) + ", pyramid of " + std::to_string(n) +
                   " corners, height " + std::to_string(height));
      Input input(random);
      const FeatureId apex = input.Point({0, 0, height - .25});
      std::vector<FeatureId> rim;
      for (int i = 0; i < n; ++i) {
        const double turn = 2 * std::numbers::pi * i / n;
        rim.push_back(input.Point({.25 * std::cos(turn), .25 * std::sin(turn), -.25}));
      }
      for (std::size_t i = 0; i < rim.size(); ++i) {
        input.Triangle(apex, rim[i], rim[(i + 1) % rim.size()]);
      }
      input.Polygon(rim);
      EXPECT_LE(MeshAndJudge(input, kDefaultQuality3D, 10),
                kBorder + 40u * static_cast<unsigned>(n));
    }
  }
}

// Segments that rise over a triangle from its corner, over its edges and in between.
TEST(SpaceSmallAngles, Spikes) {
  test::Random random(kSeed);
  for (const double wide : {20., 60., 90., 110.}) {
    for (const double rise : {1.01, 5., 21., 31., 45., 60.}) {
      for (const double share : {.05, .3, .5}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", over " + std::to_string(share) + " of " +
                     std::to_string(wide) + " degrees, at " + std::to_string(rise));
        Input input(random);
        const FeatureId apex = input.Point({0, 0, 0});
        const double turn = wide * kDegree, at = share * turn, up = rise * kDegree;
        input.Triangle(apex, input.Point({.35, 0, 0}),
                       input.Point({.35 * std::cos(turn), .35 * std::sin(turn), 0}));
        input.Segment(apex, input.Point({.3 * std::cos(up) * std::cos(at),
                                         .3 * std::cos(up) * std::sin(at), .3 * std::sin(up)}));
        EXPECT_LE(MeshAndJudge(input, kDefaultQuality3D), kBorder + (rise > 20 ? 120u : 140u));
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh::space_small_angles_test
