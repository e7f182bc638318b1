// Makes the snapshots of a server's meshes for the journal, one at a time, while their edits go on.
//
// Nothing is copied from a mesh. The features of a revision are those of the journal's newest
// generation, changed by the batches up to that revision: they are read back from there (*taken*),
// encoded, and written as the next generation. So the mesh's strand only asks for it, at no cost;
// batches that are appended meanwhile follow the snapshot. Until it is complete, the generation
// before is the newest, and a mesh is recovered from that.
//
// Threads: a background thread takes and encodes. Another one, of normal priority, writes, as
// appends wait for each of its transactions. Memory: of one mesh the generation's bytes and the
// features, decoded; then the snapshot's bytes. Thread-safe.
#ifndef DYNMESH_SERVER_JOURNAL_SNAPSHOTS_H_
#define DYNMESH_SERVER_JOURNAL_SNAPSHOTS_H_

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "core/base/mutex.h"
#include "dynmesh/codec/features_at.h"
#include "server/base/worker_pool.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

class PastFeatures;

class Snapshots {
 public:
  // A snapshot that was made, or was not.
  struct Made {
    absl::Status status;      // OK: it is in the journal
    bool unreadable = false;  // not OK, since the journal's features cannot be read
    std::uint64_t bytes = 0;
    double take = 0, encode = 0, write = 0;  // seconds of wall clock, waits included
  };
  struct Order {
    Journal::Key key = 0;
    int dimension = 2;
    std::uint64_t revision = 0;  // one that the journal has
    // Those of that revision, in place of the journal's. For a journal that cannot be read.
    std::optional<codec::FeaturesAt> features;
    // True: it is not wanted any more. The work ends soon, with CANCELLED, as it does at Stop,
    // which sets it.
    std::shared_ptr<std::atomic<bool>> ended;
    // Called once, on a thread of this object.
    std::function<void(const Made&)> done;
  };

  // The journal outlives this object, until Stop. `observe` is called with each snapshot that was
  // made; it may be null.
  explicit Snapshots(Journal* journal, std::function<void(const Made&)> observe = nullptr);
  // As Stop.
  ~Snapshots() { Stop(); }

  // Makes a snapshot after those that were ordered before. At most one of a mesh at a time.
  void Make(Order order);
  // Blocks until none is being made or waits. For tests.
  void Wait();
  // Ends what is being made or waits, and joins the threads. What is ordered later ends at once.
  void Stop();

 private:
  Made Work(Order& order);
  absl::Status ReadBack(const Order& order, PastFeatures& past) const;
  absl::Status Take(const Order& order, std::vector<std::string>* parts, Made* made) const;
  absl::Status Write(const Order& order, const std::vector<std::string>& parts);

  Journal* const journal_;
  const std::function<void(const Made&)> observe_;
  Mutex mutex_;
  CondVar idle_;
  // By their flag: not done.
  std::set<std::shared_ptr<std::atomic<bool>>> orders_ ABSL_GUARDED_BY(mutex_);
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  WorkerPool writer_{1};
  WorkerPool taker_{1, WorkerPool::Priority::kBackground};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_SNAPSHOTS_H_
