// The sizing regions that came or went since the last propagation, and where that changes nothing.
//
// A region has no effect where another one asks for as much. So a change of a region is *hidden*
// where there is a region with the same target or a finer one, both without the change and with it:
// one that stays, or one that goes where this one comes, or comes where this one goes. A size that
// moves is hidden but for two crescents, whatever its area is.
//
// Why each change may be looked at by itself. Let B be the regions before, A those after. Whether a
// ball is too large, which lattice counts and what the least target is at a point: all are minima
// over the regions, so they are the same for B as for the union of B and A unless a region that
// came has an effect beside those of B; and the same for A unless one that went has an effect
// beside those of A. So what a region that came is compared with is B, and one that went A.
//
// If a propagation was interrupted while it settled the changes, what is there is partly that of
// other regions than B. Then only regions that were there all the time hide what came.
#ifndef DYNMESH_CORE_MESHING_SIZE_CHANGES_H_
#define DYNMESH_CORE_MESHING_SIZE_CHANGES_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/inlined_vector.h"
#include "core/geometry/point.h"
#include "core/meshing/extent.h"
#include "core/meshing/sizing_field.h"

namespace dynmesh::meshing {

// Thread-compatible.
template <int D>
class SizeChanges {
 public:
  using Point = geometry::Point<D>;
  using Region = SizingRegion<D>;
  using Field = SizingField<D>;
  using Index = typename Field::Index;

  struct Change {
    Region region;
    bool came = false;              // else it went
    Index index = 0;                // of what came
    const Region* other = nullptr;  // takes its place, or gives it its place: a size that moves
  };
  // A change, or the two of a size that moves.
  using Group = absl::InlinedVector<const Change*, 2>;

  // `present`: the regions that are there now, in the box from lo to hi. Must outlive this.
  SizeChanges(const Field& present, const Point& lo, const Point& hi)
      : present_(present), lo_(lo), hi_(hi), gone_(lo, hi) {}

  // Region `index` of the present ones has come.
  void Come(Index index) {
    came_[index] = list_.size();
    list_.push_back({present_[index], true, index});
  }
  // Region `index` of the present ones is about to go.
  void Go(Index index);
  // The changes are about to be settled. If that is interrupted, there is another Begin, perhaps
  // after further changes.
  void Begin();
  // All are settled.
  void Clear();

  bool empty() const { return list_.empty(); }
  const std::vector<Change>& list() const { return list_; }
  // The list by groups, after Begin.
  const std::vector<Group>& groups() const { return groups_; }

  // True if the change is certainly hidden everywhere, by a region in which all of the changed one
  // lies and for which counts(region) is true.
  template <class Counts>
  bool IsHidden(const Change& change, Counts counts) const {
    const Extent<D> box = change.region.Box();
    return InAny(change, [&](const Field& field, auto is_other) {
      return field.AnyAround(box, change.region.target, [&](Index i) {
        return field[i].Holds(change.region) && counts(field[i]) && is_other(i);
      });
    });
  }
  // True if the change is certainly hidden in all of the box, or of the ball.
  bool IsHidden(const Change& change, const Extent<D>& box) const;
  bool IsHidden(const Change& change, const Point& centre, double radius) const;
  // True if all balls that are too large for the region and meet it as well as this ball does
  // certainly meet a region that hides the change, too. `radius`: rounded down.
  bool IsHiddenFrom(const Change& change, const Point& centre, double radius) const;
  // True if accept(region) holds for a region near the ball that is there without the change and
  // with it. Calls accept for all of them that meet the ball and for some others.
  template <class Accept>
  bool AnyOther(const Change& change, const Point& centre, double radius, Accept accept) const;
  // The finest level of lattice that those regions have at all points of the ball; `below` if that
  // is not finer. Conservative in a ball, exact at a point.
  int LevelOver(const Change& change, const Point& centre, double radius, int below) const;
  // True if none but a region that takes the place of the changed one, or gives it its place, can
  // hide the change.
  bool IsMoveAlone(const Change& change) const {
    return change.other != nullptr && list_.size() == 2 && present_.size() == 1;
  }
  // False if there is certainly no such region.
  bool MayBeHidden(const Change& change) const {
    return change.came ? present_.size() > came_.size() || (!is_mixed_ && !gone_.empty())
                       : !present_.empty();
  }

 private:
  // True if visit(field, counts) is for a field of regions, those for which counts(index) is true.
  template <class Visit>
  bool InAny(const Change& change, Visit visit) const {
    const auto stays = [&](Index i) { return !change.came || !came_.contains(i); };
    if (visit(present_, stays)) return true;
    return change.came && !is_mixed_ && visit(gone_, [](Index) { return true; });
  }

  void Pair(std::size_t gone, std::size_t came);

  const Field& present_;
  const Point lo_, hi_;
  std::vector<Change> list_;
  std::vector<Group> groups_;
  absl::flat_hash_map<Index, std::size_t> came_;  // positions in the list
  Field gone_;                                    // what went before the first Begin
  bool is_begun_ = false, is_mixed_ = false;      // there was a Begin; there were two
};

// --- Implementation -------------------------------------------------------------------------

template <int D>
void SizeChanges<D>::Go(Index index) {
  const auto at = came_.find(index);
  if (at == came_.end()) {
    list_.push_back({present_[index], false, 0});
    if (!is_begun_) gone_.Add(present_[index]);
    return;
  }
  const std::size_t position = at->second;
  came_.erase(at);
  if (is_begun_) {
    list_[position].came = false;
    return;
  }
  if (position + 1 < list_.size()) {
    list_[position] = std::move(list_.back());
    if (list_[position].came) came_[list_[position].index] = position;
  }
  list_.pop_back();
}

template <int D>
void SizeChanges<D>::Begin() {
  is_mixed_ = is_begun_;
  is_begun_ = true;
  for (Change& change : list_) change.other = nullptr;
  std::vector<std::size_t> gone, came;
  for (std::size_t i = 0; i < list_.size(); ++i) (list_[i].came ? came : gone).push_back(i);
  // Each kind comes in the order of the features' ids.
  constexpr std::size_t kFew = 32;
  if (!is_mixed_ && gone.size() == came.size()) {
    for (std::size_t i = 0; i < gone.size(); ++i) Pair(gone[i], came[i]);
  } else if (!is_mixed_ && list_.size() <= kFew) {
    for (const std::size_t i : gone) {
      for (const std::size_t j : came) Pair(i, j);
    }
  }
  groups_.clear();
  for (const Change& change : list_) {
    if (change.other == nullptr) groups_.push_back({&change});
  }
  for (const std::size_t i : gone) {
    if (list_[i].other == nullptr) continue;
    const auto is_other = [&](std::size_t j) { return list_[j].other == &list_[i].region; };
    groups_.push_back({&list_[i], &list_[*std::ranges::find_if(came, is_other)]});
  }
}

// Makes them the two changes of a size that moves, if they may be: they overlap.
template <int D>
void SizeChanges<D>::Pair(std::size_t gone, std::size_t came) {
  Change &from = list_[gone], &to = list_[came];
  if (from.other != nullptr || to.other != nullptr) return;
  if (from.region.target != to.region.target) return;
  if (!from.region.MayMeet(to.region.Box())) return;
  from.other = &to.region;
  to.other = &from.region;
}

template <int D>
void SizeChanges<D>::Clear() {
  is_begun_ = is_mixed_ = false;
  if (list_.empty()) return;
  list_.clear();
  groups_.clear();
  came_.clear();
  if (!gone_.empty()) gone_ = Field(lo_, hi_);
}

template <int D>
bool SizeChanges<D>::IsHidden(const Change& change, const Extent<D>& box) const {
  if (change.other != nullptr && change.other->Holds(box)) return true;
  if (IsMoveAlone(change)) return false;
  return InAny(change, [&](const Field& field, auto counts) {
    return field.AnyAround(box, change.region.target,
                           [&](Index i) { return field[i].Holds(box) && counts(i); });
  });
}

template <int D>
bool SizeChanges<D>::IsHidden(const Change& change, const Point& centre, double radius) const {
  if (change.other != nullptr && change.other->Holds(centre, radius)) return true;
  if (IsMoveAlone(change)) return false;
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(centre, radius);
  return InAny(change, [&](const Field& field, auto counts) {
    return field.AnyAround(box, change.region.target,
                           [&](Index i) { return field[i].Holds(centre, radius) && counts(i); });
  });
}

template <int D>
bool SizeChanges<D>::IsHiddenFrom(const Change& change, const Point& centre, double radius) const {
  if (change.other != nullptr && change.other->Meets(centre, radius)) return true;
  if (IsMoveAlone(change)) return false;
  return InAny(change, [&](const Field& field, auto counts) {
    return field.AnyAsFine(centre, radius, change.region.target,
                           [&](Index i) { return field[i].Meets(centre, radius) && counts(i); });
  });
}

template <int D>
template <class Accept>
bool SizeChanges<D>::AnyOther(const Change& change, const Point& centre, double radius,
                              Accept accept) const {
  return InAny(change, [&](const Field& field, auto counts) {
    return field.AnyAsFine(centre, radius, INFINITY,
                           [&](Index i) { return counts(i) && accept(field[i]); });
  });
}

template <int D>
int SizeChanges<D>::LevelOver(const Change& change, const Point& centre, double radius,
                              int below) const {
  int level = below;
  InAny(change, [&](const Field& field, auto counts) {
    level = field.LevelOver(centre, radius, level, counts);
    return false;
  });
  return level;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SIZE_CHANGES_H_
