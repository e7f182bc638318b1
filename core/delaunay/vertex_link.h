// The link of a vertex: its neighbours in a tetrahedralisation, and for each tetrahedron at it the
// triangle of the other three. A closed link is a triangulated sphere.
//
// The scratch of the walk around the vertex is reused from vertex to vertex: no allocation once
// warm. Thread-compatible.
#ifndef DYNMESH_CORE_DELAUNAY_VERTEX_LINK_H_
#define DYNMESH_CORE_DELAUNAY_VERTEX_LINK_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/delaunay/number_table.h"

namespace dynmesh::delaunay {

// The tables of a walk from triangle to triangle of a link: numbers for the neighbours, in order of
// arrival, and for each directed edge between two of them the triangle to its left. For at most
// kMost neighbours: a query reads one entry in the first-level cache, without a branch that would
// be mispredicted.
class SmallLinkTables {
 public:
  static constexpr int kMost = 64;

  void Begin() {
    slots_.fill(kFree);
    count_ = 0;
    if (++stamp_ < 1u << (32 - kTriangleBits)) return;
    edges_.fill(0);  // the stamps have wrapped around
    stamp_ = 1;
  }
  // The number of neighbour u; a new one gets the next number.
  int Number(std::uint32_t u) {
    ids_[count_] = u;
    for (std::uint32_t at = u * 0x9e3779b1u >> 24;; at = (at + 1) % kSlots) {
      const int known = slots_[at], number = known == kFree ? count_ : known;
      if (ids_[number] != u) continue;
      slots_[at] = static_cast<std::uint8_t>(number);
      count_ += number == count_ ? 1 : 0;
      return number;
    }
  }
  // With more than kMost neighbours no query is allowed.
  bool IsTooSmall() const { return count_ > kMost; }
  int count() const { return count_; }
  std::uint32_t id(int number) const { return ids_[number]; }

  bool Has(int a, int b) const { return edges_[a * kRow + b] >> kTriangleBits == stamp_; }
  void Set(int a, int b, int triangle) {
    edges_[a * kRow + b] = stamp_ << kTriangleBits | static_cast<std::uint32_t>(triangle);
  }
  int TriangleAt(int a, int b) const {
    return static_cast<int>(edges_[a * kRow + b] & ((1u << kTriangleBits) - 1));
  }

 private:
  static constexpr std::uint32_t kSlots = 256;
  static constexpr std::uint8_t kFree = 255;
  static constexpr int kRow = kMost + 1;   // numbers are 0 .. kMost
  static constexpr int kTriangleBits = 8;  // there are at most 2 kMost - 4

  std::array<std::uint8_t, kSlots> slots_;   // numbers, by hash
  std::array<std::uint32_t, kRow + 1> ids_;  // by number; behind them a sentinel for the query
  int count_ = 0;
  std::uint32_t stamp_ = 0;
  std::array<std::uint32_t, kRow* kRow> edges_ = {};
};

// The same for any number of neighbours.
class LargeLinkTables {
 public:
  void Begin() {
    vertices_.Clear();
    edges_.Clear();
    triangles_.clear();
  }
  int Number(std::uint32_t u) { return static_cast<int>(vertices_.Number({u})); }
  bool IsTooSmall() const { return false; }
  int count() const { return static_cast<int>(vertices_.keys().size()); }
  std::uint32_t id(int number) const { return vertices_.keys()[number][0]; }

  bool Has(int a, int b) const { return edges_.Find(Edge(a, b)) != NumberTable<2>::kNone; }
  void Set(int a, int b, int triangle) {
    edges_.Number(Edge(a, b));
    triangles_.push_back(triangle);
  }
  int TriangleAt(int a, int b) const { return triangles_[edges_.Find(Edge(a, b))]; }

 private:
  static std::array<std::uint32_t, 2> Edge(int a, int b) {
    return {static_cast<std::uint32_t>(a), static_cast<std::uint32_t>(b)};
  }

  NumberTable<1> vertices_;
  NumberTable<2> edges_;
  std::vector<int> triangles_;  // by number of edge
};

struct VertexLink {
  using Triple = std::array<int, 3>;
  std::vector<std::uint32_t> neighbours;  // in order of arrival
  std::vector<Triple> triangles;          // numbers of neighbours; with the vertex first they are
                                          // positive
  std::vector<std::uint32_t> simplices;   // of the triangles
  bool is_closed = true;                  // true if all neighbours are finite

  // By triangle: the triangles beyond the edges opposite to its corners k. Valid after Join().
  std::vector<Triple> across;
  void Join() { is_small ? JoinWith(small) : JoinWith(large); }

  // Scratch of the walk: edges to be crossed. One word each, to need no wait for a second load: the
  // packed corner that faces the triangle being left, and below it 4 * the triangle's number + its
  // edge.
  std::vector<std::uint64_t> crossings;
  SmallLinkTables small;
  LargeLinkTables large;
  bool is_small = true;  // the small tables suffice

 private:
  template <class Tables>
  void JoinWith(const Tables& tables) {
    across.clear();
    for (const auto& [a, b, c] : triangles) {
      across.push_back({tables.TriangleAt(c, b), tables.TriangleAt(a, c), tables.TriangleAt(b, a)});
    }
  }
};

}  // namespace dynmesh::delaunay

#endif  // DYNMESH_CORE_DELAUNAY_VERTEX_LINK_H_
