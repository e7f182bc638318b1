#include "server/calls/admission.h"

#include <utility>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::server {
namespace {

constexpr std::size_t kMaxRequestIdBytes = 128;

}  // namespace

absl::Status DrainingError() {
  codec::ServiceError error;
  error.reason = codec::reason::kDraining;
  error.retry_after = absl::Seconds(1);
  return codec::MakeServiceError(absl::StatusCode::kUnavailable,
                                 "the server is shutting down: try again in a while", error);
}

absl::Status RecoveringError() {
  codec::ServiceError error;
  error.reason = codec::reason::kRecovering;
  error.retry_after = absl::Milliseconds(500);
  return codec::MakeServiceError(
      absl::StatusCode::kUnavailable,
      "the server has just started and makes its meshes again: try again in a moment", error);
}

absl::StatusOr<WorkGate::Ticket> EnterWork(ServiceContext& context) {
  WorkGate::Ticket ticket = context.gate.Enter();
  if (ticket == nullptr) return DrainingError();
  return ticket;
}

absl::StatusOr<Lease> TakeStream(Quota& quota, absl::string_view what) {
  Lease lease = quota.Take();
  if (lease) return lease;
  codec::ServiceError error;
  error.reason = codec::reason::kStreamLimit;
  error.retry_after = absl::Seconds(1);
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      absl::StrCat("the server's limit of ", quota.limit(), " ", what, " is reached: try later"),
      error);
}

absl::StatusOr<StreamPlace> TakeStream(ServiceContext& context, Quota& quota,
                                       absl::string_view what, const Pass& pass) {
  StreamPlace place;
  place.of_client = context.client_streams.Take(pass.client());
  if (!place.of_client) {
    codec::ServiceError error;
    error.reason = codec::reason::kClientStreamLimit;
    error.metadata["client"] = pass.client();
    error.retry_after = absl::Seconds(1);
    return codec::MakeServiceError(
        absl::StatusCode::kResourceExhausted,
        absl::StrCat("this client has the ", context.client_streams.limit(),
                     " streams open that one client may have: end some, or try later"),
        error);
  }
  absl::StatusOr<Lease> lease = TakeStream(quota, what);
  if (!lease.ok()) return lease.status();
  place.of_kind = *std::move(lease);
  return place;
}

absl::StatusOr<Lease> TakeEdits(ServiceContext& context, std::size_t before, std::size_t count) {
  codec::ServiceError error;
  if (before + count > context.config.max_batch_edits) {
    error.reason = codec::reason::kBatchTooLarge;
    error.field = "edits";
    return codec::MakeServiceError(
        absl::StatusCode::kInvalidArgument,
        absl::StrCat("a batch may have ", context.config.max_batch_edits,
                     " edits at most, 8 points of a polygon count as one: split it"),
        error);
  }
  Lease lease = context.pending_edits.Take(count);
  if (lease) return lease;
  error.reason = codec::reason::kPendingLimit;
  error.retry_after = absl::Milliseconds(500);
  return codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                 "too many edits are waiting in the server: try again later",
                                 error);
}

absl::Status HeldEdits::Take(ServiceContext& context, std::size_t count) {
  if (count == 0) return absl::OkStatus();  // no limit on such parts
  absl::StatusOr<Lease> lease = TakeEdits(context, weight_, count);
  if (!lease.ok()) return lease.status();
  weight_ += count;
  leases_.push_back(*std::move(lease));
  return absl::OkStatus();
}

absl::Status CheckRefusal(const MeshRegistry& meshes, const MeshHost& host, absl::Status refused) {
  // What UNAVAILABLE says of the outcome is true of any state.
  if (refused.ok() || absl::IsUnavailable(refused)) return refused;
  absl::Status read = meshes.CheckRead(host.id());
  return read.ok() ? refused : read;
}

absl::StatusOr<EditTarget> OpenToEdit(ServiceContext& context, const Pass& pass,
                                      absl::StatusOr<MeshRegistry::HostPtr> host,
                                      std::function<void()> cancel) {
  if (!host.ok()) return host.status();
  if (*host == nullptr) return absl::CancelledError("the call ended before its mesh was opened");
  absl::StatusOr<StreamPlace> place =
      TakeStream(context, context.edit_streams, "edit streams", pass);
  if (!place.ok()) return place.status();
  absl::StatusOr<Access::Stream> allowed =
      context.access->Open(pass, Role::kEdit, (*host)->id(), std::move(cancel));
  if (!allowed.ok()) return allowed.status();
  return EditTarget{*std::move(host), *std::move(allowed), *std::move(place)};
}

absl::Status CheckRequestId(absl::string_view request_id) {
  if (request_id.size() <= kMaxRequestIdBytes) return absl::OkStatus();
  codec::ServiceError error;
  error.reason = codec::reason::kBadRequestId;
  error.field = "request_id";
  return codec::MakeServiceError(
      absl::StatusCode::kInvalidArgument,
      absl::StrCat("request_id has ", request_id.size(), " bytes, at most ", kMaxRequestIdBytes,
                   " are allowed"),
      error);
}

absl::Status BadRequest(absl::string_view field, absl::string_view message) {
  codec::ServiceError error;
  error.reason = codec::reason::kBadRequest;
  error.field = std::string(field);
  return codec::MakeServiceError(absl::StatusCode::kInvalidArgument,
                                 absl::StrCat(field, ": ", message), error);
}

}  // namespace dynmesh::server
