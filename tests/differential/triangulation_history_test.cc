// Meshes of kind triangulation: after every revision of random scripts the dynamic mesh is what its
// features make from scratch, and has the points and segments of the input and nothing more.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/seed.h"

namespace dynmesh::test::triangulation_history_test {
namespace {

MeshOptions Triangulations() {
  MeshOptions options;
  options.kind = MeshKind::kTriangulation;
  return options;
}

// Scripts without sizing features, which are refused.
class WithoutSizes {
 public:
  explicit WithoutSizes(ScriptGenerator generator) : generator_(std::move(generator)) {}

  EditBatch Next(const std::vector<Feature>& present) {
    EditBatch batch = generator_.Next(present);
    std::erase_if(batch, [](const Edit& edit) { return edit.feature.kind == FeatureKind::kSize; });
    return batch;
  }

 private:
  ScriptGenerator generator_;
};

// Is each point a vertex, each segment and edge of a polygon a subsegment, and nothing else one?
// The border has 24 of both.
std::string JudgeFeatures(const DynamicMesh& mesh) {
  constexpr std::size_t kBorder = 24;
  const Mesh whole = mesh.Snapshot();
  std::map<FeatureId, VertexId> points;
  std::set<std::pair<VertexId, VertexId>> edges, subsegments;
  const std::vector<Feature> features = mesh.Features();
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) points[f.id] = VertexIdAt(f.position.data(), 2);
  }
  const auto add_edge = [&](FeatureId a, FeatureId b) {
    edges.insert(std::minmax(points.at(a), points.at(b)));
  };
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kSegment) add_edge(f.ends[0], f.ends[1]);
    if (f.kind != FeatureKind::kPolygon) continue;
    for (const auto& ring : f.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) add_edge(ring[i], ring[(i + 1) % ring.size()]);
    }
  }
  std::size_t border = 0;
  for (std::size_t i = 0; i < whole.subsegments.size(); ++i) {
    if (whole.subsegments.owners[i] == kBoxFeature) {
      ++border;
    } else {
      subsegments.emplace(whole.subsegments.ends[2 * i], whole.subsegments.ends[2 * i + 1]);
    }
  }
  if (border != kBorder) return "the border has other subsegments";
  if (subsegments != edges) return "subsegments are not the edges of the input";
  if (whole.vertices.size() != points.size() + kBorder) return "vertices are not the points";
  // Euler: the border is a cycle of 24.
  if (whole.simplex_count() != 2 * whole.vertices.size() - 2 - kBorder) {
    return "there are too many triangles, or too few";
  }
  return "";
}

TEST(TriangulationHistory, IsFromScratchAfterEveryRevision) {
  const std::uint64_t seed = NewSeed();
  for (const Distribution distribution : kAllDistributions) {
    for (const auto& [points, revisions] :
         {std::pair{8, 60}, std::pair{40, 30}, std::pair{200, IsNightly() ? 200 : 8}}) {
      for (std::uint64_t k = 0; k < (IsNightly() ? 10u : 1u); ++k) {
        SCOPED_TRACE(NameOf(distribution) + ", points " + std::to_string(points) + ", seed " +
                     std::to_string(seed) + " + " + std::to_string(k));
        RunPlan plan;
        plan.revisions = revisions;
        plan.every_judged = 5;
        plan.judge = JudgeFeatures;
        const RunReport run = RunScriptOf<2>(
            WithoutSizes(ScriptGenerator(distribution, points, seed + k)), Triangulations(), plan);
        if (run.difference.found) {
          FAIL() << run.difference.what << "\nshrunk script:\n"
                 << ToScript(Triangulations(), Shrink(run.script, Triangulations(), plan));
        }
        EXPECT_EQ(run.revisions, revisions) << "too many proposals were refused";
      }
    }
  }
}

TEST(TriangulationHistory, ARefusedBatchAndAnInterruptedOneChangeNothing) {
  const auto mesh = NewMesh(Triangulations());
  ASSERT_TRUE(mesh->Apply(AddAll(MakeFeatures(Distribution::kDiagonals, 60, 3))).ok());
  const MeshHash before = mesh->hash();
  EXPECT_EQ(mesh->Apply({Edit::Add(Feature::SizeDisc(999, 0.5, 0.5, 0.1, 0.01))}).status().code(),
            absl::StatusCode::kInvalidArgument);
  EXPECT_EQ(mesh->Apply({Edit::Add(Feature::Point(998, 0.511, 0.523))},
                        {.interrupted = [] { return true; }})
                .status()
                .code(),
            absl::StatusCode::kCancelled);
  EXPECT_EQ(mesh->hash(), before);
  EXPECT_EQ(mesh->Audit().problems, std::vector<std::string>());
}

TEST(TriangulationHistory, EditsChangeWhatIsNear) {
  const auto mesh = NewMesh(Triangulations());
  Random random(5);
  EditBatch all;
  for (FeatureId id = 1; id <= 20'000; ++id) {
    all.push_back(Edit::Add(Feature::Point(id, random.Unit(), random.Unit())));
  }
  all.push_back(Edit::Add(Feature::Segment(50'000, 1, 2)));  // long
  ASSERT_TRUE(mesh->Apply(all).ok());
  std::size_t changed = 0;
  for (FeatureId id = 100; id < 400; ++id) {
    const auto diff = mesh->Apply({Edit::Remove(id)});
    ASSERT_TRUE(diff.ok()) << diff.status();
    EXPECT_EQ(diff->removed_vertices.size(), 1u);
    changed += diff->removed_simplex_count() + diff->added_simplex_count();
    EXPECT_EQ(diff->work.executed, 0u);
  }
  EXPECT_LT(changed, 300u * 12);
}

}  // namespace
}  // namespace dynmesh::test::triangulation_history_test
