// Small input angles, swept: every run ends, no triangle is over rho without excuse, no angle is
// much smaller than the input's, and the number of vertices grows only with the logarithm of one
// over the angle.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quality.h"
#include "tests/support/workload.h"

namespace dynmesh::small_angles_test {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kQualities[] = {kDefaultQuality2D, 1.0, 2.0};

struct Input {
  std::vector<Feature> features;
  FeatureId next = 1;
  FeatureId Point(double x, double y) {
    features.push_back(Feature::Point(next, x, y));
    return next++;
  }
  void Segment(FeatureId p, FeatureId q) { features.push_back(Feature::Segment(next++, p, q)); }
};

// The least angle seen is at least `least` degrees, if that is less than rho's own bound.
std::size_t MeshAndCheck(const Input& input, double quality, double least) {
  MeshOptions options;
  options.quality = quality;
  options.limits.max_vertices = 50'000;
  const auto mesh = BuildMesh(input.features, options);
  EXPECT_TRUE(mesh.ok()) << mesh.status();
  if (!mesh.ok()) return 0;
  const QualityReport report = MeasureQuality(*mesh, options);
  EXPECT_EQ(report.over_rho, report.exempt);
  const double by_rho = std::asin(1 / (2 * quality)) / kDegree;
  EXPECT_GE(report.min_angle_deg, std::min(by_rho, 0.6 * least) - 1e-3);
  EXPECT_LE(report.max_angle_deg, std::max(180 - 2 * by_rho, 141.0) + 1e-3);
  return mesh->vertices.size();
}

TEST(SmallAngles, TwoSegments) {
  for (const double quality : kQualities) {
    for (const double angle :
         {.001, .002, .005, .01, .03, .1,  .3,  1.,  2.,  5.,  7.5, 10., 15., 20.,
          25.,  29.,  30.,  35., 40., 45., 50., 55., 59., 60., 65., 75., 90.}) {
      for (const double length : {.3, .2999, .219, .1, .01}) {
        for (const double turn : {0., 17.3, 90.}) {
          SCOPED_TRACE("rho " + std::to_string(quality) + ", " + std::to_string(angle) +
                       " degrees, lengths .3 and " + std::to_string(length) + ", turned by " +
                       std::to_string(turn));
          Input input;
          const FeatureId apex = input.Point(.5, .4);
          const double a = turn * kDegree, b = (turn + angle) * kDegree;
          input.Segment(apex, input.Point(.5 + .3 * std::cos(a), .4 + .3 * std::sin(a)));
          input.Segment(apex, input.Point(.5 + length * std::cos(b), .4 + length * std::sin(b)));
          EXPECT_LE(MeshAndCheck(input, quality, angle), quality == 1 ? 500u : 200u);
        }
      }
    }
  }
}

TEST(SmallAngles, Fans) {
  constexpr std::uint64_t kSeed = 64;
  test::Random random(kSeed);
  for (const double quality : kQualities) {
    for (const int spokes : {3, 4, 5, 6, 7, 8, 12, 16, 24, 32, 36, 48, 64}) {
      for (const bool equal : {true, false}) {
        SCOPED_TRACE("seed " + std::to_string(kSeed) + ", rho " + std::to_string(quality) + ", " +
                     std::to_string(spokes) + (equal ? " equal" : " unequal") + " spokes");
        Input input;
        const FeatureId apex = input.Point(.5, .5);
        double last = -360, least = 360, first = 0;
        for (int i = 0; i < spokes; ++i) {
          const double angle = 360. * (i + (equal ? 0 : .8 * random.Unit())) / spokes;
          const double length = equal ? .4 : .4 * std::pow(.02, random.Unit());
          if (i == 0) first = angle;
          if (i > 0) least = std::min(least, angle - last);
          last = angle;
          input.Segment(apex, input.Point(.5 + length * std::cos(angle * kDegree),
                                          .5 + length * std::sin(angle * kDegree)));
        }
        least = std::min(least, first + 360 - last);
        MeshAndCheck(input, quality, least);
      }
    }
  }
}

// Triangles as flat as 0.003 degrees: two segments with a sharp angle at both ends.
TEST(SmallAngles, FlatTrianglesAndNeedles) {
  for (const double quality : kQualities) {
    for (const double a : {.003, .01, .1, .3, 1., 3., 10., 20., 30., 45.}) {
      for (const double b : {.003, .01, .1, .3, 1., 3., 10., 20., 30., 45., 80., 89.}) {
        for (const double turn : {0., 31.7}) {
          const double length = .6;
          const double u =
              length * std::tan(b * kDegree) / (std::tan(a * kDegree) + std::tan(b * kDegree));
          const double v = u * std::tan(a * kDegree);
          if (v > .35) continue;
          SCOPED_TRACE("rho " + std::to_string(quality) + ", angles " + std::to_string(a) +
                       " and " + std::to_string(b) + ", turned by " + std::to_string(turn));
          Input input;
          const auto at = [&](double x, double y) {
            const double c = std::cos(turn * kDegree), s = std::sin(turn * kDegree);
            return input.Point(.2 + x * c - y * s, .2 + x * s + y * c);
          };
          const FeatureId p = at(0, 0), q = at(length, 0), r = at(u, v);
          input.Segment(p, q);
          input.Segment(q, r);
          input.Segment(r, p);
          EXPECT_LE(MeshAndCheck(input, quality, std::min(a, b)), quality == 1 ? 500u : 200u);
        }
      }
    }
  }
}

TEST(SmallAngles, ParallelSegmentsVeryClose) {
  for (const double quality : kQualities) {
    for (const double gap : {0x1p-10, 0x1p-20, 0x1p-30}) {
      SCOPED_TRACE("rho " + std::to_string(quality) + ", gap " + std::to_string(gap));
      Input input;
      for (const double y : {.3, .3 + gap}) {
        const FeatureId p = input.Point(.2, y), q = input.Point(.2 + 64 * gap, y);
        input.Segment(p, q);
      }
      EXPECT_LE(MeshAndCheck(input, quality, 90), 1000u);
    }
  }
}

}  // namespace
}  // namespace dynmesh::small_angles_test
