#include "server/cluster/lease_keeper.h"

#include <utility>

#include "server/base/log.h"

namespace dynmesh::server {

LeaseKeeper::LeaseKeeper(std::chrono::nanoseconds ttl, Calls calls)
    : period_(ttl / 2), retry_(ttl / 10), calls_(std::move(calls)), reads_(ttl), thread_([this] {
        Run();
      }) {}

void LeaseKeeper::Run() {
  bool failing = false;
  MutexLock lock(mutex_);
  while (!stopped_) {
    lock.Unlock();
    const std::chrono::nanoseconds sent = BootTime();
    const absl::Status renewed = calls_.renew();
    if (renewed.ok()) {
      renewed_ = sent.count();  // first: if reads are answered, there is an age
      reads_.Renewed(sent);
    }
    if (failing == renewed.ok()) {
      failing = !failing;
      Log(failing ? LogLevel::kWarning : LogLevel::kInfo,
          failing ? "leases_not_renewed" : "leases_renewed_again", {{"error", renewed.message()}});
    }
    lock.Lock();
    stopping_.WaitFor(mutex_, failing ? retry_ : period_,
                      [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopped_; });
  }
}

std::chrono::nanoseconds LeaseKeeper::Age() const {
  const std::chrono::nanoseconds renewed(renewed_.load());
  return renewed.count() < 0 ? renewed : BootTime() - renewed;
}

void LeaseKeeper::Stop() {
  reads_.End();
  {
    const MutexLock lock(mutex_);
    if (std::exchange(stopped_, true)) return;
  }
  stopping_.NotifyAll();
  thread_.join();
  if (const absl::Status s = calls_.give_up(); !s.ok()) {
    // They run out by themselves.
    Log(LogLevel::kWarning, "leases_not_given_up", {{"error", s.message()}});
  }
}

}  // namespace dynmesh::server
