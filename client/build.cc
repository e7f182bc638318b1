#include "dynmesh/client/build.h"

#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "client/channel_internal.h"
#include "client/feature_sender_internal.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {
namespace {

using BuildRequest = v1::BuildMeshRequest;
using BuildResponse = v1::BuildMeshResponse;

BuildRequest FirstMessage(const MeshOptions& options, const BuildParams& params) {
  BuildRequest message;
  EncodeNewOptions(options, message.mutable_options());
  message.set_engine(params.engine == BuildEngine::kSvr ? v1::BUILD_ENGINE_SVR
                                                        : v1::BUILD_ENGINE_DYNAMIC);
  message.set_only_inside(params.only_inside);
  if (params.max_time == absl::ZeroDuration()) return message;
  absl::Duration rest;
  message.mutable_max_time()->set_seconds(
      absl::IDivDuration(params.max_time, absl::Seconds(1), &rest));
  message.mutable_max_time()->set_nanos(static_cast<int>(absl::ToInt64Nanoseconds(rest)));
  return message;
}

// One build. The caller's thread sends, a second one receives.
class Builder {
 public:
  Builder(Stub& stub, const MeshOptions& options, const BuildParams& params, absl::Duration timeout)
      : stub_(stub),
        params_(params),
        server_(stub.Of("")),
        stream_(server_->service->BuildMesh(Prepare(stub, timeout))),
        sender_(context_, *stream_, FirstMessage(options, params), options.dimension,
                params.cancelled) {}

  absl::StatusOr<Mesh> Run(std::span<const Feature> features) {
    std::thread receiver([this] { Receive(); });
    sender_.SendAll([&] { return std::exchange(features, {}); });
    receiver.join();
    const absl::Status status = codec::FromGrpcStatus(stream_->Finish());
    // The next build goes to a server that can be reached.
    stub_.Learn("", *server_, status, /*repeatable=*/false);
    if (!status.ok()) return status;
    if (!broken_.ok()) return broken_;
    if (!mesh_.has_value()) return absl::DataLossError("the server sent no whole mesh");
    // The rows must have the hash that came with them.
    if (ComputeHash(*mesh_) != mesh_->hash) {
      return absl::DataLossError("the mesh's rows do not have its hash");
    }
    return *std::move(mesh_);
  }

 private:
  using Stream = grpc::ClientReaderWriter<BuildRequest, BuildResponse>;

  grpc::ClientContext* Prepare(Stub& stub, absl::Duration timeout) {
    stub.Prepare(context_, timeout);
    return &context_;
  }

  // Reads to the end even after an error.
  void Receive() {
    codec::SnapshotAssembler assembler;
    BuildResponse response;
    while (stream_->Read(&response)) {
      if (response.has_mesh()) {
        auto added = assembler.Add(response.mesh());
        broken_.Update(added.status());
        if (added.ok() && added->has_value()) mesh_ = **std::move(added);
      } else if (params_.progress != nullptr) {
        const v1::LoadFeaturesResponse& progress = response.progress();
        params_.progress({StageOf(progress.stage()), progress.done(), progress.total()});
      }
      sender_.IsCancelled();
    }
  }

  Stub& stub_;
  const BuildParams& params_;
  const Stub::ServerPtr server_;
  grpc::ClientContext context_;
  const std::unique_ptr<Stream> stream_;
  FeatureSender<BuildRequest, Stream> sender_;
  std::optional<Mesh> mesh_;
  absl::Status broken_;
};

}  // namespace

absl::StatusOr<Mesh> RunBuild(Stub& stub, std::span<const Feature> features,
                              const MeshOptions& options, const BuildParams& params,
                              absl::Duration timeout) {
  if (absl::Status s = CheckDimension(options.dimension); !s.ok()) return s;
  return Builder(stub, options, params, timeout).Run(features);
}

}  // namespace dynmesh::client
