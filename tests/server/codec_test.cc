// The codec: round trips, in pieces below 1 MB; all else is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <set>
#include <vector>

#include "core/mesh_data/regions.h"
#include "dynmesh/error.h"
#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"
#include "tests/server/test_support.h"
#include "tests/support/same_diff.h"

namespace dynmesh::codec {
namespace {

using server::ReasonOf;

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

struct Pieces {
  std::vector<v1::MeshDiff> fragments;
  std::size_t largest = 0;
};

Pieces Cut(const MeshDiff& diff, std::size_t bytes) {
  Pieces pieces;
  DiffFragmenter fragmenter(std::make_shared<MeshDiff>(diff), false, bytes);
  v1::MeshDiff fragment;
  while (fragmenter.Next(&fragment)) {
    pieces.largest = std::max(pieces.largest, fragment.ByteSizeLong());
    pieces.fragments.push_back(fragment);
  }
  return pieces;
}

TEST(DiffCodec, ComesBackWholeWhateverTheFragmentSize) {
  for (int dimension : {2, 3}) {
    for (std::size_t n : {0, 1, 2, 3, 100, 101}) {
      const MeshDiff diff = RandomDiff(n + 1, n, dimension);
      for (std::size_t bytes : {1, 100, 1000, 1 << 20}) {
        const Pieces pieces = Cut(diff, bytes);
        DiffAssembler assembler;
        for (std::size_t i = 0; i < pieces.fragments.size(); ++i) {
          const auto back = assembler.Add(pieces.fragments[i]);
          ASSERT_TRUE(back.ok());
          ASSERT_EQ(back->has_value(), i + 1 == pieces.fragments.size());
          EXPECT_EQ(pieces.fragments[i].more(), !back->has_value());
          if (back->has_value()) ExpectEqual(**back, diff);
        }
      }
    }
  }
}

TEST(DiffCodec, LargeDiffsGoInFullMessagesBelowOneMegabyte) {
  for (const std::uint64_t seed : {5, 6}) {
    for (const int dimension : {2, 3}) {
      const Pieces pieces = Cut(RandomDiff(seed, 60'000, dimension), kFragmentBytes);
      EXPECT_LT(pieces.largest, std::size_t{1'000'000});
      ASSERT_GT(pieces.fragments.size(), 4u);
      for (std::size_t i = 0; i + 1 < pieces.fragments.size(); ++i) {
        EXPECT_GT(pieces.fragments[i].ByteSizeLong(), std::size_t{256'000});
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
    const Pieces pieces = Cut(diff, budget);
    EXPECT_LE(pieces.largest, budget + 1000);
    EXPECT_LE(pieces.fragments.size(), 2 * kRows * 3100 / budget + 1);
    DiffAssembler assembler;
    for (const v1::MeshDiff& fragment : pieces.fragments) {
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
      EXPECT_EQ((*back)->hash, mesh->hash);
      EXPECT_EQ((*back)->revision, 9u);
    }
    EXPECT_TRUE(assembler.empty());
    ASSERT_TRUE(assembler.Add(chunks[0]).ok());
    EXPECT_EQ(assembler.Add(chunks[2]).status().code(), absl::StatusCode::kDataLoss);
    EXPECT_EQ(assembler.Add(chunks[1]).status().code(), absl::StatusCode::kDataLoss);
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

TEST(EditCodec, EveryKindOfEditComesBack) {
  const EditBatch batch = {
      Edit::Add(Feature::Point(1, 0.1, -0.0)),
      Edit::Add(Feature::Segment(2, 1, 3)),
      Edit::Add(Feature::SizeAt(20, 0.1, 0.2, 0.3)),
      Edit::Set(Feature::SizeDisc(21, 0.1, 0.2, 0.4, 0.3)),
      Edit::Set(Feature::SizeBox(22, 0.1, 0.2, 0.4, 0.5, 0.3)),
      Edit::Add(Feature::Polygon(23, {{1, 3, 5}})),
      Edit::Set(Feature::Polygon(24, {{1, 3, 5, 7}, {2, 4, 6}, {}})),
      Edit::Add(Feature::Polygon(25, {})),
      Edit::Set(Feature::SizePolygon(26, {{1, 3, 5}, {~FeatureId{0}, 1, 1}}, 0.3)),
      Edit::Set(Feature::Point(3, 1e-300, 5)),
      Edit::Remove(4),
      Edit::Move(5, 0.25, 0.75),
      Edit::Add(Feature::Point(6, std::numeric_limits<double>::infinity(), 0))};
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  for (const Edit& edit : batch) EncodeEdit(edit, 2, wire.Add());
  EditBatch back;
  ASSERT_TRUE(DecodeEdits(wire, 2, &back).ok());
  EXPECT_EQ(back, batch);
}

TEST(EditCodec, EveryKindOfEditOfSpaceComesBackWithItsZ) {
  const EditBatch batch = {
      Edit::Add(Feature::Point(1, 0.1, 0.2, -0.0)),
      Edit::Set(Feature::Point(3, 1, 2, 1e-300)),
      Edit::Move(5, 0.25, 0.75, 0.125),
      Edit::Add(Feature::Segment(2, 1, 3)),
      Edit::Add(Feature::Polygon(23, {{1, 3, 5}, {2, 4, 6}})),
      Edit::Add(Feature::Size(20, {1, 2, 3}, {SizeShape::kPoint, 0.3, 0, {}})),
      Edit::Add(Feature::Size(21, {1, 2, 3}, {SizeShape::kDisc, 0.3, 0.4, {}})),
      Edit::Set(Feature::Size(22, {1, 2, 3}, {SizeShape::kBox, 0.3, 0, {4, 5, 6}})),
      Edit::Set(Feature::SizePolygon(26, {{1, 3, 5}}, 0.3))};
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  for (const Edit& edit : batch) EncodeEdit(edit, 3, wire.Add());
  EditBatch back;
  ASSERT_TRUE(DecodeEdits(wire, 3, &back).ok());
  EXPECT_EQ(back, batch);
  // Every position needs its z, both corners of a box too.
  for (const int i : {0, 1, 2, 5, 6, 7}) {
    google::protobuf::RepeatedPtrField<v1::Edit> flat;
    EncodeEdit(batch[static_cast<std::size_t>(i)], 2, flat.Add());
    back.clear();
    const absl::Status status = DecodeEdits(flat, 3, &back);
    ASSERT_TRUE(GetServiceError(status).has_value()) << i;
    EXPECT_EQ(GetServiceError(status)->reason, reason::kWrongDimension) << i;
  }
  v1::Edit* const box = wire.Mutable(7);
  box->mutable_set()->mutable_size()->mutable_box()->mutable_hi()->clear_z();
  back.clear();
  EXPECT_FALSE(DecodeEdits(wire, 3, &back).ok());
}

TEST(EditCodec, PolygonsWeighByTheirPointsAndRings) {
  const Rings rings = {std::vector<FeatureId>(69, 1), std::vector<FeatureId>(5, 2)};
  google::protobuf::RepeatedPtrField<v1::Edit> edits;
  google::protobuf::RepeatedPtrField<v1::Feature> features;
  EXPECT_EQ(Weight(edits) + Weight(features), 0u);
  for (const Feature& f : {Feature::Point(1, 0, 0), Feature::Polygon(2, rings),
                           Feature::SizePolygon(3, rings, 1), Feature::SizeAt(4, 0, 0, 1)}) {
    EncodeEdit(Edit::Add(f), 2, edits.Add());
    EncodeEdit(Edit::Set(f), 2, edits.Add());
    EncodeFeature(f, 2, features.Add());
  }
  EncodeEdit(Edit::Remove(4), 2, edits.Add());
  EXPECT_EQ(Weight(edits), 9u + 4 * 10);
  EXPECT_EQ(Weight(features), 4u + 2 * 10);
  // Two bytes on the wire, and more than twenty once it is read.
  for (int i = 0; i < 800; ++i) features.Mutable(1)->mutable_polygon()->add_rings();
  EXPECT_EQ(Weight(features), 4u + 2 * 10 + 300);
}

TEST(EditCodec, WhatTheWireFormGetsWrongIsNamed) {
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  EncodeEdit(Edit::Remove(4), 2, wire.Add());
  v1::Edit* edit = wire.Add();
  EditBatch out;
  const auto check = [&](const char* expected_reason, const std::string& features) {
    out.clear();
    const absl::Status status = DecodeEdits(wire, 2, &out);
    EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument);
    const auto error = GetServiceError(status);
    ASSERT_TRUE(error.has_value());
    EXPECT_EQ(error->reason, expected_reason);
    EXPECT_EQ(error->field, "edits[1]");
    EXPECT_EQ(error->metadata.at("edit"), "1");
    if (!features.empty()) {
      EXPECT_EQ(error->metadata.at("features"), features);
    }
  };
  check(reason::kBadRequest, "");
  edit->mutable_add()->set_id(17);
  check(dynmesh::reason::kWrongKind, "17");
  edit->mutable_add()->mutable_point()->set_z(1);
  check(reason::kWrongDimension, "17");
  edit->mutable_move()->set_id(18);
  edit->mutable_move()->mutable_to()->set_z(0);
  check(reason::kWrongDimension, "18");
}

TEST(OptionsCodec, ZerosAreDefaultsAndLimitsHold) {
  v1::MeshOptions proto;
  EXPECT_EQ(GetServiceError(DecodeOptions(proto, 100).status())->field, "options.box");
  proto.mutable_box()->mutable_lo();
  proto.mutable_box()->mutable_hi()->set_x(2);
  proto.mutable_box()->mutable_hi()->set_y(1);
  auto options = DecodeOptions(proto, 100);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->quality, kDefaultQuality2D);
  EXPECT_EQ(options->limits.max_vertices, 100u);
  v1::MeshOptions back;
  EncodeOptions(*options, &back);
  EXPECT_EQ(*DecodeOptions(back, 100), *options);
  proto.set_max_vertices(101);
  EXPECT_EQ(GetServiceError(DecodeOptions(proto, 100).status())->field, "options.max_vertices");
  proto.set_max_vertices(0);
  constexpr std::uint64_t kAny = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(DecodeOptions(proto, kAny)->limits.max_vertices, MostVertices(2));
  EXPECT_EQ(DecodeOptions(proto, kAny - 1)->limits.max_vertices, MostVertices(2));
  proto.set_max_vertices(kAny - 1);  // in a journal, perhaps, but not of a client
  EXPECT_EQ(DecodeOptions(proto, kAny)->limits.max_vertices, MostVertices(2));
  EXPECT_EQ(DecodeOptions(proto, kAny - 1).status().code(), absl::StatusCode::kInvalidArgument);
  proto.set_max_vertices(0);
  proto.set_quality(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(DecodeOptions(proto, 100).status().code(), absl::StatusCode::kInvalidArgument);
  proto.set_quality(2);
  proto.set_dimension(7);
  EXPECT_EQ(DecodeOptions(proto, 100).status().code(), absl::StatusCode::kInvalidArgument);
}

TEST(OptionsCodec, EveryBadOptionIsNamedByItsPathInTheRequest) {
  v1::MeshOptions good;
  good.mutable_box()->mutable_lo();
  good.mutable_box()->mutable_hi()->set_x(2);
  ASSERT_TRUE(DecodeOptions(good, 100).ok());
  const auto expect = [&](const char* field, const std::function<void(v1::MeshOptions&)>& spoil) {
    v1::MeshOptions bad = good;
    spoil(bad);
    const absl::Status status = DecodeOptions(bad, 100).status();
    const auto error = GetServiceError(status);
    ASSERT_TRUE(error.has_value()) << field << " " << status;
    EXPECT_EQ(error->reason, dynmesh::reason::kBadOption);
    EXPECT_EQ(error->field, field);
    EXPECT_EQ(status.message().find(std::string(field) + ": "), 0u) << status;
    EXPECT_EQ(status.message().find("limits"), absl::string_view::npos) << status;
    const v1::Status wire = StatusToProto(status);
    ASSERT_EQ(wire.details_size(), 2);
    v1::BadRequest request;
    ASSERT_TRUE(request.ParseFromString(wire.details(1).value()));
    EXPECT_EQ(request.field_violations(0).field(), field);
  };
  expect("options.quality", [](auto& o) { o.set_quality(0.5); });
  expect("options.dimension", [](auto& o) { o.set_dimension(4); });
  expect("options.box", [](auto& o) { o.mutable_box()->mutable_hi()->set_y(-1); });
  expect("options.box", [](auto& o) { o.clear_box(); });
  expect("options.max_edge", [](auto& o) { o.set_max_edge(-1); });
  expect("options.min_dihedral", [](auto& o) { o.set_min_dihedral(10); });  // in 2D
  expect("options.min_dihedral", [](auto& o) {
    o.set_dimension(3);
    o.mutable_box()->mutable_lo()->set_z(0);
    o.mutable_box()->mutable_hi()->set_z(1);
    o.set_min_dihedral(21);
  });
  expect("options.max_depth", [](auto& o) { o.set_max_depth(-3); });
  expect("options.max_vertices", [](auto& o) { o.set_max_vertices(3); });
  expect("options.max_vertices", [](auto& o) { o.set_max_vertices(101); });
  expect("options.criterion", [](auto& o) { o.set_criterion(static_cast<v1::Criterion>(7)); });
  expect("options.quality", [](auto& o) {
    o.set_criterion(v1::CRITERION_THESIS);
    o.set_quality(1.2);
  });
}

TEST(OptionsCodec, OfSpaceHaveTheirOwnDefault) {
  v1::MeshOptions proto;
  proto.set_dimension(3);
  proto.mutable_box()->mutable_lo()->set_x(-1);
  proto.mutable_box()->mutable_hi()->set_x(2);
  EXPECT_EQ(GetServiceError(DecodeOptions(proto, 1000).status())->field, "options.box");
  proto.mutable_box()->mutable_lo()->set_z(-2);
  proto.mutable_box()->mutable_hi()->set_z(3);
  const auto options = DecodeOptions(proto, 1000);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->quality, kDefaultQuality3D);
  EXPECT_EQ(options->box, (Box{{-1, 0, -2}, {2, 0, 3}}));
  EXPECT_EQ(options->min_dihedral, kDefaultMinDihedral3D);
  proto.set_min_dihedral(0);
  EXPECT_EQ(DecodeOptions(proto, 1000)->min_dihedral, 0);
  proto.set_min_dihedral(12.5);
  EXPECT_EQ(DecodeOptions(proto, 1000)->min_dihedral, 12.5);
  v1::MeshOptions with_bound;
  EncodeOptions(*DecodeOptions(proto, 1000), &with_bound);
  EXPECT_EQ(DecodeOptions(with_bound, 1000)->min_dihedral, 12.5);
  v1::MeshOptions back;
  EncodeOptions(*options, &back);
  EXPECT_EQ(*DecodeOptions(back, 1000), *options);
  proto.set_quality(1.1);
  EXPECT_FALSE(DecodeOptions(proto, 1000).ok());
  proto.set_quality(1.9);
  EXPECT_TRUE(DecodeOptions(proto, 1000).ok());
  proto.set_criterion(v1::CRITERION_THESIS);
  EXPECT_FALSE(DecodeOptions(proto, 1000).ok());
  EXPECT_FALSE(DecodeOptions(back, 100).ok());  // too few vertices for the bare cube
}

TEST(StatusCodec, ALibraryErrorArrivesAsGoogleRpcDetails) {
  const absl::Status status = MakeError(absl::StatusCode::kFailedPrecondition, "7 crosses 8",
                                        {dynmesh::reason::kSegmentsCross, {7, 8}, 3});
  const grpc::Status wire = ToGrpcStatus(status, "features");
  EXPECT_EQ(wire.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  v1::Status proto;
  ASSERT_TRUE(proto.ParseFromString(wire.error_details()));
  ASSERT_EQ(proto.details_size(), 2);
  EXPECT_EQ(proto.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  EXPECT_EQ(proto.details(1).type_url(), "type.googleapis.com/google.rpc.BadRequest");
  v1::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(proto.details(0).value()));
  EXPECT_EQ(info.domain(), "dynmesh");
  const absl::Status back = FromGrpcStatus(wire);
  EXPECT_EQ(back.code(), status.code());
  EXPECT_EQ(back.message(), status.message());
  const auto error = GetServiceError(back);
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason, dynmesh::reason::kSegmentsCross);
  EXPECT_EQ(error->Features(), (std::vector<FeatureId>{7, 8}));
  EXPECT_EQ(error->field, "features[3]");
}

TEST(StatusCodec, RetryInfoComesBack) {
  ServiceError error;
  error.reason = reason::kQueueFull;
  error.retry_after = absl::Milliseconds(1500);
  const absl::Status status =
      MakeServiceError(absl::StatusCode::kResourceExhausted, "later", error);
  const auto back = GetServiceError(FromGrpcStatus(ToGrpcStatus(status)));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->retry_after, absl::Milliseconds(1500));
}

TEST(StatusCodec, LongErrorsFitIntoHeadersAndStayText) {
  std::vector<FeatureId> many(10'000);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = ~std::uint64_t{0} - i;
  std::string message;
  while (message.size() < 5000) message += "\u00e9\u2026";
  const grpc::Status wire = ToGrpcStatus(
      MakeError(absl::StatusCode::kInvalidArgument, message, {"BAD_ID", many, std::nullopt}));
  EXPECT_LE(wire.error_message().size(), 1024u);
  EXPECT_LE(wire.error_details().size(), 3000u);
  v1::Status proto;  // parsing refuses text that is no UTF-8
  ASSERT_TRUE(proto.ParseFromString(wire.error_details()));
  EXPECT_EQ(GetServiceError(FromGrpcStatus(wire))->Features().size(), 32u);
}

TEST(StatusCodec, AStatusFromElsewhereKeepsCodeAndMessage) {
  const absl::Status plain =
      FromGrpcStatus(grpc::Status(grpc::StatusCode::UNAVAILABLE, "no route", "not a proto \xff"));
  EXPECT_EQ(plain.code(), absl::StatusCode::kUnavailable);
  EXPECT_EQ(plain.message(), "no route");
  EXPECT_FALSE(GetServiceError(plain).has_value());
  v1::Status odd;
  odd.set_code(99);
  EXPECT_EQ(StatusFromProto(odd).code(), absl::StatusCode::kUnknown);
  EXPECT_TRUE(ToGrpcStatus(absl::OkStatus()).ok());
}

}  // namespace
}  // namespace dynmesh::codec
