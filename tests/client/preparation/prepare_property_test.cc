// Random solids that cross, overlap and have cracks: what is prepared is accepted, as near as it
// says, and stays as it is when it is prepared again.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "client/cleaning/patch_distance.h"
#include "client/cleaning/vectors3.h"
#include "client/preparation/farthest.h"
#include "client/preparation/prepare.h"
#include "client/preparation/triangles.h"
#include "core/base/rounding.h"
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

  // A ribbon that goes back and forth over itself, upright, in layers up to 1e-7 apart.
  Solid NextRibbon() {
    std::uniform_real_distribution<double> step(-1, 1), exponent(-9, -1);
    const int count = 3 + Below(3);
    const double apart = std::pow(10, exponent(random_)), width = std::pow(10, -1 - Below(4));
    Solid ribbon;
    double x = 0, y = 0;
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < 4; ++k)
        ribbon.points.push_back({x, y + (k & 1 ? width : 0), k & 2 ? 1. : 0});
      x += step(random_), y += apart * step(random_);
    }
    const auto quad = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
      ribbon.faces.push_back({a, b, c});
      ribbon.faces.push_back({a, c, d});
    };
    for (std::size_t i = 0; i + 4 < ribbon.points.size(); i += 4) {
      quad(i, i + 4, i + 6, i + 2);
      quad(i + 1, i + 3, i + 7, i + 5);
      quad(i, i + 1, i + 5, i + 4);
      quad(i + 2, i + 6, i + 7, i + 3);
    }
    const std::size_t last = ribbon.points.size() - 4;
    quad(0, 2, 3, 1);
    quad(last, last + 1, last + 3, last + 2);
    return ribbon;
  }

  // Two spheres at one place, of nearly one size, turned a little or not at all.
  Solid NextSpheres() {
    std::uniform_real_distribution<double> exponent(-12, -2);
    const int rings = 2 + Below(4), sectors = 3 + Below(8);
    Solid all = Sphere(rings, sectors, 1, 0);
    const auto little = [&] { return Below(3) == 0 ? 0 : std::pow(10, exponent(random_)); };
    const int finer = Below(3);
    const double radius = 1 + little();
    all.Add(Sphere(rings + finer, sectors + finer, radius, little()));
    if (Below(2) == 0) MakeFloat(all);
    return all;
  }

  // A plate of squares, with the noise of floats, or more, in its upper side.
  Solid NextGrid() {
    std::uniform_real_distribution<double> noise(-1, 1), exponent(-9, -4);
    const std::size_t n = static_cast<std::size_t>(2 + Below(5));
    const double scale = Below(2) == 0 ? 0 : std::pow(10, exponent(random_));
    const double thickness = std::pow(10, -Below(3));
    Solid plate;
    for (const bool is_top : {false, true}) {
      for (std::size_t i = 0; i <= n; ++i) {
        for (std::size_t j = 0; j <= n; ++j) {
          const double z = is_top ? thickness + scale * noise(random_) : 0;
          plate.points.push_back({static_cast<double>(i) / 3, static_cast<double>(j) / 7, z});
        }
      }
    }
    const std::size_t top = (n + 1) * (n + 1);
    const auto quad = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
      if (Below(2) == 0) {
        plate.faces.push_back({a, b, c});
        plate.faces.push_back({a, c, d});
      } else {
        plate.faces.push_back({b, c, d});
        plate.faces.push_back({b, d, a});
      }
    };
    const auto at = [&](std::size_t i, std::size_t j) { return i * (n + 1) + j; };
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        quad(at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j));
        quad(top + at(i, j), top + at(i + 1, j), top + at(i + 1, j + 1), top + at(i, j + 1));
      }
    }
    for (std::size_t k = 0; k < n; ++k) {
      const auto wall = [&](std::size_t a, std::size_t b) { quad(a, b, top + b, top + a); };
      wall(at(k, 0), at(k + 1, 0));
      wall(at(n, k), at(n, k + 1));
      wall(at(k + 1, n), at(k, n));
      wall(at(0, k + 1), at(0, k));
    }
    MakeFloat(plate);
    return plate;
  }

  // Thin sheets on each other and side by side, 1e-7 apart or a few of that.
  Solid NextSheets() {
    Solid all;
    const int sheets = 2 + Below(3);
    double z = 0;
    for (int i = 0; i < sheets; ++i) {
      const double x = 0.25 * Below(4), y = 0.25 * Below(4);
      const double thickness = Below(3) == 0 ? 1e-7 * (1 + Below(4)) : 0.1 * (1 + Below(3));
      Solid sheet = BoxSolid({x, y, z}, {x + 1, y + 1, z + thickness});
      if (Below(3) == 0) Turn(sheet);
      all.Add(sheet);
      z += thickness + (Below(3) == 0 ? 0 : 1e-7 * Below(4));
    }
    return all;
  }

  // Tetrahedra between places of a lattice, some of them a little beside theirs, so that they share
  // planes, corners and edges, or nearly do.
  Solid NextSoup() {
    std::uniform_real_distribution<double> noise(-1, 1), exponent(-12, -3);
    const double scale = Below(2) == 0 ? 0 : std::pow(10, exponent(random_));
    const int count = 2 + Below(5);
    Solid all;
    for (int i = 0; i < count; ++i) {
      Solid solid;
      for (int k = 0; k < 4; ++k) {
        std::array<double, 3> point{};
        for (double& x : point) x = Below(4) + (Below(3) == 0 ? scale * noise(random_) : 0);
        solid.points.push_back(point);
      }
      solid.faces = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
      all.Add(solid);
    }
    if (Below(2) == 0) MakeFloat(all);
    return all;
  }

  // Two of the others, over each other.
  Solid NextMixture() {
    constexpr Solid (Solids::*kKinds[])() = {&Solids::Next,       &Solids::NextNeedles,
                                             &Solids::NextRibbon, &Solids::NextSpheres,
                                             &Solids::NextGrid,   &Solids::NextSheets};
    Solid all = (this->*kKinds[static_cast<std::size_t>(Below(6))])();
    Solid other = (this->*kKinds[static_cast<std::size_t>(Below(6))])();
    if (Below(2) == 0) Turn(other);
    all.Add(other);
    return all;
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
  static void MakeFloat(Solid& solid) {
    for (auto& point : solid.points) {
      for (double& x : point) x = static_cast<float>(x * 1.1);
    }
  }
  // Of triangles from pole to pole.
  static Solid Sphere(int rings, int sectors, double radius, double turn) {
    Solid sphere;
    sphere.points = {{0, 0, radius}, {0, 0, -radius}};
    for (int i = 1; i <= rings; ++i) {
      const double polar = std::numbers::pi * i / (rings + 1);
      for (int j = 0; j < sectors; ++j) {
        const double angle = turn + 2 * std::numbers::pi * j / sectors;
        sphere.points.push_back({radius * std::sin(polar) * std::cos(angle),
                                 radius * std::sin(polar) * std::sin(angle),
                                 radius * std::cos(polar)});
      }
    }
    const auto at = [&](int i, int j) {
      return static_cast<std::size_t>(2 + i * sectors + j % sectors);
    };
    for (int j = 0; j < sectors; ++j) {
      sphere.faces.push_back({0, at(0, j), at(0, j + 1)});
      sphere.faces.push_back({1, at(rings - 1, j + 1), at(rings - 1, j)});
      for (int i = 0; i + 1 < rings; ++i) {
        sphere.faces.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
        sphere.faces.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
      }
    }
    return sphere;
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

// What is asked of the results of a kind of solids.
struct Wanted {
  double mended = 0.25, refused = 0;  // of all, at least and at most
  bool is_closed = true;              // if not, sheets thinner than D may become one layer
  int runs = 40;
  bool by_samples = false;  // distances; else by a proof, which may give up for tiny ones
  // By which joining faces moves what it joins, beyond what is told: with numbers of floats more
  // than the slack of 1e-9. Four in each coordinate (flatten.h), and one for the polygon's inside.
  double roundings = 0;
};

// NearestOn is not accurate for needles: a point of an edge may be nearer than what it returns.
double SquaredDistanceTo(const cleaning::TriangleCorners& target, const cleaning::Point3& at) {
  double least = cleaning::SquaredDistance<3>(at, cleaning::NearestOn(target, at));
  for (std::size_t k = 0; k < 3; ++k) {
    const cleaning::Point3 foot = cleaning::FootOn(target[k], target[(k + 1) % 3], at);
    least = std::min(least, cleaning::SquaredDistance<3>(at, foot));
  }
  return least;
}

// The largest distance from one of ten points of each face to the nearest face of `to`. O(n m).
double SampledFarthest(const std::vector<Feature>& from, const std::vector<Feature>& to) {
  const std::vector<PolygonPart> targets = TrianglesOf(to);
  double farthest = 0;
  for (const PolygonPart& part : TrianglesOf(from)) {
    const auto& [a, b, c] = part.corners;
    for (int i = 0; i <= 3; ++i) {
      for (int j = 0; i + j <= 3; ++j) {
        cleaning::Point3 at;
        for (std::size_t k = 0; k < 3; ++k) at[k] = (i * a[k] + j * b[k] + (3 - i - j) * c[k]) / 3;
        double least = INFINITY;
        for (const PolygonPart& target : targets) {
          least = std::min(least, SquaredDistanceTo(target.corners, at));
        }
        farthest = std::max(farthest, least);
      }
    }
  }
  return std::sqrt(farthest);
}

void ExpectAcceptedAndNearAndStays(Solid (Solids::*next)(), const Wanted& wanted = {}) {
  const std::uint64_t seed = test::NewSeed();
  const int runs = test::IsNightly() ? 50 * wanted.runs : wanted.runs;
  const test::TempFolder folder;
  Solids solids(seed);
  int mended = 0, refused = 0;
  for (int run = 0; run < runs; ++run) {
    const std::string path = folder.Write("s.off", (solids.*next)().Off());
    const auto prepared = Prepare(path, {}, {});
    ASSERT_TRUE(prepared.ok()) << run << prepared.status();
    const Report& report = prepared->report;
    const auto mesh = DynamicMesh::Create(prepared->geometry.options);
    ASSERT_TRUE(mesh.ok()) << run;
    const absl::Status accepted = (*mesh)->Validate(AddAll(prepared->geometry.features));
    if (!accepted.ok()) {  // then it is as it was read, and the report says why
      EXPECT_FALSE(report.is_mended) << run;
      EXPECT_EQ(report.found, accepted) << run;
      ++refused;
      continue;
    }
    if (wanted.is_closed) {
      EXPECT_EQ(report.open_edges_after, 0U) << run;
    }
    if (!report.is_mended) continue;
    ++mended;
    EXPECT_LE(report.farthest, report.within) << run;
    io::GeometryOptions raw;
    raw.faces = io::FaceRules::kAsTheyCome;
    const auto given = io::ReadGeometry(path, raw);
    // Joined faces move by roundings.
    const double rounding =
        prepared->geometry.rounding.Of(LargestMagnitude(prepared->geometry.options.box, 3));
    const double slack = 1.01 * report.farthest + 1e-9 + wanted.roundings * rounding;
    const std::vector<Feature>& features = prepared->geometry.features;
    if (wanted.by_samples) {
      EXPECT_LE(SampledFarthest(given->features, features), slack) << run;
      EXPECT_LE(SampledFarthest(features, given->features), slack) << run;
    } else {
      EXPECT_TRUE(FarthestBound(given->features, features, 3, slack / 4, 2 * slack)) << run;
    }
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
  constexpr int kMany = 40;  // of fewer, parts are left to chance
  if (runs >= kMany) {
    EXPECT_GE(mended, wanted.mended * runs);
  }
  if (runs >= kMany || wanted.refused == 0) {
    EXPECT_LE(refused, wanted.refused * runs);
  }
}

TEST(PrepareProperty, WhatIsPreparedIsAcceptedAndNearAndStays) {
  ExpectAcceptedAndNearAndStays(&Solids::Next);
}

TEST(PrepareProperty, RibbonsThatGoOverThemselves) {
  ExpectAcceptedAndNearAndStays(&Solids::NextRibbon,
                                {.mended = 0.25, .refused = 0.2, .is_closed = false, .runs = 5});
}

// Some faces of two spheres cross at angles below the least one, or in needles.
TEST(PrepareProperty, SpheresAtOnePlace) {
  ExpectAcceptedAndNearAndStays(
      &Solids::NextSpheres,
      {.mended = 0.25, .refused = 0.2, .runs = 10, .by_samples = true, .roundings = 8});
}

TEST(PrepareProperty, PlatesWithNoise) {
  ExpectAcceptedAndNearAndStays(&Solids::NextGrid, {.mended = 0, .roundings = 8});
}

TEST(PrepareProperty, SheetsOnEachOther) {
  ExpectAcceptedAndNearAndStays(&Solids::NextSheets,
                                {.mended = 0.25, .is_closed = false, .runs = 20});
}

// Two tetrahedra that share a plane may be folded to one layer.
TEST(PrepareProperty, TetrahedraBetweenPlacesOfALattice) {
  ExpectAcceptedAndNearAndStays(&Solids::NextSoup, {.mended = 0.25,
                                                    .refused = 0.1,
                                                    .is_closed = false,
                                                    .runs = 20,
                                                    .by_samples = true,
                                                    .roundings = 8});
}

TEST(PrepareProperty, MixturesOfThem) {
  ExpectAcceptedAndNearAndStays(&Solids::NextMixture, {.mended = 0.25,
                                                       .refused = 0.2,
                                                       .is_closed = false,
                                                       .runs = 4,
                                                       .by_samples = true,
                                                       .roundings = 8});
}

TEST(PrepareProperty, NeedlesAreTakenAwayWithinTheDistance) {
  ExpectAcceptedAndNearAndStays(&Solids::NextNeedles);
}

}  // namespace
}  // namespace dynmesh::preparation
