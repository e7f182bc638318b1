#include "server/http/connect_protocol.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "dynmesh/v1/status_details.pb.h"
#include "server/http/message_json.h"

namespace dynmesh::server::connectrpc {
namespace {

struct Code {
  const char* name;
  int http;
};
// By the code of gRPC.
constexpr std::array<Code, 17> kCodes = {{{"ok", 200},
                                          {"canceled", 499},
                                          {"unknown", 500},
                                          {"invalid_argument", 400},
                                          {"deadline_exceeded", 504},
                                          {"not_found", 404},
                                          {"already_exists", 409},
                                          {"permission_denied", 403},
                                          {"resource_exhausted", 429},
                                          {"failed_precondition", 400},
                                          {"aborted", 409},
                                          {"out_of_range", 400},
                                          {"unimplemented", 501},
                                          {"internal", 500},
                                          {"unavailable", 503},
                                          {"data_loss", 500},
                                          {"unauthenticated", 401}}};

const Code& CodeOf(grpc::StatusCode code) {
  const auto index = static_cast<std::size_t>(code);
  return kCodes[index < kCodes.size() ? index : 2];
}

constexpr std::array<std::pair<const char*, Codec>, 4> kTypes = {
    {{"application/json", {true, false}},
     {"application/proto", {false, false}},
     {"application/connect+json", {true, true}},
     {"application/connect+proto", {false, true}}}};

// As the protocol has it: without the '=' at the end.
std::string Base64(const std::string& bytes) {
  std::string text;
  absl::Base64Escape(bytes, &text);
  while (absl::EndsWith(text, "=")) text.pop_back();
  return text;
}

// For people: what the bytes say, of the kinds that this project has. Null for others.
nlohmann::json Readable(const std::string& type, const std::string& bytes) {
  const std::string name = absl::StrCat("dynmesh.v1.", type.substr(type.rfind('.') + 1));
  const auto* const kind = v1::Status::descriptor()->file()->pool()->FindMessageTypeByName(name);
  if (kind == nullptr) return nullptr;
  const absl::StatusOr<std::string> text = BytesToJson(*kind, bytes);
  return text.ok() ? nlohmann::json::parse(*text, nullptr, false) : nullptr;
}

nlohmann::json ErrorOf(const grpc::Status& status) {
  nlohmann::json error = {{"code", NameOf(status.error_code())}};
  if (!status.error_message().empty()) error["message"] = status.error_message();
  v1::Status all;
  if (!status.error_details().empty() && all.ParseFromString(status.error_details())) {
    for (const google::protobuf::Any& detail : all.details()) {
      const std::string type = detail.type_url().substr(detail.type_url().rfind('/') + 1);
      error["details"].push_back({{"type", type},
                                  {"value", Base64(detail.value())},
                                  {"debug", Readable(type, detail.value())}});
    }
  }
  return error;
}

// Text of an error may have bytes of a client that are not UTF-8.
std::string Text(const nlohmann::json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::optional<Codec> CodecOf(absl::string_view content_type) {
  const absl::string_view type =
      absl::StripAsciiWhitespace(content_type.substr(0, content_type.find(';')));
  for (const auto& [name, codec] : kTypes) {
    if (absl::EqualsIgnoreCase(type, name)) return codec;
  }
  return std::nullopt;
}

const char* TypeOf(const Codec& codec) {
  return kTypes[(codec.is_stream ? 2 : 0) + (codec.is_json ? 0 : 1)].first;
}

const char* NameOf(grpc::StatusCode code) { return CodeOf(code).name; }

int HttpStatusOf(grpc::StatusCode code) { return CodeOf(code).http; }

std::string ErrorJson(const grpc::Status& status) { return Text(ErrorOf(status)); }

absl::StatusOr<std::chrono::milliseconds> ParseTimeout(absl::string_view text) {
  std::int64_t milliseconds = 0;
  const bool digits = std::all_of(text.begin(), text.end(), absl::ascii_isdigit);
  if (!digits || text.size() > 10 || !absl::SimpleAtoi(text, &milliseconds)) {
    return absl::InvalidArgumentError(
        "Connect-Timeout-Ms is a number of milliseconds of at most ten digits");
  }
  return std::chrono::milliseconds(milliseconds);
}

std::string Envelope(unsigned char flags, absl::string_view message) {
  const auto size = static_cast<std::uint32_t>(message.size());
  const std::array<char, kPrefixBytes> prefix = {
      static_cast<char>(flags), static_cast<char>(size >> 24), static_cast<char>(size >> 16),
      static_cast<char>(size >> 8), static_cast<char>(size)};
  return absl::StrCat(absl::string_view(prefix.data(), prefix.size()), message);
}

absl::StatusOr<absl::string_view> OpenEnvelope(absl::string_view body) {
  if (body.size() < kPrefixBytes) {
    return absl::InvalidArgumentError(
        "a message of a stream begins with five bytes: flags, length");
  }
  if (body[0] != 0) {
    return absl::InvalidArgumentError("the flags of the message are not 0: it is to be plain");
  }
  std::uint32_t size = 0;
  for (std::size_t i = 1; i < kPrefixBytes; ++i) {
    size = size << 8 | static_cast<unsigned char>(body[i]);
  }
  body.remove_prefix(kPrefixBytes);
  if (size != body.size()) {
    return absl::InvalidArgumentError(absl::StrCat("the message is said to have ", size,
                                                   " bytes, and ", body.size(),
                                                   " came: this call "
                                                   "takes one message"));
  }
  return body;
}

std::string EndOfStream(const grpc::Status& status) {
  nlohmann::json end = nlohmann::json::object();
  if (!status.ok()) end["error"] = ErrorOf(status);
  return Envelope(kEndOfStream, Text(end));
}

}  // namespace dynmesh::server::connectrpc
