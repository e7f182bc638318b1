// An order-maintenance list: a total order in which a new element can be placed right after any
// other, and any two elements can be compared, at any time.
//
// Two levels (after Dietz and Sleator). Elements live in groups of at most kGroupSize. A group has
// a 40-bit label; an element adds 24 bits below it. The whole 64-bit label is stored with the
// element, so a comparison costs one load for each of the two. Inserting is O(1) amortised while
// groups are sparse in their label space, as they are for any list that fits in memory.
//
// Thread-compatible. Elements are dense indices, reused after Erase.
#ifndef DYNMESH_CORE_SAC_ORDER_LIST_H_
#define DYNMESH_CORE_SAC_ORDER_LIST_H_

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/large_vector.h"

namespace dynmesh::sac {

using Stamp = std::uint32_t;
inline constexpr Stamp kNoStamp = ~Stamp{0};

class OrderList {
 public:
  static constexpr int kGroupSize = 64;

  // A list with two elements, first() and last(), which are never erased.
  OrderList();

  Stamp first() const { return 0; }
  Stamp last() const { return 1; }

  // A new element right after / before `s`. REQUIRES: s is present, and not
  // last() / first() respectively.
  Stamp InsertAfter(Stamp s);
  Stamp InsertBefore(Stamp s);

  // REQUIRES: s is present, neither first() nor last().
  void Erase(Stamp s);

  // True if a comes before b. False if a == b.
  bool Precedes(Stamp a, Stamp b) const { return labels_[a] < labels_[b]; }
  // `s`: any stamp, kNoStamp too.
  void Prefetch(Stamp s) const { __builtin_prefetch(labels_.data() + s); }

  // Neighbours in the order; kNoStamp past the ends. O(kGroupSize).
  Stamp Next(Stamp s) const;
  Stamp Prev(Stamp s) const;

  void Reserve(std::size_t elements);
  std::size_t size() const { return size_; }
  // For tests of costs: so far.
  std::uint64_t relabelled_groups() const { return relabelled_groups_; }
  std::size_t bytes() const;

  // Checks every invariant, O(size). False with `*why` set if one is violated.
  bool Check(std::string* why) const;

 private:
  using GroupIndex = std::uint32_t;
  static constexpr GroupIndex kNoGroup = ~GroupIndex{0};
  static constexpr int kLowBits = 24;
  static constexpr std::uint64_t kGroupSpace = std::uint64_t{1} << (64 - kLowBits);
  static constexpr std::uint64_t kAppendGap = std::uint64_t{1} << 14;

  struct Group {
    std::uint64_t label;  // < kGroupSpace
    GroupIndex prev, next;
    std::uint32_t count;
    std::array<Stamp, kGroupSize> items;
  };

  Stamp InsertAt(GroupIndex g, std::uint32_t position);
  std::uint32_t PositionInGroup(Stamp s) const;
  void SplitGroup(GroupIndex g);
  GroupIndex NewGroupAfter(GroupIndex g);
  void SpreadGroups(GroupIndex around);
  void SpreadItems(GroupIndex g);
  Stamp NewStamp();

  LargeVector<std::uint64_t> labels_;  // by stamp: group label, low bits
  LargeVector<GroupIndex> group_of_;   // by stamp
  LargeVector<Group> groups_;
  std::vector<Stamp> free_stamps_;
  std::vector<GroupIndex> free_groups_;
  std::size_t size_ = 0;
  std::uint64_t relabelled_groups_ = 0;
};

}  // namespace dynmesh::sac

#endif  // DYNMESH_CORE_SAC_ORDER_LIST_H_
