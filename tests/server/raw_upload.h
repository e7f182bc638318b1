// A raw call that uploads features in parts, to send what the client library would not:
// LoadFeatures or BuildMesh.
#ifndef DYNMESH_TESTS_SERVER_RAW_UPLOAD_H_
#define DYNMESH_TESTS_SERVER_RAW_UPLOAD_H_

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "absl/time/clock.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/mesh_codec.h"

namespace dynmesh::server {

template <class Request, class Response>
class RawUpload {
 public:
  Request& message() { return message_; }
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
  // Returns when the server has received the messages. It reports that with the first message
  // half a second after it began the call: empty ones are sent until then.
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
  grpc::ClientContext& context() { return context_; }

 protected:
  using Stream = std::unique_ptr<grpc::ClientReaderWriter<Request, Response>>;
  // `begin` begins the call; `token` is sent with it, unless empty.
  template <class Begin>
  RawUpload(const std::string& token, Begin begin) {
    if (!token.empty()) context_.AddMetadata("authorization", "Bearer " + token);
    stream_ = begin(&context_);
  }

 private:
  grpc::ClientContext context_;
  Stream stream_;
  Request message_;
  std::vector<Response> responses_;
};

class RawLoad : public RawUpload<v1::LoadFeaturesRequest, v1::LoadFeaturesResponse> {
 public:
  explicit RawLoad(v1::MeshService::Stub& stub, const char* mesh = "meshes/m")
      : RawUpload("", [&](grpc::ClientContext* context) { return stub.LoadFeatures(context); }) {
    message().set_mesh(mesh);
  }
};

class RawBuild : public RawUpload<v1::BuildMeshRequest, v1::BuildMeshResponse> {
 public:
  explicit RawBuild(v1::MeshService::Stub& stub, const std::string& token = "")
      : RawUpload(token, [&](grpc::ClientContext* context) { return stub.BuildMesh(context); }) {}
  // The first message has `options`.
  RawBuild(v1::MeshService::Stub& stub, const MeshOptions& options, const std::string& token = "")
      : RawBuild(stub, token) {
    codec::EncodeOptions(options, message().mutable_options());
    message().mutable_options()->clear_max_vertices();
  }

  // The mesh in the responses, if it is whole.
  std::optional<Mesh> ReceivedMesh() const {
    codec::SnapshotAssembler assembler;
    for (const v1::BuildMeshResponse& response : responses()) {
      if (!response.has_mesh()) continue;
      auto added = assembler.Add(response.mesh());
      if (added.ok() && added->has_value()) return **std::move(added);
    }
    return std::nullopt;
  }
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_RAW_UPLOAD_H_
