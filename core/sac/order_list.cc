#include "core/sac/order_list.h"

#include <algorithm>

namespace dynmesh::sac {

OrderList::OrderList() {
  groups_.push_back({kGroupSpace / 2, kNoGroup, kNoGroup, 2, {0, 1}});
  labels_ = {0, 0};
  group_of_ = {0, 0};
  size_ = 2;
  SpreadItems(0);
}

Stamp OrderList::NewStamp() {
  if (!free_stamps_.empty()) {
    const Stamp s = free_stamps_.back();
    free_stamps_.pop_back();
    return s;
  }
  labels_.push_back(0);
  group_of_.push_back(kNoGroup);
  return static_cast<Stamp>(labels_.size() - 1);
}

std::uint32_t OrderList::PositionInGroup(Stamp s) const {
  const Group& g = groups_[group_of_[s]];
  std::uint32_t i = g.count - 1;  // most insertions are at the end
  while (g.items[i] != s) --i;
  return i;
}

Stamp OrderList::InsertAfter(Stamp s) { return InsertAt(group_of_[s], PositionInGroup(s) + 1); }

Stamp OrderList::InsertBefore(Stamp s) { return InsertAt(group_of_[s], PositionInGroup(s)); }

Stamp OrderList::InsertAt(GroupIndex gi, std::uint32_t position) {
  if (groups_[gi].count == kGroupSize) {
    SplitGroup(gi);
    const std::uint32_t left = groups_[gi].count;
    if (position > left) {
      gi = groups_[gi].next;
      position -= left;
    }
  }
  const Stamp s = NewStamp();
  Group& g = groups_[gi];
  std::copy_backward(g.items.begin() + position, g.items.begin() + g.count,
                     g.items.begin() + g.count + 1);
  g.items[position] = s;
  ++g.count;
  ++size_;
  group_of_[s] = gi;

  constexpr std::uint64_t kLowMask = (std::uint64_t{1} << kLowBits) - 1;
  const std::uint64_t base = g.label << kLowBits;
  const std::uint64_t lo = position == 0 ? 0 : labels_[g.items[position - 1]] & kLowMask;
  const std::uint64_t hi =
      position + 1 == g.count ? kLowMask : labels_[g.items[position + 1]] & kLowMask;
  if (hi - lo < 2) {
    SpreadItems(gi);
  } else if (position + 1 == g.count) {
    // Appending is the common case of a static run: leave most of the room.
    labels_[s] = base | (lo + std::min((hi - lo) / 2, (kLowMask + 1) / (kGroupSize + 2)));
  } else {
    labels_[s] = base | (lo + (hi - lo) / 2);
  }
  return s;
}

void OrderList::SpreadItems(GroupIndex gi) {
  Group& g = groups_[gi];
  const std::uint64_t step = (std::uint64_t{1} << kLowBits) / (g.count + 1);
  std::uint64_t label = g.label << kLowBits;
  for (std::uint32_t i = 0; i < g.count; ++i) {
    label += step;
    labels_[g.items[i]] = label;
  }
}

// Moves the right part to a new group. At the end of the list only a few elements move, so that
// appending fills groups. Elsewhere half of them move, so that both groups have room to grow.
void OrderList::SplitGroup(GroupIndex gi) {
  const GroupIndex ni = NewGroupAfter(gi);
  Group& g = groups_[gi];
  Group& n = groups_[ni];
  const std::uint32_t keep = n.next == kNoGroup ? kGroupSize - 4 : kGroupSize / 2;
  n.count = g.count - keep;
  std::copy(g.items.begin() + keep, g.items.begin() + g.count, n.items.begin());
  g.count = keep;
  for (std::uint32_t i = 0; i < n.count; ++i) group_of_[n.items[i]] = ni;
  SpreadItems(gi);
  SpreadItems(ni);
}

OrderList::GroupIndex OrderList::NewGroupAfter(GroupIndex gi) {
  auto gap_end = [&] {
    const GroupIndex next = groups_[gi].next;
    return next == kNoGroup ? kGroupSpace : groups_[next].label;
  };
  if (gap_end() - groups_[gi].label < 2) SpreadGroups(gi);
  const std::uint64_t lo = groups_[gi].label;
  const std::uint64_t hi = gap_end();
  const bool append = groups_[gi].next == kNoGroup;
  GroupIndex ni;
  if (free_groups_.empty()) {
    ni = static_cast<GroupIndex>(groups_.size());
    groups_.emplace_back();
  } else {
    ni = free_groups_.back();
    free_groups_.pop_back();
  }
  Group& n = groups_[ni];
  n.label = append ? lo + std::min((hi - lo) / 2, kAppendGap) : lo + (hi - lo) / 2;
  n.prev = gi;
  n.next = groups_[gi].next;
  n.count = 0;
  if (n.next != kNoGroup) groups_[n.next].prev = ni;
  groups_[gi].next = ni;
  return ni;
}

// Spreads labels evenly over a range of label space around a group: the smallest aligned range that
// is sparse enough. A range of 2^i labels may be (2/3)^i full (Bender et al.). By that measure the
// whole space holds some 10^5 groups. A longer list uses (4/5)^i: insertions cost more, but there
// is room for as many groups as there can be stamps.
void OrderList::SpreadGroups(GroupIndex around) {
  const double growth = groups_.size() < (1u << 14) ? 4.0 / 3.0 : 1.6;
  double limit = 1;
  GroupIndex left = around, right = around;
  std::uint64_t count = 1;
  for (int bits = 1; bits <= 64 - kLowBits; ++bits) {
    limit *= growth;
    const std::uint64_t mask = (std::uint64_t{1} << bits) - 1;
    const std::uint64_t lo = groups_[around].label & ~mask;
    const std::uint64_t hi = groups_[around].label | mask;
    while (groups_[left].prev != kNoGroup && groups_[groups_[left].prev].label >= lo) {
      left = groups_[left].prev;
      ++count;
    }
    while (groups_[right].next != kNoGroup && groups_[groups_[right].next].label <= hi) {
      right = groups_[right].next;
      ++count;
    }
    const std::uint64_t step = (mask + 1) / (count + 1);
    if (static_cast<double>(count) > limit || step < 2) continue;
    std::uint64_t label = lo;
    for (GroupIndex g = left;; g = groups_[g].next) {
      label += step;
      groups_[g].label = label;
      SpreadItems(g);
      ++relabelled_groups_;
      if (g == right) return;
    }
  }
}

void OrderList::Erase(Stamp s) {
  const GroupIndex gi = group_of_[s];
  const std::uint32_t position = PositionInGroup(s);
  Group& g = groups_[gi];
  std::copy(g.items.begin() + position + 1, g.items.begin() + g.count, g.items.begin() + position);
  --g.count;
  --size_;
  group_of_[s] = kNoGroup;
  free_stamps_.push_back(s);
  if (g.count > 0) return;
  if (g.prev != kNoGroup) groups_[g.prev].next = g.next;
  if (g.next != kNoGroup) groups_[g.next].prev = g.prev;
  free_groups_.push_back(gi);
}

Stamp OrderList::Next(Stamp s) const {
  const Group& g = groups_[group_of_[s]];
  const std::uint32_t i = PositionInGroup(s) + 1;
  if (i < g.count) return g.items[i];
  return g.next == kNoGroup ? kNoStamp : groups_[g.next].items[0];
}

Stamp OrderList::Prev(Stamp s) const {
  const Group& g = groups_[group_of_[s]];
  const std::uint32_t i = PositionInGroup(s);
  if (i > 0) return g.items[i - 1];
  if (g.prev == kNoGroup) return kNoStamp;
  const Group& p = groups_[g.prev];
  return p.items[p.count - 1];
}

void OrderList::Reserve(std::size_t elements) {
  labels_.reserve(elements);
  group_of_.reserve(elements);
  groups_.reserve(elements / (kGroupSize / 2));
}

std::size_t OrderList::bytes() const {
  return labels_.size() * sizeof(labels_[0]) + group_of_.size() * sizeof(group_of_[0]) +
         groups_.size() * sizeof(Group) + free_stamps_.capacity() * sizeof(Stamp) +
         free_groups_.capacity() * sizeof(GroupIndex);
}

bool OrderList::Check(std::string* why) const {
  auto fail = [&](const char* what) {
    *why = what;
    return false;
  };
  std::size_t seen = 0;
  std::uint64_t last_label = 0;
  GroupIndex prev = kNoGroup;
  for (GroupIndex gi = group_of_[first()]; gi != kNoGroup; gi = groups_[gi].next) {
    const Group& g = groups_[gi];
    if (g.prev != prev) return fail("a group's back link is wrong");
    if (g.count == 0 || g.count > kGroupSize) return fail("a group is empty or too full");
    for (std::uint32_t i = 0; i < g.count; ++i, ++seen) {
      const Stamp s = g.items[i];
      if (group_of_[s] != gi) return fail("a stamp does not know its group");
      if (labels_[s] >> kLowBits != g.label) return fail("a stamp's label is not its group's");
      if (seen > 0 && labels_[s] <= last_label) return fail("labels do not increase");
      last_label = labels_[s];
    }
    prev = gi;
  }
  if (seen != size_) return fail("the list does not hold as many stamps as it counts");
  return true;
}

}  // namespace dynmesh::sac
