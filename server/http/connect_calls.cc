#include "server/http/connect_calls.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "server/base/call_id.h"
#include "server/base/call_peer.h"
#include "server/http/connect_protocol.h"
#include "server/http/message_json.h"
#include "server/http/raw_call.h"

namespace dynmesh::server {
namespace {

using connectrpc::Codec;
using connectrpc::TypeOf;
using google::protobuf::MethodDescriptor;

constexpr absl::string_view kService = "/dynmesh.v1.MeshService/";
// Between two looks whether the client is there, while nothing is sent.
constexpr std::chrono::milliseconds kLook{500};

const MethodDescriptor* FindMethod(absl::string_view path) {
  const auto* const service =
      v1::GetMeshRequest::descriptor()->file()->FindServiceByName("MeshService");
  return service->FindMethodByName(std::string(absl::StripPrefix(path, kService)));
}

grpc::Status Refusal(const absl::Status& status) {
  return {static_cast<grpc::StatusCode>(status.code()), std::string(status.message())};
}

// An error before the call: as the protocol's codec has it.
HttpReply Failed(const Codec& codec, const grpc::Status& status, HttpHeaders headers) {
  if (codec.is_stream) {
    return {200, std::move(headers), TypeOf(codec), connectrpc::EndOfStream(status), nullptr};
  }
  return {connectrpc::HttpStatusOf(status.error_code()), std::move(headers), "application/json",
          connectrpc::ErrorJson(status), nullptr};
}

// A message of the service for the client.
absl::StatusOr<std::string> Encoded(const Codec& codec, const MethodDescriptor& method,
                                    std::string bytes) {
  return codec.is_json ? BytesToJson(*method.output_type(), bytes) : std::move(bytes);
}

// The messages of a stream, as they come, then the status.
void SendMessages(RawCall& call, const Codec& codec, const MethodDescriptor& method,
                  HttpSink& sink) {
  std::string bytes;
  while (true) {
    const RawCall::Got got = call.Read(&bytes, std::chrono::system_clock::now() + kLook);
    if (got == RawCall::Got::kEnd) break;
    if (got == RawCall::Got::kNothing) {
      if (!sink.IsOpen()) return;
      continue;
    }
    const absl::StatusOr<std::string> message = Encoded(codec, method, std::move(bytes));
    if (!message.ok()) {
      sink.Write(connectrpc::EndOfStream(Refusal(message.status())));
      return;
    }
    if (!sink.Write(connectrpc::Envelope(0, *message))) return;
  }
  sink.Write(connectrpc::EndOfStream(call.Finish()));
}

HttpReply UnaryAnswer(RawCall& call, const Codec& codec, const MethodDescriptor& method,
                      HttpHeaders headers) {
  std::string bytes;
  call.Read(&bytes, std::chrono::system_clock::time_point::max());
  const grpc::Status& status = call.Finish();
  if (!status.ok()) return Failed(codec, status, std::move(headers));
  absl::StatusOr<std::string> message = Encoded(codec, method, std::move(bytes));
  if (!message.ok()) return Failed(codec, Refusal(message.status()), std::move(headers));
  return {200, std::move(headers), TypeOf(codec), *std::move(message), nullptr};
}

}  // namespace

bool ConnectCalls::IsMethod(absl::string_view path) { return absl::StartsWith(path, kService); }

HttpReply ConnectCalls::Answer(const HttpRequest& request) const {
  const MethodDescriptor* const method = FindMethod(request.path);
  if (method == nullptr) {
    return Failed(
        {}, {grpc::StatusCode::UNIMPLEMENTED, absl::StrCat("there is no method ", request.path)},
        {});
  }
  if (request.method != "POST") {
    return PlainReply(405, "calls are sent with POST\n", {{"Allow", "POST"}});
  }
  if (method->client_streaming()) {
    return Failed({},
                  {grpc::StatusCode::UNIMPLEMENTED,
                   absl::StrCat(method->name(), " takes a stream of messages: call it by gRPC")},
                  {});
  }
  const std::string* const type = request.Find("Content-Type");
  const std::optional<Codec> codec = type == nullptr ? std::nullopt : connectrpc::CodecOf(*type);
  if (!codec.has_value() || codec->is_stream != method->server_streaming()) {
    const bool streams = method->server_streaming();
    const std::string json = TypeOf({.is_json = true, .is_stream = streams});
    const std::string proto = TypeOf({.is_json = false, .is_stream = streams});
    return PlainReply(
        415, absl::StrCat("Content-Type of ", method->name(), " is ", json, " or ", proto, "\n"),
        {{"Accept-Post", absl::StrCat(json, ", ", proto)}});
  }
  const std::string* const given_id = request.Find("X-Request-Id");
  const std::string id = ChooseCallId(given_id == nullptr ? "" : *given_id);
  // Answers are of the moment.
  const HttpHeaders headers = {{"X-Request-Id", id}, {"Cache-Control", "no-store"}};
  const auto refuse = [&](const absl::Status& status) {
    return Failed(*codec, Refusal(status), headers);
  };
  absl::StatusOr<absl::string_view> body = absl::string_view(request.body);
  if (codec->is_stream) body = connectrpc::OpenEnvelope(request.body);
  if (!body.ok()) return refuse(body.status());
  const absl::StatusOr<std::string> message =
      codec->is_json ? JsonToBytes(*method->input_type(), *body) : std::string(*body);
  if (!message.ok()) return refuse(message.status());

  auto call = std::make_shared<RawCall>(channel_);
  grpc::ClientContext& context = call->context();
  if (const std::string* const limit = request.Find("Connect-Timeout-Ms")) {
    const auto timeout = connectrpc::ParseTimeout(*limit);
    if (!timeout.ok()) return refuse(timeout.status());
    context.set_deadline(std::chrono::system_clock::now() + *timeout);
  }
  for (const auto& [name, value] : request.headers) {
    if (!absl::EqualsIgnoreCase(name, "Authorization")) continue;
    // gRPC ends the process for other bytes.
    if (!std::all_of(value.begin(), value.end(), absl::ascii_isprint)) {
      return refuse(absl::UnauthenticatedError("Authorization has bytes that are not printable"));
    }
    context.AddMetadata("authorization", value);
  }
  context.AddMetadata(kCallIdKey, id);
  context.AddMetadata(HttpPeerKey(), request.peer);
  call->Start(request.path, *message);
  if (!codec->is_stream) return UnaryAnswer(*call, *codec, *method, headers);
  return {200, headers, TypeOf(*codec), "",
          [call = std::move(call), codec = *codec, method](HttpSink& sink) {
            SendMessages(*call, codec, *method, sink);
          }};
}

}  // namespace dynmesh::server
