#include "server/http/http_door.h"

#include <optional>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/listening.h"
#include "server/http/cross_site.h"

namespace dynmesh::server {

HttpReply HttpDoor::Answer(const HttpRequest& request) const {
  if (!ConnectCalls::IsMethod(request.path)) {
    if (std::optional<HttpReply> file = AnswerWithFile(files_, request)) return *std::move(file);
    return PlainReply(404, files_.empty() && request.path == "/"
                               ? "this program was built without its page, for which it takes npm\n"
                               : "there is POST /dynmesh.v1.MeshService/METHOD\n");
  }
  if (!has_tokens_ || request.Find("Authorization") == nullptr) {
    if (const std::string why = WhyCrossSite(request, name_); !why.empty()) {
      return PlainReply(403, absl::StrCat(why, "\n"));
    }
  }
  return calls_.Answer(request);
}

absl::StatusOr<std::unique_ptr<HttpDoor>> HttpDoor::Listen(const Options& options,
                                                           std::shared_ptr<grpc::Channel> channel) {
  const absl::StatusOr<HostPort> wanted = ParseHostPort("http", options.listen);
  if (!wanted.ok()) return wanted.status();
  std::unique_ptr<HttpDoor> door(new HttpDoor(wanted->host, options, std::move(channel)));
  auto server = HttpServer::Listen(
      wanted->host, wanted->port, options.limits,
      [door = door.get()](const HttpRequest& request) { return door->Answer(request); });
  if (!server.ok()) {
    return absl::UnavailableError(absl::StrCat("cannot listen on ", options.listen,
                                               " for HTTP: ", server.status().message()));
  }
  door->server_ = *std::move(server);
  return door;
}

std::string HttpDoor::address() const { return AddressText({host_, server_->port()}); }

}  // namespace dynmesh::server
