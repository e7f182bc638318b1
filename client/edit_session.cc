#include "dynmesh/client/edit_session.h"

#include <atomic>
#include <optional>
#include <utility>

#include "client/channel_internal.h"
#include "proto/codec/edit_codec.h"
#include "proto/codec/grpc_status.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::client {
namespace {

class GrpcEditSession final : public EditSession {
 public:
  GrpcEditSession(std::shared_ptr<Stub> stub, std::string mesh, bool stop_on_error,
                  absl::Duration timeout)
      : stub_(std::move(stub)), mesh_(std::move(mesh)), stop_on_error_(stop_on_error) {
    stub_->Resolve(FullName(mesh_), timeout);
    server_ = stub_->Of(FullName(mesh_));
    stub_->Prepare(context_, timeout);
    call_.emplace(stub_->waiting(), FullName(mesh_), server_->address, &context_,
                  /*is_stream=*/true);
    stream_ = server_->service->EditStream(&context_);
  }

  ~GrpcEditSession() override {
    if (finished_) return;
    context_.TryCancel();
    v1::MeshDiff message;
    while (stream_->Read(&message)) {
    }
    stream_->Finish();
  }

  absl::Status Send(const EditBatch& edits, const EditParams& params) override {
    if (absl::Status s = CheckDimension(params.dimension); !s.ok()) return s;
    std::size_t next = 0;
    ++unanswered_;
    do {
      const std::size_t end = PartEnd<Edit>(edits, next);
      message_.Clear();
      if (next == 0) BeginMessage(params);
      for (; next < end; ++next) {
        codec::EncodeEdit(edits[next], params.dimension, message_.add_edits());
      }
      message_.set_more(next < edits.size());
      if (!stream_->Write(message_)) {
        return absl::UnavailableError("the stream has ended: receive what is left, then finish");
      }
    } while (next < edits.size());
    call_->Expect();
    return absl::OkStatus();
  }

  absl::Status DoneSending() override {
    if (stream_->WritesDone()) return absl::OkStatus();
    return absl::UnavailableError("the stream has ended");
  }

  std::optional<Answer> Receive() override {
    while (stream_->Read(&answer_)) {
      if (answer_.status().code() != 0) {
        results_.assembler.Reset();
        Answered();
        return Answer{answer_.request_id(), Learned(codec::StatusFromProto(answer_.status()))};
      }
      auto result = results_.Add(answer_);
      if (result.ok() && !result->has_value()) {
        call_->Heard(/*more=*/true);
        continue;
      }
      Answered();
      if (!result.ok()) return Answer{answer_.request_id(), result.status()};
      return Answer{answer_.request_id(), **std::move(result)};
    }
    return std::nullopt;
  }

  absl::Status Finish() override {
    finished_ = true;
    const absl::Status status = codec::FromGrpcStatus(stream_->Finish());
    return Learned(cancelled_ ? status : UnlessCancelledHere(status));
  }

  void Cancel() override {
    cancelled_ = true;
    context_.TryCancel();
  }

 private:
  // Should a batch be sent at this moment, its answer may not be waited for: as a stream the
  // session is looked after anyway.
  void Answered() { call_->Heard(/*more=*/--unanswered_ > 0); }

  // The next session goes to the mesh's server.
  absl::Status Learned(const absl::Status& status) const {
    stub_->Learn(FullName(mesh_), *server_, status, /*repeatable=*/false);
    return status;
  }

  void BeginMessage(const EditParams& params) {
    if (!named_) {
      message_.set_mesh(FullName(mesh_));
      message_.set_stop_on_error(stop_on_error_);
      named_ = true;
    }
    message_.set_request_id(params.request_id);
    if (params.expected_revision.has_value()) {
      message_.set_expected_revision(*params.expected_revision);
    }
    message_.set_validate_only(params.validate_only);
    message_.set_omit_columns(params.omit_columns);
  }

  const std::shared_ptr<Stub> stub_;
  const std::string mesh_;
  const bool stop_on_error_;
  Stub::ServerPtr server_;
  grpc::ClientContext context_;
  std::optional<WaitingCalls::Call> call_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::EditBatch, v1::MeshDiff>> stream_;
  std::atomic<int> unanswered_{0};  // batches
  bool named_ = false;
  bool finished_ = false;
  std::atomic<bool> cancelled_{false};
  v1::EditBatch message_;  // used by the sender
  v1::MeshDiff answer_;    // used by the receiver
  ResultAssembler results_;
};

}  // namespace

std::unique_ptr<EditSession> StartEditSession(std::shared_ptr<Stub> stub, const std::string& mesh,
                                              bool stop_on_error, absl::Duration timeout) {
  return std::make_unique<GrpcEditSession>(std::move(stub), mesh, stop_on_error, timeout);
}

}  // namespace dynmesh::client
