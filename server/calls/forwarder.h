// Hands calls on to the server that has the mesh, for clients that do not go there themselves:
// general tools, as grpcurl, and stubs that were made from the .proto files in any language. Calls
// with one request and one answer only; of a stream such a client gets NOT_OWNER.
//
// The call is made with the client's token, id and deadline, and ends with it. It goes on at most
// once: the other server sends it back with NOT_OWNER if it has not got the mesh either.
// Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_FORWARDER_H_
#define DYNMESH_SERVER_CALLS_FORWARDER_H_

#include <grpcpp/grpcpp.h>

#include <functional>
#include <map>
#include <memory>
#include <string>

#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "server/meshes/mesh_opener.h"

namespace dynmesh::server {

class Forwarder {
 public:
  // `credentials`: for connections to other servers; null: nothing is handed on.
  explicit Forwarder(std::shared_ptr<grpc::ChannelCredentials> credentials)
      : credentials_(std::move(credentials)) {}

  using Async = v1::MeshService::StubInterface::async_interface;
  template <class Request, class Response>
  using Method = void (Async::*)(grpc::ClientContext*, const Request*, Response*,
                                 std::function<void(grpc::Status)>);

  // Ends a call that this server ended with `status`: hands it on if that is NOT_OWNER with an
  // address and the client does not follow; else `done` gets `status`. All but `status` live until
  // `done` was called, once, by this thread or one of gRPC.
  template <class Request, class Response>
  void End(const absl::Status& status, grpc::CallbackServerContext* call,
           Method<Request, Response> method, const Request* request, Response* response,
           std::function<void(grpc::Status)> done) {
    v1::MeshService::Stub* const other = ServerOf(status, *call);
    if (other == nullptr) return done(AsGrpc(status));
    const std::shared_ptr<grpc::ClientContext> context = ContextOf(*call);
    response->Clear();
    (other->async()->*method)(context.get(), request, response,
                              [context, done](const grpc::Status& end) { done(end); });
  }

 private:
  // Null if the call is not to be handed on.
  v1::MeshService::Stub* ServerOf(const absl::Status& status,
                                  const grpc::CallbackServerContext& call);
  static std::shared_ptr<grpc::ClientContext> ContextOf(const grpc::CallbackServerContext& call);
  static grpc::Status AsGrpc(const absl::Status& status);

  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  Mutex mutex_;
  // By address.
  std::map<std::string, std::unique_ptr<v1::MeshService::Stub>> servers_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_FORWARDER_H_
