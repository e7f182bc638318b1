// Where the mesh is to be finer than its geometry asks: regions with a target length, and
// which balls are too large for them. A loose quadtree or octree: a region hangs in the smallest
// cell of about its own size or its target, whichever is larger, and may stick out of the cell by
// half its side.
//
// A triangle that meets a region of target h is to have no edge longer than sqrt(2) h: its
// circumradius is at most h / sqrt(2). Asked of the triangle's circumscribed *ball* if that
// meets the region, so that no triangle which meets it escapes.
//
// Answers are a function of the regions present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_SIZING_FIELD_H_
#define DYNMESH_CORE_MESHING_SIZING_FIELD_H_

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/geometry/point.h"
#include "core/meshing/polygon_area.h"

namespace dynmesh::meshing {

// All places within `radius` of a box: a point, a disc, a box; or what is inside some rings.
template <int D>
struct SizingRegion {
  geometry::Point<D> lo = {}, hi = {};
  double radius = 0;
  double target = 0;                                  // h
  std::shared_ptr<const PolygonArea> area = nullptr;  // in the plane: between lo and hi; radius 0
  double most_radius() const { return target * 0.70710678118654752; }
  bool Meets(const geometry::Point<D>& centre, double ball_radius) const;
  friend bool operator==(const SizingRegion&, const SizingRegion&) = default;
};

template <int D>
class SizingField {
 public:
  using Region = SizingRegion<D>;
  using Point = geometry::Point<D>;
  using Index = std::uint32_t;

  // Covers the box: regions should meet it.
  SizingField(const Point& lo, const Point& hi);

  // O(depth), at most 40.
  Index Add(const Region& region);
  void Remove(Index index);
  bool empty() const { return count_ == 0; }
  const Region& operator[](Index index) const { return items_[index].region; }

  // Is there a region that the ball meets and is too large for? O(cells of its size nearby)
  // where none is, less where one is.
  bool IsTooLarge(const Point& centre, double radius) const;

  std::size_t bytes() const {
    return nodes_.capacity() * sizeof(Node) + items_.capacity() * sizeof(Item);
  }

 private:
  static constexpr std::uint32_t kNone = ~std::uint32_t{0};
  static constexpr int kMostDepth = 40;
  static constexpr std::array<std::uint32_t, 1 << D> Filled() {
    std::array<std::uint32_t, 1 << D> none{};
    none.fill(kNone);
    return none;
  }
  struct Node {
    std::array<std::uint32_t, 1 << D> child = Filled();
    std::uint32_t parent = kNone;
    std::uint32_t first = kNone;  // item
    double least = INFINITY;      // of most_radius() in the subtree
  };
  struct Item {
    Region region;
    std::uint32_t node = kNone, next = kNone;
  };
  struct Cell {
    std::uint32_t node;
    Point centre;
    double half;
  };

  static int Quadrant(const Point& p, const Cell& cell) {
    int q = 0;
    for (int k = 0; k < D; ++k) q |= (p[k] >= cell.centre[k] ? 1 : 0) << k;
    return q;
  }
  static Cell Child(const Cell& cell, int quadrant, std::uint32_t node);
  std::uint32_t NewNode(std::uint32_t parent);
  void UpdateLeast(std::uint32_t node);

  Cell root_;
  std::vector<Node> nodes_;
  std::vector<Item> items_;
  std::vector<std::uint32_t> free_nodes_, free_items_;
  std::size_t count_ = 0;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SIZING_FIELD_H_
