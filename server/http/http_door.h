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

namespace dynmesh::server {

class HttpDoor {
 public:
  struct Options {
    std::string listen;  // [HOST:]PORT
    HttpServer::Limits limits;
    // Tokens are checked: a request that has one was not made by a page of another site.
    bool has_tokens = false;
  };
  // `channel`: to the service, within this process. INVALID_ARGUMENT for an address that is none,
  // UNAVAILABLE if it cannot be listened on.
  static absl::StatusOr<std::unique_ptr<HttpDoor>> Listen(const Options& options,
                                                          std::shared_ptr<grpc::Channel> channel);

  // Ends all calls. By one thread.
  void Stop() { server_->Stop(); }
  std::string address() const;  // host:port with the chosen port
  HttpServer::Counts counts() const { return server_->counts(); }

 private:
  HttpDoor(std::string host, bool has_tokens, std::shared_ptr<grpc::Channel> channel)
      : host_(std::move(host)), has_tokens_(has_tokens), calls_(std::move(channel)) {}
  HttpReply Answer(const HttpRequest& request) const;

  const std::string host_;
  const bool has_tokens_;
  const ConnectCalls calls_;
  std::unique_ptr<HttpServer> server_;  // the first to end: it calls the others
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_DOOR_H_
