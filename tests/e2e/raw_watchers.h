// Many watchers of one mesh that read their messages as bytes, on one thread and few connections:
// what they cost is little beside the server. Thread-compatible.
#ifndef DYNMESH_TESTS_E2E_RAW_WATCHERS_H_
#define DYNMESH_TESTS_E2E_RAW_WATCHERS_H_

#include <google/protobuf/io/coded_stream.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::test {

class RawWatchers {
 public:
  // `count` watches of `mesh` from `revision` on, which the mesh is at.
  RawWatchers(const std::string& address, const std::string& mesh, std::uint64_t revision,
              int count) {
    constexpr int kConnections = 4;
    for (int i = 0; i < kConnections; ++i) {
      grpc::ChannelArguments arguments;
      arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
      stubs_.push_back(std::make_unique<grpc::GenericStub>(
          grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments)));
    }
    v1::WatchRequest request;
    request.set_mesh("meshes/" + mesh);
    request.set_start_revision(revision);
    const grpc::Slice slice(request.SerializeAsString());
    for (int i = 0; i < count; ++i) {
      auto& w = *watchers_.emplace_back(std::make_unique<Watcher>());
      w.request = grpc::ByteBuffer(&slice, 1);
      w.stream = stubs_[static_cast<std::size_t>(i) % stubs_.size()]->PrepareCall(
          &w.context, "/dynmesh.v1.MeshService/Watch", &queue_);
      w.stream->StartCall(&w);
    }
    thread_ = std::thread([this] { Run(); });
  }
  ~RawWatchers() {
    for (const auto& w : watchers_) w->context.TryCancel();
    thread_.join();
    queue_.Shutdown();
  }

  // All watches are set up.
  bool WaitForOpen() {
    return Wait([this] { return open_ == watchers_.size(); });
  }
  // All watchers received the revision.
  bool WaitFor(std::uint64_t revision) {
    return Wait([&] {
      for (const auto& w : watchers_) {
        if (w->revision < revision) return false;
      }
      return true;
    });
  }
  std::uint64_t messages() {
    const std::lock_guard lock(mutex_);
    return messages_;
  }

 private:
  struct Watcher {
    enum class Step { kStart, kWrite, kHalfClose, kHeaders, kRead, kFinish };
    grpc::ClientContext context;
    std::unique_ptr<grpc::GenericClientAsyncReaderWriter> stream;
    grpc::ByteBuffer request, event;
    grpc::Status status;
    Step step = Step::kStart;
    std::uint64_t revision = 0;
  };

  template <typename Done>
  bool Wait(Done done) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, std::chrono::seconds(60), done);
  }

  // The revision that a watcher is at after the message; 0 if it does not tell. Of a diff, reads
  // the first fields only.
  static std::uint64_t RevisionOf(const grpc::ByteBuffer& event) {
    grpc::Slice slice;
    if (!event.TrySingleSlice(&slice).ok() && !event.DumpToSingleSlice(&slice).ok()) return 0;
    const auto size = static_cast<int>(slice.size());
    google::protobuf::io::CodedInputStream in(slice.begin(), size);
    std::uint64_t value = 0;
    if (in.ReadTag() >> 3 != v1::WatchEvent::kDiffFieldNumber) {
      v1::WatchEvent whole;
      if (!whole.ParseFromArray(slice.begin(), size) || whole.snapshot().more()) return 0;
      return whole.has_snapshot() ? whole.snapshot().revision() : whole.progress().revision();
    }
    if (!in.ReadVarint64(&value)) return 0;
    for (std::uint32_t tag = in.ReadTag(); tag != 0 && (tag & 7) == 0; tag = in.ReadTag()) {
      if (!in.ReadVarint64(&value)) return 0;
      if (tag >> 3 == v1::MeshDiff::kToRevisionFieldNumber) return value;
    }
    return 0;
  }

  void Run() {
    std::size_t ended = 0;
    void* tag = nullptr;
    bool ok = false;
    while (ended < watchers_.size() && queue_.Next(&tag, &ok)) {
      auto& w = *static_cast<Watcher*>(tag);
      using Step = Watcher::Step;
      if (w.step == Step::kFinish) {
        ++ended;
        if (w.status.error_code() != grpc::StatusCode::CANCELLED) {
          std::fprintf(stderr, "a watch ended: %s\n", w.status.error_message().c_str());
          std::exit(1);
        }
        continue;
      }
      if (!ok) {
        w.step = Step::kFinish;
        w.stream->Finish(&w.status, &w);
        continue;
      }
      switch (w.step) {
        case Step::kStart:
          w.step = Step::kWrite;
          w.stream->Write(w.request, &w);
          break;
        case Step::kWrite:
          w.step = Step::kHalfClose;
          w.stream->WritesDone(&w);
          break;
        case Step::kHalfClose:
          w.step = Step::kHeaders;
          w.stream->ReadInitialMetadata(&w);
          break;
        case Step::kHeaders:
        case Step::kRead: {
          const std::uint64_t revision = w.step == Step::kRead ? RevisionOf(w.event) : 0;
          {
            const std::lock_guard lock(mutex_);
            w.step == Step::kHeaders ? ++open_ : ++messages_;
            if (revision != 0) w.revision = revision;
          }
          changed_.notify_all();
          w.step = Step::kRead;
          w.stream->Read(&w.event, &w);
          break;
        }
        case Step::kFinish:
          break;
      }
    }
  }

  std::vector<std::unique_ptr<grpc::GenericStub>> stubs_;
  grpc::CompletionQueue queue_;
  std::vector<std::unique_ptr<Watcher>> watchers_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t open_ = 0;
  std::uint64_t messages_ = 0;
  std::thread thread_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_E2E_RAW_WATCHERS_H_
