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

  std::size_t size() const { return count_; }
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
// side; seen from outside, the left one is on the left of the way from `from` to `to`. A cut
// shortens edges and adds, on each face that it crosses, an edge of the new face.
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
    // Where the new face's edge begins and ends on each face.
    std::array<std::uint8_t, kMostFaces> begin, end;
    begin.fill(kNone), end.fill(kNone);
    std::size_t kept = 0;
    in_use_ = in;
    for (std::size_t e = 0; e < edge_count_; ++e) {
      Edge edge = edges_[e];
      const bool from_in = (in >> edge.from & 1) != 0, to_in = (in >> edge.to & 1) != 0;
      if (!from_in && !to_in) continue;
      if (from_in != to_in) {
        const auto cut = static_cast<std::uint8_t>(count_++);
        in_use_ |= std::uint64_t{1} << cut;
        corners_[cut] =
            Between(corners_[edge.from], value[edge.from], corners_[edge.to], value[edge.to]);
        (from_in ? begin : end)[edge.left] = cut, (from_in ? end : begin)[edge.right] = cut;
        (from_in ? edge.to : edge.from) = cut;
      }
      edges_[kept++] = edge;
    }
    for (std::uint8_t face = 0; face < face_count_; ++face) {
      if (begin[face] == kNone || end[face] == kNone) continue;
      edges_[kept++] = {begin[face], end[face], face, face_count_};
    }
    edge_count_ = kept;
    ++face_count_;
    return true;
  }

  // Corners that were cut off keep their indices.
  std::size_t size() const { return count_; }
  const ClipCorner<3>& corner(std::size_t i) const { return corners_[i]; }

  // From a corner to all faces that do not have it.
  template <class Visit>
  void ForEachSimplex(const Visit& visit) const {
    const std::uint8_t apex = edges_[0].from;
    std::uint32_t has_apex = 0;  // bits of faces
    for (std::size_t e = 0; e < edge_count_; ++e) {
      const Edge& edge = edges_[e];
      if (edge.from == apex || edge.to == apex) has_apex |= 1U << edge.left | 1U << edge.right;
    }
    std::array<std::uint8_t, kMostFaces> first;  // of a face's corners
    first.fill(kNone);
    const auto look_at = [&](std::uint8_t face, std::uint8_t from, std::uint8_t to) {
      if ((has_apex >> face & 1) != 0) return;
      if (first[face] == kNone) first[face] = from;
      if (first[face] == from || first[face] == to) return;
      visit(std::array<std::size_t, 4>{apex, first[face], from, to});
    };
    for (std::size_t e = 0; e < edge_count_; ++e) {
      look_at(edges_[e].left, edges_[e].from, edges_[e].to);
      look_at(edges_[e].right, edges_[e].to, edges_[e].from);
    }
  }

  // A cut makes at most one corner an edge, and one edge a face: 4, 10, 15 and 21 corners.
  static constexpr std::size_t kMost = 54;

 private:
  static constexpr std::size_t kMostFaces = 8, kMostEdges = 28;
  static constexpr std::uint8_t kNone = 255;
  struct Edge {
    std::uint8_t from, to;
    std::uint8_t left, right;
  };

  std::array<ClipCorner<3>, kMost> corners_;
  std::array<Edge, kMostEdges> edges_;
  std::size_t edge_count_;
  std::uint8_t face_count_;
  std::size_t count_;
  std::uint64_t in_use_;  // bits of corners
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIP_H_
