// Columns of a mesh as arrays that never change, for readers beside an edit.
//
// A reader takes a copy of a column as it is now and holds it for as long as it needs it. Edits
// change the column, never a copy that is held. A copy that is not held is brought up to date by
// the rows that have changed since. So taking a column after each edit costs the rows of the edit,
// not the mesh. At most three copies of a column are kept for that.
//
// ColumnCopies and RowLog belong to the mesh and are used under its lock. A HeldColumn may be
// dropped on any thread, with or without the lock.
#ifndef DYNMESH_CLIENT_PYTHON_MODULE_HELD_COLUMN_H_
#define DYNMESH_CLIENT_PYTHON_MODULE_HELD_COLUMN_H_

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <utility>
#include <vector>

#include "dynmesh/slot_mesh.h"

namespace dynmesh::python {

// Which rows of some columns changed, by change. It forgets the oldest changes when they name more
// rows than `most` of Add.
class RowLog {
 public:
  // The number of changes so far.
  std::uint64_t now() const { return first_ + changes_.size(); }
  // Are the rows of all changes since `version` known?
  bool Knows(std::uint64_t version) const { return version >= first_; }

  // A change of `rows`, which may name one twice.
  void Add(std::vector<Slot> rows, std::size_t most) {
    if (rows.empty()) return;
    size_ += rows.size();
    changes_.push_back(std::move(rows));
    while (size_ > most) {
      size_ -= changes_.front().size();
      changes_.pop_front(), ++first_;
    }
  }
  // A change of rows that are not known.
  void AddUnknown() {
    first_ = now() + 1;
    changes_.clear(), size_ = 0;
  }

  // Calls f(row) for the rows that changed since `version`. REQUIRES: Knows(version).
  template <class F>
  void ForEachSince(std::uint64_t version, F f) const {
    for (std::uint64_t i = version - first_; i < changes_.size(); ++i) {
      for (const Slot row : changes_[static_cast<std::size_t>(i)]) f(row);
    }
  }

 private:
  std::deque<std::vector<Slot>> changes_;
  std::uint64_t first_ = 0;  // version before the first of them
  std::size_t size_ = 0;     // their rows
};

// A column as it was when it was taken.
template <class T>
class HeldColumn {
 public:
  struct Copy {
    SlotColumn<T> column;
    std::uint64_t version = 0;
    std::atomic<int> holders = 0;
  };

  HeldColumn() = default;
  explicit HeldColumn(std::shared_ptr<Copy> copy) : copy_(std::move(copy)) {
    copy_->holders.fetch_add(1, std::memory_order_relaxed);
  }
  HeldColumn(HeldColumn&& other) noexcept : copy_(std::exchange(other.copy_, nullptr)) {}
  HeldColumn& operator=(HeldColumn&& other) noexcept {
    std::swap(copy_, other.copy_);
    return *this;
  }
  ~HeldColumn() {
    if (copy_ != nullptr) copy_->holders.fetch_sub(1, std::memory_order_release);
  }

  const T* data() const { return copy_ == nullptr ? nullptr : std::as_const(copy_->column).data(); }
  std::size_t size() const { return copy_ == nullptr ? 0 : copy_->column.size(); }

 private:
  std::shared_ptr<Copy> copy_;
};

// The copies of one column.
template <class T>
class ColumnCopies {
 public:
  // The column as it is now. `width`: entries of a row; `log`: of its rows. O(rows that changed
  // since a free copy was made), else O(column).
  HeldColumn<T> Take(const SlotColumn<T>& column, std::size_t width, const RowLog& log) {
    for (const auto& copy : copies_) {
      if (copy->version == log.now()) return HeldColumn<T>(copy);
    }
    const std::shared_ptr<Copy> copy = FreeCopy();
    SlotColumn<T>& values = copy->column;
    if (values.size() == 0) {
      values = SlotColumn<T>(column);
    } else {
      const bool knows = log.Knows(copy->version);
      const std::size_t same = knows ? std::min(values.size(), column.size()) : 0;
      values.resize(column.size(), T());
      std::copy(column.data() + same, column.data() + column.size(), values.data() + same);
      if (knows) {
        log.ForEachSince(copy->version, [&](Slot row) {
          const std::size_t at = static_cast<std::size_t>(row) * width;
          if (at >= column.size()) return;  // the column was longer
          std::copy_n(column.data() + at, width, values.data() + at);
        });
      }
    }
    copy->version = log.now();
    return HeldColumn<T>(copy);
  }

  // Is there a copy? Otherwise no rows need to be logged.
  bool in_use() const { return !copies_.empty(); }
  // Frees what can no longer be brought up to date.
  void DropOld(const RowLog& log) {
    std::erase_if(copies_, [&](const auto& copy) { return !log.Knows(copy->version); });
  }

 private:
  using Copy = typename HeldColumn<T>::Copy;
  static constexpr std::size_t kMostCopies = 3;

  // The latest that no reader holds, or a new one.
  std::shared_ptr<Copy> FreeCopy() {
    std::shared_ptr<Copy> free;
    for (const auto& copy : copies_) {
      // Pairs with the release: what the last reader read is behind us.
      if (copy->holders.load(std::memory_order_acquire) != 0) continue;
      if (free == nullptr || copy->version > free->version) free = copy;
    }
    if (free != nullptr) return free;
    if (copies_.size() == kMostCopies) copies_.erase(copies_.begin());
    copies_.push_back(std::make_shared<Copy>());
    return copies_.back();
  }

  std::vector<std::shared_ptr<Copy>> copies_;  // held ones, too
};

}  // namespace dynmesh::python

#endif  // DYNMESH_CLIENT_PYTHON_MODULE_HELD_COLUMN_H_
