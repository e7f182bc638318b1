// The guarantees in 3D with polygons: after every revision of random scripts the dynamic mesh
// equals, in mesh and complete trace, one from scratch; a replica that follows the diffs has it;
// and the verifier of mesh files, which shares no code with the mesher, finds no fault.
//
// DYNMESH_NIGHTLY=1 runs the long setting (20,000 revisions).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <string>
#include <tuple>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/asked.h"
#include "tests/support/judged.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::polygon_history_test {
namespace {

// The verifier's findings; empty if there are none.
std::string Judge(const DynamicMesh& mesh) {
  return Judged(mesh.Snapshot(), mesh.options().quality, mesh.Features());
}

MeshOptions OptionsOf(const Asked& asked) {
  MeshOptions options = DefaultsIn<3>();
  options.quality = asked.quality;
  options.criterion = asked.criterion;
  options.min_dihedral = asked.min_dihedral;
  return options;
}

using Given = std::tuple<PolygonKind, int>;
class PolygonHistory : public ::testing::TestWithParam<Given> {};

// Scripts of `revisions` revisions around that many solids.
struct Setting {
  int solids, revisions, scripts;
};

// By day each kind of polygons has scripts of both sizes, and so has all that is asked, but not
// each pair of them.
std::vector<Setting> SettingsOf(PolygonKind kind, int asked) {
  if (IsNightly()) return {{1, 100, 4}, {3, 100, 5}, {8, 100, 2}};
  if ((static_cast<int>(kind) + asked) % 2 != 0) return {{1, 12, 1}};
  return {{3, 6, 1}};
}

TEST_P(PolygonHistory, DynamicIsFromScratchAndGoodAfterEveryRevision) {
  const auto [kind, asked] = GetParam();
  const MeshOptions options = OptionsOf(kAskedInSpace[asked]);
  const std::uint64_t base = IsNightly() ? 77'000 : 1'000;
  for (const Setting& s : SettingsOf(kind, asked)) {
    for (int k = 0; k < s.scripts; ++k) {
      const std::uint64_t seed =
          base + 100 * static_cast<std::uint64_t>(s.solids) + static_cast<std::uint64_t>(k);
      SCOPED_TRACE(NameOf(kind) + " solids " + std::to_string(s.solids) + " seed " +
                   std::to_string(seed));
      RunPlan plan;
      plan.revisions = s.revisions;
      plan.every_static = 4;
      plan.judge = &Judge;
      const RunReport run = RunScriptOf<3>(PolygonScript(kind, s.solids, seed), options, plan);
      if (run.difference.found) {
        FAIL() << run.difference.what << "\nshrunk script:\n"
               << ToScript(options, Shrink(run.script, options, plan));
      }
      EXPECT_EQ(run.revisions, s.revisions) << "too many proposals were refused";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, PolygonHistory,
                         ::testing::Combine(::testing::ValuesIn(kPolygonKinds),
                                            ::testing::Range(0, kAskedInSpaceCount)),
                         [](const auto& given) {
                           return NameOf(std::get<0>(given.param)) +
                                  kAskedInSpace[std::get<1>(given.param)].name;
                         });

// Plates above each other and areas with a target, at multiples of a power of two: many points of
// the plates' lattices are equidistant from two features, and on borders of all kinds.
class LatticePlates {
 public:
  explicit LatticePlates(std::uint64_t seed) : random_(seed) {}

  EditBatch Next(const std::vector<Feature>& present) {
    const auto is_there = [&](FeatureId id) {
      return std::ranges::any_of(present, [&](const Feature& f) { return f.id == id; });
    };
    const FeatureId plate = 10 * static_cast<FeatureId>(1 + random_.Below(5));
    if (random_.OneIn(4)) {
      const Feature size = Feature::Size(1, {Place(), Place(), 0.25},
                                         {SizeShape::kBox,
                                          random_.OneIn(2) ? 0.125 : 0.1,
                                          0,
                                          {Place() + 0.5, Place() + 0.5, 0.75}});
      return {is_there(1) ? Edit::Remove(1) : Edit::Add(size)};
    }
    EditBatch batch;
    if (is_there(plate)) {
      for (FeatureId i = 5; i-- > 0;) batch.push_back(Edit::Remove(plate + i));
      return batch;
    }
    const double z = 0.5 + static_cast<double>(plate) / 10 * kStep;
    const double x = Place(), y = Place(), width = 0.25 + Place(), height = 0.25 + Place();
    const auto first = static_cast<FeatureId>(random_.Below(4));
    for (FeatureId i = 0; i < 4; ++i) {
      batch.push_back(Edit::Add(
          Feature::Point(plate + i, i == 1 || i == 2 ? x + width : x, i >= 2 ? y + height : y, z)));
    }
    Rings rings(1);
    for (FeatureId i = 0; i < 4; ++i) rings[0].push_back(plate + (first + i) % 4);
    batch.push_back(Edit::Add(Feature::Polygon(plate + 4, rings)));
    return batch;
  }

 private:
  static constexpr double kStep = 1.0 / 32;

  double Place() { return kStep * random_.Below(13); }

  Random random_;
};

TEST(PolygonHistoryOnALattice, DynamicIsFromScratchAfterEveryRevision) {
  const int scripts = IsNightly() ? 200 : 4;
  for (int k = 0; k < scripts; ++k) {
    const auto seed = static_cast<std::uint64_t>(500 + k);
    SCOPED_TRACE("seed " + std::to_string(seed));
    RunPlan plan;
    plan.revisions = IsNightly() ? 50 : 10;
    plan.every_static = 4;
    const RunReport run = RunScriptOf<3>(LatticePlates(seed), DefaultsIn<3>(), plan);
    if (run.difference.found) {
      FAIL() << run.difference.what << "\nshrunk script:\n"
             << ToScript(DefaultsIn<3>(), Shrink(run.script, DefaultsIn<3>(), plan));
    }
  }
}

// Boxes in a grid, all faces there; `turned`: of box `k`, so many steps of a turn about z.
std::vector<Feature> BoxAt(FeatureId k, int side, int turned) {
  const Solid box = MakeCuboid(0.25, 0.25, 0.25);
  const auto i = static_cast<int>(k);
  const double cell = 1.0 / side, c = std::cos(0.1 * turned), s = std::sin(0.1 * turned);
  const std::array<double, 3> at = {(i % side + 0.5) * cell, (i / side % side + 0.5) * cell,
                                    (i / (side * side) + 0.5) * cell};
  std::vector<Feature> features;
  const FeatureId base = 1000 * (k + 1);
  for (std::size_t p = 0; p < box.corners.size(); ++p) {
    const auto& [x, y, z] = box.corners[p];
    features.push_back(Feature::Point(base + p, at[0] + cell * (c * x - s * y),
                                      at[1] + cell * (s * x + c * y), at[2] + cell * z));
  }
  for (std::size_t f = 0; f < box.faces.size(); ++f) {
    Rings rings = box.faces[f][0];
    for (FeatureId& corner : rings[0]) corner += base;
    features.push_back(Feature::Polygon(base + 500 + f, rings));
  }
  return features;
}

// The box in the middle of 125 turns at the same cost, in operations, as that of 27.
TEST(PolygonWork, OfABoxDoesNotGrowWithTheInput) {
  std::vector<double> executed;
  for (const int side : {3, 5}) {
    const auto middle = static_cast<FeatureId>(side * side * side / 2);
    std::vector<Feature> all;
    for (FeatureId k = 0; k < static_cast<FeatureId>(side * side * side); ++k) {
      for (const Feature& f : BoxAt(k, side, 0)) all.push_back(f);
    }
    LiveMesh<3> edited(DefaultsIn<3>(), AlwaysPropagate());
    ASSERT_TRUE(edited.Apply(AddAll(all), ApplyOptions{}).ok());
    double sum = 0;
    for (int turn = 1; turn <= 8; ++turn) {
      EditBatch batch;
      for (const Feature& f : BoxAt(middle, side, turn)) {
        if (f.kind == FeatureKind::kPoint) batch.push_back({Edit::Action::kMove, f});
      }
      const auto diff = edited.Apply(batch, ApplyOptions{});
      ASSERT_TRUE(diff.ok()) << diff.status();
      sum += static_cast<double>(diff->work.executed);
    }
    executed.push_back(sum / 8);
    RecordProperty("executed_" + std::to_string(side * side * side), std::to_string(sum / 8));
  }
  EXPECT_GT(executed[0], 10);
  EXPECT_LT(executed[1], 1.5 * executed[0]);
}

// A wavy surface of triangles, n by n cells of a 16th of the cube; corners have ids from 1 on. The
// corner in the middle has the id n / 2 * (n + 2) + 1.
std::vector<Feature> WavySurface(int n) {
  std::vector<Feature> features;
  const auto at = [n](int i, int j) { return static_cast<FeatureId>(1 + i * (n + 1) + j); };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      // The same around the middle, whatever n.
      const int u = i - n / 2, v = j - n / 2;
      const double x = u + 0.3 * std::sin(7 * u + 3 * v), y = v + 0.3 * std::sin(5 * u - 4 * v);
      features.push_back(Feature::Point(at(i, j), 0.5 + x / 16, 0.5 + y / 16,
                                        0.5 + 0.4 * std::sin(0.8 * x) * std::cos(0.6 * y) / 16));
    }
  }
  FeatureId id = at(n, n);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const FeatureId a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
      features.push_back(Feature::Polygon(++id, {{a, b, c}}));
      features.push_back(Feature::Polygon(++id, {{a, c, d}}));
    }
  }
  return features;
}

// A corner in the middle of a surface of 288 triangles moves at the same cost, in operations, as
// one in a surface of 72.
TEST(PolygonWork, OfACornerDoesNotGrowWithTheSurface) {
  std::vector<double> executed, changed;
  for (const int n : {6, 12}) {
    LiveMesh<3> edited(DefaultsIn<3>(), AlwaysPropagate());
    const std::vector<Feature> surface = WavySurface(n);
    ASSERT_TRUE(edited.Apply(AddAll(surface), ApplyOptions{}).ok());
    Feature corner = surface[static_cast<std::size_t>(n / 2 * (n + 2))];
    double sum = 0, vertices = 0;
    for (int k = 1; k <= 8; ++k) {
      corner.position[2] += (k % 2 == 0 ? 0.3 : -0.25) / 16;
      const auto diff = edited.Apply({{Edit::Action::kMove, corner}}, ApplyOptions{});
      ASSERT_TRUE(diff.ok()) << diff.status();
      sum += static_cast<double>(diff->work.executed);
      vertices += static_cast<double>(diff->added_vertices.size());
    }
    const Difference d = CompareWithScratch(edited, false);
    EXPECT_FALSE(d.found) << d.what;
    executed.push_back(sum / 8);
    changed.push_back(vertices / 8);
    RecordProperty("executed_" + std::to_string(n), std::to_string(sum / 8));
    RecordProperty("changed_" + std::to_string(n), std::to_string(vertices / 8));
  }
  EXPECT_GT(executed[0], 10);
  EXPECT_LT(executed[1], 1.5 * executed[0]);
  EXPECT_LT(changed[1], 1.5 * changed[0]);
}

}  // namespace
}  // namespace dynmesh::test::polygon_history_test
