// The connections of a server by the address of their client, and what one address may have of
// them.
//
// gRPC 1.51 does not count calls that a client resets, and none that it refuses. A client without
// a token can so send calls faster than they are refused, on any number of connections, and the
// calls of others wait behind these. So calls that were for nothing are counted here. When an
// address has had too many in a second, its connections that brought them are cut, with what they
// have sent, and its new ones are refused for a second. gRPC queues calls faster than it handles
// them, so what counts is how many connections enter before the first calls are counted:
//   * of an address without an answered call in the last ten minutes, one at a time: the next one
//     when a call of the last one was answered, it was cut or closed, or after a fifth of a second;
//   * of other addresses, those without an answered call at a limited rate: each costs a handshake.
//     An answered call gives the place back, so a host with hundreds of clients does not wait;
//   * of an address that was refused, for half of a minute one at a time, as those of a new
//     address, but however long that takes.
// Those that are too many wait here.
//
// gRPC has the connections and closes them. The table knows each by its descriptor and the kernel's
// number of its socket: a descriptor alone may be another one's by now. (A duplicate would keep the
// socket in gRPC's epoll set after gRPC has closed it, and its events would come to a later
// connection.) A connection is cut for one of its own calls, as gRPC keeps it open that long. What
// has been closed is noticed when there is no room. Thread-safe. A call costs a lock and a look-up,
// and only a wasted one or the first answered one of a connection.
#ifndef DYNMESH_SERVER_ACCESS_CONNECTION_TABLE_H_
#define DYNMESH_SERVER_ACCESS_CONNECTION_TABLE_H_

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/mutex.h"
#include "server/access/peer_key.h"

namespace dynmesh::server {

class ConnectionTable {
 public:
  using Clock = std::chrono::steady_clock;
  using Time = Clock::time_point;

  struct Limits {
    std::uint64_t per_address = 10'000;                  // connections, those that wait included
    double new_per_second = 0;                           // 0: no limit
    double wasted_per_second = 0;                        // 0: no limit
    Clock::duration silence = std::chrono::seconds(20);  // of a connection that waits
  };
  struct Counts {
    std::size_t open = 0;  // at most: some may have been closed
    std::size_t waiting = 0;
    std::uint64_t refused = 0;  // so far, of addresses that may have no more
    std::uint64_t cut = 0;      // so far
    std::uint64_t wasted = 0;   // calls so far
  };
  enum class Arrival { kEnters, kWaits, kRefused };
  // Names a socket for good.
  struct Socket {
    int descriptor = -1;
    std::uint64_t cookie = 0;  // the kernel's, SO_COOKIE
    friend bool operator==(const Socket&, const Socket&) = default;
  };
  struct Waiting {
    int socket = -1;
    PeerKey peer;
    Time since;
  };
  // kSilent: it has sent nothing yet. kLeft: it has closed its end.
  enum class Sender { kReady, kSilent, kLeft };

  // With a lock held.
  struct System {
    // Ends a connection and drops what it has received, unless it has been closed.
    std::function<void(const Socket&)> cut;
    // False if it has been closed.
    std::function<bool(const Socket&)> is_open;
  };
  ConnectionTable(const Limits& limits, System system)
      : limits_(limits), system_(std::move(system)) {}

  // --- By the acceptor -------------------------------------------------------------------------

  // A connection has come. kWaits: the table keeps the socket until TakeReady. kRefused: the
  // address has as many as it may have, or as may wait, or has had too many wasted calls.
  Arrival Arrive(const Waiting& connection, Time now);
  // It is open. Replaces what had its descriptor before.
  void Enter(const PeerKey& peer, const Socket& socket, Time now);
  // Forgets the connections that have been closed. O(connections).
  void Sweep();
  struct Ready {
    std::vector<Waiting> enter;  // Enter each
    std::vector<int> close;      // clients that have left, were silent for too long, or are refused
  };
  // What is to be done about connections that wait. `look` says what a socket's client does; it is
  // called with a lock held. Those that are silent do not delay others. The newest enter first: so
  // one that comes after an attack does not wait behind what is left of it.
  Ready TakeReady(Time now, const std::function<Sender(int)>& look);
  bool HasWaiting() const;
  // The sockets that still wait.
  std::vector<int> TakeWaiting();

  // --- By calls --------------------------------------------------------------------------------

  // False: no connection needs Answered.
  bool HasUnanswered() const { return unanswered_.load(std::memory_order_relaxed) > 0; }
  // A call on the connection was answered. True if one that waits may now enter.
  bool Answered(const PeerKey& peer, Time now);
  // A call on the connection was for nothing. True if the connection was cut for it.
  bool Wasted(const PeerKey& peer, Time now);

  Counts counts() const;
  std::size_t addresses() const;  // that are remembered

 private:
  // Capacity: the amount of `seconds`, at least 1. Full at first.
  class Bucket {
   public:
    explicit Bucket(double seconds) : seconds_(seconds) {}
    bool Take(double rate, Time now);
    void GiveBack(double rate);
    bool IsFull(double rate, Time now);

   private:
    double Most(double rate) const;
    void Fill(double rate, Time now);
    const double seconds_;
    std::optional<double> left_;
    Time filled_;
  };
  struct Address {
    // One entry of a new connection costs far more than a wasted call.
    Bucket fresh{0.4}, wasted{1};
    Time blocked_until, probation_until;
    Time known_until;  // it had an answered call
    Time entered;      // the last connection
    Time swept;
    std::size_t unanswered = 0;  // connections without an answered call, that are not cut
    std::deque<Waiting> waiting;
    absl::flat_hash_set<int> descriptors;
  };
  struct Connection {
    PeerKey peer;
    std::uint64_t cookie = 0;
    bool is_answered = false;
    bool is_cut = false;
    std::uint64_t wasted = 0;  // calls since second_
    Time second;
  };

  Address& AddressOfLocked(const PeerKey& peer, Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  static constexpr std::size_t kMostWaiting = 1'000;  // of one address

  // Enters no connection of the address beside one that has no answered call.
  bool EntersAlone(const Address& address, Time now) const {
    return now < address.probation_until ||
           (limits_.new_per_second > 0 && now >= address.known_until);
  }
  bool IsOneUnderWayLocked(const Address& address, Time now) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  bool MayEnterLocked(Address& address, Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ForgetLocked(int descriptor) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SweepIfDueLocked(Address& address, Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void SweepLocked(const Address& address) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void ForgetAddressesLocked(Time now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const Limits limits_;
  const System system_;
  mutable Mutex mutex_;
  // Pointers stay valid.
  absl::flat_hash_map<PeerKey, std::unique_ptr<Address>> addresses_ ABSL_GUARDED_BY(mutex_);
  absl::flat_hash_map<int, Connection> connections_ ABSL_GUARDED_BY(mutex_);
  absl::flat_hash_map<PeerKey, int> descriptors_ ABSL_GUARDED_BY(mutex_);
  // Number of addresses at which unused ones are removed.
  std::size_t sweep_at_ ABSL_GUARDED_BY(mutex_) = 1024;
  Counts counts_ ABSL_GUARDED_BY(mutex_);
  std::atomic<std::size_t> unanswered_{0};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_CONNECTION_TABLE_H_
