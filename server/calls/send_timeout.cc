#include "server/calls/send_timeout.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "proto/codec/status_codec.h"
#include "server/calls/cut_call.h"

namespace dynmesh::server {
namespace {

std::string SlowReceiver(absl::Duration limit) {
  return absl::StrCat(codec::reason::kSlowReceiver, ": a message was not taken for ",
                      absl::FormatDuration(limit), ": read on, or ask again");
}

}  // namespace

// Finish would wait behind the message that is not taken.
void LimitSends(ServiceContext& context, grpc::CallbackServerContext* rpc,
                OpenSends::Sender& sender) {
  sender.Enter(context.sends, [rpc, limit = context.config.send_timeout] {
    CutCall(*rpc, GRPC_STATUS_DEADLINE_EXCEEDED, SlowReceiver(limit));
  });
}

absl::Status WhyCut(const ServiceContext& context, const OpenSends::Sender& sender,
                    absl::string_view otherwise) {
  if (!sender.ended()) return absl::CancelledError(otherwise);
  codec::ServiceError error;
  error.reason = codec::reason::kSlowReceiver;
  return codec::MakeServiceError(absl::StatusCode::kDeadlineExceeded,
                                 SlowReceiver(context.config.send_timeout), error);
}

void EndSlowReceivers(ServiceContext& context) {
  const absl::Duration limit = context.config.send_timeout;
  if (limit == absl::ZeroDuration()) return;
  context.sends.EndSlow(OpenSends::Clock::now() - absl::ToChronoNanoseconds(limit));
}

}  // namespace dynmesh::server
