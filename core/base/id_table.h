// Numbers by id, for many ids at once: a search waits for memory, a block of them waits once. Built
// once, then read only. Thread-safe once constructed. Memory: 24 to 48 bytes an id.
#ifndef DYNMESH_CORE_BASE_ID_TABLE_H_
#define DYNMESH_CORE_BASE_ID_TABLE_H_

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/mix.h"

namespace dynmesh {

class IdTable {
 public:
  using Id = std::uint64_t;
  using Number = std::uint32_t;
  static constexpr Number kNone = ~Number{0};

  // number_of(i), below kNone, is that of ids[i]. Of equal ids the first counts. O(n) expected.
  template <class NumberOf>
  IdTable(std::span<const Id> ids, NumberOf number_of)
      : shift_(64 - std::bit_width(std::max<std::size_t>(ids.size() + ids.size() / 2, 1))),
        slots_(std::size_t{1} << (64 - shift_), Slot{0, kNone}) {
    for (std::size_t from = 0; from < ids.size(); from += kBlock) {
      const std::size_t to = std::min(from + kBlock, ids.size());
      for (std::size_t i = from; i < to; ++i) __builtin_prefetch(&slots_[HomeOf(ids[i])], 1);
      for (std::size_t i = from; i < to; ++i) Enter(ids[i], number_of(i), i);
    }
  }
  // The number of ids[i] is i.
  explicit IdTable(std::span<const Id> ids)
      : IdTable(ids, [](std::size_t i) { return static_cast<Number>(i); }) {}

  // The index of the first id that stands for the second time, if any does.
  std::optional<std::size_t> repeated() const { return repeated_; }

  // kNone if there is no such id.
  Number Find(Id id) const {
    for (std::size_t at = HomeOf(id);; at = Behind(at)) {
      if (slots_[at].number == kNone || slots_[at].id == id) return slots_[at].number;
    }
  }
  // numbers[i] becomes Find(ids[i]). REQUIRES: both have the same size.
  void FindAll(std::span<const Id> ids, std::span<Number> numbers) const {
    for (std::size_t from = 0; from < ids.size(); from += kBlock) {
      const std::size_t to = std::min(from + kBlock, ids.size());
      for (std::size_t i = from; i < to; ++i) __builtin_prefetch(&slots_[HomeOf(ids[i])]);
      for (std::size_t i = from; i < to; ++i) numbers[i] = Find(ids[i]);
    }
  }

 private:
  static constexpr std::size_t kBlock = 32;
  struct Slot {
    Id id;
    Number number;
  };

  // Ids are hashes, but may have been chosen: what falls together differs from run to run. No
  // result depends on it.
  std::size_t HomeOf(Id id) const {
    static constexpr char kAnywhere = 0;
    const Id mixed = MixBits(id ^ reinterpret_cast<std::uintptr_t>(&kAnywhere));
    return static_cast<std::size_t>(mixed >> shift_);
  }
  std::size_t Behind(std::size_t at) const { return (at + 1) & (slots_.size() - 1); }

  void Enter(Id id, Number number, std::size_t i) {
    std::size_t at = HomeOf(id);
    for (; slots_[at].number != kNone; at = Behind(at)) {
      if (slots_[at].id != id) continue;
      if (!repeated_) repeated_ = i;
      return;
    }
    slots_[at] = {id, number};
  }

  const int shift_;  // 64 less the bits of an index
  std::vector<Slot> slots_;
  std::optional<std::size_t> repeated_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_ID_TABLE_H_
