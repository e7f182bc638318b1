// Facets at small angles that move, come and go: after each edit the mesh, its complete trace and
// the static mesh are those of a run from scratch, and a replica follows.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/surfaces.h"

namespace dynmesh::test::sharp_surfaces_test {
namespace {

using Place = std::array<double, 3>;

class SharpSurfaces : public ::testing::TestWithParam<std::uint64_t> {
 protected:
  SharpSurfaces() : mesh_(NewMesh(DefaultsIn<3>())), replica_(*mesh_) {}

  // In random order: their indices are others than from scratch.
  void Load(std::vector<Feature> features) {
    std::shuffle(features.begin(), features.end(), std::mt19937_64(GetParam()));
    Apply(AddAll(features));
  }
  void Apply(const EditBatch& batch) {
    SCOPED_TRACE("seed " + std::to_string(GetParam()) + ", revision " + std::to_string(revisions_));
    const auto diff = mesh_->Apply(batch);
    ASSERT_TRUE(diff.ok()) << diff.status();
    ASSERT_EQ(replica_.Follow(*diff, *mesh_).what, "");
    ASSERT_EQ(CompareWithScratch(*mesh_, ++revisions_ % 2 == 0).what, "");
  }

  // About the middle of the domain.
  static Feature PointAt(FeatureId id, const Place& p) {
    return Feature::Point(id, 0.5 + p[0], 0.5 + p[1], 0.5 + p[2]);
  }

  Random random_{GetParam()};

 private:
  const std::unique_ptr<DynamicMesh> mesh_;
  Replica replica_;
  int revisions_ = 0;
};

// Two sheets on an edge, the second turned about it; a point between them comes and goes.
TEST_P(SharpSurfaces, AWedgeOpensAndShuts) {
  constexpr double kDegree = std::numbers::pi / 180, kWidth = .3;
  const auto outer = [](FeatureId id, double z, double degrees) {
    const double turn = 0.3 + degrees * kDegree;
    return PointAt(id, {kWidth * std::cos(turn), kWidth * std::sin(turn), z});
  };
  const std::vector<Feature> features = {PointAt(1, {0, 0, -.25}),
                                         PointAt(2, {0, 0, .2}),
                                         outer(3, .25, 0),
                                         outer(4, -.2, 0),
                                         outer(5, .25, 60),
                                         outer(6, -.2, 60),
                                         Feature::Polygon(7, {{1, 2, 3, 4}}),
                                         Feature::Polygon(8, {{1, 2, 5, 6}})};
  ASSERT_NO_FATAL_FAILURE(Load(features));
  for (const double degrees : {25., 9., 1.2, 0.3, 15., 20.5, 75.}) {
    ASSERT_NO_FATAL_FAILURE(
        Apply({Edit::Set(outer(5, .25, degrees)), Edit::Set(outer(6, -.2, degrees))}));
    const double between = 0.3 + degrees * kDegree * (0.3 + 0.4 * random_.Unit());
    ASSERT_NO_FATAL_FAILURE(
        Apply({Edit::Add(PointAt(11, {.2 * std::cos(between), .2 * std::sin(between), 0}))}));
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Remove(11)}));
  }
}

// A block whose top has a corner in common, and no more, with a facet below: between them is a
// needle, and its long edge rises over the top.
TEST_P(SharpSurfaces, ANeedleAtAnEdgeGetsThinner) {
  constexpr double kScale = .3;
  const auto at = [](FeatureId id, double x, double y, double z) {
    return PointAt(id, {kScale * (x - 1), kScale * (y - .5), kScale * (z - .5)});
  };
  const auto tip = [&](double degrees) {
    const double down = 2 * std::tan(degrees * std::numbers::pi / 180);
    return at(9, 2, .002 + .3 * down, 1 - down);
  };
  std::vector<Feature> features = {at(1, 0, .5, 0), at(2, 2, .5, 0), at(3, 2, 1, 0),
                                   at(4, 0, 1, 0),  at(5, 0, 0, 1),  at(6, 2, .002, 1),
                                   at(7, 2, 1, 1),  at(8, 0, 1, 1),  tip(.9)};
  FeatureId next = 10;
  for (const Rings& rings : {Rings{{1, 4, 3, 2}},
                             {{5, 6, 7, 8}},
                             {{1, 2, 9}},
                             {{1, 9, 5}},
                             {{5, 9, 6}},
                             {{2, 3, 7}},
                             {{2, 7, 6}},
                             {{2, 6, 9}},
                             {{3, 4, 8}},
                             {{3, 8, 7}},
                             {{4, 1, 5}},
                             {{4, 5, 8}}}) {
    features.push_back(Feature::Polygon(next++, rings));
  }
  ASSERT_NO_FATAL_FAILURE(Load(features));
  for (const double degrees : {.3, .05, .006, .6}) {
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Set(tip(degrees))}));
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Remove(14)}));  // the needle
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Add(features[13])}));
  }
}

// A flat cone, with 20 degrees at its rim, inside of the faces of a box.
TEST_P(SharpSurfaces, AConeMovesThroughABox) {
  constexpr FeatureId kSides = 9, kApex = 20, kRim = 21, kFaces = 40;
  const auto corners = [](const Place& at) {
    std::vector<Feature> points = {PointAt(kApex, {at[0], at[1], at[2] + 0.045})};
    for (FeatureId i = 0; i < kSides; ++i) {
      const double turn = 2 * std::numbers::pi * static_cast<double>(i) / kSides;
      points.push_back(
          PointAt(kRim + i, {at[0] + .12 * std::cos(turn), at[1] + .12 * std::sin(turn), at[2]}));
    }
    return points;
  };
  std::vector<Feature> features = corners({-.25, 0, 0});
  std::vector<FeatureId> rim;
  for (FeatureId i = 0; i < kSides; ++i) {
    rim.push_back(kRim + i);
    features.push_back(Feature::Polygon(kFaces + i, {{kApex, kRim + i, kRim + (i + 1) % kSides}}));
  }
  features.push_back(Feature::Polygon(kFaces + kSides, {rim}));
  const std::vector<Feature> box = BoxSurface(1, {.1, .3, .35}, {.9, .7, .65});
  features.insert(features.end(), box.begin(), box.end());
  ASSERT_NO_FATAL_FAILURE(Load(features));
  for (int step = 1; step <= 8; ++step) {
    EditBatch moved;
    for (const Feature& point : corners({-.25 + .06 * step, .04 * random_.Unit(), .01 * step})) {
      moved.push_back(Edit::Set(point));
    }
    ASSERT_NO_FATAL_FAILURE(Apply(moved));
  }
}

// Triangles over a grid whose heights are random: angles from some degrees on, at edges and between
// neighbours. Faces are removed and put back, corners move.
TEST_P(SharpSurfaces, FacesOfAScanComeAndGo) {
  constexpr int kSide = 5;
  const auto id = [](int x, int y) { return static_cast<FeatureId>(1 + x + kSide * y); };
  const auto corner = [&](int x, int y) {
    return PointAt(id(x, y), {.12 * (x - 2 + .3 * random_.Unit()), .12 * (y - 2),
                              .05 * random_.Unit() + .1 * (x % 2)});
  };
  std::vector<Feature> features;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) features.push_back(corner(x, y));
  }
  const std::vector<Feature> faces = GridTriangles(kSide - 1, 100, id);
  features.insert(features.end(), faces.begin(), faces.end());
  ASSERT_NO_FATAL_FAILURE(Load(features));
  for (int step = 0; step < 8; ++step) {
    const Feature& face =
        faces[static_cast<std::size_t>(random_.Below(static_cast<int>(faces.size())))];
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Remove(face.id)}));
    if (step % 2 == 0) {
      const int x = random_.Below(kSide), y = random_.Below(kSide);
      ASSERT_NO_FATAL_FAILURE(Apply({Edit::Set(corner(x, y))}));
    }
    ASSERT_NO_FATAL_FAILURE(Apply({Edit::Add(face)}));
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SharpSurfaces,
                         ::testing::Range<std::uint64_t>(1, IsNightly() ? 31 : 2));

}  // namespace
}  // namespace dynmesh::test::sharp_surfaces_test
