// Edits on the wire: round trips, and what is wrong is named.
#include "proto/codec/edit_codec.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::codec {
namespace {

Edit Labelled(Edit edit, FeatureLabel label) {
  edit.feature.label = std::move(label);
  return edit;
}

TEST(EditCodec, EveryKindOfEditComesBack) {
  const EditBatch batch = {
      Edit::Add(Feature::Point(1, 0.1, -0.0)),
      Edit::Add(Feature::Segment(2, 1, 3)),
      Edit::Set(Feature::Segment(2, 1, 3).Unsplit()),
      Edit::Add(Feature::Polygon(28, {{1, 3, 5}}).Unsplit()),
      Edit::Add(Feature::SizeAt(20, 0.1, 0.2, 0.3)),
      Edit::Set(Feature::SizeDisc(21, 0.1, 0.2, 0.4, 0.3)),
      Edit::Set(Feature::SizeBox(22, 0.1, 0.2, 0.4, 0.5, 0.3)),
      Edit::Add(Feature::Polygon(23, {{1, 3, 5}})),
      Edit::Set(Feature::Polygon(24, {{1, 3, 5, 7}, {2, 4, 6}, {}})),
      Edit::Add(Feature::Polygon(25, {})),
      Edit::Set(Feature::SizePolygon(26, {{1, 3, 5}, {~FeatureId{0}, 1, 1}}, 0.3)),
      Edit::Add(Feature::SizeCapsule(27, {{0.1, -0.0}, {1e-300, 5}, {3, 4}}, 0.2, 0.3)),
      Edit::Set(Feature::SizeCapsule(27, {}, -1, 0.3)),
      Edit::Set(Feature::Point(3, 1e-300, 5)),
      Edit::Remove(4),
      Labelled(Edit::Add(Feature::Point(7, 1, 2)), {-5, "Inlet"}),
      Labelled(Edit::Set(Feature::Segment(8, 1, 2)), {0, "W\xc3\xa4nde"}),
      Labelled(Edit::Add(Feature::Polygon(9, {{1, 2, 3}})),
               {std::numeric_limits<std::int64_t>::min(), ""}),
      Edit::SetLabel(7, {std::numeric_limits<std::int64_t>::max(), "x"}),
      Edit::SetLabel(8, {}),
      Edit::Move(5, 0.25, 0.75),
      Edit::Add(Feature::Point(6, std::numeric_limits<double>::infinity(), 0))};
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  for (const Edit& edit : batch) EncodeEdit(edit, 2, wire.Add());
  EditBatch back;
  ASSERT_TRUE(DecodeEdits(wire, 2, &back).ok());
  EXPECT_EQ(back, batch);
}

TEST(EditCodec, OnlySegmentsAndPolygonsAreUnsplit) {
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  EncodeEdit(Edit::Add(Feature::Point(1, 0, 0).Unsplit()), 2, wire.Add());
  EXPECT_FALSE(wire[0].add().unsplit());
  wire.Mutable(0)->mutable_add()->set_unsplit(true);
  EditBatch back;
  const auto error = GetServiceError(DecodeEdits(wire, 2, &back));
  ASSERT_TRUE(error.has_value());
  EXPECT_EQ(error->reason, dynmesh::reason::kWrongKind);
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
      Edit::Set(Feature::SizePolygon(26, {{1, 3, 5}}, 0.3)),
      Edit::Add(Feature::SizeCapsule(27, {{1, 2, 3}, {4, 5, -0.0}}, 0.2, 0.3))};
  google::protobuf::RepeatedPtrField<v1::Edit> wire;
  for (const Edit& edit : batch) EncodeEdit(edit, 3, wire.Add());
  EditBatch back;
  ASSERT_TRUE(DecodeEdits(wire, 3, &back).ok());
  EXPECT_EQ(back, batch);
  // Every position needs its z, both corners of a box too.
  for (const int i : {0, 1, 2, 5, 6, 7, 9}) {
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

TEST(EditCodec, LabelsWeighByTheirNames) {
  const Edit edit = Labelled(Edit::Add(Feature::Point(1, 0.5, 0.5)), {1, std::string(120, 'n')});
  google::protobuf::RepeatedPtrField<v1::Edit> edits;
  google::protobuf::RepeatedPtrField<v1::Feature> features;
  EncodeEdit(edit, 2, edits.Add());
  EncodeEdit(Edit::SetLabel(1, *edit.feature.label), 2, edits.Add());
  EncodeFeature(edit.feature, 2, features.Add());
  EXPECT_EQ(Weight(edits), 2u + 5);
  EXPECT_EQ(Weight(features), 1u + 2);
  EXPECT_EQ(Weight(EditBatch{edit, Edit::SetLabel(1, *edit.feature.label)}), 2u + 5);
}

TEST(EditCodec, CapsulesWeighByTheirVertices) {
  const Feature f = Feature::SizeCapsule(1, Path(80, {0.5, 0.5}), 0.1, 0.1);
  google::protobuf::RepeatedPtrField<v1::Edit> edits;
  google::protobuf::RepeatedPtrField<v1::Feature> features;
  EncodeEdit(Edit::Add(f), 2, edits.Add());
  EncodeFeature(f, 2, features.Add());
  EXPECT_EQ(Weight(edits), 1u + 30);
  EXPECT_EQ(Weight(features), 1u + 30);
  EXPECT_EQ(Weight(EditBatch{Edit::Set(f)}), 1u + 30);
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

}  // namespace
}  // namespace dynmesh::codec
