// A journal in memory of one mesh, with scripted delays and failures of its appends. Thread-safe.
#ifndef DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_
#define DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_

#include <gtest/gtest.h>

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
  absl::Status ReadPast(Key, std::uint64_t, std::uint64_t, const Visitor&) override {
    return absl::OkStatus();
  }
  absl::StatusOr<std::uint64_t> Oldest(Key) override { return 0; }
  absl::Status Compact(Key, std::uint64_t revision, const std::vector<std::string>&) override {
    const std::lock_guard lock(mutex_);
    EXPECT_FALSE(appending_) << "a snapshot beside an append";
    EXPECT_EQ(revision, last_);
    compacted_ = revision;
    return absl::OkStatus();
  }
  // The revision of the last snapshot.
  std::uint64_t compacted() const {
    const std::lock_guard lock(mutex_);
    return compacted_;
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
  std::vector<Group> groups_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_MESHES_SCRIPTED_JOURNAL_H_
