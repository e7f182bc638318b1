// Answers calls of unknown methods: UNIMPLEMENTED, with the method's name. gRPC itself would answer
// without a text. Thread-safe.
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
