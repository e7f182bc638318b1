// A small program for the self-adjusting engine, complete.
//
// THE PROBLEM. Points with weights on a line of integers choose leaders, level by level.
// At level l the points take turns in a fixed random order. A point looks at the nearest leader
// (ties: the left one) that is within 2^l of it and not deposed so far. If there is none, the point
// becomes a leader. If the point has a greater value, it deposes that leader and becomes one. Else
// it follows that leader. After all turns, the greatest value among a leader's followers is added
// to its own, and leaders not deposed enter level l+1. leader_oracle.h does the same in forty lines
// of plain loops.
//
// This file has the class and the procedures; leader_changes.h publishes their outputs and sends
// the notifications.
//
// The rules for programs are in docs/engine.md. Operations here: Join(point, level) is a point's
// turn; Gather(leader, level) sums a leader up. Epochs are 2l for Join, 2l+1 for Gather. Objects are
// Records; the state Deposed makes a record invisible from its time on.
//
// The places are the nodes of a binary tree over the line; level l is at height l + fold, and
// Fold() moves everything one height up, like a tree that merges leaves.
#ifndef DYNMESH_TESTS_CORE_SAC_LEADER_PROGRAM_H_
#define DYNMESH_TESTS_CORE_SAC_LEADER_PROGRAM_H_

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "core/sac/engine.h"
#include "core/sac/subscriptions.h"
#include "core/sac/untraced_engine.h"
#include "tests/core/sac/leader_oracle.h"

namespace dynmesh::sac {
namespace testing {
template <template <class> class EngineTemplate>
class LeaderProgram;

struct LeaderPayload {
  Weight greatest = 0;  // Gather: of the followers' values
};
}  // namespace testing

template <template <class> class EngineTemplate>
struct PayloadOf<testing::LeaderProgram<EngineTemplate>> {
  using Type = testing::LeaderPayload;
};

namespace testing {

enum LeaderKind : Kind { kJoin = 0, kGather = 1 };

template <template <class> class EngineTemplate>
class LeaderProgram {
 public:
  using Engine = EngineTemplate<LeaderProgram>;
  using Context = typename Engine::Context;
  static constexpr bool kTraced = Engine::kTraced;

  // Folds the places once more than `fold_at` << (times folded) links are present.
  explicit LeaderProgram(const Line& line, std::size_t fold_at = ~std::size_t{0} >> 32)
      : line_(line), fold_at_(fold_at), engine_(*this) {}

  // --- Input, between propagations --------------------------------------------------

  void Add(Position x, Weight weight) {
    const Item p = NewPoint();
    points_[p].x = x;
    points_[p].weight = weight;
    input_[x] = p;
    engine_.Request(kJoin, p, EpochOf(kJoin, 0));
  }
  void Remove(Position x) {
    const Item p = input_.at(x);
    engine_.Unrequest(kJoin, p, EpochOf(kJoin, 0));
    removed_.push_back(p);  // its operations still have to find it
    input_.erase(x);
  }
  // Input changed in place, which the operations of the point read.
  void SetWeight(Position x, Weight weight) {
    Point& p = points_[input_.at(x)];
    if (p.weight == weight) return;
    p.weight = weight;
    engine_.NotifyChain(p.operations, engine_.beginning());
  }

  template <class Interrupt>
  bool Propagate(Interrupt interrupt) {
    if (!engine_.Propagate(interrupt)) return false;
    free_points_.insert(free_points_.end(), removed_.begin(), removed_.end());
    removed_.clear();
    return true;
  }
  bool Propagate() {
    return Propagate([] { return false; });
  }

  // Moves all places one height up. False if they are as coarse as can be.
  bool Fold() {
    if (fold_ + line_.levels > line_.log_side) return false;
    for (int level = line_.levels - 1; level >= 0; --level) {
      const Place end = PlaceOf(level, line_.side() - 1) + 1;
      for (Place place = PlaceOf(level, 0); place < end; ++place) {
        if constexpr (kTraced) {
          for (const OpId op : engine_.subscriptions().Take(place)) {
            engine_.ReplacePlace(op, place, place / 2);
          }
        }
        for (const std::uint32_t link : links_.Take(place)) links_.Add(place / 2, link);
      }
    }
    ++fold_;
    return true;
  }

  // --- Results ------------------------------------------------------------------------

  std::vector<LeaderRow> Rows() const {
    std::vector<LeaderRow> rows;
    for (const Record& r : records_) {
      if (!r.present) continue;
      rows.push_back({r.level, r.is_link, points_[r.point].x, points_[r.leader].x, r.value,
                      !r.deposed.empty()});
    }
    std::sort(rows.begin(), rows.end());
    return rows;
  }
  Engine& engine() { return engine_; }
  const Engine& engine() const { return engine_; }
  int folds() const { return fold_; }
  std::size_t record_limit() const { return records_.size(); }
  std::uint64_t Audit(std::vector<std::string>* problems) const;
  // To plant corruption: the engine's own data.
  OpId& OperationsAt(Position x) { return points_[input_.at(x)].operations; }
  Position& PositionAt(Position x) { return points_[input_.at(x)].x; }
  std::uint32_t AnyPresentLink() const {
    std::uint32_t i = 0;
    while (!records_[i].present || !records_[i].is_link) ++i;
    return i;
  }
  Weight& ValueOf(std::uint32_t record) { return records_[record].value; }

  // --- For the engine -----------------------------------------------------------------

  std::uint64_t Priority(Kind kind, Item item) const {
    return line_.Priority(points_[item].x, kind);
  }
  bool Before(Kind kind_a, Item a, Kind kind_b, Item b) const {
    return kind_a != kind_b ? kind_a < kind_b : points_[a].x < points_[b].x;
  }
  OpId& OperationsOf(Kind, Item item) { return points_[item].operations; }
  void Execute(Context& context) { context.kind == kJoin ? Join(context) : Gather(context); }
  void Publish(Output output, Stamp at);
  void Withdraw(Output output, Stamp at);
  void Release(Output output);

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};

  struct Point {
    Position x = 0;
    Weight weight = 0;
    OpId operations = kNoOp;
    std::array<std::uint32_t, kMaxLevels + 1> summit;  // records, by level
  };
  // A link has the leader that a point follows; a summit has a leader's sum for the next level.
  // Objects never change: another value is another record.
  struct Record {
    bool is_link = false;
    bool present = false;
    int level = 0;
    Item point = 0, leader = 0;
    Weight value = 0;  // of the point
    Stamp birth = kNoStamp;
    std::vector<Stamp> deposed;  // times at which someone deposes this leader
  };
  enum Made : std::uint32_t { kRecord, kDeposed };
  static Output MakeOutput(Made what, std::uint32_t record) { return record << 1 | what; }
  static Made WhatOf(Output o) { return static_cast<Made>(o & 1); }
  static std::uint32_t RecordOf(Output o) { return o >> 1; }
  static Epoch EpochOf(Kind kind, int level) { return 2 * static_cast<Epoch>(level) + kind; }
  static int LevelOf(Epoch epoch) { return static_cast<int>(epoch / 2); }

  void Join(Context& context);
  void Gather(Context& context);
  Weight ValueAt(Item p, int level) const {
    if (level == 0) return points_[p].weight;
    return records_[points_[p].summit[level]].value;
  }
  bool IsVisible(const Context& context, const Record& r) const {
    return context.Sees(r.birth) && !(!r.deposed.empty() && context.Sees(EndOf(r)));
  }
  Stamp EndOf(const Record& r) const {
    Stamp end = kNoStamp;
    for (const Stamp s : r.deposed) end = end == kNoStamp || engine_.Precedes(s, end) ? s : end;
    return end;
  }
  bool IsNearer(Position to, const Record& a, const Record& b) const {
    return Line::IsNearer(to, points_[a.leader].x, points_[b.leader].x);
  }
  void EmitRecord(Context& context, const Record& wanted);

  Place PlaceOf(int level, Position x) const {
    const int height = level + fold_;
    return (Place{1} << (line_.log_side - height)) + (x >> height);
  }
  template <class F>  // f(place) for places that cover what is in reach of x
  void ForPlacesNear(int level, Position x, F f) const {
    const Place end = PlaceOf(level, line_.Right(x, level));
    for (Place place = PlaceOf(level, line_.Left(x, level)); place <= end; ++place) f(place);
  }
  template <class F>  // f(record index) for links of this level near x, and farther ones
  void ForLinksNear(int level, Position x, F f) const {
    ForPlacesNear(level, x, [&](Place place) {
      for (const auto& [i, parts] : links_.at(place)) {
        if (records_[i].level == level) f(i);
      }
    });
  }
  void NotifyJoins(std::uint32_t link, bool appears, Stamp after, Stamp until);
  void NotifyGathers(std::uint32_t link, bool appears, Stamp after);
  bool MattersToJoin(OpId op, std::uint32_t link, bool appears) const;
  bool MattersToGather(OpId op, std::uint32_t link, bool appears) const;
  void DeposedChanged(std::uint32_t link, Stamp before, Stamp now);

  Item NewPoint() {
    if (free_points_.empty()) {
      points_.emplace_back();
      free_points_.push_back(static_cast<Item>(points_.size() - 1));
    }
    const Item p = free_points_.back();
    free_points_.pop_back();
    points_[p] = {};
    points_[p].summit.fill(kNone);
    return p;
  }

  const Line line_;
  const std::size_t fold_at_;
  int fold_ = 0;
  std::map<Position, Item> input_;
  std::vector<Point> points_;
  std::vector<Item> free_points_, removed_;
  std::vector<Record> records_;
  std::vector<std::uint32_t> free_records_;
  std::size_t links_present_ = 0;
  Subscriptions links_;  // by place: where links are
  Engine engine_;
};

// --- The procedures: the same for every engine ------------------------------------------

template <template <class> class E>
void LeaderProgram<E>::Join(Context& context) {
  const int level = LevelOf(context.epoch);
  const Item p = context.item;
  const Position x = points_[p].x;
  std::uint32_t nearest = kNone;
  ForLinksNear(level, x, [&](std::uint32_t i) {
    const Record& r = records_[i];
    if (r.leader != r.point || !line_.InReach(x, points_[r.point].x, level)) return;
    if (!IsVisible(context, r)) return;
    if (nearest == kNone || IsNearer(x, r, records_[nearest])) nearest = i;
  });
  const Weight value = ValueAt(p, level);
  Item leader = p;
  if (nearest != kNone) {
    context.Read(nearest);
    if (value > records_[nearest].value) {
      context.Emit(MakeOutput(kDeposed, nearest));
    } else {
      leader = records_[nearest].leader;
    }
  }
  Record link;
  link.is_link = true;
  link.level = level;
  link.point = p;
  link.leader = leader;
  link.value = value;
  EmitRecord(context, link);
  context.Request(kGather, leader, EpochOf(kGather, level));  // as all its followers do
  ForPlacesNear(level, x, [&](Place place) { context.Subscribe(place); });
}

template <template <class> class E>
void LeaderProgram<E>::Gather(Context& context) {
  const int level = LevelOf(context.epoch);
  const Item q = context.item;
  Record summit;
  summit.level = level + 1;
  summit.point = summit.leader = q;
  bool deposed = false;
  Weight own = 0, greatest = 0;
  ForLinksNear(level, points_[q].x, [&](std::uint32_t i) {
    const Record& r = records_[i];
    if (r.leader != q) return;
    if (r.point == q) {
      own = r.value;
      deposed = !r.deposed.empty();
    } else {
      greatest = std::max(greatest, r.value);
    }
  });
  context.payload().greatest = greatest;
  summit.value = own + greatest;
  EmitRecord(context, summit);
  if (!deposed && level + 1 < line_.levels) context.Request(kJoin, q, EpochOf(kJoin, level + 1));
  ForPlacesNear(level, points_[q].x, [&](Place place) { context.Subscribe(place); });
}

// A record of the previous execution is kept if it says the same.
template <template <class> class E>
void LeaderProgram<E>::EmitRecord(Context& context, const Record& wanted) {
  for (const Output o : context.old_outputs()) {
    if (WhatOf(o) != kRecord) continue;
    const Record& old = records_[RecordOf(o)];
    assert(old.present && old.point == wanted.point && old.level == wanted.level);
    if (old.leader == wanted.leader && old.value == wanted.value) return context.Emit(o);
  }
  if (free_records_.empty()) {
    records_.emplace_back();
    free_records_.push_back(static_cast<std::uint32_t>(records_.size() - 1));
  }
  const std::uint32_t i = free_records_.back();
  free_records_.pop_back();
  records_[i] = wanted;
  records_[i].birth = context.now;
  context.Emit(MakeOutput(kRecord, i));
}

}  // namespace testing
}  // namespace dynmesh::sac

#endif  // DYNMESH_TESTS_CORE_SAC_LEADER_PROGRAM_H_
