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

std::string HoldersOf(const ServiceContext& context, absl::string_view limit) {
  for (const SharedLimit* shared :
       {&context.watchers, &context.edit_streams, &context.snapshot_streams, &context.builds,
        &context.pasts, &context.pending_edits}) {
    if (shared->what() == limit) return shared->Holders();
  }
  return "";
}

namespace {

// Null access: no token is known.
bool IsShared(const ServiceContext& context) {
  return context.access != nullptr && context.access->has_several_clients();
}

std::string ShareText(const SharedLimit& limit) {
  return absl::StrCat("this client has its share of the server's ", limit.what(), ", ",
                      limit.share(), " of ", limit.limit());
}

}  // namespace

std::string SharingClient(const ServiceContext& context, const Pass& pass) {
  return IsShared(context) ? pass.client() : std::string();
}

absl::StatusOr<SharedLimit::Place> TakePlace(ServiceContext& context, SharedLimit& limit,
                                             const Pass& pass) {
  bool is_share = false;
  SharedLimit::Place place = limit.Take(pass.client(), 1, IsShared(context), is_share);
  if (place) return place;
  codec::ServiceError error;
  error.reason = is_share ? codec::reason::kClientStreamLimit : codec::reason::kStreamLimit;
  error.metadata["limit"] = limit.what();
  error.retry_after = absl::Seconds(1);
  if (is_share) {
    error.metadata["client"] = pass.client();
    return codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                   absl::StrCat(ShareText(limit), ": end some, or try later"),
                                   error);
  }
  return codec::MakeServiceError(absl::StatusCode::kResourceExhausted,
                                 absl::StrCat("the server's limit of ", limit.limit(), " ",
                                              limit.what(), " is reached: try later"),
                                 error);
}

absl::StatusOr<StreamPlace> TakeStream(ServiceContext& context, SharedLimit& limit,
                                       const Pass& pass) {
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
  absl::StatusOr<SharedLimit::Place> of_kind = TakePlace(context, limit, pass);
  if (!of_kind.ok()) return of_kind.status();
  place.of_kind = *std::move(of_kind);
  return place;
}

absl::StatusOr<SharedLimit::Place> TakeEdits(ServiceContext& context, const Pass& pass,
                                             std::size_t before, std::size_t count) {
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
  SharedLimit& limit = context.pending_edits;
  bool is_share = false;
  SharedLimit::Place place = limit.Take(pass.client(), count, IsShared(context), is_share);
  if (place) return place;
  error.reason = codec::reason::kPendingLimit;
  error.metadata["limit"] = limit.what();
  error.retry_after = absl::Milliseconds(500);
  if (is_share) error.metadata["client"] = pass.client();
  return codec::MakeServiceError(
      absl::StatusCode::kResourceExhausted,
      is_share ? absl::StrCat(ShareText(limit), ": wait for the answers to those it has sent")
               : "too many edits are waiting in the server: try again later",
      error);
}

absl::Status EditShares::Take(ServiceContext& context, const Pass& pass, std::size_t count) {
  if (count == 0) return absl::OkStatus();  // no limit on such parts
  absl::StatusOr<SharedLimit::Place> place = TakeEdits(context, pass, weight_, count);
  if (!place.ok()) return place.status();
  weight_ += count;
  places_.push_back(*std::move(place));
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
                                      Access::Cancel cancel) {
  if (!host.ok()) return host.status();
  if (*host == nullptr) return absl::CancelledError("the call ended before its mesh was opened");
  absl::StatusOr<StreamPlace> place = TakeStream(context, context.edit_streams, pass);
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
