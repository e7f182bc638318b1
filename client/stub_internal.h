// The servers that a client knows, and which of them has which mesh. A mesh that several servers
// share is one server's at a time: the others answer NOT_OWNER and name it. So the client goes
// there and remembers it; if it cannot be reached, the client asks the others
// (waiting_calls_internal.h says what happens if it does not answer). Includes gRPC, which no
// public header may do. Thread-safe.
#ifndef DYNMESH_CLIENT_STUB_INTERNAL_H_
#define DYNMESH_CLIENT_STUB_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "client/connector_internal.h"
#include "client/waiting_calls_internal.h"
#include "core/base/mutex.h"
#include "dynmesh/v1/mesh_service.grpc.pb.h"
#include "proto/codec/status_codec.h"

namespace dynmesh::client {

// The end of a call that was not cancelled here. A server that shuts down cancels the calls that
// reach it before its clients have noticed: it is not available. It cancels streams, too, whose
// token lost the right that they need: the next attempt tells that.
inline absl::Status UnlessCancelledHere(absl::Status status) {
  if (!absl::IsCancelled(status) || codec::GetServiceError(status).has_value()) return status;
  return absl::UnavailableError(
      "the server ended the call: it shuts down, or the token lost the right to it");
}

class Stub {
 public:
  struct Server {
    std::string address;
    std::shared_ptr<grpc::Channel> channel;
    std::unique_ptr<v1::MeshService::Stub> service;

    // Connects at the next call, however long gRPC would wait after failures: another server says
    // that this one is there.
    void ConnectNow() const { grpc::experimental::ChannelResetConnectionBackoff(channel.get()); }
  };
  using ServerPtr = std::shared_ptr<const Server>;
  using Service = v1::MeshService::Stub;
  // After a call ended: it is over, or to be made again at Of.
  enum class Next { kOver, kAtOnce, kAfterPause };

  // `addresses`: HOST:PORT, with commas between.
  Stub(const std::string& addresses, std::shared_ptr<grpc::ChannelCredentials> credentials,
       const grpc::ChannelArguments& arguments, const std::string& token, bool from_followers);

  // The server to ask for the mesh, by its full name; for an empty name one that answers.
  ServerPtr Of(const std::string& mesh);

  // What a read of the mesh gives to Of, Learn and Follow: the mesh's full name, or, if the answer
  // may be a follower's, a name of its own, as that server need not be the mesh's.
  std::string ReadKey(const std::string& mesh) const {
    return from_followers_ ? "read of " + mesh : mesh;
  }
  // The next read asks the first server again, not the one that it was sent to.
  void Forget(const std::string& key);
  // The client got that revision of the mesh: later reads are not to be older.
  void Saw(const std::string& mesh, std::uint64_t revision);
  // Says in the request that the answer may be a follower's, if so. `revision`: the answer's least.
  template <class Request>
  void AskFollowers(Request* request, std::uint64_t revision = 0) const {
    if (!from_followers_) return;
    const MutexLock lock(mutex_);
    const auto seen = seen_.find(request->mesh());
    request->set_min_revision(std::max(revision, seen == seen_.end() ? 0 : seen->second));
  }

  // To be called before the call begins. `redirects`: how often it was sent to another server.
  void Prepare(grpc::ClientContext& context, absl::Duration timeout = absl::InfiniteDuration(),
               int redirects = 0) const;

  // A call about `mesh` to the server `asked` ended with `status`. `repeatable`: it may be made
  // again although it may have had its effect.
  Next Learn(const std::string& mesh, const Server& asked, const absl::Status& status,
             bool repeatable);

  // True if there is more than one server.
  bool is_shared() const;

  // For WaitingCalls.

  // Null unless there is more than one server.
  WaitingCalls* waiting() { return is_shared() ? &waiting_ : nullptr; }
  // A server that is known, by chance; empty if there is no other.
  std::string AddressOtherThan(const std::string& address) const;
  bool Knows(const std::string& address) const;
  ServerPtr At(const std::string& address);
  // The server at `address` has the mesh.
  void Moved(const std::string& mesh, const std::string& address);

  Connector& connector() { return connector_; }

  // Runs `run(service, context)`, which returns a status or a value, where the mesh is: a bounded
  // number of times, with pauses, until `timeout`.
  template <class Run>
  auto Follow(const std::string& mesh, bool repeatable, absl::Duration timeout, const Run& run);

  // For a call that cannot be made twice: finds the server of the mesh first, if there are several.
  void Resolve(const std::string& mesh, absl::Duration timeout);

 private:
  static constexpr int kMostAttempts = 60, kMostAttemptsOfOne = 4;

  static const absl::Status& StatusOf(const absl::Status& status) { return status; }
  template <class T>
  static const absl::Status& StatusOf(const absl::StatusOr<T>& value) {
    return value.status();
  }
  ServerPtr AtLocked(const std::string& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void AvoidLocked(const std::string& mesh, const std::string& address)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const std::shared_ptr<grpc::ChannelCredentials> credentials_;
  const grpc::ChannelArguments arguments_;
  const std::string authorization_;
  const bool from_followers_;

  mutable Mutex mutex_;
  std::vector<std::string> known_ ABSL_GUARDED_BY(mutex_);  // given or named by a server
  std::size_t first_ ABSL_GUARDED_BY(mutex_) = 0;  // of known_: asked for a mesh without a route
  // The address of a mesh's server.
  std::map<std::string, std::string> routes_ ABSL_GUARDED_BY(mutex_);
  // Revisions, if reads may be a follower's.
  std::map<std::string, std::uint64_t> seen_ ABSL_GUARDED_BY(mutex_);
  std::map<std::string, ServerPtr> servers_ ABSL_GUARDED_BY(mutex_);  // by address

  Connector connector_;
  WaitingCalls waiting_{this};
};

template <class Run>
auto Stub::Follow(const std::string& mesh, bool repeatable, absl::Duration timeout,
                  const Run& run) {
  constexpr absl::Duration kFirst = absl::Milliseconds(20), kLongest = absl::Milliseconds(200);
  const absl::Time end = absl::Now() + timeout;
  absl::Duration pause = kFirst;
  int redirects = 0;
  for (int attempt = 1;; ++attempt) {
    const ServerPtr server = Of(mesh);
    grpc::ClientContext context;
    Prepare(context, end - absl::Now(), redirects);
    auto result = [&] {
      // Another server may do what this one was asked for.
      const WaitingCalls::Call call(repeatable ? waiting() : nullptr, mesh, server->address,
                                    &context);
      return run(*server->service, context);
    }();
    if (absl::IsCancelled(StatusOf(result))) result = UnlessCancelledHere(StatusOf(result));
    const Next next = Learn(mesh, *server, StatusOf(result), repeatable);
    if (next == Next::kOver) return result;
    if (attempt >= (is_shared() ? kMostAttempts : kMostAttemptsOfOne)) return result;
    if (next == Next::kAtOnce) {
      Of(mesh)->ConnectNow();
      if (++redirects <= 3) continue;
    }
    if (next == Next::kAfterPause) redirects = 0;
    if (absl::Now() + pause >= end) return result;
    connector_.Pause(pause);
    pause = std::min(1.5 * pause, kLongest);
  }
}

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_STUB_INTERNAL_H_
