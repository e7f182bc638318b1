// A journal in memory of one mesh, with scripted delays and failures of its appends and snapshots.
// Thread-safe.
#ifndef DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_
#define DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_

#include <gtest/gtest.h>

#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/journal/journal.h"
#include "tests/support/deadline.h"

namespace dynmesh::server {

class ScriptedJournal final : public Journal {
 public:
  // What was appended at once.
  struct Group {
    std::vector<Entry> entries;
    std::vector<Request> requests;
  };

  // The answer to append number `n`, from 1 on; not OK: it is not done. Null: all are OK.
  void Answer(std::function<absl::Status(int n)> answer) {
    const std::lock_guard lock(mutex_);
    answer_ = std::move(answer);
  }
  // Appends wait from now on.
  void Hold() {
    const std::lock_guard lock(mutex_);
    held_ = true;
  }
  void Release() {
    const std::lock_guard lock(mutex_);
    held_ = false;
    changed_.notify_all();
  }
  // Of the appends that wait, now and later, those up to number `n` go on.
  void ReleaseUpTo(int n) {
    const std::lock_guard lock(mutex_);
    released_ = n;
    changed_.notify_all();
  }
  // Until so many appends have come since it was made.
  void WaitForAppends(int count) {
    std::unique_lock lock(mutex_);
    test::WaitUntil("appends", changed_, lock, [&] { return appends_ >= count; });
  }
  // That of the last append.
  std::thread::id thread() const {
    const std::lock_guard lock(mutex_);
    return thread_;
  }
  int appends() const {
    const std::lock_guard lock(mutex_);
    return appends_;
  }
  std::vector<Group> groups() const {
    const std::lock_guard lock(mutex_);
    return groups_;
  }
  // The last revision that was written.
  std::uint64_t last() const {
    const std::lock_guard lock(mutex_);
    return last_;
  }
  // How many batches each append that was done had.
  std::vector<std::size_t> sizes() const {
    std::vector<std::size_t> sizes;
    for (const Group& group : groups()) sizes.push_back(group.entries.size());
    return sizes;
  }

  std::string name() const override { return "memory"; }
  absl::StatusOr<std::vector<Mesh>> List() override { return std::vector<Mesh>(); }
  absl::StatusOr<Key> Create(const std::string&, const std::string&) override { return Key{1}; }
  absl::Status Delete(Key) override { return absl::OkStatus(); }
  bool Sweep(Key) override { return false; }
  using Journal::Append;
  absl::Status Append(Key, const std::vector<Entry>& entries,
                      const std::vector<Request>& requests) override {
    std::unique_lock lock(mutex_);
    EXPECT_FALSE(appending_) << "two appends of a mesh at once";
    appending_ = true;
    thread_ = std::this_thread::get_id();
    const int n = ++appends_;
    changed_.notify_all();
    test::WaitUntil("the release of an append", changed_, lock,
                    [&] { return !held_ || n <= released_; });
    absl::Status status = answer_ == nullptr ? absl::OkStatus() : answer_(n);
    if (status.ok()) groups_.push_back({entries, requests});
    if (status.ok() && !entries.empty()) last_ = entries.back().revision;
    appending_ = false;
    return status;
  }
  absl::Status Read(Key, const Visitor&) override { return absl::OkStatus(); }
  // All entries up to `to`, whatever snapshots there are.
  absl::Status ReadPast(Key, std::uint64_t, std::uint64_t to, const Visitor& visitor) override {
    std::vector<Group> groups;
    {
      const std::lock_guard lock(mutex_);
      if (!damage_.ok()) return damage_;
      groups = groups_;
    }
    for (const Group& group : groups) {
      for (const Entry& entry : group.entries) {
        if (entry.revision > to) return absl::OkStatus();
        if (absl::Status s = visitor.entry(entry); !s.ok()) return s;
      }
    }
    return absl::OkStatus();
  }
  absl::StatusOr<std::uint64_t> Oldest(Key) override { return 0; }
  using Journal::Compact;
  absl::Status Compact(Key, std::uint64_t revision, const std::vector<std::string>& parts,
                       const std::atomic<bool>& cancelled) override {
    std::unique_lock lock(mutex_);
    EXPECT_FALSE(compacting_) << "two snapshots at once";
    EXPECT_LE(revision, last_);
    EXPECT_GT(revision, compacted_);
    compacting_ = true;
    ++snapshots_;
    changed_.notify_all();
    // Its flag tells no one.
    while (snapshots_held_ && !cancelled) changed_.wait_for(lock, std::chrono::milliseconds(1));
    compacting_ = false;
    if (cancelled) return absl::CancelledError("ended");
    if (!snapshot_answer_.ok()) return snapshot_answer_;
    compacted_ = revision;
    parts_ = parts;
    return absl::OkStatus();
  }
  // Snapshots wait from now on, or go on.
  void HoldSnapshots(bool held) {
    const std::lock_guard lock(mutex_);
    snapshots_held_ = held;
    changed_.notify_all();
  }
  // Until so many have been begun since it was made.
  void WaitForSnapshots(int count) {
    std::unique_lock lock(mutex_);
    test::WaitUntil("snapshots", changed_, lock, [&] { return snapshots_ >= count; });
  }
  // The answer to snapshots from now on; to reading back.
  void AnswerSnapshots(const absl::Status& status) {
    const std::lock_guard lock(mutex_);
    snapshot_answer_ = status;
  }
  void Damage(const absl::Status& status) {
    const std::lock_guard lock(mutex_);
    damage_ = status;
  }
  // The revision of the last snapshot, its bytes, and how many were begun.
  std::uint64_t compacted() const {
    const std::lock_guard lock(mutex_);
    return compacted_;
  }
  std::vector<std::string> parts() const {
    const std::lock_guard lock(mutex_);
    return parts_;
  }
  int snapshots() const {
    const std::lock_guard lock(mutex_);
    return snapshots_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::function<absl::Status(int)> answer_;
  bool held_ = false;
  int released_ = 0;
  bool appending_ = false;
  std::thread::id thread_;
  int appends_ = 0;
  std::uint64_t last_ = 0;
  std::uint64_t compacted_ = 0;
  std::vector<std::string> parts_;
  int snapshots_ = 0;
  bool snapshots_held_ = false;
  bool compacting_ = false;
  absl::Status snapshot_answer_, damage_;
  std::vector<Group> groups_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_
