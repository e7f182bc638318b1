// The service over HTTP: its methods by the Connect protocol, for browsers and for `curl`.
// Thread-safe except destruction.
#ifndef DYNMESH_SERVER_HTTP_HTTP_DOOR_H_
#define DYNMESH_SERVER_HTTP_HTTP_DOOR_H_

#include <grpcpp/grpcpp.h>

#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/http/connect_calls.h"
#include "server/http/http_server.h"
#include "server/http/static_files.h"

namespace dynmesh::server {

class HttpDoor {
 public:
  struct Options {
    std::string listen;  // [HOST:]PORT
    HttpServer::Limits limits;
    std::string name;  // of the address that browsers have, as of a proxy; empty: the host's own
    // Tokens are checked: a request that has one was not made by a page of another site.
    bool has_tokens = false;
    absl::Span<const StaticFile> files;  // answered to any site: they are the program's, not data
  };
  // `channel`: to the service, within this process. INVALID_ARGUMENT for an address that is none,
  // UNAVAILABLE if it cannot be listened on.
  static absl::StatusOr<std::unique_ptr<HttpDoor>> Listen(const Options& options,
                                                          std::shared_ptr<grpc::Channel> channel);

  // Takes no more calls, and ends those that are open after `grace`. By one thread.
  void Stop(std::chrono::milliseconds grace) { server_->Stop(grace); }
  std::string address() const;  // host:port with the chosen port
  HttpServer::Counts counts() const { return server_->counts(); }

 private:
  HttpDoor(std::string host, const Options& options, std::shared_ptr<grpc::Channel> channel)
      : host_(std::move(host)),
        name_(options.name.empty() ? host_ : options.name),
        has_tokens_(options.has_tokens),
        files_(options.files),
        calls_(std::move(channel)) {}
  HttpReply Answer(const HttpRequest& request) const;

  const std::string host_;
  const std::string name_;
  const bool has_tokens_;
  const absl::Span<const StaticFile> files_;
  const ConnectCalls calls_;
  std::unique_ptr<HttpServer> server_;  // the first to end: it calls the others
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_DOOR_H_
