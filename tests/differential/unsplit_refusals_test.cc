// What unsplit segments and polygons refuse (Feature::unsplit): with what error, by which edit, and
// without a trace.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"

namespace dynmesh::test::unsplit_refusals_test {
namespace {

MeshOptions Unit() {
  MeshOptions options = DefaultsIn<2>();
  options.box = {{0, 0, 0}, {1, 1, 0}};
  return options;
}

absl::Status Refusal(const std::vector<Feature>& present, const EditBatch& batch) {
  LiveMesh<2> mesh(Unit(), AlwaysPropagate());
  const auto first = mesh.Apply(AddAll(present), ApplyOptions{});
  EXPECT_TRUE(first.ok()) << first.status();
  const MeshHash hash = mesh.hash();
  const AuditReport before = mesh.Audit();
  const absl::Status status = mesh.Apply(batch, ApplyOptions{}).status();
  if (status.ok()) return status;
  EXPECT_EQ(mesh.hash(), hash);
  EXPECT_EQ(mesh.Audit().trace, before.trace);
  return status;
}

void ExpectEncroached(const absl::Status& status, std::vector<FeatureId> features,
                      const std::string& part) {
  const auto detail = GetErrorDetail(status);
  ASSERT_TRUE(detail.has_value()) << status;
  EXPECT_EQ(detail->reason, reason::kEncroached) << status;
  EXPECT_EQ(detail->features, features) << status;
  EXPECT_NE(status.message().find(part), std::string::npos) << status;
}

std::vector<Feature> OneEdge() {
  return {Feature::Point(1, 0.25, 0.5), Feature::Point(2, 0.75, 0.5),
          Feature::Segment(3, 1, 2).Unsplit()};
}

TEST(UnsplitRefusals, APointInTheCircleNamesTheSpacing) {
  const EditBatch point = {Edit::Add(Feature::Point(4, 0.5, 0.6))};
  ExpectEncroached(Refusal(OneEdge(), point), {4, 3}, "a spacing of at most 0.199");
  // The same whichever comes first.
  std::vector<Feature> present = OneEdge();
  present[2].unsplit = false;
  present.push_back(point[0].feature);
  ExpectEncroached(Refusal(present, {Edit::Set(OneEdge()[2])}), {3, 4}, "a spacing of at most");
  // With that spacing it is accepted.
  std::vector<Feature> fine = {Feature::Point(1, 0.25, 0.5), Feature::Point(2, 0.75, 0.5)};
  for (FeatureId i = 0; i < 3; ++i) {
    if (i < 2) {
      fine.push_back(Feature::Point(10 + i, 0.25 + static_cast<double>(i + 1) / 6, 0.5));
    }
    fine.push_back(Feature::Segment(20 + i, i == 0 ? 1 : 9 + i, i == 2 ? 2 : 10 + i).Unsplit());
  }
  EXPECT_TRUE(Refusal(fine, point).ok());
}

TEST(UnsplitRefusals, OnePointOnTheCircleIsLegalTwoOnBothSidesAreNot) {
  const Feature above = Feature::Point(4, 0.5, 0.75), below = Feature::Point(5, 0.5, 0.25),
                beside = Feature::Point(6, 0.3, 0.65);
  EXPECT_TRUE(Refusal(OneEdge(), {Edit::Add(above)}).ok());
  EXPECT_TRUE(Refusal(OneEdge(), {Edit::Add(above), Edit::Add(beside)}).ok());
  ExpectEncroached(Refusal(OneEdge(), {Edit::Add(above), Edit::Add(below)}), {5, 3}, "circle");
  std::vector<Feature> present = OneEdge();
  present[2].unsplit = false;
  present.push_back(above);
  present.push_back(below);
  ExpectEncroached(Refusal(present, {Edit::Set(OneEdge()[2])}), {3, 4}, "circle");
}

TEST(UnsplitRefusals, SegmentsThatMayBeSplitStayOutside) {
  std::vector<Feature> more = {Feature::Point(4, 0.1, 0.6), Feature::Point(5, 0.9, 0.6),
                               Feature::Segment(6, 4, 5)};
  ExpectEncroached(Refusal(OneEdge(), AddAll(more)), {6, 3}, "mark that unsplit, too");
  more[2].unsplit = true;  // no vertex of either is in the other's circle
  more[0].position = {0.24, 0.8, 0}, more[1].position = {0.76, 0.8, 0};
  EXPECT_TRUE(Refusal(OneEdge(), AddAll(more)).ok());
  more[2].unsplit = false;
  EXPECT_TRUE(Refusal(OneEdge(), AddAll(more)).ok());
}

TEST(UnsplitRefusals, SegmentsLeaveAtARightAngleOrMore) {
  for (const double x : {0.25, 0.1, 0.26}) {
    std::vector<Feature> more = {Feature::Point(4, x, 0.9), Feature::Segment(5, 1, 4)};
    const absl::Status status = Refusal(OneEdge(), AddAll(more));
    if (x <= 0.25) {
      EXPECT_TRUE(status.ok()) << status;
      continue;
    }
    ExpectEncroached(status, {5, 3}, "mark segment 5 unsplit, too");
    more[1].unsplit = true;
    more[0].position[1] = 0.8;  // out of each other's circles
    EXPECT_TRUE(Refusal(OneEdge(), AddAll(more)).ok());
  }
}

TEST(UnsplitRefusals, PolygonsMarkTheEdgesThatTheyShare) {
  std::vector<Feature> present = {Feature::Point(1, 0.2, 0.2), Feature::Point(2, 0.8, 0.2),
                                  Feature::Point(3, 0.8, 0.8), Feature::Point(4, 0.2, 0.8),
                                  Feature::Segment(5, 1, 2)};
  LiveMesh<2> mesh(Unit(), AlwaysPropagate());
  ASSERT_TRUE(mesh.Apply(AddAll(present), ApplyOptions{}).ok());
  const MeshHash before = mesh.hash();
  const Feature polygon = Feature::Polygon(6, {{1, 2, 3, 4}});
  ASSERT_TRUE(mesh.Apply({Edit::Add(polygon.Unsplit())}, ApplyOptions{}).ok());
  EXPECT_EQ(CompareWithScratch(mesh, true).what, "");
  ExpectEncroached(mesh.Apply({Edit::Add(Feature::Point(9, 0.5, 0.25))}, ApplyOptions{}).status(),
                   {9, 5}, "spacing");
  ExpectEncroached(mesh.Apply({Edit::Add(Feature::Point(9, 0.75, 0.5))}, ApplyOptions{}).status(),
                   {9, 6}, "spacing");
  ASSERT_TRUE(mesh.Apply({Edit::Set(polygon)}, ApplyOptions{}).ok());
  EXPECT_TRUE(mesh.Apply({Edit::Add(Feature::Point(9, 0.5, 0.25))}, ApplyOptions{}).ok());
  EXPECT_EQ(CompareWithScratch(mesh, true).what, "");
  ASSERT_TRUE(mesh.Apply({Edit::Remove(9), Edit::Remove(6)}, ApplyOptions{}).ok());
  EXPECT_EQ(mesh.hash(), before);
}

TEST(UnsplitRefusals, OnlyPlanarMeshesByEdgesOfTheDynamicMesherHaveIt) {
  const std::vector<Feature> edge = OneEdge();
  MeshOptions options = DefaultsIn<3>();
  const auto reason_of = [&](const MeshOptions& with, BuildEngine engine) {
    BuildOptions build;
    build.engine = engine;
    const auto mesh = BuildMesh(edge, with, build);
    const auto detail = GetErrorDetail(mesh.status());
    return detail ? detail->reason : "";
  };
  EXPECT_EQ(reason_of(options, BuildEngine::kDynamic), reason::kBadUnsplit);
  options = Unit();
  options.kind = MeshKind::kQuadtree;
  EXPECT_EQ(reason_of(options, BuildEngine::kDynamic), reason::kBadUnsplit);
  options = Unit();
  options.criterion = Criterion::kThesis;
  EXPECT_EQ(reason_of(options, BuildEngine::kDynamic), reason::kBadUnsplit);
  EXPECT_EQ(reason_of(Unit(), BuildEngine::kSvr), reason::kBadOption);
}

}  // namespace
}  // namespace dynmesh::test::unsplit_refusals_test
