#include "server/calls/snapshot_call.h"

#include <memory>
#include <utility>

#include "core/mesh_data/region_filter.h"
#include "proto/codec/mesh_codec.h"
#include "server/calls/chunks_call.h"
#include "server/calls/requests.h"

namespace dynmesh::server {
namespace {

class SnapshotCall final
    : public ChunksCall<SnapshotCall, v1::SnapshotChunk, codec::SnapshotFragmenter> {
 public:
  absl::Status Begin(ServiceContext& context, const v1::GetSnapshotRequest& request,
                     const MeshRegistry::HostPtr& host) {
    absl::StatusOr<mesh_data::RegionChoice> regions = DecodeRegions(request.regions());
    if (!regions.ok()) return regions.status();
    context.readers->Post([call = self(), host, regions = *std::move(regions)] {
      auto mesh = host->store()->Latest();
      if (!mesh.ok()) return call->Fail(mesh.status());
      if (absl::Status s = call->CheckRead(*host); !s.ok()) return call->Fail(s);
      if (!regions.IsEverything()) {
        mesh = std::make_shared<const Mesh>(mesh_data::OnlyInside(**mesh, regions));
      }
      call->Stream(*std::move(mesh));
    });
    return absl::OkStatus();
  }
};

}  // namespace

grpc::ServerWriteReactor<v1::SnapshotChunk>* StartSnapshotCall(
    ServiceContext& context, const v1::GetSnapshotRequest& request,
    const absl::StatusOr<Pass>& pass, grpc::CallbackServerContext* rpc) {
  return SnapshotCall::Start(context, request, pass, rpc);
}

}  // namespace dynmesh::server
