// The intersection of two simplices, cut into simplices: what a supermesh is made of.
//
// One of them is clipped by the half-spaces of the other, in doubles (Sutherland and Hodgman 1974;
// in 3D edge by edge, with the cut closed by a new face). Each corner keeps its barycentric
// coordinates in the simplex that is clipped. Half-spaces are taken wider by a slack of some units
// of rounding: old and new simplices often have faces in one plane, and signs of places on it are
// noise, which makes no ring. So pieces are a little too large or too small, and what uses them
// allows for that. O(1), no allocation.
#ifndef DYNMESH_CORE_TRANSFER_CLIP_H_
#define DYNMESH_CORE_TRANSFER_CLIP_H_

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/transfer/simplex.h"

namespace dynmesh::transfer {

// A corner of a piece: its place, and its barycentric coordinates in the clipped simplex.
template <std::size_t D>
struct ClipCorner {
  Vec<D> place;
  std::array<double, D + 1> lambda;
};

// Where the segment from a (value da) to b (db) meets value 0.
template <std::size_t D>
ClipCorner<D> Between(const ClipCorner<D>& a, double da, const ClipCorner<D>& b, double db) {
  const double t = da / (da - db);
  ClipCorner<D> r;
  for (std::size_t k = 0; k < D; ++k) r.place[k] = a.place[k] + t * (b.place[k] - a.place[k]);
  for (std::size_t k = 0; k <= D; ++k) r.lambda[k] = a.lambda[k] + t * (b.lambda[k] - a.lambda[k]);
  return r;
}

// visit(i) for each bit i of `bits` that is set.
template <class Visit>
void ForEachBit(std::uint64_t bits, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(static_cast<std::size_t>(std::countr_zero(bits)));
}

template <std::size_t D>
class Clipped;

// A convex polygon, counter-clockwise.
template <>
class Clipped<2> {
 public:
  explicit Clipped(const Corners<2>& c) : count_(3) {
    for (std::size_t k = 0; k < 3; ++k) corners_[k] = {c[k], {}}, corners_[k].lambda[k] = 1;
  }

  // Keeps what lies in `half`, or less than `slack` (of its value) outside; false if nothing does.
  bool By(const HalfSpace<2>& half, double slack) {
    std::array<double, kMost> value;
    bool any_in = false, any_out = false;
    for (std::size_t i = 0; i < count_; ++i) {
      value[i] = half(corners_[i].place) + slack;
      any_in |= value[i] > 0, any_out |= value[i] < 0;
    }
    if (!any_in) return false;
    if (!any_out) return true;
    std::array<ClipCorner<2>, kMost> kept;
    std::size_t kept_count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const std::size_t j = i + 1 == count_ ? 0 : i + 1;
      if (value[i] >= 0 && kept_count < kMost) kept[kept_count++] = corners_[i];
      if ((value[i] < 0) != (value[j] < 0) && kept_count < kMost) {
        kept[kept_count++] = Between(corners_[i], value[i], corners_[j], value[j]);
      }
    }
    corners_ = kept, count_ = kept_count;
    return count_ >= 3;
  }

  // Bits of corners.
  std::uint64_t in_use() const { return (std::uint64_t{1} << count_) - 1; }
  const ClipCorner<2>& corner(std::size_t i) const { return corners_[i]; }

  // visit(indices of D + 1 corners) for each simplex of a triangulation.
  template <class Visit>
  void ForEachSimplex(const Visit& visit) const {
    for (std::size_t i = 1; i + 1 < count_; ++i) visit(std::array<std::size_t, 3>{0, i, i + 1});
  }

  // Each of three cuts adds a corner; rounding may add one or two more.
  static constexpr std::size_t kMost = 10;

 private:
  std::array<ClipCorner<2>, kMost> corners_;
  std::size_t count_;
};

// A convex polyhedron, by its edges. An edge goes between two corners and has a face on either
// side; seen from outside, the left one is on the left of the way from its first end to its second.
// A cut shortens edges and adds, on each face that it crosses, an edge of the new face.
template <>
class Clipped<3> {
 public:
  explicit Clipped(const Corners<3>& c)
      : edges_{{{1, 2, 0, 3},
                {2, 3, 0, 1},
                {3, 1, 0, 2},
                {0, 3, 1, 2},
                {2, 0, 1, 3},
                {0, 1, 2, 3}}},
        edge_count_(6),
        face_count_(4),
        count_(4),
        in_use_(0b1111) {
    for (std::size_t k = 0; k < 4; ++k) corners_[k] = {c[k], {}}, corners_[k].lambda[k] = 1;
  }

  // Without branches where nothing predicts them: an entry that is not wanted is overwritten.
  bool By(const HalfSpace<3>& half, double slack) {
    std::array<double, kMost> value;
    std::uint64_t in = 0;
    bool any_in = false;
    ForEachBit(in_use_, [&](std::size_t v) {
      value[v] = half(corners_[v].place) + slack;
      any_in |= value[v] > 0;
      in |= std::uint64_t{value[v] >= 0} << v;
    });
    if (!any_in) return false;
    if (in == in_use_) return true;
    in_use_ = in;
    std::array<std::uint8_t, kMostEdges + 1> crossing;  // edges with one end in the half-space
    std::size_t kept = 0, crossing_count = 0;
    for (std::size_t e = 0; e < edge_count_; ++e) {
      const Edge edge = edges_[e];
      const bool from_in = (in >> edge.ends[0] & 1) != 0, to_in = (in >> edge.ends[1] & 1) != 0;
      edges_[kept] = edge;
      crossing[crossing_count] = static_cast<std::uint8_t>(kept);
      kept += from_in | to_in;
      crossing_count += from_in ^ to_in;
    }
    // The new face's edge on each face: where it begins, and where it ends.
    std::array<std::array<std::uint8_t, kMostFaces>, 2> cap;
    cap[0].fill(kNone), cap[1].fill(kNone);
    for (std::size_t c = 0; c < crossing_count; ++c) {
      Edge& edge = edges_[crossing[c]];
      const auto [from, to] = edge.ends;
      const bool from_in = (in >> from & 1) != 0;
      const auto cut = static_cast<std::uint8_t>(count_++);
      in_use_ |= std::uint64_t{1} << cut;
      corners_[cut] = Between(corners_[from], value[from], corners_[to], value[to]);
      cap[!from_in][edge.left] = cut, cap[from_in][edge.right] = cut;
      edge.ends[from_in] = cut;
    }
    for (std::uint8_t face = 0; face < face_count_; ++face) {
      edges_[kept] = {{cap[0][face], cap[1][face]}, face, face_count_};
      kept += cap[0][face] != kNone && cap[1][face] != kNone;
    }
    edge_count_ = kept;
    ++face_count_;
    return true;
  }

  // Bits of corners; indices of those that were cut off are not used again.
  std::uint64_t in_use() const { return in_use_; }
  const ClipCorner<3>& corner(std::size_t i) const { return corners_[i]; }

  // From a corner to all faces that do not have it.
  template <class Visit>
  void ForEachSimplex(const Visit& visit) const {
    const std::uint8_t apex = edges_[0].ends[0];
    std::uint32_t has_apex = 0;  // bits of faces
    std::array<std::uint8_t, kMostFaces> corner_of;
    for (std::size_t e = 0; e < edge_count_; ++e) {
      const Edge& edge = edges_[e];
      const std::uint32_t faces = 1U << edge.left | 1U << edge.right;
      has_apex |= faces & -std::uint32_t{edge.ends[0] == apex || edge.ends[1] == apex};
      corner_of[edge.left] = corner_of[edge.right] = edge.ends[0];
    }
    // Triangles of the other faces, each with a corner of its face.
    std::array<std::array<std::uint8_t, 3>, 2 * kMostEdges + 1> triangles;
    std::size_t count = 0;
    const auto add = [&](std::uint8_t face, std::uint8_t from, std::uint8_t to) {
      const std::uint8_t corner = corner_of[face];
      triangles[count] = {corner, from, to};
      count += ((has_apex >> face & 1) == 0) & (corner != from) & (corner != to);
    };
    for (std::size_t e = 0; e < edge_count_; ++e) {
      add(edges_[e].left, edges_[e].ends[0], edges_[e].ends[1]);
      add(edges_[e].right, edges_[e].ends[1], edges_[e].ends[0]);
    }
    for (std::size_t t = 0; t < count; ++t) {
      const auto& [a, b, c] = triangles[t];
      visit(std::array<std::size_t, 4>{apex, a, b, c});
    }
  }

  // A cut makes at most one corner an edge, and one edge a face: 4, 10, 15 and 21 corners.
  static constexpr std::size_t kMost = 54;

 private:
  static constexpr std::size_t kMostFaces = 8, kMostEdges = 28;
  static constexpr std::uint8_t kNone = 255;
  struct Edge {
    std::array<std::uint8_t, 2> ends;  // from, to
    std::uint8_t left, right;
  };

  std::array<ClipCorner<3>, kMost> corners_;
  std::array<Edge, kMostEdges + 1> edges_;
  std::size_t edge_count_;
  std::uint8_t face_count_;
  std::size_t count_;
  std::uint64_t in_use_;  // bits of corners
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIP_H_
