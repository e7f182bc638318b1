// The answers to the writers of one mesh. Every revision of the mesh must have been the answer to
// exactly one batch: a revision answered twice was applied twice, one without an answer is lost.
//
// Thread-safe. An answer costs O(1).
#ifndef DYNMESH_TESTS_E2E_SOAK_LEDGER_H_
#define DYNMESH_TESTS_E2E_SOAK_LEDGER_H_

#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <vector>

#include "dynmesh/client/edit_session.h"
#include "tests/e2e/soak/figures.h"

namespace dynmesh::soak {

class Ledger {
 public:
  void Answered(const client::EditResult& result) {
    const std::uint64_t to = result.diff.to_revision;
    if (result.diff.from_revision == to) return;  // edits that cancelled each other
    const std::lock_guard lock(mutex_);
    if (to >= answered_.size()) answered_.resize(to + 1);
    // If an answer got lost, the retry is answered once.
    if (answered_[to] || result.diff.from_revision + 1 != to) ++doubled_;
    answered_[to] = true;
    if (to > head_) head_ = to;
  }

  // The last revision that was answered; watchers cannot be ahead of it for long.
  std::uint64_t head() const { return head_; }
  std::uint64_t doubled() const {
    const std::lock_guard lock(mutex_);
    return doubled_;
  }
  // Revisions up to the server's head without an answer, or answers beyond it.
  std::uint64_t Lost(std::uint64_t server_head) const {
    const std::lock_guard lock(mutex_);
    std::uint64_t lost = 0;
    for (std::uint64_t r = 1; r < answered_.size() || r <= server_head; ++r) {
      const bool answered = r < answered_.size() && answered_[r];
      if (answered != (r <= server_head)) ++lost;
    }
    return lost;
  }

  Latencies single;  // edits of one point
  Latencies batch;   // all others that were applied
  std::atomic<std::uint64_t> refused = 0, cancelled = 0, replayed = 0;

 private:
  mutable std::mutex mutex_;
  std::vector<bool> answered_;
  std::atomic<std::uint64_t> head_ = 0;
  std::uint64_t doubled_ = 0;
};

// The faults, for the summary: the first few as text. Thread-safe.
class Faults {
 public:
  void Add(const std::string& what) {
    const std::lock_guard lock(mutex_);
    ++count_;
    if (words_.size() < 20) words_.push_back(what);
  }
  std::uint64_t count() const {
    const std::lock_guard lock(mutex_);
    return count_;
  }
  std::vector<std::string> words() const {
    const std::lock_guard lock(mutex_);
    return words_;
  }

 private:
  mutable std::mutex mutex_;
  std::uint64_t count_ = 0;
  std::vector<std::string> words_;
};

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_LEDGER_H_
