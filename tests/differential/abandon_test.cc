// A propagation that is stopped, at any operation, restores the former trace and mesh, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::abandon_test {
namespace {

// Applies `batch`, but stops it again and again, later each time, until it comes to its end.
// Every stop has to leave everything as it was.
template <int D>
int StopAgainAndAgain(LiveMesh<D>& mesh, const EditBatch& batch) {
  const MeshHash hash = mesh.hash();
  const MeshHash trace = mesh.Audit().trace;
  const std::uint64_t at = mesh.revision();
  int tried = 0;
  // In 3D an operation is expensive: not at each of them.
  for (int stop = 0;; stop += D == 2 ? 1 : 1 + stop / 3) {
    int asked = 0;
    const auto diff = mesh.Apply(batch, {.interrupted = [&] { return asked++ == stop; }});
    if (diff.ok()) return tried;
    ++tried;
    const AuditReport audit = mesh.Audit();
    EXPECT_EQ(diff.status().code(), absl::StatusCode::kCancelled);
    EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kCancelled);
    EXPECT_EQ(mesh.revision(), at);
    EXPECT_EQ(mesh.hash(), hash) << "stop " << stop;
    EXPECT_EQ(audit.problems, std::vector<std::string>());
    EXPECT_EQ(audit.trace, trace) << "stop " << stop;
    if (::testing::Test::HasFailure()) return tried;
  }
}

constexpr std::uint64_t kSeed = 4;

// Anchors are decided before the first operation. They depend on the features beside them, so those
// that were decided must be decided again. Stops the batch at the first operations after its
// validation.
template <int D>
void ExpectStopsAmongAnchorsToChangeNothing(const EditBatch& present, const EditBatch& batch) {
  LiveMesh<D> mesh(DefaultsIn<D>(), AlwaysPropagate());
  ASSERT_TRUE(mesh.Apply(present, ApplyOptions{}).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  const auto first = static_cast<int>(batch.size());
  for (int stop = first; stop < first + 40; ++stop) {
    int asked = 0;
    const auto diff = mesh.Apply(batch, {.interrupted = [&] { return asked++ == stop; }});
    ASSERT_TRUE(absl::IsCancelled(diff.status())) << "stop " << stop;
    ASSERT_EQ(mesh.hash(), hash) << "stop " << stop;
    ASSERT_EQ(mesh.Audit().trace, trace) << "stop " << stop;
  }
  ASSERT_TRUE(mesh.Apply(batch, ApplyOptions{}).ok());
  const Difference d = CompareWithScratch(mesh, true);
  EXPECT_FALSE(d.found) << d.what;
}

// `points` points in an area with a target length: half of them, then the others and moves.
template <int D>
void ExpectStopsAmongAnchorsOfPointsToChangeNothing(FeatureId points, double target) {
  const Sizing disc = {SizeShape::kDisc, target, 0.25, {}};
  EditBatch present = {Edit::Add(Feature::Size(1, {0.5, 0.5, 0.5}, disc))}, batch;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> inside(0.35, 0.65);
  const auto add = [&](FeatureId id) {
    return Edit::Add(Feature::Point(id, inside(random), inside(random), inside(random)));
  };
  for (FeatureId i = 0; i < points; ++i) (i % 2 == 0 ? present : batch).push_back(add(10 + i));
  for (FeatureId i = 0; i < points; i += 4) {
    batch.push_back(Edit::Move(10 + i, inside(random), inside(random), inside(random)));
  }
  ExpectStopsAmongAnchorsToChangeNothing<D>(present, batch);
}

template <int D, class Generator>
void ExpectStopsToChangeNothing(Generator generator, int revisions, double min_dihedral = 0) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  MeshOptions options = DefaultsIn<D>();
  options.min_dihedral = min_dihedral;
  LiveMesh<D> mesh(options, AlwaysPropagate());
  int tried = 0;
  for (int revision = 0; revision < revisions;) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty() || !mesh.Validate(batch).ok()) continue;
    tried += StopAgainAndAgain(mesh, batch);
    ASSERT_FALSE(::testing::Test::HasFailure());
    ++revision;
    const Difference d = CompareWithScratch(mesh, true);
    ASSERT_FALSE(d.found) << d.what;
  }
  EXPECT_GT(tried, D == 2 ? 50 : 10 * revisions);
}

class Abandon : public ::testing::TestWithParam<Distribution> {};

TEST_P(Abandon, AtEveryOperationBringsTheFormerTraceBack) {
  if (DimensionOf(GetParam()) == 2) {
    ExpectStopsToChangeNothing<2>(ScriptGenerator(GetParam(), 10, kSeed), 5);
  } else {
    ExpectStopsToChangeNothing<3>(ScriptGenerator(GetParam(), 10, kSeed), 2);
  }
}

class AbandonPolygons : public ::testing::TestWithParam<PolygonKind> {};

TEST_P(AbandonPolygons, AtAnyOperationBringsTheFormerTraceBack) {
  ExpectStopsToChangeNothing<3>(PolygonScript(GetParam(), 2, kSeed), IsNightly() ? 8 : 3);
}

TEST_P(AbandonPolygons, AmongCuresBringsTheFormerTraceBack) {
  ExpectStopsToChangeNothing<3>(PolygonScript(GetParam(), 2, kSeed), IsNightly() ? 8 : 2, 15);
}

TEST(AbandonAnchors, AtAnyOfThemBringsTheFormerTraceBack2D) {
  ExpectStopsAmongAnchorsOfPointsToChangeNothing<2>(480, 0.02);
}
TEST(AbandonAnchors, AtAnyOfThemBringsTheFormerTraceBack3D) {
  ExpectStopsAmongAnchorsOfPointsToChangeNothing<3>(60, 0.06);
}
// A polygon with anchors of its own comes, another one goes.
TEST(AbandonAnchors, AtAnyOfFacetsBringsTheFormerTraceBack) {
  const Sizing disc = {SizeShape::kDisc, 0.05, 0.3, {}};
  EditBatch present = {Edit::Add(Feature::Size(1, {0.5, 0.5, 0.5}, disc))}, batch;
  const auto add = [](FeatureId first, double z, EditBatch& to) {
    for (FeatureId i = 0; i < 4; ++i) {
      to.push_back(Edit::Add(
          Feature::Point(first + i, i == 0 || i == 3 ? 0.25 : 0.75, i < 2 ? 0.25 : 0.75, z)));
    }
    to.push_back(
        Edit::Add(Feature::Polygon(first + 4, {{first, first + 1, first + 2, first + 3}})));
  };
  add(10, 0.375, present);
  add(20, 0.625, batch);
  batch.push_back(Edit::Remove(14));
  ExpectStopsAmongAnchorsToChangeNothing<3>(present, batch);
}

INSTANTIATE_TEST_SUITE_P(All, Abandon, ::testing::ValuesIn(kAllDistributions),
                         [](const auto& given) { return NameOf(given.param); });
INSTANTIATE_TEST_SUITE_P(Space, Abandon, ::testing::ValuesIn(kSpaceDistributions),
                         [](const auto& given) { return NameOf(given.param); });
INSTANTIATE_TEST_SUITE_P(All, AbandonPolygons, ::testing::ValuesIn(kPolygonKinds),
                         [](const auto& given) { return NameOf(given.param); });

template <class Dimension>
class Limit : public ::testing::Test {
 public:
  static constexpr int kDimension = Dimension::value;
};
using Dimensions = ::testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Limit, Dimensions);

TYPED_TEST(Limit, OfVerticesRefusesTheBatchAndChangesNothing) {
  constexpr int D = TestFixture::kDimension;
  MeshOptions options = DefaultsIn<D>();
  options.limits.max_vertices = D == 2 ? 120 : 900;
  const auto given = D == 2 ? Distribution::kUniform : Distribution::kSpaceUniform;
  const std::vector<Feature> features = MakeFeatures(given, 300, 1);
  for (const bool rebuild : {false, true}) {
    LiveMesh<D> mesh(options, rebuild ? LiveMeshTuning{} : AlwaysPropagate());
    ASSERT_TRUE(mesh.Apply({Edit::Add(Feature::Point(1, 0.5, 0.5, 0.5))}, ApplyOptions{}).ok());
    const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
    EditBatch many;
    for (const Feature& f : features) {
      many.push_back(
          Edit::Add(Feature::Point(f.id + 10, f.position[0], f.position[1], f.position[2])));
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
  EXPECT_EQ(BuildMesh(features, options).status().code(), absl::StatusCode::kResourceExhausted);
}

TYPED_TEST(Limit, OfDepthRefusesTheBatchAndChangesNothing) {
  constexpr int D = TestFixture::kDimension;
  MeshOptions options = DefaultsIn<D>();
  options.limits.max_depth = 3;
  LiveMesh<D> mesh(options, AlwaysPropagate());
  const EditBatch segment = {Edit::Add(Feature::Point(1, 0.1, 0.5, 0.5)),
                             Edit::Add(Feature::Point(2, 0.9, 0.5, 0.5)),
                             Edit::Add(Feature::Segment(3, 1, 2))};
  ASSERT_TRUE(mesh.Apply(segment, ApplyOptions{}).ok());
  const MeshHash hash = mesh.hash(), trace = mesh.Audit().trace;
  // A point so near the segment asks for more halvings than three.
  const auto diff = mesh.Apply({Edit::Add(Feature::Point(4, 0.3, 0.501, 0.5))}, ApplyOptions{});
  ASSERT_EQ(diff.status().code(), absl::StatusCode::kResourceExhausted);
  EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kDepthLimit);
  EXPECT_EQ(mesh.hash(), hash);
  EXPECT_EQ(mesh.Audit().trace, trace);
}

// A square around (x, y); its points have the ids from `first` on, in order.
std::vector<Feature> Square(FeatureId first, double x, double y, double half) {
  return {Feature::Point(first, x - half, y - half), Feature::Point(first + 1, x + half, y - half),
          Feature::Point(first + 2, x + half, y + half),
          Feature::Point(first + 3, x - half, y + half)};
}
Feature SquarePolygon(FeatureId id, FeatureId first) {
  return Feature::Polygon(id, {{first, first + 1, first + 2, first + 3}});
}

class PolygonLimit : public ::testing::TestWithParam<bool> {
 protected:
  PolygonLimit() : mesh_({}, GetParam() ? LiveMeshTuning{} : AlwaysPropagate()) {}

  void Accept(const EditBatch& batch) {
    const auto diff = mesh_.Apply(batch, ApplyOptions{});
    ASSERT_TRUE(diff.ok()) << diff.status();
  }
  // Refused for `polygon`, as from scratch, and nothing has changed.
  void Refuse(const EditBatch& batch, FeatureId polygon, std::vector<Feature> result) {
    const std::uint64_t revision = mesh_.revision();
    const MeshHash hash = mesh_.hash(), trace = mesh_.Audit().trace;
    const std::vector<Feature> features = mesh_.Features();
    const absl::Status status = mesh_.Apply(batch, ApplyOptions{}).status();
    ASSERT_EQ(status.code(), absl::StatusCode::kResourceExhausted) << status;
    EXPECT_EQ(*GetErrorDetail(status), (ErrorDetail{reason::kPolygonLimit, {polygon}, {}}));
    EXPECT_EQ(mesh_.revision(), revision);
    EXPECT_EQ(mesh_.hash(), hash);
    EXPECT_EQ(mesh_.Features(), features);
    const AuditReport audit = mesh_.Audit();
    EXPECT_TRUE(audit.problems.empty()) << audit.problems.front();
    EXPECT_EQ(audit.trace, trace);
    EXPECT_EQ(BuildMesh(result, {}).status(), status);
    std::reverse(result.begin(), result.end());
    EXPECT_EQ(BuildMesh(result, {}).status(), status);
  }
  void ExpectLikeScratch() {
    const Difference d = CompareWithScratch(mesh_, true);
    EXPECT_FALSE(d.found) << d.what;
  }

  LiveMesh<2> mesh_;
};

// Polygons 1001, 1002, ... on the same four points.
TEST_P(PolygonLimit, OfOnesThatAreAlikeRefusesTheBatchAndChangesNothing) {
  std::vector<Feature> all = Square(1, 0.5, 0.5, 0.25);
  for (FeatureId i = 0; i < kMostPolygonsAtAPlace; ++i) all.push_back(SquarePolygon(1001 + i, 1));
  Accept(AddAll(all));
  ExpectLikeScratch();
  all.push_back(SquarePolygon(500, 1));
  Refuse({Edit::Add(all.back())}, 1000 + kMostPolygonsAtAPlace, all);
  Accept({Edit::Remove(1500), Edit::Add(all.back())});
  ExpectLikeScratch();
  // Very many at once.
  for (FeatureId i = 0; i < 5000; ++i) all.push_back(SquarePolygon(10'000 + i, 1));
  EditBatch many = {Edit::Add(Feature::Point(600, 0.1, 0.1))};
  for (FeatureId i = 0; i < 5000; ++i) many.push_back(Edit::Add(SquarePolygon(10'000 + i, 1)));
  std::erase_if(all, [](const Feature& f) { return f.id == 1500; });
  all.push_back(Feature::Point(600, 0.1, 0.1));
  Refuse(many, 14'999, all);
  Accept({Edit::Remove(2000), Edit::Add(Feature::Point(600, 0.1, 0.1))});
  ExpectLikeScratch();
}

// Two sets of polygons, each below the limit, that a move puts over each other. This changes labels
// of triangles that it does not rebuild.
TEST_P(PolygonLimit, OfOnesThatMoveOverEachOtherRefusesTheBatchAndChangesNothing) {
  std::vector<Feature> all = Square(1, 0.25, 0.5, 0.0625);
  const std::vector<Feature> other = Square(11, 0.75, 0.5, 0.03125);
  all.insert(all.end(), other.begin(), other.end());
  for (FeatureId i = 0; i < 600; ++i) {
    all.push_back(SquarePolygon(1000 + i, 1));
    all.push_back(SquarePolygon(2000 + i, 11));
  }
  Accept(AddAll(all));
  const auto move = [&](double x, double y) {
    EditBatch batch;
    for (const Feature& f : Square(1, x, y, 0.0625)) {
      batch.push_back(Edit::Move(f.id, f.position[0], f.position[1]));
      all[f.id - 1] = f;
    }
    return batch;
  };
  const EditBatch over = move(0.75, 0.5);
  Refuse(over, 2599, all);
  Accept(move(0.75, 0.75));
  ExpectLikeScratch();
  // Within the holes of the others there is room.
  EditBatch holes = move(0.75, 0.5);
  const std::vector<Feature> hole = Square(21, 0.75, 0.5, 0.015625);
  for (const Feature& f : hole) holes.push_back(Edit::Add(f));
  for (FeatureId i = 0; i < 600; ++i) {
    holes.push_back(Edit::Set(Feature::Polygon(1000 + i, {{1, 2, 3, 4}, {11, 12, 13, 14}})));
  }
  Accept(holes);
  ExpectLikeScratch();
}

// One in the other, 32 at a time, so that there are many labels on the way in.
TEST_P(PolygonLimit, OfOnesInEachOtherRefusesTheBatchAndChangesNothing) {
  constexpr FeatureId kLots = 32, kInALot = kMostPolygonsAtAPlace / kLots;
  std::vector<Feature> all;
  const auto add = [&](FeatureId lot, FeatureId count) {
    const double half = 0.45 * std::pow(0.8, static_cast<double>(lot));
    for (const Feature& f : Square(10'000 + 4 * lot, 0.5, 0.5, half)) all.push_back(f);
    for (FeatureId i = 0; i < count; ++i) {
      all.push_back(SquarePolygon(1 + lot * kInALot + i, 10'000 + 4 * lot));
    }
  };
  for (FeatureId lot = 0; lot < kLots; ++lot) add(lot, kInALot);
  Accept(AddAll(all));
  ExpectLikeScratch();
  const std::size_t before = all.size();
  add(kLots, 2);
  const EditBatch innermost = AddAll(std::span(all).subspan(before));
  Refuse(innermost, 2 + kMostPolygonsAtAPlace, all);
  // The same place, reached from outside.
  Accept({Edit::Remove(1), Edit::Remove(2)});
  Accept(innermost);
  ExpectLikeScratch();
  Refuse({Edit::Add(SquarePolygon(1, 10'000)), Edit::Add(SquarePolygon(2, 10'000))},
         2 + kMostPolygonsAtAPlace, all);
}

INSTANTIATE_TEST_SUITE_P(All, PolygonLimit, ::testing::Bool(), [](const auto& given) {
  return given.param ? "BuiltAnewIfLarge" : "Propagated";
});

}  // namespace
}  // namespace dynmesh::test::abandon_test
