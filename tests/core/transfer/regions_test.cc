// Mass and regions: mass in unchanged regions is conserved, and mass that changes its region is
// reported.
#include <map>
#include <set>

#include "tests/core/geometry/random_points.h"
#include "tests/core/transfer/field_lab.h"

namespace dynmesh {
namespace {

using testing::FieldFunction;
using testing::IsLive;
using testing::Mass;
using testing::MassOf;
using testing::RowCount;
using testing::Sample;

using Masses = std::map<RegionId, Mass>;

Masses MassesOf(const SlotMesh& mesh, FieldKind kind, const std::vector<double>& u) {
  std::set<RegionId> regions;
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (IsLive(mesh, c)) regions.insert(mesh.regions()[c]);
  }
  Masses masses;
  for (const RegionId region : regions) {
    masses[region] =
        MassOf(mesh, kind, u, [&](std::size_t c) { return mesh.regions()[c] == region; });
  }
  return masses;
}

// A square (polygon 10) and a triangle beside it (11) with a common edge.
EditBatch TwoPolygons() {
  const double corners[5][2] = {{0.2, 0.2}, {0.6, 0.25}, {0.6, 0.7}, {0.25, 0.65}, {0.9, 0.5}};
  EditBatch batch;
  for (FeatureId id = 1; id <= 5; ++id) {
    batch.push_back(Edit::Add(Feature::Point(id, corners[id - 1][0], corners[id - 1][1])));
  }
  batch.push_back(Edit::Add(Feature::Polygon(10, {{1, 2, 3, 4}})));
  batch.push_back(Edit::Add(Feature::Polygon(11, {{2, 5, 3}})));
  return batch;
}

// A cube's surface (polygons 11 to 16 with the region 11).
EditBatch Cube() {
  EditBatch batch;
  FeatureId id = 1;
  for (const double z : {0.3, 0.7}) {
    for (const auto& [x, y] : {std::pair{0.3, 0.3}, {0.7, 0.3}, {0.7, 0.7}, {0.3, 0.7}}) {
      batch.push_back(Edit::Add(Feature::Point(id++, x, y, z)));
    }
  }
  const FeatureId faces[6][4] = {{1, 2, 3, 4}, {5, 6, 7, 8}, {1, 2, 6, 5},
                                 {2, 3, 7, 6}, {3, 4, 8, 7}, {4, 1, 5, 8}};
  for (FeatureId f = 0; f < 6; ++f) {
    batch.push_back(Edit::Add(
        Feature::Polygon(11 + f, {{faces[f][0], faces[f][1], faces[f][2], faces[f][3]}})));
  }
  return batch;
}

struct Scene {
  std::unique_ptr<DynamicMesh> mesh;
  SlotMesh slots;
  explicit Scene(int dimension) {
    MeshOptions options = testing::UnitBox(dimension);
    options.quality = DefaultQuality(dimension);
    mesh = std::move(DynamicMesh::Create(options)).value();
    const auto diff = mesh->Apply(dimension == 2 ? TwoPolygons() : Cube());
    EXPECT_TRUE(diff.ok()) << diff.status();
    slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  }
  bool Edit(const EditBatch& batch) {
    const auto diff = mesh->Apply(batch);
    if (!diff.ok()) return false;
    EXPECT_TRUE(slots.Apply(*diff).ok());
    return true;
  }
};

double ShortWave(const double* x) { return 2 + std::sin(7 * x[0]) * std::cos(8 * x[1]); }

class RegionsOf : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimension, RegionsOf, ::testing::Values(2, 3),
                         [](const auto& of) { return std::to_string(of.param) + "D"; });

TEST_P(RegionsOf, KeepTheirMassWhereTheirShapeStays) {
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0.1, 0.9);
  for (const FieldKind kind : {FieldKind::kP0, FieldKind::kP0Linear, FieldKind::kDG1,
                               FieldKind::kDualCorners, FieldKind::kP1}) {
    Scene scene(dimension);
    std::vector<double> u = Sample(scene.slots, kind, ShortWave),
                        by_region(RowCount(scene.slots, kind));
    const auto width = static_cast<std::size_t>(dimension + 1);
    const auto cell_of = [&](std::size_t i) { return testing::IsAtCorners(kind) ? i / width : i; };
    const auto value_in = [](RegionId region) { return 0.1 + 1e6 * static_cast<double>(region); };
    if (kind != FieldKind::kP1) {
      for (std::size_t i = 0; i < by_region.size(); ++i) {
        by_region[i] = value_in(scene.slots.regions()[cell_of(i)]);
      }
    }
    Masses before = MassesOf(scene.slots, kind, u);
    int edits = 0;
    for (FeatureId id = 100; edits < (dimension == 2 ? 60 : 12); ++id) {
      const double x = draw(random), y = draw(random), z = draw(random);
      const bool comes = id % 2 == 0;
      if (!scene.Edit(comes ? EditBatch{Edit::Add(Feature::Point(id, x, y, z))}
                            : EditBatch{Edit::Remove(id - 1)})) {
        ++id;
        continue;
      }
      ++edits;
      u.resize(RowCount(scene.slots, kind)), by_region.resize(u.size());
      auto transfer = Transfer::Make(scene.slots);
      ASSERT_TRUE(transfer.ok());
      const auto flows = transfer->Carry({.kind = kind}, u);
      ASSERT_TRUE(flows.ok()) << flows.status();
      EXPECT_TRUE(flows->empty());
      ASSERT_TRUE(transfer->Carry({.kind = kind}, by_region).ok());
      const Masses after = MassesOf(scene.slots, kind, u);
      ASSERT_EQ(after.size(), before.size());
      for (const auto& [region, mass] : after) {
        ASSERT_NEAR(mass.sum, before[region].sum, 1e-13 * before[region].size)
            << "region " << region << ", kind " << static_cast<int>(kind);
      }
      before = after;
      if (kind == FieldKind::kP1) continue;
      for (std::size_t i = 0; i < by_region.size(); ++i) {
        if (!IsLive(scene.slots, cell_of(i))) continue;
        ASSERT_EQ(by_region[i], value_in(scene.slots.regions()[cell_of(i)]));
      }
    }
  }
}

// 1 in the region, walls included, and 0 elsewhere: its walls leave no room where they get coarser.
double RoundFront(const double* x) {
  const double r = std::hypot(x[0] - 0.4, x[1] - 0.45);
  return std::tanh(40 * (0.15 - r));
}

TEST_P(RegionsOf, KeepTheirMassWithinBoundsWhereTheseHaveRoom) {
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0.1, 0.9);
  for (const testing::FieldFunction& f : {FieldFunction(ShortWave), FieldFunction(RoundFront)}) {
    Scene scene(dimension);
    const FieldKind kind = FieldKind::kP1;
    std::vector<double> u = Sample(scene.slots, kind, f);
    Masses before = MassesOf(scene.slots, kind, u);
    int edits = 0, with_flows = 0;
    for (FeatureId id = 100; edits < (dimension == 2 ? 120 : 16); ++id) {
      const double x = draw(random), y = draw(random), z = draw(random);
      std::vector<bool> was;
      for (std::size_t v = 0; v < scene.slots.ids().size(); ++v) {
        was.push_back(scene.slots.ids()[v] != 0);
      }
      if (!scene.Edit(id % 2 == 0 ? EditBatch{Edit::Add(Feature::Point(id, x, y, z))}
                                  : EditBatch{Edit::Remove(id - 1)})) {
        ++id;
        continue;
      }
      ++edits;
      double low = 1e300, high = -1e300;
      for (std::size_t v = 0; v < was.size(); ++v) {
        if (was[v]) low = std::min(low, u[v]), high = std::max(high, u[v]);
      }
      u.resize(RowCount(scene.slots, kind));
      auto transfer = Transfer::Make(scene.slots);
      ASSERT_TRUE(transfer.ok());
      const auto flows = transfer->Carry({.kind = kind, .bounded = true}, u);
      ASSERT_TRUE(flows.ok()) << flows.status();
      for (std::size_t v = 0; v < u.size(); ++v) {
        if (scene.slots.ids()[v] == 0) continue;
        ASSERT_GE(u[v], low);
        ASSERT_LE(u[v], high);
      }
      with_flows += !flows->empty();
      Masses after = MassesOf(scene.slots, kind, u);
      ASSERT_EQ(after.size(), before.size());
      const double size = MassOf(scene.slots, kind, u).size;
      Masses told = before;
      for (const RegionFlow& flow : *flows) {
        ASSERT_EQ(flow.amounts.size(), 1U);
        ASSERT_NE(flow.from, flow.to);
        told[flow.from].sum -= flow.amounts[0], told[flow.to].sum += flow.amounts[0];
      }
      for (const auto& [region, mass] : after) {
        ASSERT_NEAR(mass.sum, told[region].sum, 1e-13 * size)
            << "region " << region << ", edit " << edits;
      }
      before = std::move(after);
    }
    RecordProperty("edits_with_flows", with_flows);
    EXPECT_LE(with_flows, edits / 4);
  }
}

// Edits that change the shapes of regions, in this order.
std::vector<EditBatch> ChangesOfShape(int dimension) {
  if (dimension == 2) {
    return {{Edit::Move(3, 0.55, 0.75)},
            {Edit::Move(5, 0.85, 0.55)},
            {Edit::Remove(11)},
            {Edit::Remove(10)}};
  }
  return {{Edit::Move(5, 0.3, 0.3, 0.75), Edit::Move(6, 0.7, 0.3, 0.75),
           Edit::Move(7, 0.7, 0.7, 0.75), Edit::Move(8, 0.3, 0.7, 0.75)},
          {Edit::Remove(13)}};
}

double Linear(const double* x) { return 2 - 3 * x[0] + 5 * x[1]; }

TEST_P(RegionsOf, ThatChangeTheirShapeKeepLinearFields) {
  for (const FieldKind kind : {FieldKind::kDG1, FieldKind::kP1}) {
    for (const bool bounded : {false, true}) {
      Scene scene(GetParam());
      std::vector<double> u = Sample(scene.slots, kind, Linear);
      for (const EditBatch& batch : ChangesOfShape(GetParam())) {
        ASSERT_TRUE(scene.Edit(batch));
        u.resize(RowCount(scene.slots, kind));
        auto transfer = Transfer::Make(scene.slots);
        ASSERT_TRUE(transfer.ok());
        ASSERT_TRUE(transfer->Carry({.kind = kind, .bounded = bounded}, u).ok());
        ASSERT_LT(testing::GreatestError(scene.slots, kind, u, Linear), 1e-11)
            << "kind " << static_cast<int>(kind) << ", revision " << scene.slots.revision();
      }
    }
  }
}

TEST_P(RegionsOf, ThatChangeTheirShapeTellWhatChangesSides) {
  const int dimension = GetParam();
  for (const FieldKind kind :
       {FieldKind::kP0, FieldKind::kP0Linear, FieldKind::kDG1, FieldKind::kDualCorners}) {
    Scene scene(dimension);
    std::vector<double> u = Sample(scene.slots, kind, ShortWave);
    for (const EditBatch& batch : ChangesOfShape(dimension)) {
      const Masses before = MassesOf(scene.slots, kind, u);
      const Mass all_before = MassOf(scene.slots, kind, u);
      ASSERT_TRUE(scene.Edit(batch));
      u.resize(RowCount(scene.slots, kind));
      auto transfer = Transfer::Make(scene.slots);
      ASSERT_TRUE(transfer.ok());
      const auto flows = transfer->Carry({.kind = kind}, u);
      ASSERT_TRUE(flows.ok()) << flows.status();
      EXPECT_FALSE(flows->empty());
      const Mass all_after = MassOf(scene.slots, kind, u);
      EXPECT_NEAR(all_after.sum, all_before.sum, 1e-13 * all_before.size);
      std::map<RegionId, double> change;
      for (const auto& [region, mass] : before) change[region] -= mass.sum;
      for (const auto& [region, mass] : MassesOf(scene.slots, kind, u)) change[region] += mass.sum;
      for (const RegionFlow& flow : *flows) {
        ASSERT_EQ(flow.amounts.size(), 1U);
        change[flow.from] += flow.amounts[0], change[flow.to] -= flow.amounts[0];
      }
      for (const auto& [region, rest] : change) {
        EXPECT_NEAR(rest, 0, 1e-12 * all_before.size)
            << "region " << region << ", kind " << static_cast<int>(kind) << ", revision "
            << scene.slots.revision();
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh
