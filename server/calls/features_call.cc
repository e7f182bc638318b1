#include "server/calls/features_call.h"

#include <optional>
#include <utility>

#include "proto/codec/features_codec.h"
#include "server/calls/chunks_call.h"

namespace dynmesh::server {
namespace {

class FeaturesCall final
    : public ChunksCall<FeaturesCall, v1::FeaturesChunk, codec::FeaturesFragmenter> {
 public:
  absl::Status Begin(ServiceContext&, const v1::GetFeaturesRequest& request,
                     const MeshRegistry::HostPtr& host) {
    std::optional<std::uint64_t> revision;
    if (request.has_revision()) revision = request.revision();
    const int dimension = host->mesh_options().dimension;
    return host->Features(
        revision, cancelled(),
        [call = self(), dimension, host](absl::StatusOr<codec::FeaturesAt> found) {
          if (!found.ok()) return call->Fail(found.status());
          if (absl::Status s = call->CheckRead(*host); !s.ok()) return call->Fail(s);
          call->Stream(*std::move(found), dimension);
        });
  }
};

}  // namespace

grpc::ServerWriteReactor<v1::FeaturesChunk>* StartFeaturesCall(
    ServiceContext& context, const v1::GetFeaturesRequest& request,
    const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
  return FeaturesCall::Start(context, request, pass, rpc);
}

}  // namespace dynmesh::server
