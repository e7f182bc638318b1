// When to try again what has failed, such as to reach a server. A pause is about a third of the
// time since the first failure. So the next try comes soon after the fault has ended, measured by
// how long it lasted, and one that lasts is asked rarely. Does not depend on gRPC.
#ifndef DYNMESH_CLIENT_BACKOFF_INTERNAL_H_
#define DYNMESH_CLIENT_BACKOFF_INTERNAL_H_

#include <algorithm>
#include <chrono>
#include <optional>
#include <random>

#include "absl/time/time.h"

namespace dynmesh::client {

// Thread-compatible.
class Backoff {
 public:
  using Clock = std::chrono::steady_clock;

  // The shortest and the longest pause, but for chance.
  Backoff(absl::Duration shortest, absl::Duration longest)
      : shortest_(shortest), longest_(longest) {}

  // The pause after a failure at `now`. `chance`, in [0, 1), makes it up to a fifth shorter or
  // longer: clients that have lost the same server do not all come back at the same moment.
  absl::Duration Failed(Clock::time_point now, double chance) {
    if (!since_.has_value()) since_ = now;
    const absl::Duration third = 0.3 * absl::FromChrono(now - *since_);
    return (0.8 + 0.4 * chance) * std::clamp(third, std::min(shortest_, longest_), longest_);
  }
  // The same, now.
  absl::Duration Failed() { return Failed(Clock::now(), Chance()); }
  // The next failure is the first again.
  void Succeeded() { since_.reset(); }

 private:
  static double Chance() {
    thread_local std::minstd_rand random{std::random_device()()};
    return std::uniform_real_distribution<double>()(random);
  }

  const absl::Duration shortest_, longest_;
  std::optional<Clock::time_point> since_;  // the first failure
};

}  // namespace dynmesh::client

#endif  // DYNMESH_CLIENT_BACKOFF_INTERNAL_H_
