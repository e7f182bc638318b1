// Meshes and diffs on the wire: whole in fragments below 1 MB; all else is refused.
#include "proto/codec/mesh_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "core/mesh_data/regions.h"
#include "tests/support/same_diff.h"

namespace dynmesh::codec {
namespace {

VertexColumns RandomVertices(std::mt19937_64& random, std::size_t n, int dimension) {
  VertexColumns v;
  for (std::size_t i = 0; i < n; ++i) {
    v.ids.push_back(random() | 1);
    for (int k = 0; k < dimension; ++k) v.coordinates.push_back(static_cast<double>(random()));
    v.containing_dimensions.push_back(static_cast<std::uint8_t>(random() % 4));
    v.owners.push_back(i % 3 == 0 ? kBoxFeature : random() % 5);
  }
  return v;
}

SimplexColumn RandomIds(std::mt19937_64& random, std::size_t n) {
  SimplexColumn ids(n);
  for (auto& id : ids) id = random();
  return ids;
}

SubsegmentColumns RandomSubsegments(std::mt19937_64& random, std::size_t n) {
  SubsegmentColumns s;
  s.ends = RandomIds(random, 2 * n);
  s.owners = RandomIds(random, n);
  return s;
}

SubfacetColumns RandomSubfacets(std::mt19937_64& random, std::size_t n) {
  SubfacetColumns s;
  s.corners = RandomIds(random, 3 * n);
  s.owners = RandomIds(random, n);
  return s;
}

const std::vector<std::vector<FeatureId>> kPolygons = {{}, {5}, {5, 6}, {5, 6, 7}, {1, 8, 9, 10}};

// Mostly in none, so that some messages have no regions.
RegionColumn RandomRegions(std::mt19937_64& random, std::size_t n) {
  RegionColumn regions;
  for (std::size_t i = 0; i < n; ++i) {
    regions.push_back(RegionIdOf(kPolygons[random() % 3 == 0 ? random() % kPolygons.size() : 0]));
  }
  if (n > 0) regions.back() = RegionIdOf(kPolygons[4]);  // not a column that says nothing
  return regions;
}

std::vector<RegionSet> SetsOf(std::initializer_list<const RegionColumn*> columns) {
  std::vector<RegionSet> sets;
  for (const auto& p : kPolygons) {
    if (p.size() > 1) sets.push_back({RegionIdOf(p), p});
  }
  mesh_data::KeepNamed(sets, columns);
  return sets;
}

// Some rows say nothing, if they may; whole messages have no marker or no name.
LabelColumn RandomLabels(std::mt19937_64& random, std::size_t n, bool all_named) {
  LabelColumn labels;
  for (std::size_t i = 0; i < n; ++i) {
    LabelOfFeature row;
    row.id = 10 * i + 1 + random() % 10;
    if (i % 100 < 50) row.label.marker = static_cast<std::int64_t>(random());
    if (all_named || i % 70 < 30) row.label.name = std::string(1 + random() % 255, 'n');
    labels.push_back(row);
  }
  return labels;
}

MeshDiff RandomDiff(std::uint64_t seed, std::size_t n, int dimension) {
  std::mt19937_64 random(seed);
  const auto corners = static_cast<std::size_t>(dimension) + 1;
  MeshDiff d;
  d.dimension = dimension;
  d.from_revision = 41;
  d.to_revision = 42;
  d.removed_vertices = RandomIds(random, n / 2);
  d.removed_simplices = RandomIds(random, corners * n);
  d.removed_subsegments = RandomSubsegments(random, n / 5);
  d.added_vertices = RandomVertices(random, n, dimension);
  d.added_simplices = RandomIds(random, corners * 2 * n);
  d.added_subsegments = RandomSubsegments(random, n / 3);
  if (seed % 2 == 0) {
    d.removed_regions = RandomRegions(random, n);
    d.added_regions = RandomRegions(random, 2 * n);
    d.region_sets = SetsOf({&d.removed_regions, &d.added_regions});
  }
  if (dimension == 3) {
    d.removed_subfacets = RandomSubfacets(random, n / 2);
    d.added_subfacets = RandomSubfacets(random, n);
  }
  d.labels = RandomLabels(random, n, seed % 3 == 0);
  d.work = {1, 2, 3, 4.5, 1.5, 0.25};
  d.hash = {random(), random()};
  return d;
}

void ExpectEqual(const MeshDiff& a, const MeshDiff& b) {
  EXPECT_EQ(a.dimension, b.dimension);
  EXPECT_EQ(a.from_revision, b.from_revision);
  EXPECT_EQ(a.to_revision, b.to_revision);
  test::ExpectSameRows(a, b);
  EXPECT_EQ(a.work.executed, b.work.executed);
  EXPECT_EQ(a.work.microseconds, b.work.microseconds);
  EXPECT_EQ(a.work.validate_microseconds, b.work.validate_microseconds);
  EXPECT_EQ(a.work.diff_microseconds, b.work.diff_microseconds);
  EXPECT_EQ(a.hash, b.hash);
}

struct Fragments {
  std::vector<v1::MeshDiff> fragments;
  std::size_t largest = 0;
};

Fragments Cut(const MeshDiff& diff, std::size_t bytes) {
  Fragments cut;
  DiffFragmenter fragmenter(std::make_shared<MeshDiff>(diff), false, bytes);
  v1::MeshDiff fragment;
  while (fragmenter.Next(&fragment)) {
    cut.largest = std::max(cut.largest, fragment.ByteSizeLong());
    cut.fragments.push_back(fragment);
  }
  return cut;
}

TEST(DiffCodec, ComesBackWholeWhateverTheFragmentSize) {
  for (int dimension : {2, 3}) {
    for (std::size_t n : {0, 1, 2, 3, 100, 101}) {
      const MeshDiff diff = RandomDiff(n + 1, n, dimension);
      for (std::size_t bytes : {1, 100, 1000, 1 << 20}) {
        const Fragments cut = Cut(diff, bytes);
        DiffAssembler assembler;
        for (std::size_t i = 0; i < cut.fragments.size(); ++i) {
          const auto back = assembler.Add(cut.fragments[i]);
          ASSERT_TRUE(back.ok());
          ASSERT_EQ(back->has_value(), i + 1 == cut.fragments.size());
          EXPECT_EQ(cut.fragments[i].more(), !back->has_value());
          if (back->has_value()) ExpectEqual(**back, diff);
        }
      }
    }
  }
}

TEST(DiffCodec, LargeDiffsGoInFullMessagesBelowOneMegabyte) {
  for (const std::uint64_t seed : {5, 6}) {
    for (const int dimension : {2, 3}) {
      const Fragments cut = Cut(RandomDiff(seed, 60'000, dimension), kFragmentBytes);
      EXPECT_LT(cut.largest, std::size_t{1'000'000});
      ASSERT_GT(cut.fragments.size(), 4u);
      for (std::size_t i = 0; i + 1 < cut.fragments.size(); ++i) {
        EXPECT_GT(cut.fragments[i].ByteSizeLong(), std::size_t{256'000});
      }
    }
  }
}

// Regions that many polygons overlap in weigh more than the simplices in them.
TEST(DiffCodec, RegionSetsCountWhereMessagesAreCut) {
  MeshDiff diff;
  diff.to_revision = 1;
  constexpr std::size_t kRows = 2000;
  for (std::size_t i = 0; i < kRows; ++i) {
    std::vector<FeatureId> polygons;
    for (std::size_t k = 0; k < 300; ++k) polygons.push_back((FeatureId{1} << 63) + i * 1000 + k);
    diff.added_simplices.insert(diff.added_simplices.end(), {3 * i + 1, 3 * i + 2, 3 * i + 3});
    diff.added_regions.push_back(RegionIdOf(polygons));
    diff.region_sets.push_back({diff.added_regions.back(), polygons});
  }
  std::ranges::sort(diff.region_sets, {}, &RegionSet::id);
  for (const std::size_t budget : {std::size_t{50'000}, kFragmentBytes}) {
    const Fragments cut = Cut(diff, budget);
    EXPECT_LE(cut.largest, budget + 1000);
    EXPECT_LE(cut.fragments.size(), 2 * kRows * 3100 / budget + 1);
    DiffAssembler assembler;
    for (const v1::MeshDiff& fragment : cut.fragments) {
      std::set<RegionId> needed(fragment.added_simplices().regions().begin(),
                                fragment.added_simplices().regions().end());
      EXPECT_EQ(needed.size(), fragment.added_simplices().region_sets_size());
      const auto back = assembler.Add(fragment);
      ASSERT_TRUE(back.ok()) << back.status();
      if (back->has_value()) ExpectEqual(**back, diff);
    }
  }
}

TEST(DiffCodec, MessagesWithoutPolygonsTellOfNoRegions) {
  MeshDiff diff = RandomDiff(6, 50, 2);
  diff.removed_regions.assign(50, kNoRegion);
  for (const v1::MeshDiff& fragment : Cut(diff, 400).fragments) {
    EXPECT_EQ(fragment.removed_simplices().regions_size(), 0);
    EXPECT_EQ(fragment.removed_simplices().region_sets_size(), 0);
  }
}

TEST(DiffCodec, RegionsThatMakeNoSenseAreRefused) {
  const auto refuse = [](auto change) {
    v1::MeshDiff bad = Cut(RandomDiff(6, 10, 2), 1 << 20).fragments.at(0);
    ASSERT_TRUE(DiffAssembler().Add(bad).ok());
    ASSERT_GT(bad.added_simplices().region_sets_size(), 0);
    v1::SimplexColumn& column = *bad.mutable_added_simplices();
    change(column, *column.mutable_region_sets(0));
    EXPECT_EQ(DiffAssembler().Add(bad).status().code(), absl::StatusCode::kDataLoss);
  };
  refuse([](v1::SimplexColumn& s, v1::RegionSet&) { s.add_regions(1); });
  refuse([](v1::SimplexColumn& s, v1::RegionSet&) { s.mutable_regions()->RemoveLast(); });
  refuse([](v1::SimplexColumn&, v1::RegionSet& set) { set.set_id(set.id() + 1); });
  refuse([](v1::SimplexColumn&, v1::RegionSet& set) { set.clear_polygons(); });
  refuse([](v1::SimplexColumn&, v1::RegionSet& set) {
    set.mutable_polygons()->Truncate(1);
    set.set_id(set.polygons(0));
  });
  refuse([](v1::SimplexColumn&, v1::RegionSet& set) {
    set.mutable_polygons()->SwapElements(0, 1);
    set.set_id(RegionIdOf(std::vector<FeatureId>(set.polygons().begin(), set.polygons().end())));
  });
  refuse([](v1::SimplexColumn& s, v1::RegionSet& set) { *s.add_region_sets() = set; });
}

TEST(DiffCodec, LabelsThatMakeNoSenseAreRefused) {
  MeshDiff diff;
  diff.to_revision = 1;
  diff.labels = {{3, {1, "a"}}, {4, {}}, {7, {0, "b"}}};
  const v1::MeshDiff good = Cut(diff, 1 << 20).fragments.at(0);
  const auto back = DiffAssembler().Add(good);
  ASSERT_TRUE(back.ok() && back->has_value()) << back.status();
  EXPECT_EQ((*back)->labels, diff.labels);
  const auto refuse = [&](auto change) {
    v1::MeshDiff bad = good;
    change(*bad.mutable_labels());
    EXPECT_EQ(DiffAssembler().Add(bad).status().code(), absl::StatusCode::kDataLoss);
  };
  refuse([](v1::LabelColumns& l) { l.add_features(9); });
  refuse([](v1::LabelColumns& l) { l.add_markers(9); });
  refuse([](v1::LabelColumns& l) { l.mutable_names()->RemoveLast(); });
  refuse([](v1::LabelColumns& l) { l.mutable_features()->SwapElements(0, 1); });
  refuse([](v1::LabelColumns& l) { l.set_features(1, 3); });
  refuse([](v1::LabelColumns& l) { l.set_features(0, 0); });
  // Fragments in the wrong order.
  const auto fragments = Cut(diff, 1).fragments;
  ASSERT_EQ(fragments.size(), 3u);
  DiffAssembler assembler;
  ASSERT_TRUE(assembler.Add(fragments[1]).ok());
  ASSERT_TRUE(assembler.Add(fragments[0]).ok());
  EXPECT_FALSE(assembler.Add(fragments[2]).ok());
}

TEST(DiffCodec, MessagesWithoutMarkersOrNamesTellOfNone) {
  MeshDiff diff;
  diff.to_revision = 1;
  diff.labels = {{3, {1, ""}}, {4, {-1, ""}}};
  EXPECT_EQ(Cut(diff, 1 << 20).fragments.at(0).labels().names_size(), 0);
  diff.labels = {{3, {0, "a"}}, {4, {}}};
  EXPECT_EQ(Cut(diff, 1 << 20).fragments.at(0).labels().markers_size(), 0);
  diff.labels = {};
  EXPECT_FALSE(Cut(diff, 1 << 20).fragments.at(0).has_labels());
}

TEST(DiffCodec, WithoutColumnsThereIsOneSmallMessage) {
  DiffFragmenter fragmenter(std::make_shared<MeshDiff>(RandomDiff(6, 1000, 2)), true);
  v1::MeshDiff fragment;
  ASSERT_TRUE(fragmenter.Next(&fragment));
  EXPECT_TRUE(fragment.columns_omitted());
  EXPECT_LT(fragment.ByteSizeLong(), 200u);
  EXPECT_FALSE(fragmenter.Next(&fragment));
}

TEST(DiffCodec, FragmentsThatDoNotFitAreRefused) {
  const auto fragments = Cut(RandomDiff(7, 100, 3), 1000).fragments;
  ASSERT_GT(fragments.size(), 2u);
  const auto refuse = [&](auto change) {
    DiffAssembler assembler;
    ASSERT_TRUE(assembler.Add(fragments[0]).ok());
    v1::MeshDiff bad = fragments[1];
    change(bad);
    EXPECT_EQ(assembler.Add(bad).status().code(), absl::StatusCode::kDataLoss);
    EXPECT_TRUE(assembler.empty());
  };
  refuse([](v1::MeshDiff& d) { d.set_to_revision(43); });
  refuse([](v1::MeshDiff& d) { d.set_dimension(2); });
  refuse([](v1::MeshDiff& d) { d.mutable_added_vertices()->add_ids(1); });
  refuse([](v1::MeshDiff& d) { d.mutable_added_simplices()->add_vertex_ids(1); });
  refuse([](v1::MeshDiff& d) { d.mutable_removed_subsegments()->add_ends(1); });
  refuse([](v1::MeshDiff& d) { d.mutable_removed_subfacets()->add_corners(1); });
  refuse([](v1::MeshDiff& d) { d.mutable_added_subfacets()->add_owners(1); });
  refuse([](v1::MeshDiff& d) {
    d.set_more(false);
    d.set_hash("nonsense");
  });
  DiffAssembler assembler;
  v1::MeshDiff bad = fragments[0];
  bad.set_dimension(-1);
  EXPECT_FALSE(assembler.Add(bad).ok());
}

TEST(SnapshotCodec, ComesBackWholeAndALostChunkIsNoticed) {
  for (const int dimension : {2, 3}) {
    const auto corners = static_cast<std::size_t>(dimension) + 1;
    std::mt19937_64 random(8);
    auto mesh = std::make_shared<Mesh>();
    mesh->dimension = dimension;
    mesh->revision = 9;
    mesh->vertices = RandomVertices(random, 500, dimension);
    mesh->simplices = RandomIds(random, corners * 900);
    mesh->regions = RandomRegions(random, 900);
    mesh->region_sets = SetsOf({&mesh->regions});
    mesh->subsegments = RandomSubsegments(random, 50);
    if (dimension == 3) mesh->subfacets = RandomSubfacets(random, 70);
    mesh->labels = RandomLabels(random, 90, true);
    mesh->hash = {random(), random()};
    std::vector<v1::SnapshotChunk> chunks;
    SnapshotFragmenter fragmenter(mesh, 5000);
    v1::SnapshotChunk chunk;
    while (fragmenter.Next(&chunk)) chunks.push_back(chunk);
    ASSERT_GT(chunks.size(), 4u);
    EXPECT_EQ(chunks[0].vertex_count(), 500u);
    EXPECT_EQ(chunks[0].simplex_count(), 900u);
    EXPECT_EQ(chunks[0].subfacet_count(), mesh->subfacets.size());

    SnapshotAssembler assembler;
    for (const auto& c : chunks) {
      const auto back = assembler.Add(c);
      ASSERT_TRUE(back.ok());
      if (!back->has_value()) continue;
      EXPECT_EQ((*back)->vertices, mesh->vertices);
      EXPECT_EQ((*back)->simplices, mesh->simplices);
      EXPECT_EQ((*back)->regions, mesh->regions);
      EXPECT_EQ((*back)->region_sets, mesh->region_sets);
      EXPECT_EQ((*back)->dimension, dimension);
      EXPECT_EQ((*back)->subsegments, mesh->subsegments);
      EXPECT_EQ((*back)->subfacets, mesh->subfacets);
      EXPECT_EQ((*back)->labels, mesh->labels);
      EXPECT_EQ((*back)->hash, mesh->hash);
      EXPECT_EQ((*back)->revision, 9u);
    }
    EXPECT_TRUE(assembler.empty());
    ASSERT_TRUE(assembler.Add(chunks[0]).ok());
    EXPECT_EQ(assembler.Add(chunks[2]).status().code(), absl::StatusCode::kDataLoss);
    EXPECT_EQ(assembler.Add(chunks[1]).status().code(), absl::StatusCode::kDataLoss);
  }
}

TEST(SnapshotCodec, LabelsThatMakeNoSenseAreRefused) {
  auto mesh = std::make_shared<Mesh>();
  mesh->labels = {{3, {1, "a"}}, {7, {0, "b"}}};
  v1::SnapshotChunk good;
  ASSERT_TRUE(SnapshotFragmenter(mesh).Next(&good));
  ASSERT_TRUE(SnapshotAssembler().Add(good).ok());
  for (const bool empty : {false, true}) {
    v1::SnapshotChunk bad = good;
    empty ? bad.mutable_labels()->set_markers(0, 0) : bad.mutable_labels()->set_features(0, 7);
    if (empty) bad.mutable_labels()->set_names(0, "");
    EXPECT_EQ(SnapshotAssembler().Add(bad).status().code(), absl::StatusCode::kDataLoss);
  }
}

TEST(SnapshotCodec, SubfacetsThatMakeNoSenseAreRefused) {
  auto mesh = std::make_shared<Mesh>();
  mesh->dimension = 3;
  std::mt19937_64 random(9);
  mesh->subfacets = RandomSubfacets(random, 5);
  v1::SnapshotChunk chunk;
  ASSERT_TRUE(SnapshotFragmenter(mesh).Next(&chunk));
  ASSERT_TRUE(SnapshotAssembler().Add(chunk).ok());
  chunk.mutable_subfacets()->mutable_corners()->RemoveLast();
  EXPECT_EQ(SnapshotAssembler().Add(chunk).status().code(), absl::StatusCode::kDataLoss);
}

}  // namespace
}  // namespace dynmesh::codec
