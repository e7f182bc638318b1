// ErrorDetail as the payload of a status: three lines of text,
//   reason
//   index of the edit, or empty
//   feature ids, separated by spaces
// Copies of the status keep it, and it is readable in a log.
#include "dynmesh/error.h"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "absl/strings/string_view.h"

namespace dynmesh {
namespace {

constexpr char kDetailUrl[] = "dynmesh/ErrorDetail";

std::string Encode(const ErrorDetail& detail) {
  const std::string edit = detail.edit ? absl::StrCat(*detail.edit) : "";
  return absl::StrCat(detail.reason, "\n", edit, "\n", absl::StrJoin(detail.features, " "));
}

std::optional<ErrorDetail> Decode(const std::string& text) {
  const std::vector<absl::string_view> lines = absl::StrSplit(text, '\n');
  if (lines.size() != 3) return std::nullopt;
  ErrorDetail detail;
  detail.reason = std::string(lines[0]);
  if (!lines[1].empty()) {
    std::uint64_t edit = 0;
    if (!absl::SimpleAtoi(lines[1], &edit)) return std::nullopt;
    detail.edit = static_cast<std::size_t>(edit);
  }
  for (const absl::string_view word : absl::StrSplit(lines[2], ' ', absl::SkipEmpty())) {
    FeatureId id = kNoFeature;
    if (!absl::SimpleAtoi(word, &id)) return std::nullopt;
    detail.features.push_back(id);
  }
  return detail;
}

}  // namespace

absl::Status MakeError(absl::StatusCode code, std::string message, ErrorDetail detail) {
  // An OK status cannot carry a payload and would hide the error.
  if (code == absl::StatusCode::kOk) code = absl::StatusCode::kInternal;
  absl::Status status(code, message);
  status.SetPayload(kDetailUrl, absl::Cord(Encode(detail)));
  return status;
}

std::optional<ErrorDetail> GetErrorDetail(const absl::Status& status) {
  const auto payload = status.GetPayload(kDetailUrl);
  if (!payload) return std::nullopt;
  return Decode(std::string(*payload));
}

}  // namespace dynmesh
