// Connects again to servers that could not be reached, in a thread of its own, while there are any.
//
// gRPC does so, too, but late. It looks at a connection only while a call waits for it, and else
// every 5 s; after a failure it ends calls at once instead of letting them wait. So after an outage
// of a second no call succeeds for up to ten, however often it is repeated. Here a thread waits for
// the connection instead of the calls, and decides when the next attempt is due
// (backoff_internal.h).
//
// Thread-safe.
#ifndef DYNMESH_CLIENT_CONNECTOR_INTERNAL_H_
#define DYNMESH_CLIENT_CONNECTOR_INTERNAL_H_

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <thread>

#include "absl/time/time.h"
#include "client/backoff_internal.h"
#include "core/base/mutex.h"

namespace dynmesh::client {

class Connector {
 public:
  Connector() = default;
  // Waits for the thread, 0.1 s at most.
  ~Connector();
  Connector(const Connector&) = delete;
  Connector& operator=(const Connector&) = delete;

  // A call found that the server at the other end cannot be reached. Attempts go on until one
  // succeeds, or no call has asked for the server for half a minute.
  void Reach(const std::shared_ptr<grpc::Channel>& channel);

  // Waits for `limit`, or until a server that could not be reached can be.
  void Pause(absl::Duration limit);

  // How often a server that could not be reached could be.
  std::uint64_t reached();

  // `reached` is called each time that a server that could not be reached can be, by the
  // connector's thread, until Unlisten(owner) has returned. It must not call the connector.
  void Listen(const void* owner, std::function<void()> reached);
  void Unlisten(const void* owner);

 private:
  using Clock = Backoff::Clock;
  struct Target {
    std::shared_ptr<grpc::Channel> channel;
    Backoff backoff;
    Clock::time_point next;    // attempt
    Clock::time_point wanted;  // until then
    bool has_failed = false;   // an attempt, not only the connection before
    bool is_watched = false;   // gRPC tells when its state has changed
  };

  void Run();
  // Looks at all targets that are not watched. True if one was reached.
  bool Step(grpc::CompletionQueue& changes) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  // True if it is over.
  bool Advance(Target& target, bool* reached, grpc::CompletionQueue& changes) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  Mutex mutex_;
  CondVar wake_, counted_;
  std::map<const grpc::Channel*, Target> targets_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t count_ ABSL_GUARDED_BY(mutex_) = 0;  // of servers reached
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;

  Mutex listeners_mutex_;  // before any lock of a listener
  std::map<const void*, std::function<void()>> listeners_ ABSL_GUARDED_BY(listeners_mutex_);

  std::thread thread_ ABSL_GUARDED_BY(mutex_);  // runs from the first failure on
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_CONNECTOR_INTERNAL_H_
