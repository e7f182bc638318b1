// Options of a mesh on the wire: defaults, limits, and the path of what is wrong.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "dynmesh/error.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/mesh_codec.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::codec {
namespace {

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

TEST(OptionsCodec, AKindBringsItsDefaults) {
  v1::MeshOptions proto;
  proto.set_dimension(3);
  proto.mutable_box()->mutable_lo()->set_z(0);
  proto.mutable_box()->mutable_hi()->set_z(1);
  EXPECT_EQ(DecodeOptions(proto, 10'000)->kind, MeshKind::kDelaunay);
  proto.set_kind(v1::MESH_KIND_QUADTREE);
  const auto options = DecodeOptions(proto, 100);
  ASSERT_TRUE(options.ok()) << options.status();
  EXPECT_EQ(options->kind, MeshKind::kQuadtree);
  EXPECT_EQ(options->min_dihedral, 0);
  v1::MeshOptions back;
  EncodeOptions(*options, &back);
  EXPECT_EQ(*DecodeOptions(back, 100), *options);
  proto.set_dimension(2);
  proto.mutable_box()->mutable_lo()->clear_z();
  proto.mutable_box()->mutable_hi()->clear_z();
  proto.set_kind(v1::MESH_KIND_TRIANGULATION);
  const auto triangulation = DecodeOptions(proto, 100);
  ASSERT_TRUE(triangulation.ok()) << triangulation.status();
  EXPECT_EQ(triangulation->kind, MeshKind::kTriangulation);
  back.Clear();
  EncodeOptions(*triangulation, &back);
  EXPECT_EQ(*DecodeOptions(back, 100), *triangulation);
  proto.set_kind(static_cast<v1::MeshKind>(7));
  EXPECT_EQ(GetServiceError(DecodeOptions(proto, 100).status())->field, "options.kind");
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

}  // namespace
}  // namespace dynmesh::codec
