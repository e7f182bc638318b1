#include "server/http/raw_call.h"

#include <vector>

namespace dynmesh::server {

RawCall::~RawCall() {
  if (stream_ != nullptr && !status_.has_value()) {
    context_.TryCancel();
    Finish();
  }
  queue_.Shutdown();
  void* tag = nullptr;
  bool ok = false;
  while (queue_.Next(&tag, &ok)) {
  }
}

bool RawCall::Wait() {
  void* tag = nullptr;
  bool ok = false;
  return queue_.Next(&tag, &ok) && ok;
}

void RawCall::Start(const std::string& method, absl::string_view request) {
  stream_ = stub_.PrepareCall(&context_, method, &queue_);
  stream_->StartCall(this);
  has_ended_ = !Wait();
  if (has_ended_) return;
  const grpc::Slice slice(request.data(), request.size());
  stream_->WriteLast(grpc::ByteBuffer(&slice, 1), {}, this);
  has_ended_ = !Wait();
}

RawCall::Got RawCall::Read(std::string* message, std::chrono::system_clock::time_point deadline) {
  if (has_ended_) return Got::kEnd;
  if (!is_reading_) {
    stream_->Read(&incoming_, this);
    is_reading_ = true;
  }
  void* tag = nullptr;
  bool ok = false;
  if (queue_.AsyncNext(&tag, &ok, deadline) == grpc::CompletionQueue::TIMEOUT) return Got::kNothing;
  is_reading_ = false;
  if (!ok) {
    has_ended_ = true;
    return Got::kEnd;
  }
  std::vector<grpc::Slice> slices;
  (void)incoming_.Dump(&slices);
  message->clear();
  for (const grpc::Slice& slice : slices) {
    message->append(reinterpret_cast<const char*>(slice.begin()), slice.size());
  }
  incoming_.Clear();
  return Got::kMessage;
}

const grpc::Status& RawCall::Finish() {
  if (status_.has_value()) return *status_;
  std::string ignored;
  while (Read(&ignored, std::chrono::system_clock::time_point::max()) != Got::kEnd) {
  }
  status_.emplace();
  stream_->Finish(&*status_, this);
  Wait();
  return *status_;
}

}  // namespace dynmesh::server
