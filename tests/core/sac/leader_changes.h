// The changes in a LeaderProgram and their notifications; the other half of leader_program.h. Each
// filter defines when a change at a place does not affect an operation.
#ifndef DYNMESH_TESTS_CORE_SAC_LEADER_CHANGES_H_
#define DYNMESH_TESTS_CORE_SAC_LEADER_CHANGES_H_

#include <algorithm>
#include <cassert>
#include <string>
#include <vector>

#include "core/sac/engine_audit.h"
#include "tests/core/sac/leader_program.h"

namespace dynmesh::sac::testing {

// --- Publishing ---------------------------------------------------------------------------

template <template <class> class E>
void LeaderProgram<E>::Publish(Output output, Stamp at) {
  const std::uint32_t i = RecordOf(output);
  Record& r = records_[i];
  if (WhatOf(output) == kDeposed) {
    const Stamp before = EndOf(r);
    r.deposed.push_back(at);
    DeposedChanged(i, before, EndOf(r));
    return;
  }
  r.birth = at;
  r.present = true;
  if (r.is_link) {
    links_.Add(PlaceOf(r.level, points_[r.point].x), i);
    if (++links_present_ > fold_at_ << fold_) Fold();
    NotifyJoins(i, true, at, EndOf(r));
    NotifyGathers(i, true, at);
  } else {
    points_[r.point].summit[r.level] = i;
    if constexpr (kTraced) engine_.NotifyChain(points_[r.point].operations, at);
  }
}

template <template <class> class E>
void LeaderProgram<E>::Withdraw(Output output, Stamp at) {
  const std::uint32_t i = RecordOf(output);
  Record& r = records_[i];
  if (WhatOf(output) == kDeposed) {
    const Stamp before = EndOf(r);
    r.deposed.erase(std::find(r.deposed.begin(), r.deposed.end(), at));
    DeposedChanged(i, before, EndOf(r));
    return;
  }
  assert(r.present && r.birth == at);
  r.present = false;
  if (r.is_link) {
    links_.Remove(PlaceOf(r.level, points_[r.point].x), i);
    --links_present_;
    NotifyJoins(i, false, at, EndOf(r));
    NotifyGathers(i, false, at);
  } else {
    // No notification: a new one has been published, or its reader is removed as well.
    std::uint32_t& summit = points_[r.point].summit[r.level];
    if (summit == i) summit = kNone;
  }
}

template <template <class> class E>
void LeaderProgram<E>::Release(Output output) {
  if (WhatOf(output) != kRecord) return;
  assert(!records_[RecordOf(output)].present && records_[RecordOf(output)].deposed.empty());
  free_records_.push_back(RecordOf(output));
}

// Those between the old and the new end: the leader is visible from one of both only.
template <template <class> class E>
void LeaderProgram<E>::DeposedChanged(std::uint32_t link, Stamp before, Stamp now) {
  const Record& r = records_[link];
  if (before == now || !r.present) return;
  const bool longer = now == kNoStamp || (before != kNoStamp && engine_.Precedes(before, now));
  NotifyJoins(link, longer, longer ? before : now, longer ? now : before);
  if constexpr (kTraced) {
    engine_.NotifyChain(points_[r.point].operations, longer ? before : now);
  }
}

template <template <class> class E>
void LeaderProgram<E>::NotifyJoins(std::uint32_t link, bool appears, Stamp after, Stamp until) {
  if constexpr (kTraced) {
    const Record& r = records_[link];
    if (r.leader != r.point || !engine_.AnyAfter(after)) return;
    engine_.Notify(PlaceOf(r.level, points_[r.point].x), after, until,
                   [&](OpId op) { return MattersToJoin(op, link, appears); });
  }
}
template <template <class> class E>
void LeaderProgram<E>::NotifyGathers(std::uint32_t link, bool appears, Stamp after) {
  if constexpr (kTraced) {
    if (!engine_.AnyAfter(after)) return;
    const Record& r = records_[link];
    engine_.Notify(PlaceOf(r.level, points_[r.point].x), after, kNoStamp,
                   [&](OpId op) { return MattersToGather(op, link, appears); });
  }
}

template <template <class> class E>
bool LeaderProgram<E>::MattersToJoin(OpId op, std::uint32_t link, bool appears) const {
  if constexpr (kTraced) {
    const Record& r = records_[link];
    if (engine_.epoch(op) != EpochOf(kJoin, r.level)) return false;
    const Position x = points_[engine_.item(op)].x;
    if (!line_.InReach(x, points_[r.point].x, r.level)) return false;
    const auto reads = engine_.reads(op);
    if (reads.empty()) return appears;
    return appears ? IsNearer(x, r, records_[reads[0]]) : reads[0] == link;
  }
  return false;
}
template <template <class> class E>
bool LeaderProgram<E>::MattersToGather(OpId op, std::uint32_t link, bool appears) const {
  if constexpr (kTraced) {
    const Record& r = records_[link];
    if (engine_.epoch(op) != EpochOf(kGather, r.level)) return false;
    if (engine_.item(op) != r.leader) return false;
    if (r.point == r.leader) return true;
    const Weight known = engine_.payload(op).greatest;
    return appears ? r.value > known : r.value == known;
  }
  return false;
}

// --- Audit --------------------------------------------------------------------------------

// The hash of the trace by value, and whether every record present is its maker's.
template <template <class> class E>
std::uint64_t LeaderProgram<E>::Audit(std::vector<std::string>* problems) const {
  const auto hash_record = [&](std::uint32_t i) {
    const Record& r = records_[i];
    return Line::Mix(Line::Mix(points_[r.point].x, points_[r.leader].x),
                     Line::Mix(static_cast<unsigned>(r.level) * 2u + r.is_link, r.value));
  };
  std::size_t made = 0, present = 0;
  const auto hash_op = [&](OpId op) {
    std::uint64_t h = engine_.payload(op).greatest;
    for (const std::uint32_t i : engine_.reads(op)) h = Line::Mix(h, hash_record(i));
    for (const Output o : engine_.outputs(op)) {
      const Record& r = records_[RecordOf(o)];
      h += Line::Mix(hash_record(RecordOf(o)), WhatOf(o));
      if (!r.present) problems->push_back("an operation names a record that is not present");
      if (WhatOf(o) == kDeposed) continue;
      ++made;
      if (r.birth != engine_.stamp(op)) problems->push_back("a record's birth is another's");
    }
    return h;
  };
  const std::uint64_t hash =
      engine_.Audit([&](Kind kind, Item item) { return Line::Mix(points_[item].x, kind); }, hash_op,
                    [](OpId, std::uint64_t) {}, problems);
  for (const Record& r : records_) present += r.present;
  if (made != present) problems->push_back("a record is present that no operation made");
  return hash;
}

}  // namespace dynmesh::sac::testing

#endif  // DYNMESH_TESTS_CORE_SAC_LEADER_CHANGES_H_
