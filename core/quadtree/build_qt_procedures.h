// The procedures of build_qt.h, for sources that instantiate it.
#ifndef DYNMESH_CORE_QUADTREE_BUILD_QT_PROCEDURES_H_
#define DYNMESH_CORE_QUADTREE_BUILD_QT_PROCEDURES_H_

#include <utility>

#include "core/quadtree/build_qt.h"
#include "core/sac/engine_audit.h"

namespace dynmesh::quadtree {

template <int D, template <class> class E>
BuildQt<D, E>::BuildQt(const Grid<D>& grid)
    : grid_(grid), features_(grid_, cells_, shapes_), engine_(*this) {
  engine_.Request(kCrowd, kRoot, CrowdEpoch(0));
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

// All changes have been made, so the filter asks what the operations would find. It need not ask
// at most cells near a feature: one that comes makes no cell less crowded, one that goes none more
// crowded, and a cell that stays crowded has other children only if the feature meets it.
template <int D, template <class> class E>
bool BuildQt<D, E>::Propagate(absl::FunctionRef<bool()> interrupt) {
  NotifyOfInput();
  if (!engine_.Propagate(interrupt)) return false;
  Collect();
  return true;
}

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
    const auto stays_crowded = [&](const CellRecord& r) {
      return r.is_crowded && r.is_open && r.common.are_apart();
    };
    if (engine_.AnyAfter(beginning)) {
      for (const ShapeIndex shape : gone_) {
        features_.ForEachNear(shape, [&](CellIndex i, auto may_meet) {
          const CellRecord& r = cells_[i];
          if (r.is_crowded && (!stays_crowded(r) || may_meet())) notify(i);
        });
      }
      for (const ShapeIndex shape : come_) {
        features_.ForEachNear(shape, [&](CellIndex i, auto may_meet) {
          const CellRecord& r = cells_[i];
          if (!(r.is_crowded && r.is_open) || may_meet()) notify(i);
        });
      }
    }
  }
  free_shapes_.insert(free_shapes_.end(), gone_.begin(), gone_.end());
  gone_.clear();
  come_.clear();
}

// What Crowd records. A crowded cell that is not open yet has other children than any record.
template <int D, template <class> class E>
std::uint32_t BuildQt<D, E>::ChildrenOf(CellIndex i) {
  if (!features_.IsCrowded(i)) return 0;
  return cells_[i].is_open ? features_.ChildrenMet(i) : ~std::uint32_t{0};
}

template <int D, template <class> class E>
void BuildQt<D, E>::Crowd(Context& context) {
  const CellIndex i = context.item;
  context.payload().children = 0;
  if (!features_.IsCrowded(i)) return;
  if (!cells_[i].is_open) features_.Open(i);
  context.Emit(OutputOf(i, kIsCrowded));
  const int level = cells_.LevelOf(i);
  const std::uint32_t children = features_.ChildrenMet(i);
  context.payload().children = children;
  for (int which = 0; which < Key::kChildren; ++which) {
    if ((children >> which & 1) == 0) continue;
    context.Request(kCrowd, cells_.ChildOf(i, which), CrowdEpoch(level + 1));
  }
  RequestGrade(context, i, GradeEpoch(level));
}

// The cells of twice its side that touch it: its parent, and those beside the parent on its sides.
template <int D, template <class> class E>
void BuildQt<D, E>::Grade(Context& context) {
  const CellIndex i = context.item;
  context.Emit(OutputOf(i, kIsSplit));
  if (i == kRoot) return;
  const CellIndex parent = cells_.ParentOf(i);
  const sac::Epoch epoch = GradeEpoch(cells_.LevelOf(parent));
  const auto which = static_cast<std::size_t>(CellTree<D>::WhichOf(i));
  for (const std::size_t offset : Offsets<D>::kTouching[which]) {
    const CellIndex coarser = cells_.MakeBeside(parent, offset);
    if (coarser != kNone) RequestGrade(context, coarser, epoch);
  }
}

template <int D, template <class> class E>
void BuildQt<D, E>::RequestGrade(Context& context, CellIndex i, sac::Epoch epoch) {
  // Without a trace requests are not counted: one is enough.
  if (!kTraced && cells_[i].is_graded) return;
  cells_[i].is_graded = true;
  context.Request(kGrade, i, epoch);
}

template <int D, template <class> class E>
void BuildQt<D, E>::SetSplit(CellIndex i, bool is_split) {
  CellRecord& r = cells_[i];
  if (r.is_split != is_split) is_split ? ++split_count_ : --split_count_;
  r.is_split = is_split;
  if (r.is_changed) return;
  r.is_changed = true;
  changed_.push_back(i);
}

template <int D, template <class> class E>
void BuildQt<D, E>::Publish(sac::Output output, sac::Stamp) {
  const CellIndex i = output >> 1;
  if ((output & 1) == kIsSplit) {
    cells_.MakeChildren(i);
    return SetSplit(i, true);
  }
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
  if ((output & 1) == kIsCrowded && !cells_[i].is_crowded) features_.Close(i);
  cells_.MayBeUnused(i);
}

template <int D, template <class> class E>
void BuildQt<D, E>::Collect() {
  features_.CloseEmpty();
  cells_.FreeUnused();
}

template <int D, template <class> class E>
Cell<D> BuildQt<D, E>::LeafAt(const geometry::Point<D>& x) const {
  CellIndex i = kRoot;
  Key cell;
  while (cells_[i].is_split) {
    const int which = grid_.ChildAt(cell, x);
    i = cells_.ChildOf(i, which);
    cell = cell.Child(which);
  }
  return cell;
}

template <int D, template <class> class E>
std::vector<Cell<D>> BuildQt<D, E>::Leaves() const {
  std::vector<Key> leaves;
  leaves.reserve(leaf_count());
  ForEachLeaf([&](const Key& leaf) { leaves.push_back(leaf); });
  return leaves;
}

// A cell that is split now and was not before: it was a leaf if its parent was split. Those of its
// children that are not split are leaves now. The other way round the same.
template <int D, template <class> class E>
LeafDiff<D> BuildQt<D, E>::TakeChanges() {
  LeafDiff<D> diff;
  for (const CellIndex i : changed_) {
    const CellRecord& r = cells_[i];
    if (r.is_split == r.was_split) continue;
    const auto is_split = [&](CellIndex j) { return cells_[j].is_split; };
    const auto was_split = [&](CellIndex j) { return cells_[j].was_split; };
    const auto report = [&](auto with_cell, auto without_cell, auto& leaf, auto& children) {
      const Key cell = cells_.CellOf(i);
      if (i == kRoot || without_cell(cells_.ParentOf(i))) leaf.push_back(cell);
      for (int which = 0; which < Key::kChildren; ++which) {
        if (!with_cell(cells_.ChildOf(i, which))) children.push_back(cell.Child(which));
      }
    };
    if (r.is_split) {
      report(is_split, was_split, diff.removed, diff.added);
    } else {
      report(was_split, is_split, diff.added, diff.removed);
    }
  }
  for (const CellIndex i : changed_) {
    cells_[i].was_split = cells_[i].is_split;
    cells_[i].is_changed = false;
    cells_.MayBeUnused(i);
    if (i != kRoot) cells_.MayBeUnused(cells_.ParentOf(i));
  }
  changed_.clear();
  cells_.FreeUnused();
  return diff;
}

template <int D, template <class> class E>
std::size_t BuildQt<D, E>::bytes() const {
  std::size_t bytes = cells_.bytes() + features_.bytes() + shapes_.capacity() * sizeof(Shape<D>);
  if constexpr (kTraced) bytes += engine_.bytes();
  return bytes;
}

template <int D, template <class> class E>
std::uint64_t BuildQt<D, E>::Audit(std::vector<std::string>* problems) const {
  if constexpr (!kTraced) {
    return 0;
  } else {
    const auto hash_of = [&](CellIndex i, std::uint64_t what) {
      return Mix(cells_.CellOf(i).Hash() ^ what);
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

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_BUILD_QT_PROCEDURES_H_
