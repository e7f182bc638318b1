// Answers calls of methods that the server does not have: UNIMPLEMENTED, with their name. Without
// it gRPC does, without a text. Thread-safe.
#ifndef DYNMESH_SERVER_CALLS_UNKNOWN_METHODS_H_
#define DYNMESH_SERVER_CALLS_UNKNOWN_METHODS_H_

#include <grpcpp/generic/async_generic_service.h>

namespace dynmesh::server {

class UnknownMethods final : public grpc::CallbackGenericService {
 public:
  grpc::ServerGenericBidiReactor* CreateReactor(grpc::GenericCallbackServerContext* call) override;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_UNKNOWN_METHODS_H_
