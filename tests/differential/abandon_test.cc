// A propagation that is stopped, at whatever operation, leaves the former trace and
// mesh, bit for bit.
#include <gtest/gtest.h>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"

namespace dynmesh::test {
namespace {

class Abandon : public testing::TestWithParam<Distribution> {};

TEST_P(Abandon, AtEveryOperationBringsTheFormerTraceBack) {
  const std::uint64_t seed = 4;
  MeshOptions options;
  PlanarMesh mesh(options, AlwaysPropagate());
  ScriptGenerator generator(GetParam(), 10, seed);
  int tried = 0;
  for (int revision = 0; revision < 5;) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty() || !mesh.Validate(batch).ok()) continue;
    const MeshHash hash = mesh.hash();
    const MeshHash trace = mesh.Audit().trace;
    const std::uint64_t at = mesh.revision();
    for (int stop = 0;; ++stop) {
      int asked = 0;
      const auto diff = mesh.Apply(batch, [&] { return asked++ == stop; });
      if (diff.ok()) break;
      ++tried;
      ASSERT_EQ(diff.status().code(), absl::StatusCode::kCancelled) << "seed " << seed;
      ASSERT_EQ(GetErrorDetail(diff.status())->reason, reason::kCancelled);
      ASSERT_EQ(mesh.revision(), at);
      ASSERT_EQ(mesh.hash(), hash) << "seed " << seed << " stop " << stop;
      const AuditReport audit = mesh.Audit();
      ASSERT_TRUE(audit.problems.empty()) << audit.problems.front();
      ASSERT_EQ(audit.trace, trace) << "seed " << seed << " stop " << stop;
    }
    ++revision;
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
  }
  EXPECT_GT(tried, 50);
}

INSTANTIATE_TEST_SUITE_P(All, Abandon, testing::ValuesIn(kAllDistributions),
                         [](const auto& given) { return NameOf(given.param); });

TEST(Limit, OfVerticesRefusesTheBatchAndChangesNothing) {
  MeshOptions options;
  options.limits.max_vertices = 120;
  for (const bool rebuild : {false, true}) {
    PlanarMesh mesh(options, rebuild ? PlanarMeshTuning{} : AlwaysPropagate());
    ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(1, 0.5, 0.5))}, ApplyOptions{}).ok());
    const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
    EditBatch many;
    for (const Feature& f : MakeFeatures(Distribution::kUniform, 300, 1)) {
      many.push_back(Edit::Add(Feature::Point(f.id + 10, f.position[0], f.position[1])));
    }
    const auto diff = mesh.Apply(many, ApplyOptions{});
    ASSERT_EQ(diff.status().code(), absl::StatusCode::kResourceExhausted);
    EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kVertexLimit);
    EXPECT_EQ(mesh.hash(), hash);
    EXPECT_EQ(mesh.Audit().trace, trace);
    EXPECT_EQ(mesh.revision(), 1u);
    EXPECT_EQ(mesh.Features().size(), 1u);
    EXPECT_TRUE(mesh.Apply({Edit::Remove(1)}, ApplyOptions{}).ok());
  }
  std::vector<Feature> many = MakeFeatures(Distribution::kUniform, 300, 1);
  EXPECT_EQ(BuildMesh(many, options).status().code(), absl::StatusCode::kResourceExhausted);
}

TEST(Limit, OfDepthRefusesTheBatchAndChangesNothing) {
  MeshOptions options;
  options.limits.max_depth = 3;
  PlanarMesh mesh(options, AlwaysPropagate());
  const EditBatch segment = {Edit::Add(Feature::Point(1, 0.1, 0.5)),
                             Edit::Add(Feature::Point(2, 0.9, 0.5)),
                             Edit::Add(Feature::Segment(3, 1, 2))};
  ASSERT_TRUE(mesh.Apply(segment, ApplyOptions{}).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  // A point so near the segment asks for more halvings than three.
  const auto diff = mesh.Apply({Edit::Add(Feature::Point(4, 0.3, 0.501))}, ApplyOptions{});
  ASSERT_EQ(diff.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kDepthLimit);
  EXPECT_EQ(mesh.hash(), hash);
  EXPECT_EQ(mesh.Audit().trace, trace);
}

}  // namespace
}  // namespace dynmesh::test
