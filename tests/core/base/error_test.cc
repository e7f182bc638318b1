#include "dynmesh/error.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/string_view.h"

namespace dynmesh {
namespace {

TEST(Error, CarriesCodeMessageAndDetail) {
  const ErrorDetail detail{reason::kSegmentsCross, {12, kBoxFeature, 1}, 7};
  const absl::Status status =
      MakeError(absl::StatusCode::kFailedPrecondition, "segment 12 crosses", detail);
  EXPECT_EQ(status.code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(status.message(), "segment 12 crosses");
  EXPECT_EQ(GetErrorDetail(status), detail);
}

TEST(Error, KeepsDetailWithoutEditAndWithoutFeatures) {
  for (const ErrorDetail& detail : {ErrorDetail{reason::kBadOption, {}, std::nullopt},
                                    ErrorDetail{"X", {}, 0}, ErrorDetail{"", {5}, std::nullopt}}) {
    EXPECT_EQ(GetErrorDetail(MakeError(absl::StatusCode::kInternal, "m", detail)), detail);
  }
}

TEST(Error, DetailSurvivesACopyOfTheStatus) {
  const ErrorDetail detail{reason::kTooClose, {3, 4}, 1};
  absl::Status copy;
  {
    const absl::Status status = MakeError(absl::StatusCode::kFailedPrecondition, "m", detail);
    copy = status;
  }
  EXPECT_EQ(GetErrorDetail(copy), detail);
}

TEST(Error, StatusesMadeElsewhereHaveNoDetail) {
  EXPECT_EQ(GetErrorDetail(absl::OkStatus()), std::nullopt);
  EXPECT_EQ(GetErrorDetail(absl::NotFoundError("nothing here")), std::nullopt);
}

TEST(Error, ADamagedPayloadIsNoDetail) {
  for (const char* payload : {"", "A", "A\n1", "A\nx\n1", "A\n1\n1 y", "A\n1\n2\n3", "A\n-1\n"}) {
    absl::Status status = MakeError(absl::StatusCode::kInternal, "m", {"A", {}, 1});
    status.ForEachPayload([&](absl::string_view url, const absl::Cord&) {
      status.SetPayload(std::string(url), absl::Cord(payload));
    });
    EXPECT_EQ(GetErrorDetail(status), std::nullopt) << payload;
  }
}

TEST(Error, IsNeverOk) { EXPECT_FALSE(MakeError(absl::StatusCode::kOk, "m", {"A", {}, 1}).ok()); }

}  // namespace
}  // namespace dynmesh
