// Random solids that cross, overlap and have cracks: what is prepared is accepted, as near as it
// says, and stays as it is when it is prepared again.
#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "client/preparation/farthest.h"
#include "client/preparation/prepare.h"
#include "core/io/formats/mesh_output.h"
#include "dynmesh/dynamic_mesh.h"
#include "gtest/gtest.h"
#include "tests/client/preparation/solids.h"
#include "tests/support/nightly.h"
#include "tests/support/seed.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::preparation {
namespace {

using test::BoxSolid;
using test::Solid;

class Solids {
 public:
  explicit Solids(std::uint64_t seed) : random_(seed) {}

  // A few boxes with corners on a coarse grid, some of them turned about z, with noise of floats,
  // or of a millionth.
  Solid Next() {
    Solid all;
    const int boxes = 1 + Below(4);
    for (int i = 0; i < boxes; ++i) {
      std::array<double, 3> lo{}, hi{};
      for (std::size_t k = 0; k < 3; ++k) {
        lo[k] = Below(5), hi[k] = lo[k] + 1 + Below(3);
      }
      Solid box = BoxSolid(lo, hi);
      if (Below(3) == 0) Turn(box);
      if (Below(3) == 0) Open(box);
      all.Add(box);
    }
    if (Below(2) == 0) {
      for (auto& point : all.points) {
        for (double& x : point) x = static_cast<float>(x * 1.1);
      }
    }
    return all;
  }

  // A ring with crowds of points, some seen from the tips at less than a mesh takes.
  Solid NextNeedles() {
    std::uniform_real_distribution<double> exponent(-7, -3), height(-7, -4), part(0.2, 1);
    std::vector<std::array<double, 2>> ring;
    const int crowds = 3 + Below(4);
    for (int i = 0; i < crowds; ++i) {
      double angle = 2 * std::numbers::pi * (i + 0.3 * part(random_)) / crowds;
      for (int k = Below(6); k >= 0; --k) {
        const double radius = 1 + (Below(2) == 0 ? 0 : std::pow(10, height(random_)));
        ring.push_back({radius * std::cos(angle), radius * std::sin(angle)});
        angle += std::pow(10, exponent(random_));
      }
    }
    return test::DoublePyramid(ring);
  }

 private:
  int Below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  void Turn(Solid& solid) {
    const double angle = std::uniform_real_distribution<double>(0, 1)(random_);
    for (auto& [x, y, z] : solid.points) {
      const double turned = std::cos(angle) * x - std::sin(angle) * y;
      y = std::sin(angle) * x + std::cos(angle) * y, x = turned;
    }
  }
  // Each face has points of its own, off by up to a millionth.
  void Open(Solid& solid) {
    std::uniform_real_distribution<double> noise(-1e-6, 1e-6);
    Solid open;
    for (const auto& face : solid.faces) {
      const std::size_t first = open.points.size();
      for (const std::size_t corner : face) {
        open.points.push_back(solid.points[corner]);
        for (double& x : open.points.back()) x += noise(random_);
      }
      open.faces.push_back({first, first + 1, first + 2});
    }
    solid = open;
  }

  std::mt19937_64 random_;
};

void ExpectAcceptedAndNearAndStays(Solid (Solids::*next)()) {
  const std::uint64_t seed = test::NewSeed();
  const int runs = test::IsNightly() ? 2000 : 40;
  const test::TempFolder folder;
  Solids solids(seed);
  int mended = 0;
  for (int run = 0; run < runs; ++run) {
    const std::string path = folder.Write("s.off", (solids.*next)().Off());
    const auto prepared = Prepare(path, {}, {});
    ASSERT_TRUE(prepared.ok()) << run << prepared.status();
    const Report& report = prepared->report;
    const auto mesh = DynamicMesh::Create(prepared->geometry.options);
    ASSERT_TRUE(mesh.ok()) << run;
    const absl::Status accepted = (*mesh)->Validate(AddAll(prepared->geometry.features));
    ASSERT_TRUE(accepted.ok()) << run << accepted;
    EXPECT_EQ(report.open_edges_after, 0U) << run;
    if (!report.is_mended) continue;
    ++mended;
    EXPECT_LE(report.farthest, report.within) << run;
    io::GeometryOptions raw;
    raw.faces = io::FaceRules::kAsTheyCome;
    const auto given = io::ReadGeometry(path, raw);
    // Joined faces move by roundings.
    const double slack = 1.01 * report.farthest + 1e-9;
    EXPECT_TRUE(
        FarthestBound(given->features, prepared->geometry.features, 3, slack / 4, 2 * slack))
        << run;
    const std::string again_path = folder.Path("again.dynmesh");
    ASSERT_TRUE(io::WriteFeatureFile(again_path, {prepared->geometry.options,
                                                  prepared->geometry.features,
                                                  {},
                                                  {},
                                                  *prepared->geometry.labels})
                    .ok());
    const auto again = Prepare(again_path, {}, {1e-4});
    ASSERT_TRUE(again.ok()) << run << again.status();
    EXPECT_FALSE(again->report.is_mended) << run;
  }
  EXPECT_GT(mended, runs / 4);
}

TEST(PrepareProperty, WhatIsPreparedIsAcceptedAndNearAndStays) {
  ExpectAcceptedAndNearAndStays(&Solids::Next);
}

TEST(PrepareProperty, NeedlesAreTakenAwayWithinTheDistance) {
  ExpectAcceptedAndNearAndStays(&Solids::NextNeedles);
}

}  // namespace
}  // namespace dynmesh::preparation
