// The bucketed priority queue (Sec. 1.5, Fig. 1.5): both the algorithm's work queue and the queue
// of change propagation.
//
// Time has a leading field, the *epoch* (for a mesher: bucket, round, class), and within it a
// random priority. Entries of later epochs are kept unsorted in that epoch's list. The earliest
// epoch is sorted when it is opened; entries that arrive while it is open go to a small heap. Push
// and Pop are O(1) amortised except for the sort, as long as new work belongs to the open epoch or
// a few later ones.
//
// Ties of the priority are broken by Less, a strict order that is a function of what the entries
// stand for. Thread-compatible.
#ifndef DYNMESH_CORE_SAC_WORK_QUEUE_H_
#define DYNMESH_CORE_SAC_WORK_QUEUE_H_

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

namespace dynmesh::sac {

using Epoch = std::uint64_t;
inline constexpr Epoch kForever = ~Epoch{0};  // later than all epochs

// Entry: has a field `priority`. Less(a, b): a before b among equal priorities.
template <class Entry, class Less>
class WorkQueue {
 public:
  explicit WorkQueue(Less less) : less_(std::move(less)) {}

  bool empty() const { return size_ == 0; }
  std::size_t size() const { return size_; }
  std::size_t SizeIn(Epoch epoch) const {
    const auto it = waiting_.find(epoch);
    return (it == waiting_.end() ? 0 : it->second.size()) +
           (open_ && epoch == open_epoch_ ? sorted_.size() + late_.size() : 0);
  }

  // The epoch of the earliest entry. REQUIRES: not empty.
  Epoch first_epoch() const {
    const bool is_open = open_ && !(sorted_.empty() && late_.empty());
    if (waiting_.empty()) return open_epoch_;
    const Epoch first = waiting_.begin()->first;
    return is_open ? std::min(open_epoch_, first) : first;
  }

  void Push(Epoch epoch, const Entry& entry) {
    ++size_;
    if (open_ && epoch == open_epoch_) {
      late_.push_back(entry);
      std::push_heap(late_.begin(), late_.end(), After());
      return;
    }
    std::vector<Entry>*& list = cache_[epoch % kCache].second;
    if (cache_[epoch % kCache].first != epoch || list == nullptr) {
      cache_[epoch % kCache].first = epoch;
      list = &waiting_[epoch];
    }
    list->push_back(entry);
  }

  // Takes the earliest entry. REQUIRES: not empty.
  std::pair<Epoch, Entry> Pop() {
    if (!open_ || (!waiting_.empty() && waiting_.begin()->first < open_epoch_) ||
        (sorted_.empty() && late_.empty())) {
      Open();
    }
    --size_;
    if (late_.empty() || (!sorted_.empty() && Before(sorted_.back(), late_.front()))) {
      const Entry entry = sorted_.back();
      sorted_.pop_back();
      return {open_epoch_, entry};
    }
    std::pop_heap(late_.begin(), late_.end(), After());
    const Entry entry = late_.back();
    late_.pop_back();
    return {open_epoch_, entry};
  }

  // The entry that will be popped after `ahead` others if nothing else arrives; null if there is
  // none in this epoch.
  const Entry* Ahead(std::size_t ahead) const {
    return ahead < sorted_.size() ? &sorted_[sorted_.size() - 1 - ahead] : nullptr;
  }

  // Call at the beginning of a propagation: work for earlier times may arrive now.
  void Rewind() {
    if (!open_) return;
    open_ = false;
    if (sorted_.empty() && late_.empty()) return;
    auto& list = waiting_[open_epoch_];
    list.insert(list.end(), sorted_.begin(), sorted_.end());
    list.insert(list.end(), late_.begin(), late_.end());
    sorted_.clear();
    late_.clear();
  }

  std::size_t bytes() const { return (sorted_.capacity() + late_.capacity()) * sizeof(Entry); }

 private:
  static constexpr std::size_t kCache = 61;

  bool Before(const Entry& a, const Entry& b) const {
    return a.priority != b.priority ? a.priority < b.priority : less_(a, b);
  }
  auto After() const {
    return [this](const Entry& a, const Entry& b) { return Before(b, a); };
  }

  // Latest first. Requests often come in order: operations of an epoch run in order.
  void Sort(std::vector<Entry>& entries) const {
    const auto before = [this](const Entry& a, const Entry& b) { return Before(a, b); };
    if (std::is_sorted(entries.begin(), entries.end(), before)) {
      std::reverse(entries.begin(), entries.end());
    } else {
      std::sort(entries.begin(), entries.end(), After());
    }
  }

  void Open() {
    Rewind();
    const auto first = waiting_.begin();
    open_epoch_ = first->first;
    sorted_.swap(first->second);
    if (cache_[open_epoch_ % kCache].first == open_epoch_) cache_[open_epoch_ % kCache] = {};
    waiting_.erase(first);
    Sort(sorted_);
    open_ = true;
  }

  Less less_;
  std::map<Epoch, std::vector<Entry>> waiting_;
  std::pair<Epoch, std::vector<Entry>*> cache_[kCache] = {};
  std::vector<Entry> sorted_;  // of the open epoch, earliest last
  std::vector<Entry> late_;    // heap, earliest on top
  Epoch open_epoch_ = 0;
  bool open_ = false;
  std::size_t size_ = 0;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_WORK_QUEUE_H_
