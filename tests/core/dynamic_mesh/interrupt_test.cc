// Work polls for cancellation all the time, not only between operations: a number of times per row,
// feature and point. Wherever it is cancelled, the state is restored.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "core/base/steps.h"
#include "core/mesh_data/diff_meshes.h"
#include "core/plc/plc.h"
#include "tests/differential/differential.h"
#include "tests/support/same_diff.h"

namespace dynmesh::test::interrupt_test {
namespace {

LiveMeshTuning AlwaysRebuild() {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = 0;
  tuning.rebuild.features = -1;
  return tuning;
}

TEST(Steps, AreNeverMoreThanAFewBetweenTwoQuestions) {
  std::size_t since = 0, asked = 0;
  const auto stop = [&] {
    since = 0;
    return ++asked == 50;
  };
  Steps steps(stop);
  for (std::size_t i = 0; !steps.Stop(1 + i % 7); ++i) {
    since += 1 + i % 7;
    ASSERT_LE(since, Steps::kBetween);
  }
  EXPECT_EQ(asked, 50u);
  EXPECT_TRUE(steps.stopped());
  EXPECT_TRUE(steps.Stop());
  EXPECT_EQ(asked, 50u);  // no more
}

TEST(Interrupt, ADifferenceIsAskedAboutAllAlong) {
  const std::vector<Feature> few = MakeFeatures(Distribution::kUniform, 3'000, 1),
                             many = MakeFeatures(Distribution::kUniform, 6'000, 2);
  const Mesh from = *BuildMesh(few, {}), to = *BuildMesh(many, {});
  std::size_t asked = 0;
  const auto count = [&] { return ++asked == 0; };
  Steps counting(count);
  const MeshDiff diff = mesh_data::DiffMeshes(from, to, counting);
  // Vertices are looked up, simplices sorted and merged.
  const std::size_t rows =
      from.vertices.size() + to.vertices.size() + 2 * (from.simplex_count() + to.simplex_count());
  EXPECT_GE(asked, rows / Steps::kBetween);
  MeshDiff plain = mesh_data::DiffMeshes(from, to), same = diff;
  Canonicalize(plain);
  Canonicalize(same);
  ExpectSameRows(plain, same);
  for (std::size_t stop = 1; stop <= asked; ++stop) {
    std::size_t left = stop;
    const auto at = [&] { return --left == 0; };
    Steps steps(at);
    mesh_data::DiffMeshes(from, to, steps);
    EXPECT_TRUE(steps.stopped());
    EXPECT_EQ(left, 0u);
  }
}

template <int D>
void ExpectABuildToBeAskedAllAlong(const std::vector<Feature>& before,
                                   const std::vector<Feature>& features) {
  LiveMesh<D> mesh(DefaultsIn<D>(), AlwaysRebuild());
  ASSERT_TRUE(mesh.Apply(AddAll(before), ApplyOptions()).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  const EditBatch batch = AddAll(features);

  // Polls of operations, and others.
  LiveMesh<D> other(DefaultsIn<D>(), AlwaysRebuild());
  ASSERT_TRUE(other.Apply(AddAll(before), ApplyOptions()).ok());
  std::size_t all = 0;
  const auto diff = other.Apply(batch, {.interrupted = [&] { return ++all == 0; }});
  ASSERT_TRUE(diff.ok()) << diff.status();
  const MeshStats stats = other.Stats();
  const std::size_t rows = 2 * features.size() + 2 * stats.vertices + 2 * stats.simplices;
  EXPECT_GE(all, diff->work.executed + rows / Steps::kBetween);

  // Before the operations, and after.
  std::vector<std::size_t> stops;
  for (std::size_t i = 1; i <= 30; ++i) stops.push_back(i);
  for (std::size_t i = 0; i < 60; ++i) stops.push_back(all - i);
  for (const std::size_t stop : stops) {
    std::size_t asked = 0;
    const auto stopped = mesh.Apply(batch, {.interrupted = [&] { return ++asked == stop; }});
    ASSERT_TRUE(absl::IsCancelled(stopped.status())) << stop << " of " << all;
    EXPECT_EQ(mesh.hash(), hash);
    EXPECT_EQ(mesh.revision(), 1u);
    EXPECT_EQ(mesh.Features().size(), before.size());
  }
  EXPECT_EQ(mesh.Audit().trace, trace);
  EXPECT_EQ(mesh.Audit().problems, std::vector<std::string>());
  const auto again = mesh.Apply(batch, ApplyOptions());
  ASSERT_TRUE(again.ok()) << again.status();
  EXPECT_EQ(again->hash, diff->hash);
}

std::vector<Feature> WithIdsFrom(FeatureId first, std::vector<Feature> features) {
  for (Feature& f : features) {
    f.id += first;
    for (FeatureId& end : f.ends) end += end == kNoFeature ? 0 : first;
    for (auto& ring : f.rings) {
      for (FeatureId& id : ring) id += first;
    }
  }
  return features;
}

TEST(Interrupt, ABuildIsAskedAboutAllAlong) {
  const auto later = [](std::vector<Feature> features) {
    return WithIdsFrom(1'000'000, std::move(features));
  };
  ExpectABuildToBeAskedAllAlong<2>({Feature::Point(1, 0.501, 0.502)},
                                   later(MakeFeatures(Distribution::kUniform, 5'000, 3)));
  ExpectABuildToBeAskedAllAlong<3>({Feature::Point(1, 0.501, 0.502, 0.503)},
                                   later(MakeFeatures(Distribution::kSpaceUniform, 2'500, 3)));
}

// About half of the features go, and come back.
template <int D>
void ExpectAPropagationToBeAskedAllAlong(const std::vector<Feature>& features) {
  EditBatch go, come;
  std::set<FeatureId> needed;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) continue;
    if (f.id % 2 == 0) {
      go.push_back(Edit::Remove(f.id));
    } else {
      for (const FeatureId end : f.ends) needed.insert(end);
      for (const auto& ring : f.rings) needed.insert(ring.begin(), ring.end());
    }
  }
  for (const Feature& f : features) {
    const bool goes = f.kind != FeatureKind::kPoint ? f.id % 2 == 0 : !needed.contains(f.id);
    if (goes && f.kind == FeatureKind::kPoint) go.push_back(Edit::Remove(f.id));
    if (goes) come.push_back(Edit::Add(f));
  }
  plc::Plc<D> plc(DefaultsIn<D>());
  plc.Apply(*plc.Check(AddAll(features)));
  LiveMesh<D> mesh(DefaultsIn<D>(), AlwaysPropagate());
  ASSERT_TRUE(mesh.Apply(AddAll(features), ApplyOptions()).ok());
  for (const EditBatch& batch : {go, come}) {
    const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
    std::size_t by_validation = 0;
    const auto delta = plc.Check(batch, nullptr, [&](std::size_t) { return ++by_validation == 0; });
    ASSERT_TRUE(delta.ok()) << delta.status();
    constexpr std::size_t kMostAtOnce = 256;
    const std::size_t parts = (delta->size() + kMostAtOnce - 1) / kMostAtOnce;
    ASSERT_GE(parts, 2u);
    // The last time before the first operation.
    for (std::size_t part = 0; part <= parts; ++part) {
      std::size_t left = by_validation + 1 + part;
      const auto stopped = mesh.Apply(batch, {.interrupted = [&] { return --left == 0; }});
      ASSERT_TRUE(absl::IsCancelled(stopped.status())) << part << " of " << parts;
      EXPECT_EQ(mesh.hash(), hash);
      const AuditReport audit = mesh.Audit();
      EXPECT_EQ(audit.problems, std::vector<std::string>());
      EXPECT_EQ(audit.trace, trace) << part << " of " << parts;
    }
    ASSERT_TRUE(mesh.Apply(batch, ApplyOptions()).ok());
    plc.Apply(*delta);
    const Difference d = CompareWithScratch(mesh, true);
    EXPECT_FALSE(d.found) << d.what;
  }
}

TEST(Interrupt, APropagationIsAskedWhileTheChangeIsHandedOver) {
  ExpectAPropagationToBeAskedAllAlong<2>(MakeFeatures(Distribution::kUniform, 700, 5));
  ExpectAPropagationToBeAskedAllAlong<2>(MakeFeatures(Distribution::kWedges, 800, 5));
  ExpectAPropagationToBeAskedAllAlong<2>(MakeFeatures(Distribution::kPolygons, 1'000, 5));
  ExpectAPropagationToBeAskedAllAlong<3>(MakeFeatures(Distribution::kTurnedGridEdges, 600, 5));
}

// Points alone are processed together, not one by one.
TEST(Interrupt, ValidationOfAFirstLoadIsAskedAllAlong) {
  const plc::Plc2 plc{MeshOptions()};
  const EditBatch load = AddAll(MakeFeatures(Distribution::kUniform, 20'000, 4));
  std::size_t asked = 0;
  ASSERT_TRUE(plc.Check(load, nullptr, [&](std::size_t) { return ++asked == 0; }).ok());
  // As edits, as changes, for their cell, their order and their distances.
  EXPECT_GE(asked, 5 * load.size() / Steps::kBetween);
  for (std::size_t stop = 1; stop <= asked; ++stop) {
    std::size_t left = stop;
    const auto stopped = plc.Check(load, nullptr, [&](std::size_t) { return --left == 0; });
    EXPECT_TRUE(absl::IsCancelled(stopped.status())) << stop << " of " << asked;
    EXPECT_EQ(left, 0u);
  }
}

TEST(Interrupt, ValidationIsAskedBeforeItsFirstFeature) {
  plc::Plc2 plc{MeshOptions()};
  const std::vector<Feature> present = MakeFeatures(Distribution::kUniform, 20'000, 4);
  plc.Apply(*plc.Check(AddAll(present)));
  EditBatch most;
  for (std::size_t i = 0; i < present.size() / 2; ++i) {
    most.push_back(Edit::Remove(present[i].id));
  }
  most.push_back(Edit::Add(Feature::Point(1'000'000, 0.51, 0.49)));
  std::size_t early = 0;
  ASSERT_TRUE(plc.Check(most, nullptr,
                        [&](std::size_t waiting) {
                          early += waiting == plc::kNotKnown;
                          return false;
                        })
                  .ok());
  // The edits, what they change, and an index of what stays.
  EXPECT_GE(early, 2 * most.size() / Steps::kBetween + present.size() / Steps::kBetween);
  for (std::size_t stop = 1; stop <= early; stop += 3) {
    std::size_t asked = 0;
    const auto stopped = plc.Check(most, nullptr, [&](std::size_t) { return ++asked == stop; });
    EXPECT_TRUE(absl::IsCancelled(stopped.status()));
    EXPECT_EQ(asked, stop);
  }
}

}  // namespace
}  // namespace dynmesh::test::interrupt_test
