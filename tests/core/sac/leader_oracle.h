// The result of leader_program.h by definition: loops over all points, no engine.
#ifndef DYNMESH_TESTS_CORE_SAC_LEADER_ORACLE_H_
#define DYNMESH_TESTS_CORE_SAC_LEADER_ORACLE_H_

#include <algorithm>
#include <compare>
#include <cstdint>
#include <map>
#include <vector>

namespace dynmesh::sac::testing {

using Position = std::uint32_t;
using Weight = std::uint32_t;
inline constexpr int kMaxLevels = 16;

// The line [0, 2^log_side), on how many levels leaders are chosen, and how many bits of
// the hash make the order (few: many ties, which positions then break).
struct Line {
  int log_side;
  int levels;
  int priority_bits = 64;

  Position side() const { return Position{1} << log_side; }
  static Position Reach(int level) { return Position{1} << level; }
  static Position Distance(Position a, Position b) { return a < b ? b - a : a - b; }
  static bool InReach(Position a, Position b, int level) { return Distance(a, b) <= Reach(level); }
  Position Left(Position x, int level) const { return x - std::min(x, Reach(level)); }
  Position Right(Position x, int level) const { return std::min(x + Reach(level), side() - 1); }
  static bool IsNearer(Position to, Position a, Position b) {
    const Position da = Distance(to, a), db = Distance(to, b);
    return da != db ? da < db : a < b;
  }
  static std::uint64_t Mix(std::uint64_t a, std::uint64_t b) {
    std::uint64_t h = a * 0x9e3779b97f4a7c15ULL ^ (b + 0x2545f4914f6cdd1dULL);
    h = (h ^ (h >> 31)) * 0xbf58476d1ce4e5b9ULL;
    return h ^ (h >> 29);
  }
  std::uint64_t Priority(Position x, unsigned kind) const {
    return Mix(x, kind) & ~std::uint64_t{0} << (64 - priority_bits);
  }
};

// Level 0 to levels - 1: the leader that a point follows. Level 1 to levels: a leader's sum.
struct LeaderRow {
  int level;
  bool is_link;
  Position x, leader;
  Weight value;
  bool deposed;
  auto operator<=>(const LeaderRow&) const = default;
};

inline std::vector<LeaderRow> LeadersByDefinition(const std::map<Position, Weight>& input,
                                                  const Line& line) {
  std::vector<LeaderRow> rows;
  std::map<Position, Weight> present = input;
  for (int level = 0; level < line.levels; ++level) {
    std::vector<LeaderRow> order;
    for (const auto& [x, value] : present) order.push_back({level, true, x, x, value, false});
    std::stable_sort(order.begin(), order.end(), [&](const LeaderRow& a, const LeaderRow& b) {
      return line.Priority(a.x, 0) < line.Priority(b.x, 0);
    });
    for (std::size_t i = 0; i < order.size(); ++i) {
      LeaderRow* nearest = nullptr;
      for (std::size_t k = 0; k < i; ++k) {
        LeaderRow& r = order[k];
        if (r.leader != r.x || r.deposed || !Line::InReach(r.x, order[i].x, level)) continue;
        if (nearest == nullptr || Line::IsNearer(order[i].x, r.x, nearest->x)) nearest = &r;
      }
      if (nearest == nullptr) continue;
      if (order[i].value > nearest->value) {
        nearest->deposed = true;
      } else {
        order[i].leader = nearest->x;
      }
    }
    present.clear();
    for (const LeaderRow& q : order) {
      if (q.leader != q.x) continue;
      Weight greatest = 0;
      for (const LeaderRow& r : order) {
        if (r.leader == q.x && r.x != q.x) greatest = std::max(greatest, r.value);
      }
      rows.push_back({level + 1, false, q.x, q.x, q.value + greatest, false});
      if (!q.deposed) present[q.x] = q.value + greatest;
    }
    rows.insert(rows.end(), order.begin(), order.end());
  }
  std::sort(rows.begin(), rows.end());
  return rows;
}

}  // namespace dynmesh::sac::testing

#endif  // DYNMESH_TESTS_CORE_SAC_LEADER_ORACLE_H_
