#include "proto/codec/status_codec.h"

#include <algorithm>
#include <utility>

#include "absl/strings/cord.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "dynmesh/error.h"
#include "dynmesh/v1/status_details.pb.h"

namespace dynmesh::codec {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr char kBadRequestUrl[] = "type.googleapis.com/google.rpc.BadRequest";
constexpr char kRetryInfoUrl[] = "type.googleapis.com/google.rpc.RetryInfo";
constexpr char kDomain[] = "dynmesh";
constexpr std::size_t kMaxMessageBytes = 1024;
constexpr std::size_t kMaxFeatures = 32;

// Cuts between characters: a part of one is invalid UTF-8, which a proto3 string must not contain.
std::string Shorten(absl::string_view text) {
  if (text.size() <= kMaxMessageBytes) return std::string(text);
  std::size_t end = kMaxMessageBytes - 3;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0) == 0x80) --end;
  return absl::StrCat(text.substr(0, end), "...");
}

ServiceError FromDetail(const ErrorDetail& detail, absl::string_view edits_field) {
  ServiceError error;
  error.reason = detail.reason;
  if (!detail.features.empty()) {
    const std::size_t n = std::min(detail.features.size(), kMaxFeatures);
    error.metadata["features"] =
        absl::StrJoin(detail.features.begin(), detail.features.begin() + n, ",");
  }
  if (detail.edit.has_value()) {
    error.metadata["edit"] = absl::StrCat(*detail.edit);
    error.field = absl::StrCat(edits_field, "[", *detail.edit, "]");
  }
  return error;
}

template <typename Message>
bool ParsePayload(const absl::Status& status, const char* url, Message* out) {
  const auto payload = status.GetPayload(url);
  return payload.has_value() && out->ParseFromString(std::string(*payload));
}

std::optional<ServiceError> FromPayloads(const absl::Status& status) {
  v1::ErrorInfo info;
  if (!ParsePayload(status, kErrorInfoUrl, &info)) return std::nullopt;
  ServiceError error;
  error.reason = info.reason();
  error.metadata = {info.metadata().begin(), info.metadata().end()};
  v1::BadRequest bad;
  if (ParsePayload(status, kBadRequestUrl, &bad) && bad.field_violations_size() > 0) {
    error.field = bad.field_violations(0).field();
  }
  v1::RetryInfo retry;
  if (ParsePayload(status, kRetryInfoUrl, &retry)) {
    error.retry_after = absl::Seconds(retry.retry_delay().seconds()) +
                        absl::Nanoseconds(retry.retry_delay().nanos());
  }
  return error;
}

// Converts the detail of either kind. The library's detail names edits by index only.
std::optional<ServiceError> Detail(const absl::Status& status, absl::string_view edits_field) {
  if (const auto detail = GetErrorDetail(status)) return FromDetail(*detail, edits_field);
  return FromPayloads(status);
}

void SetPayloads(absl::Status& status, const ServiceError& error) {
  v1::ErrorInfo info;
  info.set_reason(error.reason);
  info.set_domain(kDomain);
  info.mutable_metadata()->insert(error.metadata.begin(), error.metadata.end());
  status.SetPayload(kErrorInfoUrl, absl::Cord(info.SerializeAsString()));
  if (!error.field.empty()) {
    v1::BadRequest bad;
    auto* violation = bad.add_field_violations();
    violation->set_field(error.field);
    violation->set_description(Shorten(status.message()));
    status.SetPayload(kBadRequestUrl, absl::Cord(bad.SerializeAsString()));
  }
  if (error.retry_after.has_value()) {
    v1::RetryInfo retry;
    const std::int64_t nanos = absl::ToInt64Nanoseconds(*error.retry_after);
    retry.mutable_retry_delay()->set_seconds(nanos / 1'000'000'000);
    retry.mutable_retry_delay()->set_nanos(static_cast<std::int32_t>(nanos % 1'000'000'000));
    status.SetPayload(kRetryInfoUrl, absl::Cord(retry.SerializeAsString()));
  }
}

}  // namespace

std::vector<FeatureId> ServiceError::Features() const {
  std::vector<FeatureId> ids;
  const auto it = metadata.find("features");
  if (it == metadata.end()) return ids;
  for (absl::string_view text : absl::StrSplit(it->second, ',', absl::SkipEmpty())) {
    FeatureId id = kNoFeature;
    if (absl::SimpleAtoi(text, &id)) ids.push_back(id);
  }
  return ids;
}

absl::Status MakeServiceError(absl::StatusCode code, absl::string_view message,
                              const ServiceError& error) {
  absl::Status status(code, message);
  SetPayloads(status, error);
  return status;
}

std::optional<ServiceError> GetServiceError(const absl::Status& status) {
  return Detail(status, "edits");
}

v1::Status StatusToProto(const absl::Status& status, absl::string_view edits_field) {
  v1::Status proto;
  proto.set_code(static_cast<int>(status.code()));
  proto.set_message(Shorten(status.message()));
  const std::optional<ServiceError> error = Detail(status, edits_field);
  if (!error.has_value()) return proto;
  absl::Status carrier(status.code(), status.message());
  SetPayloads(carrier, *error);
  for (const char* url : {kErrorInfoUrl, kBadRequestUrl, kRetryInfoUrl}) {
    if (const auto payload = carrier.GetPayload(url)) {
      auto* any = proto.add_details();
      any->set_type_url(url);
      any->set_value(std::string(*payload));
    }
  }
  return proto;
}

absl::Status StatusFromProto(const v1::Status& proto) {
  // An unknown code, of a newer peer, becomes UNKNOWN.
  const int code = proto.code() >= 0 && proto.code() <= 16 ? proto.code() : 2;
  absl::Status status(static_cast<absl::StatusCode>(code), proto.message());
  if (status.ok()) return status;
  for (const auto& any : proto.details()) {
    status.SetPayload(any.type_url(), absl::Cord(any.value()));
  }
  return status;
}

}  // namespace dynmesh::codec
