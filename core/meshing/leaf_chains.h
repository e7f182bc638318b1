// The points of a spatial tree's leaves (spatial_tree.h): chains of blocks of 16. A chain has more
// than one block only where points coincide.
#ifndef DYNMESH_CORE_MESHING_LEAF_CHAINS_H_
#define DYNMESH_CORE_MESHING_LEAF_CHAINS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "core/base/large_vector.h"
#include "core/geometry/point.h"
#include "core/meshing/extent.h"

namespace dynmesh::meshing {

// A chain is named by its first block; kNone is the empty chain. Thread-compatible.
template <int D>
class LeafChains {
 public:
  using Point = geometry::Point<D>;
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr std::uint32_t kCapacity = 16;

  // True if the first block is full.
  bool IsFull(std::uint32_t chain) const {
    return chain != kNone && leaves_[chain].count == kCapacity;
  }
  // True if the chain, which is not empty, has more than one block.
  bool IsLong(std::uint32_t chain) const { return leaves_[chain].next != kNone; }
  // The points of the first block. REQUIRES: the chain is not empty.
  std::uint32_t CountOfFirst(std::uint32_t chain) const { return leaves_[chain].count; }

  void Append(std::uint32_t& chain, std::uint32_t id, const Point& p) {
    if (chain == kNone) chain = NewLeaf();
    std::uint32_t l = chain;
    while (leaves_[l].count == kCapacity) {
      if (leaves_[l].next == kNone) {
        const std::uint32_t fresh = NewLeaf();
        leaves_[l].next = fresh;
      }
      l = leaves_[l].next;
    }
    Leaf& leaf = leaves_[l];
    for (int k = 0; k < D; ++k) leaf.x[k][leaf.count] = p[k];
    leaf.id[leaf.count++] = id;
  }
  // REQUIRES: the chain has a point with that id.
  void Remove(std::uint32_t& chain, std::uint32_t id) {
    std::uint32_t l = chain, i = 0;
    while (leaves_[l].id[i] != id) {
      if (++i == leaves_[l].count) {
        l = leaves_[l].next;
        i = 0;
      }
    }
    // The last point of the chain moves into its slot.
    std::uint32_t last = chain, before_last = kNone;
    while (leaves_[last].next != kNone) {
      before_last = last;
      last = leaves_[last].next;
    }
    Leaf& tail = leaves_[last];
    const std::uint32_t j = --tail.count;
    for (int k = 0; k < D; ++k) leaves_[l].x[k][i] = tail.x[k][j];
    leaves_[l].id[i] = tail.id[j];
    if (tail.count > 0) return;
    (before_last != kNone ? leaves_[before_last].next : chain) = kNone;
    free_leaves_.push_back(last);
  }
  // Moves the points of the chain, which has one block, to the chains chain_of(point).
  template <class ChainOf>
  void MoveAll(std::uint32_t chain, ChainOf chain_of) {
    for (std::uint32_t i = 0; i < leaves_[chain].count; ++i) {
      const Point p = PointAt(leaves_[chain], i);
      Append(chain_of(p), leaves_[chain].id[i], p);
    }
    free_leaves_.push_back(chain);
  }

  // Calls f(id, point) for each point.
  template <class F>
  void ForEach(std::uint32_t chain, F f) const {
    for (; chain != kNone; chain = leaves_[chain].next) {
      const Leaf& leaf = leaves_[chain];
      for (std::uint32_t i = 0; i < leaf.count; ++i) f(leaf.id[i], PointAt(leaf, i));
    }
  }
  // Calls visit(id, point) for each point in one of the balls. These lie in the box. Subtracts the
  // points looked at from *most; returns false when that is negative.
  template <class Visit>
  bool VisitBalls(std::uint32_t chain, std::span<const Ball<D>> balls, const Extent<D>& box,
                  int* most, Visit& visit) const {
    for (; chain != kNone; chain = leaves_[chain].next) {
      *most -= static_cast<int>(leaves_[chain].count);
      if (*most < 0) return false;
      if constexpr (D == 2) {
        VisitPointwise(leaves_[chain], balls, box, visit);
      } else {
        VisitBallwise(leaves_[chain], balls, visit);
      }
    }
    return true;
  }
  // Prefetches where the points are: most leaves hold only a few.
  void Prefetch(std::uint32_t chain) const {
    const Leaf& leaf = leaves_[chain];
    __builtin_prefetch(&leaf.count);
    for (const auto& row : leaf.x) __builtin_prefetch(&row[2]);
    __builtin_prefetch(&leaf.id[0]);
  }

  void Reserve(std::size_t leaves) { leaves_.reserve(leaves); }
  std::size_t bytes() const { return leaves_.size() * sizeof(Leaf); }

 private:
  struct Leaf {
    std::uint32_t count = 0;
    std::uint32_t next = kNone;
    double x[D][kCapacity];
    std::uint32_t id[kCapacity];
  };

  static Point PointAt(const Leaf& leaf, std::uint32_t i) {
    Point p;
    for (int k = 0; k < D; ++k) p[k] = leaf.x[k][i];
    return p;
  }
  std::uint32_t NewLeaf() {
    if (!free_leaves_.empty()) {
      const std::uint32_t l = free_leaves_.back();
      free_leaves_.pop_back();
      leaves_[l].count = 0;
      leaves_[l].next = kNone;
      return l;
    }
    leaves_.emplace_back();
    return static_cast<std::uint32_t>(leaves_.size() - 1);
  }

  // In 2D balls are few, and testing a cell costs as much as testing its points. No
  // branches on coordinates, as half of them would be mispredicted.
  template <class Visit>
  static void VisitPointwise(const Leaf& leaf, std::span<const Ball<D>> balls, const Extent<D>& box,
                             Visit& visit) {
    std::array<std::uint8_t, kCapacity> in_box;
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < leaf.count; ++i) {
      bool is_in = true;
      for (int k = 0; k < D; ++k) {
        is_in &= box.lo[k] <= leaf.x[k][i];
        is_in &= leaf.x[k][i] <= box.hi[k];
      }
      in_box[count] = static_cast<std::uint8_t>(i);
      count += is_in ? 1 : 0;
    }
    for (std::uint32_t j = 0; j < count; ++j) {
      const std::uint32_t i = in_box[j];
      const Point p = PointAt(leaf, i);
      bool is_in = false;
      for (const Ball<D>& ball : balls) {
        is_in |= geometry::SquaredDistance(p, ball.centre) <= ball.radius2;
      }
      if (is_in) visit(leaf.id[i], p);
    }
  }
  template <class Visit>
  static void VisitBallwise(const Leaf& leaf, std::span<const Ball<D>> balls, Visit& visit) {
    // Four points at a time, in registers as two pairs. Entries after the last point are ignored.
    using Pair [[gnu::vector_size(2 * sizeof(double))]] = double;
    using Flags [[gnu::vector_size(2 * sizeof(double))]] = std::int64_t;
    static_assert(kCapacity % 4 == 0);
    for (std::uint32_t from = 0; from < leaf.count; from += 4) {
      Pair x[2][D];
      for (int j = 0; j < 2; ++j) {
        for (int k = 0; k < D; ++k) std::memcpy(&x[j][k], &leaf.x[k][from + 2 * j], sizeof(Pair));
      }
      Flags is_in[2] = {};
      for (const Ball<D>& ball : balls) {
        for (int j = 0; j < 2; ++j) {
          Pair d2 = {};
          for (int k = 0; k < D; ++k) {
            const Pair d = x[j][k] - ball.centre[k];
            d2 += d * d;
          }
          is_in[j] |= d2 <= ball.radius2;
        }
      }
      for (std::uint32_t i = from; i < std::min(from + 4, leaf.count); ++i) {
        if (is_in[(i - from) / 2][i % 2] == 0) continue;
        visit(leaf.id[i], PointAt(leaf, i));
      }
    }
  }

  LargeVector<Leaf> leaves_;
  std::vector<std::uint32_t> free_leaves_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_LEAF_CHAINS_H_
