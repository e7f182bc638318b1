// Finds which of n boxes meet a box: a tree over their centres, built once.
//
// Boxes are closed: those that touch meet. Coordinates are finite. Building costs O(n lg n), a
// query O(lg n) and the boxes found where these overlap little; it does not allocate.
// Thread-compatible: const members may run concurrently.
#ifndef DYNMESH_CORE_BASE_BOX_TREE_H_
#define DYNMESH_CORE_BASE_BOX_TREE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <utility>
#include <vector>

namespace dynmesh::boxes {

template <std::size_t D>
struct Box {
  using Corner = std::array<double, D>;
  Corner low, high;
  // Of one point at least.
  template <class Corners>
  static Box Of(const Corners& corners) {
    Box box = {corners[0], corners[0]};
    for (const auto& c : corners) box.Hold(c);
    return box;
  }
  void Hold(const Corner& x) {
    for (std::size_t k = 0; k < D; ++k) {
      low[k] = std::min(low[k], x[k]), high[k] = std::max(high[k], x[k]);
    }
  }
  bool Meets(const Box& o) const {
    bool meets = true;
    for (std::size_t k = 0; k < D; ++k) meets &= low[k] <= o.high[k] && o.low[k] <= high[k];
    return meets;
  }
};

template <std::size_t D>
class BoxTree {
 public:
  BoxTree() = default;  // without boxes
  explicit BoxTree(std::vector<Box<D>> boxes) : boxes_(std::move(boxes)), order_(boxes_.size()) {
    std::iota(order_.begin(), order_.end(), 0U);
    if (!boxes_.empty()) Build(0, static_cast<std::uint32_t>(order_.size()));
  }

  // visit(index) for each box that meets `box`, in no particular order.
  template <class Visit>
  void ForEachMeeting(const Box<D>& box, const Visit& visit) const {
    Any(box, [&](std::uint32_t i) {
      visit(i);
      return false;
    });
  }
  // Does a box meet `box`?
  bool Meets(const Box<D>& box) const {
    return Any(box, [](std::uint32_t) { return true; });
  }

  const Box<D>& box(std::size_t i) const { return boxes_[i]; }

 private:
  static constexpr std::uint32_t kLeaf = 6;
  struct Node {
    Box<D> box;
    std::uint32_t begin, end;
    std::uint32_t right;  // 0: a leaf
  };

  // Calls accept(index) for boxes that meet `box` until it returns true, and returns whether it
  // did.
  template <class Accept>
  bool Any(const Box<D>& box, const Accept& accept) const {
    // A left subtree follows its root; the right one has a stored index.
    std::array<std::uint32_t, 64> stack;
    std::size_t depth = 0;
    if (!nodes_.empty()) stack[depth++] = 0;
    while (depth > 0) {
      const std::uint32_t at = stack[--depth];
      const Node& node = nodes_[at];
      if (!node.box.Meets(box)) continue;
      if (node.right != 0) {
        stack[depth++] = node.right;
        stack[depth++] = at + 1;
        continue;
      }
      for (std::uint32_t i = node.begin; i < node.end; ++i) {
        if (boxes_[order_[i]].Meets(box) && accept(order_[i])) return true;
      }
    }
    return false;
  }

  std::uint32_t Build(std::uint32_t begin, std::uint32_t end) {
    const auto made = static_cast<std::uint32_t>(nodes_.size());
    Box<D> box = boxes_[order_[begin]];
    for (std::uint32_t i = begin + 1; i < end; ++i) {
      box.Hold(boxes_[order_[i]].low), box.Hold(boxes_[order_[i]].high);
    }
    nodes_.push_back({box, begin, end, 0});
    if (end - begin <= kLeaf) return made;
    std::size_t axis = 0;
    for (std::size_t k = 1; k < D; ++k) {
      if (box.high[k] - box.low[k] > box.high[axis] - box.low[axis]) axis = k;
    }
    const std::uint32_t middle = begin + (end - begin) / 2;
    const auto middle_of = [&](std::uint32_t i) {
      return boxes_[i].low[axis] + boxes_[i].high[axis];
    };
    std::nth_element(order_.begin() + begin, order_.begin() + middle, order_.begin() + end,
                     [&](std::uint32_t a, std::uint32_t b) { return middle_of(a) < middle_of(b); });
    Build(begin, middle);
    const std::uint32_t right = Build(middle, end);
    nodes_[made].right = right;
    return made;
  }

  std::vector<Box<D>> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace dynmesh::boxes

#endif  // DYNMESH_CORE_BASE_BOX_TREE_H_
