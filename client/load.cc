#include "dynmesh/client/load.h"

#include <thread>
#include <utility>

#include "client/channel_internal.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::client {
namespace {

using Response = v1::LoadFeaturesResponse;

constexpr std::size_t kPointBytes = 34;  // upper bound of a row

LoadProgress::Stage StageOf(Response::Stage stage) {
  switch (stage) {
    case Response::WAITING:
      return LoadProgress::Stage::kWait;
    case Response::VALIDATING:
      return LoadProgress::Stage::kValidate;
    case Response::REFINING:
      return LoadProgress::Stage::kRefine;
    case Response::DIFFING:
      return LoadProgress::Stage::kDiff;
    case Response::JOURNALING:
      return LoadProgress::Stage::kWrite;
    default:
      return LoadProgress::Stage::kSend;
  }
}

// One load. The caller's thread sends, a second one receives.
class Loader {
 public:
  Loader(Stub& stub, const std::string& mesh, const LoadParams& params, absl::Duration timeout)
      : params_(params) {
    stub.Prepare(context_, timeout);
    stream_ = stub.service->LoadFeatures(&context_);
    message_.set_mesh(FullName(mesh));
    message_.set_request_id(params.request_id);
    if (params.expected_revision.has_value()) {
      message_.set_expected_revision(*params.expected_revision);
    }
  }

  absl::StatusOr<LoadResult> Run(const FeatureSource& source) {
    std::thread receiver([this] { Receive(); });
    SendAll(source);
    receiver.join();
    const grpc::Status status = stream_->Finish();
    if (!status.ok()) return codec::FromGrpcStatus(status);
    if (!result_.has_value()) return absl::DataLossError("the server sent no result");
    absl::StatusOr<MeshHash> hash = MeshHash::FromHex(result_->hash());
    if (!hash.ok()) return absl::DataLossError("the server sent a hash that is none");
    return LoadResult{result_->from_revision(), result_->to_revision(), *hash,
                      codec::DecodeWork(result_->work()), result_->replayed()};
  }

 private:
  // Ends early if the stream ends; Finish reports why.
  void SendAll(const FeatureSource& source) {
    for (auto some = source(); !some.empty(); some = source()) {
      for (const Feature& feature : some) {
        if (!Add(feature)) return;
      }
    }
    message_.set_last(true);
    if (Write()) stream_->WritesDone();
  }

  // Keeps the order of features: the points of a message precede its other features.
  bool Add(const Feature& feature) {
    if (feature.kind == FeatureKind::kPoint && message_.features_size() == 0) {
      codec::EncodePointRow(feature, params_.dimension, message_.mutable_points());
      bytes_ += kPointBytes;
    } else {
      codec::EncodeFeature(feature, params_.dimension, message_.add_features());
      bytes_ += WireBytes(feature);
    }
    return bytes_ < kMessageBytes || Write();
  }

  bool Write() {
    if (IsCancelled()) return false;
    const bool ok = stream_->Write(message_);
    message_.Clear();
    bytes_ = 0;
    return ok;
  }

  void Receive() {
    Response response;
    while (stream_->Read(&response)) {
      if (response.has_result()) {
        result_ = std::move(*response.mutable_result());
      } else if (params_.progress != nullptr) {
        params_.progress({StageOf(response.stage()), response.done(), response.total()});
      }
      IsCancelled();
    }
  }

  bool IsCancelled() {
    if (params_.cancelled == nullptr || !params_.cancelled->load()) return false;
    context_.TryCancel();
    return true;
  }

  const LoadParams& params_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::LoadFeaturesRequest, Response>> stream_;
  v1::LoadFeaturesRequest message_;  // used by the sender
  std::size_t bytes_ = 0;            // upper bound of its size
  std::optional<v1::LoadResult> result_;
};

}  // namespace

absl::StatusOr<LoadResult> RunLoad(Stub& stub, const std::string& mesh, const FeatureSource& source,
                                   const LoadParams& params, absl::Duration timeout) {
  if (absl::Status s = CheckDimension(params.dimension); !s.ok()) return s;
  return Loader(stub, mesh, params, timeout).Run(source);
}

}  // namespace dynmesh::client
