// BuildQT: the size-conforming quadtree (octree, ...) of a set of features, as a program for the
// self-adjusting engine (Hudson, Dynamic Mesh Refinement, secs. 4.1, 5.1, 6.1).
//
// A cell of the root's tree is split if it is crowded (feature_tree.h), or *ill-graded*: it touches
// a cell of half its side that is split. The result:
//   * cells that touch differ in side by a factor 2 at most;
//   * the local feature size at x is between 1/4 and 4.5 sqrt(D) times the side of x's leaf
//     (Thm 4.1.4).
//
// The split cells are the least fixed point of that rule. It needs no order and no reasons of
// splits (Fig. 4.4), as it has a closed form, level by level:
//   K_l = crowded cells of level l      a function of the features near each; from the root down
//   S_l = K_l and all cells of level l that touch a cell of S_{l+1}          from the finest up
// S_l holds the parents of S_{l+1}, so it is a tree. Two kinds of operation, one a cell:
//   Crowd(c)  at time l: reads the features near c. If c is crowded, requests Grade(c), and
//             Crowd of each child that a feature meets.
//   Grade(c)  at time (levels) + (levels - l): outputs that c is split, and requests Grade of the
//             cells of twice its side that touch it. It reads nothing: its requests keep count of
//             the reasons why a cell is split.
// An edit changes O(1) cells a level in K near the feature, for each m_f; and in S what these are
// the reason for, O(1) cells a level around them. So it runs O(m_f lg L/s) operations.
//
// The result is a function of the set of features and the grid. Thread-compatible.
#ifndef DYNMESH_CORE_QUADTREE_BUILD_QT_H_
#define DYNMESH_CORE_QUADTREE_BUILD_QT_H_

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/quadtree/cell.h"
#include "core/quadtree/cell_tree.h"
#include "core/quadtree/feature_tree.h"
#include "core/quadtree/shape.h"
#include "core/sac/engine.h"
#include "core/sac/untraced_engine.h"

namespace dynmesh::quadtree {

template <int D, template <class> class E>
class BuildQt;

struct CrowdPayload {
  // Of a crowded cell: bit i if a feature meets child i. Else 0.
  std::uint32_t children = 0;
};

}  // namespace dynmesh::quadtree

template <int D, template <class> class E>
struct dynmesh::sac::PayloadOf<dynmesh::quadtree::BuildQt<D, E>> {
  using Type = dynmesh::quadtree::CrowdPayload;
};

namespace dynmesh::quadtree {

// A change of the leaves. Neither is sorted.
template <int D>
struct LeafDiff {
  std::vector<Cell<D>> removed, added;
};

template <int D, template <class> class E>
class BuildQt {
 public:
  using Engine = E<BuildQt>;
  using Context = typename Engine::Context;
  using Key = Cell<D>;
  static constexpr bool kTraced = Engine::kTraced;

  explicit BuildQt(const Grid<D>& grid);
  BuildQt(const BuildQt&) = delete;
  BuildQt& operator=(const BuildQt&) = delete;

  // --- Input, between propagations -----------------------------------------------------------

  // The index is the caller's until Remove. REQUIRES: the shape is in the root.
  ShapeIndex Add(Shape<D> shape);
  void Remove(ShapeIndex shape);

  // Runs what is due. `interrupt()` is called before each operation; if it returns true, Propagate
  // returns false, and another call, possibly after further changes, continues.
  bool Propagate(absl::FunctionRef<bool()> interrupt);
  bool Propagate() { return Propagate(sac::NoInterrupt()); }

  // --- Results --------------------------------------------------------------------------------

  const Grid<D>& grid() const { return grid_; }
  // The leaf that x is in, on borders the upper one. O(depth).
  Key LeafAt(const geometry::Point<D>& x) const;
  // Calls f(leaf) for each, in the order of a walk, lower children first. O(leaves).
  template <class F>
  void ForEachLeaf(F f) const {
    ForEachLeafIn(kRoot, Key(), f);
  }
  // In the same order.
  std::vector<Key> Leaves() const;
  std::size_t leaf_count() const { return 1 + split_count_ * (Key::kChildren - 1); }
  // Since the last call, or the construction. O(change).
  LeafDiff<D> TakeChanges();

  const Engine& engine() const { return engine_; }
  Engine& engine() { return engine_; }
  // Records of cells: leaves, inner cells, and some that wait to be reused.
  std::size_t cell_count() const { return cells_.size(); }
  std::size_t bytes() const;
  // The hash of the trace; see sac::Engine::Audit.
  std::uint64_t Audit(std::vector<std::string>* problems) const;

  // --- For the engine (program.h) -------------------------------------------------------------

  // In the order of a curve, not at random: a run from scratch takes two thirds of the time, as
  // neighbours come one after the other. Where cells cluster, an epoch becomes a search tree
  // (epoch_order.h).
  std::uint64_t Priority(sac::Kind, sac::Item item) const { return cells_.MortonOf(item); }
  bool Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const {
    return kind_a != kind_b ? kind_a < kind_b : cells_.CellOf(a) < cells_.CellOf(b);
  }
  sac::OpId& OperationsOf(sac::Kind, sac::Item item) { return cells_[item].operations; }
  const sac::OpId& OperationsOf(sac::Kind, sac::Item item) const { return cells_[item].operations; }
  void Execute(Context& context) { context.kind == kCrowd ? Crowd(context) : Grade(context); }
  void Publish(sac::Output output, sac::Stamp at);
  void Withdraw(sac::Output output, sac::Stamp at);
  void Release(sac::Output output);

 private:
  enum : sac::Kind { kCrowd, kGrade };
  enum : std::uint32_t { kIsCrowded, kIsSplit };
  static sac::Output OutputOf(CellIndex i, std::uint32_t what) { return i << 1 | what; }

  sac::Epoch CrowdEpoch(int level) const { return static_cast<sac::Epoch>(level); }
  sac::Epoch GradeEpoch(int level) const {
    return static_cast<sac::Epoch>(2 * kMostLevel + 1 - level);
  }
  void Crowd(Context& context);
  void Grade(Context& context);
  void RequestGrade(Context& context, CellIndex i, sac::Epoch epoch);
  void NotifyOfInput();
  void Collect();
  void SetSplit(CellIndex i, bool is_split);
  template <class F>
  void ForEachLeafIn(CellIndex i, const Key& cell, F& f) const {
    if (!cells_[i].is_split) return f(cell);
    for (int which = 0; which < Key::kChildren; ++which) {
      ForEachLeafIn(cells_.ChildOf(i, which), cell.Child(which), f);
    }
  }
  std::uint32_t ChildrenOf(CellIndex i);

  const Grid<D> grid_;
  CellTree<D> cells_;
  std::vector<Shape<D>> shapes_;
  std::vector<ShapeIndex> free_shapes_;
  FeatureTree<D> features_;
  Engine engine_;
  std::vector<ShapeIndex> come_, gone_;  // since the last propagation
  std::vector<CellIndex> changed_;
  std::size_t split_count_ = 0;
};

extern template class BuildQt<2, sac::Engine>;
extern template class BuildQt<2, sac::UntracedEngine>;
extern template class BuildQt<3, sac::Engine>;
extern template class BuildQt<3, sac::UntracedEngine>;

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_BUILD_QT_H_
