// A raw BuildMesh call, to send what the client library would not.
#ifndef DYNMESH_TESTS_SERVER_RAW_BUILD_H_
#define DYNMESH_TESTS_SERVER_RAW_BUILD_H_

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

#include "absl/time/clock.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::server {

class RawBuild {
 public:
  using Response = v1::BuildMeshResponse;

  explicit RawBuild(v1::MeshService::Stub& stub) : stream_(stub.BuildMesh(&context_)) {}
  // The first message has `options`.
  RawBuild(v1::MeshService::Stub& stub, const MeshOptions& options) : RawBuild(stub) {
    codec::EncodeOptions(options, message_.mutable_options());
    message_.mutable_options()->clear_max_vertices();
  }

  v1::BuildMeshRequest& message() { return message_; }
  void Add(const Feature& feature) { codec::EncodeFeature(feature, 2, message_.add_features()); }
  bool Send() {
    const bool ok = stream_->Write(message_);
    message_.Clear();
    return ok;
  }
  void HalfClose() { stream_->WritesDone(); }
  std::optional<Response> Receive() {
    Response response;
    if (!stream_->Read(&response)) return std::nullopt;
    return response;
  }
  // The first report: with the first message half a second after the server began the call. Empty
  // ones are sent until then.
  std::optional<Response> WaitUntilReceived() {
    std::atomic<bool> reported{false};
    std::thread sender([&] {
      while (!reported && Send()) absl::SleepFor(absl::Milliseconds(50));
    });
    auto response = Receive();
    reported = true;
    sender.join();
    return response;
  }
  // Reads to the end and returns the status; messages before it go to responses().
  absl::Status Finish() {
    while (auto response = Receive()) responses_.push_back(*std::move(response));
    return codec::FromGrpcStatus(stream_->Finish());
  }
  bool SendLast() {
    message_.set_last(true);
    return Send();
  }
  absl::Status SendLastAndFinish() {
    SendLast();
    HalfClose();
    return Finish();
  }
  const std::vector<Response>& responses() const { return responses_; }
  // The mesh in the responses, if it is whole.
  std::optional<Mesh> ReceivedMesh() const {
    codec::SnapshotAssembler assembler;
    for (const Response& response : responses_) {
      if (!response.has_mesh()) continue;
      auto added = assembler.Add(response.mesh());
      if (added.ok() && added->has_value()) return **std::move(added);
    }
    return std::nullopt;
  }
  grpc::ClientContext& context() { return context_; }

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::BuildMeshRequest, Response>> stream_;
  v1::BuildMeshRequest message_;
  std::vector<Response> responses_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_RAW_BUILD_H_
