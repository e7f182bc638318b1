#include "server/http/message_json.h"

#include <google/protobuf/message.h>
#include <google/protobuf/util/json_util.h>

#include <memory>

#include "absl/strings/ascii.h"
#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

std::unique_ptr<google::protobuf::Message> MakeMessage(const google::protobuf::Descriptor& type) {
  return std::unique_ptr<google::protobuf::Message>(
      google::protobuf::MessageFactory::generated_factory()->GetPrototype(&type)->New());
}

}  // namespace

absl::StatusOr<std::string> JsonToBytes(const google::protobuf::Descriptor& type,
                                        absl::string_view json) {
  const std::unique_ptr<google::protobuf::Message> message = MakeMessage(type);
  if (!absl::StripAsciiWhitespace(json).empty()) {
    const auto status =
        google::protobuf::util::JsonStringToMessage({json.data(), json.size()}, message.get());
    if (!status.ok()) {
      return absl::InvalidArgumentError(
          absl::StrCat("the body is no JSON of a ", type.full_name(), ": ",
                       absl::string_view(status.message().data(), status.message().size())));
    }
  }
  return message->SerializeAsString();
}

absl::StatusOr<std::string> BytesToJson(const google::protobuf::Descriptor& type,
                                        absl::string_view bytes) {
  const std::unique_ptr<google::protobuf::Message> message = MakeMessage(type);
  std::string json;
  if (!message->ParseFromArray(bytes.data(), static_cast<int>(bytes.size())) ||
      !google::protobuf::util::MessageToJsonString(*message, &json).ok()) {
    return absl::InternalError(absl::StrCat("not a ", type.full_name()));
  }
  return json;
}

}  // namespace dynmesh::server
