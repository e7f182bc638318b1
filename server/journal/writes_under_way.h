// The writing calls of a journal that have not been answered, in the order of their beginning: how
// long the oldest has waited tells of a disk or a database that hangs. And whether new ones are
// refused, as at the end of a drain. O(1) for each call, without an allocation. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_WRITES_UNDER_WAY_H_
#define DYNMESH_SERVER_JOURNAL_WRITES_UNDER_WAY_H_

#include <chrono>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"

namespace dynmesh::server {

class WritesUnderWay {
  using Clock = std::chrono::steady_clock;

 public:
  // A call, from its construction to its destruction. The list outlives it.
  class Write {
   public:
    explicit Write(WritesUnderWay& all) : all_(all) {
      const MutexLock lock(all_.mutex_);
      since_ = Clock::now();
      before_ = all_.newest_;
      (before_ != nullptr ? before_->after_ : all_.oldest_) = this;
      all_.newest_ = this;
    }
    Write(const Write&) = delete;
    Write& operator=(const Write&) = delete;
    ~Write() {
      const MutexLock lock(all_.mutex_);
      (before_ != nullptr ? before_->after_ : all_.oldest_) = after_;
      (after_ != nullptr ? after_->before_ : all_.newest_) = before_;
    }

   private:
    friend class WritesUnderWay;
    WritesUnderWay& all_;
    Clock::time_point since_;
    Write *before_ = nullptr, *after_ = nullptr;
  };

  // From now on ended() is `why`. The first call counts.
  void End(const absl::Status& why) {
    const MutexLock lock(mutex_);
    if (ended_.ok()) ended_ = why;
  }
  // Not OK: what is not handed to the disk or the database yet is refused with this.
  absl::Status ended() const {
    const MutexLock lock(mutex_);
    return ended_;
  }

  // The age of the oldest; zero if there is none.
  absl::Duration Oldest() const {
    const MutexLock lock(mutex_);
    if (oldest_ == nullptr) return absl::ZeroDuration();
    return absl::FromChrono(Clock::now() - oldest_->since_);
  }

 private:
  mutable Mutex mutex_;
  Write* oldest_ ABSL_GUARDED_BY(mutex_) = nullptr;
  Write* newest_ ABSL_GUARDED_BY(mutex_) = nullptr;
  absl::Status ended_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_WRITES_UNDER_WAY_H_
