// The batches of a mesh that its writer has applied and that are not answered, in order. The first
// of them may be *in flight*: another thread is writing them to the journal, as one group. The
// others *wait*: they were applied meanwhile, and are the next group.
//
//   applied, oldest first:  [ in flight, one append | waiting, the next append ]
//
// At most one append is under way, so groups are written in order. Batches are published and
// answered once their own append has succeeded. Held with them are answers that depend on their
// changes, such as refusals and retries: each is given when all batches before it are written. If
// an append fails, all that is held fails, as everything after it was applied to what is undone.
//
// Thread-compatible: belongs to the mesh's strand. Only the Flight is shared with the thread that
// writes.
#ifndef DYNMESH_SERVER_MESHES_APPEND_PIPELINE_H_
#define DYNMESH_SERVER_MESHES_APPEND_PIPELINE_H_

#include <atomic>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "server/journal/mesh_log.h"
#include "server/meshes/edit_group.h"
#include "server/meshes/edit_job.h"

namespace dynmesh::server {

class AppendPipeline {
 public:
  // Of all that is held, in flight or waiting: the entries, and the bytes of their edits and diffs.
  struct Limits {
    std::size_t edits = 1'024;
    std::size_t bytes = 32 << 20;
  };

  // An append under way. Its batches live until the pipeline gives them back.
  class Flight {
   public:
    Flight(std::vector<MeshLog::Batch> batches, std::shared_ptr<const EditJob> first)
        : batches_(std::move(batches)), first_(std::move(first)) {}

    const std::vector<MeshLog::Batch>& batches() const { return batches_; }
    const EditJob& first() const { return *first_; }
    // By the thread that wrote the batches, once.
    void End(absl::Status written) {
      written_ = std::move(written);
      ended_.store(true, std::memory_order_release);
    }
    bool ended() const { return ended_.load(std::memory_order_acquire); }
    // The append's outcome. REQUIRES: ended().
    const absl::Status& written() const { return written_; }

   private:
    const std::vector<MeshLog::Batch> batches_;
    const std::shared_ptr<const EditJob> first_;
    absl::Status written_;
    std::atomic<bool> ended_{false};
  };
  using FlightPtr = std::shared_ptr<Flight>;

  explicit AppendPipeline(const Limits& limits) : limits_(limits) {}

  // True if nothing is held: then the mesh equals the journal's state.
  bool empty() const { return flight_ == nullptr && waiting_.empty(); }
  // True if nothing more is to be applied until an append has ended.
  bool full() const { return size_ >= limits_.edits || bytes_ >= limits_.bytes; }
  // The append under way; null: there is none.
  const FlightPtr& flight() const { return flight_; }
  // Entries that wait.
  std::size_t waiting() const { return waiting_.size(); }
  // Number of revisions that the batches held made.
  std::size_t revisions() const { return in_flight_.revisions() + waiting_.revisions(); }
  // The batch held with this request_id; null if there is none.
  const HeldEdit* Find(absl::string_view request_id) const;

  // REQUIRES: if it is empty, the edit is unwritten. O(size of edits and diff).
  void Add(HeldEdit edit);
  // All that waits is in flight from now on. REQUIRES: there is no flight, and it is not empty.
  const FlightPtr& Begin();
  // After an append that succeeded: its batches, and what waited for nothing else, in order.
  std::vector<HeldEdit> TakeWritten();
  // After an append that failed: all that is held, in order. `flown` of these were in flight.
  std::vector<HeldEdit> TakeAll(std::size_t* flown);

 private:
  const Limits limits_;
  EditGroup in_flight_, waiting_;
  FlightPtr flight_;
  std::size_t size_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_APPEND_PIPELINE_H_
