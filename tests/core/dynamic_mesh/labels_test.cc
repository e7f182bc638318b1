// Labels of features: a random history equals a map of labels and a mesh without them; what is
// refused or taken back leaves no trace; no mesh depends on them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/label_script.h"
#include "tests/support/same_diff.h"
#include "tests/support/seed.h"
#include "tests/support/workload.h"

namespace dynmesh::labels_test {
namespace {

using test::Distribution;
using test::Random;

MeshOptions OptionsOf(int dimension, MeshKind kind = MeshKind::kDelaunay) {
  MeshOptions options;
  options.dimension = dimension;
  options.kind = kind;
  options.quality = DefaultQuality(dimension);
  options.min_dihedral = DefaultMinDihedral(dimension, kind);
  return options;
}

std::unique_ptr<DynamicMesh> MakeMesh(int dimension = 2, MeshKind kind = MeshKind::kDelaunay) {
  return *DynamicMesh::Create(OptionsOf(dimension, kind));
}

Feature Labelled(Feature feature, FeatureLabel label) {
  feature.label = std::move(label);
  return feature;
}

std::string ReasonOf(const absl::Status& status) {
  const auto detail = GetErrorDetail(status);
  return detail.has_value() ? detail->reason : "";
}

// What a diff would have of a mesh that stays.
bool HasNoMeshChange(const MeshDiff& diff) {
  return diff.removed_vertices.empty() && diff.added_vertices.ids.empty() &&
         diff.removed_simplices.empty() && diff.added_simplices.empty() &&
         diff.removed_subsegments.owners.empty() && diff.added_subsegments.owners.empty() &&
         diff.removed_subfacets.owners.empty() && diff.added_subfacets.owners.empty();
}

TEST(OptionalLabel, IsAValueOfTheSizeOfAPointer) {
  static_assert(sizeof(OptionalLabel) == sizeof(void*));
  OptionalLabel none, a = {7, "a"};
  EXPECT_FALSE(none);
  EXPECT_TRUE(none->empty());
  EXPECT_FALSE(OptionalLabel(0, "")) << "an empty label is none";
  EXPECT_TRUE(a);
  EXPECT_EQ(*a, (FeatureLabel{7, "a"}));
  EXPECT_NE(a, none);
  EXPECT_EQ(a, OptionalLabel(7, "a"));
  EXPECT_NE(a, OptionalLabel(8, "a"));
  EXPECT_NE(a, OptionalLabel(7, "b"));
  OptionalLabel b = a;
  a = none;
  EXPECT_FALSE(a);
  EXPECT_EQ(b->marker, 7) << "a copy is its own";
  a = b;
  const OptionalLabel& self = a;
  a = self;
  EXPECT_EQ(a, b);
  none = std::move(b);
  EXPECT_EQ(none, a);
}

TEST(Labels, EveryEditTellsWhatItMakesOfThem) {
  const auto mesh = MakeMesh();
  const auto apply = [&](const EditBatch& batch) {
    const auto diff = mesh->Apply(batch);
    EXPECT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(diff->to_revision, mesh->revision());
    return *diff;
  };
  MeshDiff diff = apply({Edit::Add(Labelled(Feature::Point(2, 0.2, 0.2), {5, "corner"})),
                         Edit::Add(Feature::Point(1, 0.8, 0.2)),
                         Edit::Add(Labelled(Feature::Segment(3, 1, 2), {0, "wall"}))});
  EXPECT_EQ(diff.labels, (LabelColumn{{2, {5, "corner"}}, {3, {0, "wall"}}}));
  EXPECT_EQ(mesh->Snapshot().labels, diff.labels);

  // An edit of labels alone is a revision without a change of the mesh.
  const MeshHash hash = mesh->hash();
  diff =
      apply({Edit::SetLabel(1, {-3, ""}), Edit::SetLabel(2, {}), Edit::SetLabel(3, {0, "wall"})});
  EXPECT_EQ(diff.labels, (LabelColumn{{1, {-3, ""}}, {2, {}}}));
  EXPECT_TRUE(HasNoMeshChange(diff));
  EXPECT_EQ(diff.hash, hash);
  EXPECT_EQ(diff.from_revision + 1, diff.to_revision);
  EXPECT_EQ(mesh->Snapshot().labels, (LabelColumn{{1, {-3, ""}}, {3, {0, "wall"}}}));

  // Moved and set features keep theirs; a set may bring another one.
  diff = apply({Edit::Move(1, 0.7, 0.3), Edit::Set(Feature::Segment(3, 2, 1))});
  EXPECT_TRUE(diff.labels.empty());
  EXPECT_EQ(mesh->Features()[0].label, OptionalLabel(-3, ""));
  EXPECT_EQ(mesh->Features()[2].label, OptionalLabel(0, "wall"));
  diff = apply({Edit::Set(Labelled(Feature::Segment(3, 1, 2), {4, "door"}))});
  EXPECT_EQ(diff.labels, (LabelColumn{{3, {4, "door"}}}));

  // Removed and added again is a new feature; the label goes with the old one.
  diff = apply({Edit::Remove(3), Edit::Add(Labelled(Feature::Segment(3, 1, 2), {9, ""}))});
  EXPECT_EQ(diff.labels, (LabelColumn{{3, {9, ""}}}));
  diff = apply({Edit::Remove(3), Edit::Add(Feature::Segment(3, 1, 2))});
  EXPECT_EQ(diff.labels, (LabelColumn{{3, {}}}));
  diff = apply({Edit::SetLabel(3, {1, "x"}), Edit::Remove(3)});
  EXPECT_TRUE(diff.labels.empty()) << "it had none before";
  diff = apply({Edit::Remove(1)});
  EXPECT_EQ(diff.labels, (LabelColumn{{1, {}}}));
  EXPECT_TRUE(mesh->Snapshot().labels.empty());

  // In one batch the last edit counts, and labels that end as they were are not told.
  diff = apply({Edit::SetLabel(2, {1, ""}), Edit::SetLabel(2, {2, ""})});
  EXPECT_EQ(diff.labels, (LabelColumn{{2, {2, ""}}}));
  diff = apply({Edit::SetLabel(2, {1, ""}), Edit::SetLabel(2, {2, ""})});
  EXPECT_TRUE(diff.labels.empty());
  EXPECT_EQ(diff.from_revision + 1, diff.to_revision);
}

TEST(Labels, BadOnesAreNamedAndChangeNothing) {
  const auto mesh = MakeMesh();
  ASSERT_TRUE(mesh->Apply({Edit::Add(Labelled(Feature::Point(1, 0.5, 0.5), {1, "a"}))}).ok());
  const std::vector<Feature> before = mesh->Features();
  const std::string good(kMostNameBytes, 'n'), bad = good + "n";
  struct Case {
    EditBatch batch;
    const char* reason;
    FeatureId feature;
    std::size_t edit;
  };
  const Feature other = Feature::Point(2, 0.25, 0.5);
  const Case cases[] = {
      {{Edit::SetLabel(1, {1, bad})}, reason::kBadLabel, 1, 0},
      {{Edit::SetLabel(1, {}), Edit::Add(Labelled(other, {0, "a\nb"}))}, reason::kBadLabel, 2, 1},
      {{Edit::Set(Labelled(Feature::Point(1, 0.5, 0.5), {0, "\xff"}))}, reason::kBadLabel, 1, 0},
      {{Edit::SetLabel(2, {1, "a"})}, reason::kUnknownFeature, 2, 0},
      {{Edit::SetLabel(2, {1, "a"}), Edit::Add(other)}, reason::kUnknownFeature, 2, 0},
      {{Edit::Remove(1), Edit::SetLabel(1, {})}, reason::kUnknownFeature, 1, 1},
      {{Edit::SetLabel(0, {})}, reason::kBadId, 0, 0},
      // An edit of a label is not to blame for the feature's position.
      {{Edit::Add(Feature::Point(2, 0.5, 0.5)), Edit::SetLabel(2, {1, ""})},
       reason::kDuplicatePoint,
       2,
       0},
      {{Edit::Add(Feature::Point(2, 2, 2)), Edit::SetLabel(3, {1, ""})},
       reason::kOutsideBox,
       2,
       0}};
  for (const Case& c : cases) {
    const absl::Status status = mesh->Apply(c.batch).status();
    const auto detail = GetErrorDetail(status);
    ASSERT_TRUE(detail.has_value()) << status;
    EXPECT_EQ(detail->reason, c.reason) << status;
    EXPECT_EQ(detail->features.front(), c.feature) << status;
    EXPECT_EQ(detail->edit, c.edit) << status;
    EXPECT_EQ(mesh->Validate(c.batch), status);
    EXPECT_EQ(mesh->Features(), before);
    EXPECT_EQ(mesh->revision(), 1u);
  }
  EXPECT_EQ(mesh->Apply({Edit::SetLabel(1, {1, bad})}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_TRUE(mesh->Apply({Edit::SetLabel(1, {1, good})}).ok());
  const Feature bad_feature = Labelled(other, {0, bad});
  EXPECT_EQ(ReasonOf(BuildMesh(std::span(&bad_feature, 1), OptionsOf(2)).status()),
            reason::kBadLabel);
}

TEST(Labels, ARefusedBatchLeavesThemAndATakenBackOneBringsThemBack) {
  const auto mesh = MakeMesh();
  ASSERT_TRUE(mesh->Apply({Edit::Add(Labelled(Feature::Point(1, 0.5, 0.5), {1, "a"})),
                           Edit::Add(Labelled(Feature::Point(2, 0.25, 0.5), {2, "b"}))})
                  .ok());
  const std::vector<Feature> before = mesh->Features();
  const EditBatch batch = {Edit::SetLabel(1, {7, "z"}), Edit::Remove(2),
                           Edit::Add(Labelled(Feature::Point(3, 0.1, 0.5), {3, "c"}))};
  ApplyOptions veto;
  LabelColumn shown;
  veto.commit = [&](const MeshDiff& diff) {
    shown = diff.labels;
    return absl::UnavailableError("no");
  };
  EXPECT_FALSE(mesh->Apply(batch, veto).ok());
  EXPECT_EQ(shown, (LabelColumn{{1, {7, "z"}}, {2, {}}, {3, {3, "c"}}}));
  EXPECT_EQ(mesh->Features(), before);
  ApplyOptions cancel;
  cancel.interrupted = [] { return true; };
  EXPECT_EQ(mesh->Apply(batch, cancel).status().code(), absl::StatusCode::kCancelled);
  EXPECT_EQ(mesh->Features(), before);

  ApplyOptions revocable;
  revocable.revocable = true;
  ASSERT_TRUE(mesh->Apply(batch, revocable).ok());
  const std::vector<Feature> after = mesh->Features();
  ASSERT_TRUE(mesh->Apply({Edit::SetLabel(1, {}), Edit::SetLabel(3, {0, "d"})}, revocable).ok());
  ASSERT_TRUE(mesh->Apply({Edit::SetLabel(1, {5, ""}), Edit::Remove(3)}, revocable).ok());
  mesh->TakeBack(2);
  EXPECT_EQ(mesh->Features(), after);
  mesh->TakeBack(1);
  EXPECT_EQ(mesh->Features(), before);
  EXPECT_EQ(mesh->Snapshot().labels, (LabelColumn{{1, {1, "a"}}, {2, {2, "b"}}}));
}

struct History {
  const char* name;
  Distribution distribution;
  MeshKind kind;
};

class LabelHistory : public ::testing::TestWithParam<History> {};

// What labels should be, by the words of Edit.
using Oracle = std::map<FeatureId, FeatureLabel>;

void ApplyTo(Oracle& oracle, const EditBatch& batch) {
  for (const Edit& edit : batch) {
    const FeatureId id = edit.feature.id;
    const FeatureLabel label = *edit.feature.label;
    switch (edit.action) {
      case Edit::Action::kAdd:
      case Edit::Action::kSet:
        if (!label.empty()) oracle[id] = label;
        break;
      case Edit::Action::kRemove:
        oracle.erase(id);
        break;
      case Edit::Action::kMove:
        break;
      case Edit::Action::kSetLabel:
        label.empty() ? static_cast<void>(oracle.erase(id)) : static_cast<void>(oracle[id] = label);
        break;
    }
  }
}

LabelColumn Rows(const Oracle& oracle) {
  LabelColumn rows;
  for (const auto& [id, label] : oracle) rows.push_back({id, label});
  return rows;
}

// The difference of two oracles.
LabelColumn RowsBetween(const Oracle& from, const Oracle& to) {
  Oracle rows;
  for (const auto& [id, label] : from) {
    if (!to.contains(id)) rows[id] = {};
  }
  for (const auto& [id, label] : to) {
    if (!from.contains(id) || from.at(id) != label) rows[id] = label;
  }
  return Rows(rows);
}

TEST_P(LabelHistory, EqualsAMapAndAMeshWithoutLabels) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("DYNMESH_TEST_SEED=", seed));
  const int dimension = test::DimensionOf(GetParam().distribution);
  const MeshOptions options = OptionsOf(dimension, GetParam().kind);
  const auto mesh = *DynamicMesh::Create(options), bare = *DynamicMesh::Create(options);
  test::ScriptGenerator generator(GetParam().distribution, 40, seed);
  Random random(seed + 1);
  SlotMesh replica = *SlotMesh::FromMesh(mesh->Snapshot());
  Oracle oracle;
  std::size_t told = 0;
  for (int step = 0; step < 60; ++step) {
    SCOPED_TRACE(absl::StrCat("step ", step));
    const std::vector<Feature> present = mesh->Features();
    const EditBatch plain = generator.Next(bare->Features());
    const EditBatch batch = test::WithLabels(plain, present, random);
    if (batch.empty()) continue;
    Oracle next = oracle;
    ApplyTo(next, batch);
    const bool takes_back = random.OneIn(4);
    if (takes_back) {
      ApplyOptions revocable;
      revocable.revocable = true;
      const auto diff = mesh->Apply(batch, revocable);
      if (diff.ok()) {
        ASSERT_EQ(diff->labels, RowsBetween(oracle, next));
        mesh->TakeBack(1);
        mesh->Settle();
      }
      ASSERT_EQ(mesh->Features(), present);
      ASSERT_EQ(mesh->hash(), bare->hash());
      continue;
    }
    const auto diff = mesh->Apply(batch);
    const auto without =
        plain.empty() ? bare->Apply({Edit::SetLabel(present[0].id, {})}) : bare->Apply(plain);
    ASSERT_EQ(diff.ok(), without.ok()) << diff.status() << " " << without.status();
    if (!diff.ok()) continue;
    ASSERT_EQ(diff->labels, RowsBetween(oracle, next));
    told += diff->labels.size();
    oracle = std::move(next);
    // The mesh, its diff and its hash are those without labels.
    ASSERT_EQ(diff->hash, without->hash);
    MeshDiff a = *diff, b = *without;
    Canonicalize(a), Canonicalize(b);
    b.labels = a.labels;
    test::ExpectSameRows(a, b);
    ASSERT_EQ(mesh->Snapshot().labels, Rows(oracle));
    ASSERT_TRUE(replica.Apply(*diff).ok());
    ASSERT_EQ(replica.labels(), Rows(oracle));
    ASSERT_EQ(replica.ToMesh().labels, Rows(oracle));
  }
  EXPECT_GT(told, 20u);
  EXPECT_EQ(mesh->Audit().trace, bare->Audit().trace);
  // History does not matter, nor how the features came.
  const std::vector<Feature> features = mesh->Features();
  for (const Feature& f : features) {
    const auto it = oracle.find(f.id);
    EXPECT_EQ(*f.label, it == oracle.end() ? FeatureLabel() : it->second);
    EXPECT_EQ(replica.FindLabel(f.id), *f.label);
  }
  const auto built = BuildMesh(features, options);
  ASSERT_TRUE(built.ok()) << built.status();
  EXPECT_EQ(built->labels, Rows(oracle));
  EXPECT_EQ(built->hash, mesh->hash());
  const auto again = *DynamicMesh::Create(options);
  ASSERT_TRUE(again->Apply(AddAll(features)).ok());
  EXPECT_EQ(again->Features(), features);
}

INSTANTIATE_TEST_SUITE_P(
    Kinds, LabelHistory,
    ::testing::Values(History{"Plane", Distribution::kPolygons, MeshKind::kDelaunay},
                      History{"Sized", Distribution::kSized, MeshKind::kDelaunay},
                      History{"Space", Distribution::kGridEdges, MeshKind::kDelaunay},
                      History{"Quadtree", Distribution::kSegmentsAxis, MeshKind::kQuadtree},
                      History{"Octree", Distribution::kGridEdges, MeshKind::kQuadtree}),
    [](const auto& history) { return history.param.name; });

}  // namespace
}  // namespace dynmesh::labels_test
