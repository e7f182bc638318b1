// Every kind of transfer conserves the fields' sums, over the scenes of locality_scenes.h, the
// edits of deploy/data, large batches, and a mesh that loses all features.
//
// DYNMESH_NIGHTLY=1 runs 10,000 edits where the default runs 200.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <numbers>
#include <string>
#include <vector>

#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "tests/core/transfer/field_lab.h"
#include "tests/differential/locality_scenes.h"
#include "tests/support/source_path.h"
#include "tests/support/workload.h"

namespace dynmesh::test::conservation_test {
namespace {

using testing::FieldLab;
using testing::Mass;

constexpr double kOfOneEdit = 1e-14, kOfAll = 1e-12;  // of the sum of sizes

// A mesh with a field of each kind: a wave and a steep front, both of the box's size.
class Fields {
 public:
  Fields(const MeshOptions& options, const EditBatch& first) : lab_(options, first) {
    const Box& box = options.box;
    const double size = box.hi[0] - box.lo[0];
    const auto wave = [=](const double* x) {
      return 0.3 +
             std::sin(5 * (x[0] - box.lo[0]) / size) * std::cos(4 * (x[1] - box.lo[1]) / size);
    };
    const auto front = [=](const double* x) {
      return std::tanh(30 * ((x[0] - box.lo[0]) - (x[1] - box.lo[1])) / size);
    };
    for (const FieldKind kind : {FieldKind::kP0, FieldKind::kP0Linear, FieldKind::kP1,
                                 FieldKind::kDG1, FieldKind::kDual}) {
      if (kind == FieldKind::kDual && options.dimension == 3) continue;  // slow there
      for (const bool bounded : {false, true}) {
        FieldOptions field;
        field.kind = kind, field.bounded = bounded;
        bounded ? lab_.Add(field, front) : lab_.Add(field, wave);
      }
    }
    for (std::size_t f = 0; f < lab_.fields().size(); ++f) first_.push_back(lab_.MassOfField(f));
    last_ = first_;
  }

  // Applies the batch; each field must keep its sum. False if the mesh refuses it.
  bool Edit(const EditBatch& batch, const std::string& what) {
    if (!lab_.Edit(batch)) return false;
    Check(what);
    return true;
  }

  // Against what they held since the last check.
  void Check(const std::string& what) {
    for (std::size_t f = 0; f < lab_.fields().size(); ++f) {
      const Mass mass = lab_.MassOfField(f);
      EXPECT_NEAR(mass.sum, last_[f].sum, kOfOneEdit * last_[f].size) << what << Name(f);
      last_[f] = mass;
    }
  }
  void CheckAll() {
    for (std::size_t f = 0; f < lab_.fields().size(); ++f) {
      EXPECT_NEAR(lab_.MassOfField(f).sum, first_[f].sum, kOfAll * first_[f].size) << Name(f);
    }
  }
  // The greatest drift since the beginning, of the sum of sizes.
  double Drift() const {
    double worst = 0;
    for (std::size_t f = 0; f < first_.size(); ++f) {
      worst = std::max(worst, std::abs(lab_.MassOfField(f).sum - first_[f].sum) / first_[f].size);
    }
    return worst;
  }
  FieldLab& lab() { return lab_; }

 private:
  std::string Name(std::size_t f) {
    const FieldOptions& options = lab_.fields()[f].options;
    return ", kind " + std::to_string(static_cast<int>(options.kind)) +
           (options.bounded ? ", bounded" : "");
  }

  FieldLab lab_;
  std::vector<Mass> first_, last_;
};

class Conservation : public ::testing::TestWithParam<LocalityScene> {};
INSTANTIATE_TEST_SUITE_P(Scene, Conservation, ::testing::ValuesIn(LocalityScenes()),
                         [](const auto& of) { return std::string(of.param.name); });

TEST_P(Conservation, OfEachEdit) {
  const Scene scene = GetParam().make(GetParam().n);
  Fields fields(scene.options, AddAll(scene.features));
  for (std::size_t e = 0; e < scene.edits.size() && !HasFailure(); ++e) {
    EXPECT_TRUE(fields.Edit(scene.edits[e], "edit " + std::to_string(e)));
  }
  fields.CheckAll();
}

// The scripts that deploy/run replays: a crack, a valve, a storm on a coast.
class ConservationOfData : public ::testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Script, ConservationOfData, ::testing::Values("crack", "valve", "storm"),
                         [](const auto& of) { return std::string(of.param); });

TEST_P(ConservationOfData, OfEachRevision) {
  const std::string folder = SourcePath("deploy/data/"), name = GetParam();
  MeshOptions options;
  EditBatch first;
  io::ScriptParseOptions parse;
  const bool has_map = name == "storm";
  if (has_map) {
    const auto map = io::ReadPolyFile(folder + "coastline-110m.poly");
    ASSERT_TRUE(map.ok()) << map.status();
    options.box = io::BoundingBox(map->features);
    first = AddAll(map->features);
    parse.require_header = false;
  }
  const auto script = io::ReadEditScript(folder + name + ".dynmesh", parse);
  ASSERT_TRUE(script.ok()) << script.status();
  if (!has_map) options = script->Options();
  Fields fields(options, first);
  for (std::size_t b = 0; b < script->batches.size() && !HasFailure(); ++b) {
    EXPECT_TRUE(fields.Edit(script->batches[b].edits, script->Where(b, std::nullopt)));
  }
  fields.CheckAll();
}

class ConservationIn : public ::testing::TestWithParam<int> {
 protected:
  Feature AnyPoint(FeatureId id) {
    const double x = random_.Unit(), y = random_.Unit();
    return Feature::Point(id, x, y, GetParam() == 2 ? 0 : random_.Unit());
  }
  MeshOptions Options() const { return testing::UnitBox(GetParam()); }
  // A disc or a ball on the diagonal.
  Feature Size(FeatureId id, double at, double radius, double target) const {
    const double height = GetParam() == 2 ? 0 : at;
    return Feature::Size(id, {at, at, height}, {SizeShape::kDisc, target, radius, {}});
  }
  Random random_{20'261'124};
};
INSTANTIATE_TEST_SUITE_P(Dimension, ConservationIn, ::testing::Values(2, 3),
                         [](const auto& of) { return std::to_string(of.param) + "D"; });

TEST_P(ConservationIn, LargeBatches) {
  constexpr FeatureId kSize = 1000;
  EditBatch first;
  for (FeatureId id = 1; id <= kSize; ++id) first.push_back(Edit::Add(AnyPoint(id)));
  Fields fields(Options(), first);
  for (int step = 0; step < 3 && !HasFailure(); ++step) {
    EditBatch moved, out, in;
    for (FeatureId id = 1; id <= kSize; ++id) {
      moved.push_back(Edit::Set(AnyPoint(id)));
      out.push_back(Edit::Remove(id));
      in.push_back(Edit::Add(AnyPoint(id)));
    }
    EXPECT_TRUE(fields.Edit(moved, "all moved"));
    EXPECT_TRUE(fields.Edit(out, "all removed"));
    EXPECT_TRUE(fields.Edit(in, "all back elsewhere"));
  }
  fields.CheckAll();
}

TEST_P(ConservationIn, SizesThatComeMoveAndGo) {
  Fields fields(Options(), {Edit::Add(AnyPoint(1))});
  const int steps = GetParam() == 2 ? 20 : 5;
  const double target = GetParam() == 2 ? 0.02 : 0.08;
  for (int step = 0; step <= steps && !HasFailure(); ++step) {
    const double at = 0.25 + 0.5 * step / steps;
    const Feature disc = Size(10, at, 0.12, target);
    EXPECT_TRUE(fields.Edit({step == 0 ? Edit::Add(disc) : Edit::Set(disc)}, "a disc moves"));
    EXPECT_TRUE(fields.Edit({Edit::Add(Size(11, 1 - at, 0.05, target / 2))}, "another comes"));
    EXPECT_TRUE(fields.Edit({Edit::Remove(11)}, "and goes"));
  }
  EXPECT_TRUE(fields.Edit({Edit::Remove(10)}, "the disc goes"));
  fields.CheckAll();
}

// A disc of segments that moves.
TEST(ConservationOfADisc, ThatMoves) {
  const auto disc = [](double x, bool is_new) {
    EditBatch batch;
    for (int i = 0; i < 24; ++i) {
      const double angle = 2 * std::numbers::pi * i / 24;
      const Feature corner = Feature::Point(static_cast<FeatureId>(i + 1),
                                            x + 0.1 * std::cos(angle), 0.5 + 0.1 * std::sin(angle));
      batch.push_back(is_new ? Edit::Add(corner) : Edit::Set(corner));
    }
    for (int i = 0; is_new && i < 24; ++i) {
      batch.push_back(
          Edit::Add(Feature::Segment(static_cast<FeatureId>(i + 101), static_cast<FeatureId>(i + 1),
                                     static_cast<FeatureId>((i + 1) % 24 + 1))));
    }
    return batch;
  };
  MeshOptions options;
  options.max_edge = 0.04;
  Fields fields(options, disc(0.2, true));
  for (int step = 1; step <= 60 && !::testing::Test::HasFailure(); ++step) {
    EXPECT_TRUE(fields.Edit(disc(0.2 + 0.01 * step, false), "step " + std::to_string(step)));
  }
  fields.CheckAll();
}

TEST_P(ConservationIn, ManyEdits) {
  const char* nightly = std::getenv("DYNMESH_NIGHTLY");
  const int edits = nightly != nullptr && *nightly != '0' ? 10'000 : 200;
  const int points = GetParam() == 2 ? 60 : 30;
  EditBatch first;
  for (int i = 1; i <= points; ++i) {
    first.push_back(Edit::Add(AnyPoint(static_cast<FeatureId>(i))));
  }
  Fields fields(Options(), first);
  for (int e = 0; e < edits && !HasFailure(); ++e) {
    const auto id = static_cast<FeatureId>(1 + random_.Below(points));
    fields.Edit({Edit::Set(AnyPoint(id))}, "edit " + std::to_string(e));
  }
  fields.CheckAll();
  std::cout << edits << " edits: " << fields.Drift() << " of the mass\n";
}

}  // namespace
}  // namespace dynmesh::test::conservation_test
