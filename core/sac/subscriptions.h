// For each place the operations that subscribe to it, and to which parts of it. Some subscribers
// are *attentive*: a kind of change that concerns only these notifies them alone and skips
// thousands of others. In a list the attentive ones come first. Otherwise lists have no order: it
// differs between histories that end in the same trace, so no result may depend on it.
// Thread-compatible.
#ifndef DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_
#define DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/large_vector.h"
#include "core/sac/block_pool.h"

namespace dynmesh::sac {

using Place = std::uint32_t;  // dense, chosen by the program
// A set of bits with a meaning of the program's. Notify(parts) reaches a subscriber iff (subscribed
// & parts) == parts.
using Parts = std::uint32_t;
inline constexpr Parts kAllParts = ~Parts{0};

class Subscriptions {
 public:
  struct Subscriber {
    std::uint32_t op;
    Parts parts;
  };
  std::span<const Subscriber> at(Place place) const {
    if (place >= lists_.size()) return {};
    return {data(lists_[place]), lists_[place].count};
  }
  // How many subscribe to `place`, also during a load.
  std::size_t CountAt(Place place) const { return place < lists_.size() ? lists_[place].count : 0; }
  // The attentive subscribers of `place`.
  std::span<const Subscriber> attentive_at(Place place) const {
    if (place >= lists_.size()) return {};
    return {data(lists_[place]), lists_[place].attentive};
  }
  // The operations that subscribe to all of `parts` at `place`. Valid until the next call.
  // Branchless: which subscribers do is unpredictable.
  std::span<const std::uint32_t> SubscribersOfAll(Place place, Parts parts) {
    const auto subscribers = at(place);
    if (asked_.size() <= subscribers.size()) asked_.resize(2 * subscribers.size() + 1);
    std::size_t count = 0;
    for (const auto& [op, of] : subscribers) {
      asked_[count] = op;
      count += (of & parts) == parts ? 1 : 0;
    }
    return std::span(asked_).first(count);
  }

  // Bulk load, for a run from scratch: until EndLoad subscriptions are only collected, then sorted
  // by place, so that no list grows step by step. Before EndLoad only CountAt may be asked. Take
  // ends the load by itself. REQUIRES: there is no subscription yet, and none is removed before
  // EndLoad.
  void BeginLoad() { loading_ = true; }
  void EndLoad();

  void Add(Place place, std::uint32_t op, Parts parts = kAllParts, bool attentive = false) {
    if (place >= lists_.size()) lists_.resize(place + place / 4 + 16);
    List& list = lists_[place];
    if (loading_) {
      ++list.count;
      return loaded_.push_back({place, {op, parts}, attentive});
    }
    if (kWords * (list.count + std::uint64_t{1}) > list.block.capacity())
      pool_.Resize(list.block, kWords * (list.count + std::uint64_t{1} + list.count / 4));
    Append(list, {op, parts}, attentive);
  }

  // REQUIRES: op subscribes to place.
  void Remove(Place place, std::uint32_t op) {
    assert(!loading_);
    List& list = lists_[place];
    Subscriber* s = Find(list, op);
    if (s < data(list) + list.attentive) {
      // The last attentive subscriber moves here; its own slot is filled below.
      Subscriber* const last = data(list) + --list.attentive;
      *s = *last;
      s = last;
    }
    *s = data(list)[list.count - 1];
    if (--list.count == 0) pool_.Free(list.block);
  }
  void Set(Place place, std::uint32_t op, Parts parts, bool attentive = false) {
    assert(!loading_);
    List& list = lists_[place];
    Subscriber* const s = Find(list, op);
    s->parts = parts;
    const bool was = s < data(list) + list.attentive;
    if (attentive && !was) std::swap(*s, data(list)[list.attentive++]);
    if (!attentive && was) std::swap(*s, data(list)[--list.attentive]);
  }

  // Empties a place and returns its subscribers. Their own records still name the place.
  std::vector<std::uint32_t> Take(Place place) {
    EndLoad();
    std::vector<std::uint32_t> result;
    for (const Subscriber& s : at(place)) result.push_back(s.op);
    if (place < lists_.size()) {
      pool_.Free(lists_[place].block);
      lists_[place].count = lists_[place].attentive = 0;
    }
    return result;
  }

  // Reserves room for so many subscriptions.
  void Reserve(std::size_t count) {
    lists_.reserve(count / 4);
    loaded_.reserve(count);
    pool_.Reserve(kWords * count * 5 / 4);
  }
  std::size_t places() const { return lists_.size(); }
  std::size_t bytes() const { return lists_.size() * sizeof(List) + pool_.bytes(); }
  const BlockPool& pool() const { return pool_; }

 private:
  struct List {
    BlockPool::Block block;
    std::uint32_t count = 0;
    std::uint32_t attentive = 0;  // of them
  };
  static constexpr std::uint64_t kWords = sizeof(Subscriber) / sizeof(std::uint32_t);

  Subscriber* data(const List& list) {
    return reinterpret_cast<Subscriber*>(pool_.data(list.block));
  }
  const Subscriber* data(const List& list) const {
    return reinterpret_cast<const Subscriber*>(pool_.data(list.block));
  }
  Subscriber* Find(const List& list, std::uint32_t op) {
    Subscriber* s = data(list);
    while (s->op != op) ++s;
    assert(s < data(list) + list.count);
    return s;
  }

  // REQUIRES: there is room.
  void Append(List& list, const Subscriber& s, bool attentive) {
    Subscriber* const all = data(list);
    all[list.count++] = s;
    if (attentive) std::swap(all[list.count - 1], all[list.attentive++]);
  }

  struct Loaded {
    Place place;
    Subscriber subscriber;
    bool attentive;
  };

  LargeVector<List> lists_;
  BlockPool pool_;
  bool loading_ = false;
  LargeVector<Loaded> loaded_;
  std::vector<std::uint32_t> asked_;  // scratch of SubscribersOfAll
};

inline void Subscriptions::EndLoad() {
  if (!loading_) return;
  loading_ = false;
  for (List& list : lists_) {
    pool_.Resize(list.block, kWords * list.count);
    list.count = 0;
  }
  for (const Loaded& l : loaded_) {
    Append(lists_[l.place], l.subscriber, l.attentive);
  }
  loaded_ = {};
}

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_SUBSCRIPTIONS_H_
