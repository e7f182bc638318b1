// One call with one request, by bytes: its messages are not looked at. By one thread.
#ifndef DYNMESH_SERVER_HTTP_RAW_CALL_H_
#define DYNMESH_SERVER_HTTP_RAW_CALL_H_

#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

class RawCall {
 public:
  enum class Got { kMessage, kEnd, kNothing };

  // Metadata and the deadline are set in `context` before Start.
  explicit RawCall(const std::shared_ptr<grpc::Channel>& channel) : stub_(channel) {}
  // Cancels it, if it has not ended.
  ~RawCall();
  RawCall(const RawCall&) = delete;
  RawCall& operator=(const RawCall&) = delete;

  grpc::ClientContext& context() { return context_; }
  // `method` as /package.Service/Method.
  void Start(const std::string& method, absl::string_view request);
  // The next message. kNothing: none has come by the deadline. kEnd: there is none any more.
  Got Read(std::string* message, std::chrono::system_clock::time_point deadline);
  // Reads until the end. The status; the same when called again.
  const grpc::Status& Finish();

 private:
  // Waits for the operation that was begun last. False: it failed.
  bool Wait();

  grpc::GenericStub stub_;
  grpc::ClientContext context_;
  grpc::CompletionQueue queue_;
  std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream_;
  grpc::ByteBuffer incoming_;
  bool is_reading_ = false;
  bool has_ended_ = false;
  std::optional<grpc::Status> status_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_RAW_CALL_H_
