// Answers calls of the Connect protocol: hands each on to the service as a call of gRPC in this
// process. So both doors have the same methods, rights, limits, metrics and log. Thread-safe; an
// answer takes the thread that asks for it, until the call has ended.
#ifndef DYNMESH_SERVER_HTTP_CONNECT_CALLS_H_
#define DYNMESH_SERVER_HTTP_CONNECT_CALLS_H_

#include <grpcpp/grpcpp.h>

#include <memory>

#include "absl/strings/string_view.h"
#include "server/http/http_message.h"

namespace dynmesh::server {

class ConnectCalls {
 public:
  // `channel`: to the service, within this process.
  explicit ConnectCalls(std::shared_ptr<grpc::Channel> channel) : channel_(std::move(channel)) {}

  // Whether the path is that of the service's methods.
  static bool IsMethod(absl::string_view path);

  // Methods with one request each. A stream of requests, which browsers cannot send, is answered
  // UNIMPLEMENTED.
  HttpReply Answer(const HttpRequest& request) const;

 private:
  const std::shared_ptr<grpc::Channel> channel_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_CONNECT_CALLS_H_
