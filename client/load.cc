#include "dynmesh/client/load.h"

#include <optional>
#include <thread>
#include <utility>

#include "client/channel_internal.h"
#include "client/feature_sender_internal.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {
namespace {

using LoadResponse = v1::LoadFeaturesResponse;

v1::LoadFeaturesRequest FirstMessage(const std::string& mesh, const LoadParams& params) {
  v1::LoadFeaturesRequest message;
  message.set_mesh(FullName(mesh));
  message.set_request_id(params.request_id);
  if (params.expected_revision.has_value()) {
    message.set_expected_revision(*params.expected_revision);
  }
  return message;
}

// One load. The caller's thread sends, a second one receives.
class Loader {
 public:
  Loader(Stub& stub, const std::string& mesh, const LoadParams& params, absl::Duration timeout)
      : stub_(stub),
        mesh_(FullName(mesh)),
        params_(params),
        server_(stub.Of(mesh_)),
        stream_(server_->service->LoadFeatures(Prepare(stub, timeout))),
        sender_(context_, *stream_, FirstMessage(mesh, params), params.dimension, params.cancelled),
        call_(stub.waiting(), mesh_, server_->address, &context_, /*is_stream=*/true) {}

  absl::StatusOr<LoadResult> Run(const FeatureSource& source) {
    std::thread receiver([this] { Receive(); });
    sender_.SendAll(source);
    receiver.join();
    absl::Status status = codec::FromGrpcStatus(stream_->Finish());
    if (!sender_.IsCancelled()) status = UnlessCancelledHere(std::move(status));
    // The next load goes to the mesh's server.
    stub_.Learn(mesh_, *server_, status, /*repeatable=*/false);
    if (!status.ok()) return status;
    if (!result_.has_value()) return absl::DataLossError("the server sent no result");
    absl::StatusOr<MeshHash> hash = MeshHash::FromHex(result_->hash());
    if (!hash.ok()) return absl::DataLossError("the server sent a hash that is none");
    return LoadResult{result_->from_revision(), result_->to_revision(), *hash,
                      codec::DecodeWork(result_->work()), result_->replayed()};
  }

 private:
  using Stream = grpc::ClientReaderWriter<v1::LoadFeaturesRequest, LoadResponse>;

  grpc::ClientContext* Prepare(Stub& stub, absl::Duration timeout) {
    stub.Prepare(context_, timeout);
    return &context_;
  }

  void Receive() {
    LoadResponse response;
    while (stream_->Read(&response)) {
      call_.Heard(/*more=*/false);
      if (response.has_result()) {
        result_ = std::move(*response.mutable_result());
      } else if (params_.progress != nullptr) {
        params_.progress({StageOf(response.stage()), response.done(), response.total()});
      }
      sender_.IsCancelled();
    }
  }

  Stub& stub_;
  const std::string mesh_;
  const LoadParams& params_;
  const Stub::ServerPtr server_;
  grpc::ClientContext context_;
  const std::unique_ptr<Stream> stream_;
  FeatureSender<v1::LoadFeaturesRequest, Stream> sender_;
  WaitingCalls::Call call_;
  std::optional<v1::LoadResult> result_;
};

}  // namespace

LoadProgress::Stage StageOf(LoadResponse::Stage stage) {
  switch (stage) {
    case LoadResponse::WAITING:
      return LoadProgress::Stage::kWait;
    case LoadResponse::VALIDATING:
      return LoadProgress::Stage::kValidate;
    case LoadResponse::REFINING:
      return LoadProgress::Stage::kRefine;
    case LoadResponse::DIFFING:
      return LoadProgress::Stage::kDiff;
    case LoadResponse::JOURNALING:
      return LoadProgress::Stage::kWrite;
    default:
      return LoadProgress::Stage::kSend;
  }
}

absl::StatusOr<LoadResult> RunLoad(Stub& stub, const std::string& mesh, const FeatureSource& source,
                                   const LoadParams& params, absl::Duration timeout) {
  if (absl::Status s = CheckDimension(params.dimension); !s.ok()) return s;
  stub.Resolve(FullName(mesh), timeout);  // `source` cannot be read again
  return Loader(stub, mesh, params, timeout).Run(source);
}

}  // namespace dynmesh::client
