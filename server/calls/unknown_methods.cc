#include "server/calls/unknown_methods.h"

#include <string>

#include "absl/status/status.h"
#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/version.h"
#include "proto/codec/grpc_status.h"

namespace dynmesh::server {
namespace {

constexpr std::size_t kMostOfAName = 128;

class UnknownCall final : public grpc::ServerGenericBidiReactor {
 public:
  explicit UnknownCall(const std::string& method) {
    Finish(codec::ToGrpcStatus(
        absl::UnimplementedError(absl::StrCat("dynmeshd ", kVersion, " has no method ",
                                              absl::CHexEscape(method.substr(0, kMostOfAName))))));
  }
  void OnDone() override { delete this; }
};

}  // namespace

grpc::ServerGenericBidiReactor* UnknownMethods::CreateReactor(
    grpc::GenericCallbackServerContext* call) {
  return new UnknownCall(call->method());
}

}  // namespace dynmesh::server
