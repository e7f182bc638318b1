#include "core/quadtree/build_qt.h"

#include <algorithm>
#include <utility>

#include "core/sac/engine_audit.h"

namespace dynmesh::quadtree {

using geometry::Point;

template <int D, template <class> class E>
BuildQt<D, E>::BuildQt(const Grid<D>& grid)
    : grid_(grid), features_(grid_, cells_, shapes_), engine_(*this) {
  engine_.Request(kCrowd, features_.root(), CrowdEpoch(0));
}

template <int D, template <class> class E>
ShapeIndex BuildQt<D, E>::Add(Shape<D> shape) {
  ShapeIndex index;
  if (free_shapes_.empty()) {
    index = static_cast<ShapeIndex>(shapes_.size());
    shapes_.push_back(std::move(shape));
  } else {
    index = free_shapes_.back();
    free_shapes_.pop_back();
    shapes_[index] = std::move(shape);
  }
  features_.Add(index);
  if (kTraced) come_.push_back(index);
  return index;
}

template <int D, template <class> class E>
void BuildQt<D, E>::Remove(ShapeIndex shape) {
  features_.Remove(shape);
  gone_.push_back(shape);
}

// All changes have been made, so the filter asks what the operations would find.
template <int D, template <class> class E>
void BuildQt<D, E>::NotifyOfInput() {
  if constexpr (kTraced) {
    const sac::Stamp beginning = engine_.beginning();
    const auto notify = [&](CellIndex i) {
      for (sac::OpId op = cells_[i].operations; op != sac::kNoOp; op = engine_.next_of_item(op)) {
        if (engine_.kind(op) != kCrowd) continue;
        engine_.NotifyOperation(op, beginning, sac::kNoStamp, [&](sac::OpId id) {
          return engine_.payload(id).children != ChildrenOf(i);
        });
      }
    };
    if (engine_.AnyAfter(beginning)) {
      for (const ShapeIndex shape : gone_) features_.ForEachNear(shape, notify);
      for (const ShapeIndex shape : come_) features_.ForEachNear(shape, notify);
    }
  }
  free_shapes_.insert(free_shapes_.end(), gone_.begin(), gone_.end());
  gone_.clear();
  come_.clear();
}

// What Crowd records. A cell that is not open, but crowded, has other children than any record.
template <int D, template <class> class E>
std::uint32_t BuildQt<D, E>::ChildrenOf(CellIndex i) const {
  if (!features_.IsCrowded(i)) return 0;
  std::uint32_t children = 0;
  if (!cells_[i].is_open) return ~children;
  for (int which = 0; which < Key::kChildren; ++which) {
    if (features_.ChildOf(i, which) != kNone) children |= 1u << which;
  }
  return children;
}

template <int D, template <class> class E>
void BuildQt<D, E>::Crowd(Context& context) {
  const CellIndex i = context.item;
  context.payload().children = 0;
  if (!features_.IsCrowded(i)) return;
  if (!cells_[i].is_open) features_.Open(i);
  context.Emit(OutputOf(i, kIsCrowded));
  const int level = cells_[i].cell.level;
  for (int which = 0; which < Key::kChildren; ++which) {
    const CellIndex child = features_.ChildOf(i, which);
    if (child == kNone) continue;
    context.payload().children |= 1u << which;
    context.Request(kCrowd, child, CrowdEpoch(level + 1));
  }
  context.Request(kGrade, i, GradeEpoch(level));
}

template <int D, template <class> class E>
void BuildQt<D, E>::Grade(Context& context) {
  context.Emit(OutputOf(context.item, kIsSplit));
  const Key cell = cells_[context.item].cell;
  ForEachCoarserTouching(cell, [&](const Key& coarser) {
    context.Request(kGrade, cells_.FindOrAdd(coarser), GradeEpoch(coarser.level));
  });
}

template <int D, template <class> class E>
void BuildQt<D, E>::SetSplit(CellIndex i, bool is_split) {
  CellRecord<D>& r = cells_[i];
  r.is_split = is_split;
  if (std::exchange(r.is_changed, true)) return;
  changed_.push_back(i);
}

template <int D, template <class> class E>
void BuildQt<D, E>::Publish(sac::Output output, sac::Stamp) {
  const CellIndex i = output >> 1;
  if ((output & 1) == kIsSplit) return SetSplit(i, true);
  cells_[i].is_crowded = true;
}
template <int D, template <class> class E>
void BuildQt<D, E>::Withdraw(sac::Output output, sac::Stamp) {
  const CellIndex i = output >> 1;
  if ((output & 1) == kIsSplit) return SetSplit(i, false);
  cells_[i].is_crowded = false;
}
template <int D, template <class> class E>
void BuildQt<D, E>::Release(sac::Output output) {
  const CellIndex i = output >> 1;
  if ((output & 1) == kIsCrowded && !cells_[i].is_crowded && cells_[i].is_listed) {
    features_.Close(i);
  }
  cells_.MayBeUnused(i);
}

template <int D, template <class> class E>
void BuildQt<D, E>::Collect() {
  features_.ForgetEmpty();
  cells_.FreeUnused();
}

template <int D, template <class> class E>
Cell<D> BuildQt<D, E>::LeafAt(const Point<D>& x) const {
  Key cell;
  while (IsSplit(cell)) cell = cell.Child(grid_.ChildAt(cell, x));
  return cell;
}

template <int D, template <class> class E>
std::vector<Cell<D>> BuildQt<D, E>::Leaves() const {
  std::vector<Key> leaves, open = {Key()};
  while (!open.empty()) {
    const Key cell = open.back();
    open.pop_back();
    if (!IsSplit(cell)) {
      leaves.push_back(cell);
      continue;
    }
    for (int which = 0; which < Key::kChildren; ++which) open.push_back(cell.Child(which));
  }
  std::sort(leaves.begin(), leaves.end());
  return leaves;
}

template <int D, template <class> class E>
LeafDiff<D> BuildQt<D, E>::TakeChanges() {
  LeafDiff<D> diff;
  for (const CellIndex i : changed_) {
    const CellRecord<D>& r = cells_[i];
    if (r.is_split == r.was_split) continue;
    const Key cell = r.cell;
    // It was a leaf, or is one now, unless its parent was or is one.
    auto& parent_side = r.is_split ? diff.removed : diff.added;
    const bool is_whole = cell.level == 0;
    if (is_whole || (r.is_split ? WasSplit(cell.Parent()) : IsSplit(cell.Parent()))) {
      parent_side.push_back(cell);
    }
    auto& child_side = r.is_split ? diff.added : diff.removed;
    for (int which = 0; which < Key::kChildren; ++which) {
      const Key child = cell.Child(which);
      if (!(r.is_split ? IsSplit(child) : WasSplit(child))) child_side.push_back(child);
    }
  }
  for (const CellIndex i : changed_) {
    cells_[i].was_split = cells_[i].is_split;
    cells_[i].is_changed = false;
    cells_.MayBeUnused(i);
  }
  changed_.clear();
  cells_.FreeUnused();
  std::sort(diff.removed.begin(), diff.removed.end());
  std::sort(diff.added.begin(), diff.added.end());
  return diff;
}

template <int D, template <class> class E>
std::size_t BuildQt<D, E>::bytes() const {
  std::size_t bytes = cells_.bytes() + shapes_.capacity() * sizeof(Shape<D>);
  if constexpr (kTraced) bytes += engine_.bytes();
  return bytes;
}

template <int D, template <class> class E>
std::uint64_t BuildQt<D, E>::Audit(std::vector<std::string>* problems) const {
  if constexpr (!kTraced) {
    return 0;
  } else {
    const auto hash_of = [&](CellIndex i, std::uint64_t what) {
      return Mix(cells_[i].cell.Hash() ^ what);
    };
    return engine_.Audit([&](sac::Kind kind, sac::Item item) { return hash_of(item, kind); },
                         [&](sac::OpId op) {
                           std::uint64_t h = Mix(engine_.payload(op).children);
                           for (const sac::Output o : engine_.outputs(op)) {
                             h += hash_of(o >> 1, 2 + (o & 1));
                           }
                           return h;
                         },
                         [](sac::OpId, std::uint64_t) {}, problems);
  }
}

template class BuildQt<2, sac::Engine>;
template class BuildQt<2, sac::UntracedEngine>;
template class BuildQt<3, sac::Engine>;
template class BuildQt<3, sac::UntracedEngine>;
template class BuildQt<4, sac::Engine>;
template class BuildQt<4, sac::UntracedEngine>;

}  // namespace dynmesh::quadtree
