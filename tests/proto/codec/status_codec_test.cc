// Errors on the wire: details of google.rpc, within the bounds of headers.
#include "proto/codec/status_codec.h"

#include <gtest/gtest.h>

#include <string>

#include "dynmesh/error.h"
#include "dynmesh/v1/status_details.pb.h"
#include "proto/codec/grpc_status.h"

namespace dynmesh::codec {
namespace {

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
