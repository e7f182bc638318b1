// A quadtree as DynamicMesh: what its vertices say, what it accepts, what it refuses.
#include "core/dynamic_mesh/live_quadtree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "dynmesh/quadtree.h"

namespace dynmesh::live_quadtree_test {
namespace {

MeshOptions Quadtree(int dimension = 2) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.kind = MeshKind::kQuadtree;
  return options;
}

std::vector<QuadtreeCell> CellsOf(const VertexColumns& vertices, const MeshOptions& options) {
  std::vector<QuadtreeCell> cells;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto cell = QuadtreeCellAt(
        options, &vertices.coordinates[i * static_cast<std::size_t>(options.dimension)]);
    EXPECT_TRUE(cell.has_value());
    if (cell.has_value()) cells.push_back(*cell);
  }
  return cells;
}

TEST(LiveQuadtree, BeginsWithItsRoot) {
  for (const int dimension : {2, 3}) {
    const MeshOptions options = Quadtree(dimension);
    const auto tree = *DynamicMesh::Create(options);
    const Mesh mesh = tree->Snapshot();
    ASSERT_EQ(mesh.vertices.size(), 1u);
    const auto cells = CellsOf(mesh.vertices, options);
    EXPECT_EQ(cells[0].level, 0);
    EXPECT_EQ(cells[0].box, DomainBox(options));
    EXPECT_EQ(cells[0].side, 2);
    EXPECT_EQ(tree->Stats().vertices, 1u);
  }
}

TEST(LiveQuadtree, ItsVerticesAreLeavesThatCoverTheRoot) {
  for (const int dimension : {2, 3}) {
    MeshOptions options = Quadtree(dimension);
    options.box = {{-3, 10, 1000}, {4, 12, 1001}};
    const auto tree = *DynamicMesh::Create(options);
    const auto diff = tree->Apply({Edit::Add(Feature::Point(1, -2.5, 10.25, 1000.5)),
                                   Edit::Add(Feature::Point(2, 3.5, 11, 1000.25)),
                                   Edit::Add(Feature::Point(3, 3.5, 11.001, 1000.25))},
                                  {});
    ASSERT_TRUE(diff.ok()) << diff.status();
    const auto cells = CellsOf(tree->Snapshot().vertices, options);
    EXPECT_EQ(cells.size(), tree->Stats().vertices);
    double measure = 0, finest = INFINITY;
    for (const QuadtreeCell& cell : cells) {
      measure += std::pow(cell.side, dimension);
      finest = std::min(finest, cell.side);
    }
    const Box root = DomainBox(options);
    EXPECT_DOUBLE_EQ(measure, std::pow(root.hi[0] - root.lo[0], dimension));
    // The leaf at point 2 follows its distance from point 3.
    const double at[] = {3.5, 11, 1000.25};
    const auto id = tree->Locate({at, static_cast<std::size_t>(dimension)});
    ASSERT_EQ(id.size(), static_cast<std::size_t>(dimension) + 1);
    EXPECT_TRUE(std::all_of(id.begin() + 1, id.end(), [](VertexId i) { return i == 0; }));
    const VertexColumns vertices = tree->Snapshot().vertices;
    const auto row = std::find(vertices.ids.begin(), vertices.ids.end(), id[0]);
    ASSERT_NE(row, vertices.ids.end());
    const QuadtreeCell leaf = cells[static_cast<std::size_t>(row - vertices.ids.begin())];
    for (int k = 0; k < dimension; ++k) {
      EXPECT_TRUE(leaf.box.lo[k] <= at[k] && at[k] <= leaf.box.hi[k]);
    }
    const FeatureSizeBounds bounds = FeatureSizeIn(leaf, dimension);
    EXPECT_LE(bounds.least, 0.001);
    EXPECT_GE(bounds.greatest, 0.001);
    EXPECT_EQ(leaf.side, finest);
  }
}

TEST(LiveQuadtree, OtherPositionsAreNoCentres) {
  const MeshOptions options = Quadtree();  // its root is (0, 0) to (2, 2)
  for (const auto& [x, y] : {std::pair(0.0, 1.0),
                             {1.0, 0.5},
                             {2.0, 1.0},
                             {-0.5, 1.0},
                             {0.1, 0.1},
                             {NAN, 1.0},
                             {0.5, 0.25}}) {
    const double centre[] = {x, y};
    EXPECT_FALSE(QuadtreeCellAt(options, centre).has_value()) << x << " " << y;
  }
  const double centre[] = {0.25, 1.75};
  const auto cell = QuadtreeCellAt(options, centre);
  ASSERT_TRUE(cell.has_value());
  EXPECT_EQ(cell->level, 2);
  EXPECT_EQ(cell->at, (std::array<std::uint64_t, 3>{0, 3, 0}));
}

TEST(LiveQuadtree, LocatesNothingOutsideTheRoot) {
  const auto tree = *DynamicMesh::Create(Quadtree());
  const std::vector<double> points = {-0.001, 1, 1, 1, 2, 2, 2.001, 0};
  const SimplexColumn ids = tree->Locate(points);
  EXPECT_EQ(ids[0], 0u);
  EXPECT_NE(ids[3], 0u);
  EXPECT_EQ(ids[6], ids[3]);
  EXPECT_EQ(ids[9], 0u);
}

TEST(LiveQuadtree, FeaturesMayMeetAtAnyAngle) {
  const auto tree = *DynamicMesh::Create(Quadtree(3));
  const EditBatch batch = {
      Edit::Add(Feature::Point(1, 0, 0, 0)),       Edit::Add(Feature::Point(2, 1, 0, 0)),
      Edit::Add(Feature::Point(3, 1, 0.01, 0)),    Edit::Add(Feature::Point(4, 1, 0.01, 5e-6)),
      Edit::Add(Feature::Segment(5, 1, 2)),        Edit::Add(Feature::Segment(6, 1, 3)),
      Edit::Add(Feature::Polygon(7, {{1, 2, 3}})), Edit::Add(Feature::Polygon(8, {{1, 2, 4}}))};
  EXPECT_TRUE(tree->Apply(batch, {}).ok());
  MeshOptions delaunay = Quadtree(3);
  delaunay.kind = MeshKind::kDelaunay;
  const auto refused = (*DynamicMesh::Create(delaunay))->Apply(batch, {});
  EXPECT_EQ(GetErrorDetail(refused.status())->reason, reason::kSmallAngle);
}

TEST(LiveQuadtree, SizingFeaturesAreRefused) {
  const auto tree = *DynamicMesh::Create(Quadtree());
  const auto diff = tree->Apply({Edit::Add(Feature::SizeAt(7, 0.5, 0.5, 0.1))}, {});
  ASSERT_FALSE(diff.ok());
  EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kBadSize);
  EXPECT_NE(diff.status().message().find("feature 7"), std::string::npos);
}

TEST(LiveQuadtree, OptionsOfDelaunayMeshesAreRefused) {
  const auto expect = [](const char* field, auto change) {
    MeshOptions options = Quadtree(3);
    change(options);
    const auto tree = DynamicMesh::Create(options);
    ASSERT_FALSE(tree.ok()) << field;
    EXPECT_EQ(GetErrorDetail(tree.status())->reason, reason::kBadOption);
    EXPECT_EQ(tree.status().message().substr(0, std::string(field).size()), field);
    EXPECT_FALSE(BuildMesh({}, options).ok());
  };
  expect("quality", [](MeshOptions& o) { o.quality = 3; });
  expect("criterion", [](MeshOptions& o) { o.criterion = Criterion::kThesis; });
  expect("max_edge", [](MeshOptions& o) { o.max_edge = 0.1; });
  expect("min_dihedral", [](MeshOptions& o) { o.min_dihedral = 10; });
  expect("kind", [](MeshOptions& o) { o.kind = static_cast<MeshKind>(7); });
  expect("limits.max_vertices", [](MeshOptions& o) { o.limits.max_vertices = 0; });
}

// Exactly as many leaves as allowed, by any way.
TEST(LiveQuadtree, MaxVerticesLimitsItsLeaves) {
  const EditBatch near = {Edit::Add(Feature::Point(1, 0.1, 0.1)),
                          Edit::Add(Feature::Point(2, 0.1001, 0.1))};
  const EditBatch elsewhere = {Edit::Add(Feature::Point(3, 0.9, 0.9)),
                               Edit::Add(Feature::Point(4, 0.9001, 0.9))};
  MeshOptions options = Quadtree();
  EditBatch both = near;
  both.insert(both.end(), elsewhere.begin(), elsewhere.end());
  const auto free = *DynamicMesh::Create(options);
  ASSERT_TRUE(free->Apply(both, {}).ok());
  options.limits.max_vertices = free->Stats().vertices;
  EXPECT_TRUE((*DynamicMesh::Create(options))->Apply(both, {}).ok());
  --options.limits.max_vertices;
  const auto tree = *DynamicMesh::Create(options);
  for (const EditBatch& batch : {both, near, elsewhere}) {
    const MeshHash before = tree->hash();
    const auto diff = tree->Apply(batch, {});
    EXPECT_EQ(diff.ok(), batch == near);
    if (diff.ok()) continue;
    EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kVertexLimit);
    EXPECT_EQ(tree->hash(), before);
  }
  // In one batch: the present leaves go, others come.
  EditBatch exchange = elsewhere;
  exchange.push_back(Edit::Remove(1));
  exchange.push_back(Edit::Remove(2));
  EXPECT_TRUE(tree->Apply(exchange, {}).ok());
  EXPECT_EQ(tree->Audit().problems, std::vector<std::string>());
}

// Only 4,096 different ids: the batch that would make two equal ones is undone.
TEST(LiveQuadtree, EqualIdsAreRefused) {
  LiveQuadtree<2> tree(Quadtree(), [](const double* c, int d, std::uint64_t salt) -> VertexId {
    return VertexIdAt(c, d, salt) % 4096 + 1;
  });
  int applied = 0, refused = 0;
  for (int i = 0; i < 60; ++i) {
    const MeshHash before = tree.hash();
    const auto diff =
        tree.Apply({Edit::Add(Feature::Point(static_cast<FeatureId>(i + 1), std::fmod(0.618 * i, 1),
                                             std::fmod(0.414 * i, 1)))},
                   {});
    ++(diff.ok() ? applied : refused);
    if (diff.ok()) continue;
    EXPECT_EQ(GetErrorDetail(diff.status())->reason, reason::kIdCollision);
    EXPECT_EQ(tree.hash(), before);
    EXPECT_EQ(tree.Audit().problems, std::vector<std::string>());
  }
  EXPECT_GT(applied, 2);
  EXPECT_GT(refused, 2);
}

TEST(LiveQuadtree, ProgressAndMemoryAreReported) {
  const auto tree = *DynamicMesh::Create(Quadtree());
  EditBatch batch;
  for (int i = 0; i < 2000; ++i) {
    batch.push_back(Edit::Add(Feature::Point(
        static_cast<FeatureId>(i + 1), std::fmod(0.6180339 * i, 1), std::fmod(0.4142135 * i, 1))));
  }
  std::vector<ApplyProgress> reports;
  ApplyOptions apply;
  apply.progress = [&](const ApplyProgress& p) { reports.push_back(p); };
  ASSERT_TRUE(tree->Apply(batch, apply).ok());
  ASSERT_GE(reports.size(), 6u);
  EXPECT_EQ(reports.back().stage, ApplyProgress::Stage::kDiff);
  EXPECT_EQ(reports.back().done, reports.back().total);
  const MeshStats full = tree->Stats();
  EXPECT_GT(full.operations, 2000u);
  EditBatch removal;
  for (int i = 0; i < 2000; ++i) removal.push_back(Edit::Remove(static_cast<FeatureId>(i + 1)));
  ASSERT_TRUE(tree->Apply(removal, {}).ok());
  const MeshStats empty = tree->Stats();
  EXPECT_EQ(empty.vertices, 1u);
  EXPECT_LT(empty.trace_bytes + empty.mesh_bytes, (full.trace_bytes + full.mesh_bytes) / 3);
}

}  // namespace
}  // namespace dynmesh::live_quadtree_test
