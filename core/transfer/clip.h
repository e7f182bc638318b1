// The intersection of two simplices, cut into simplices: the pieces of a supermesh.
//
// Clips one simplex by the half-spaces of the other, in doubles (Sutherland and Hodgman 1974; in 3D
// edge by edge, with the cut closed by a new face). A corner has no position: all quantities needed
// are linear along an edge. If a corner's distance to a half-space's plane may be rounding, it
// counts as on the plane. It is kept, and no edge is cut next to it. Such corners are frequent: old
// and new simplices often share vertices and faces, and signs of distances there are noise. So
// pieces are slightly too large or too small; their users allow for that. O(1), no allocation.
#ifndef DYNMESH_CORE_TRANSFER_CLIP_H_
#define DYNMESH_CORE_TRANSFER_CLIP_H_

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/transfer/simplex.h"

namespace dynmesh::transfer {

// A corner of a piece: its barycentric coordinates in the clipped simplex, and the values of the
// half-spaces there. Negative is outside, up to noise.
template <std::size_t D>
struct ClipCorner {
  std::array<double, D + 1> lambda, values;
};

// The values of the half-spaces at each corner of the simplex to be clipped.
template <std::size_t D>
using ClipValues = std::array<std::array<double, D + 1>, D + 1>;

template <std::size_t D>
ClipCorner<D> ClipCornerOf(const ClipValues<D>& values, std::size_t c) {
  ClipCorner<D> corner = {{}, values[c]};
  corner.lambda[c] = 1;
  return corner;
}

// Where half-space k has value 0 on the segment from a to b. REQUIRES: it changes sign there.
template <std::size_t D>
ClipCorner<D> Between(const ClipCorner<D>& a, const ClipCorner<D>& b, std::size_t k) {
  const double t = a.values[k] / (a.values[k] - b.values[k]);
  ClipCorner<D> r;
  for (std::size_t i = 0; i <= D; ++i) r.lambda[i] = a.lambda[i] + t * (b.lambda[i] - a.lambda[i]);
  for (std::size_t i = 0; i <= D; ++i) r.values[i] = a.values[i] + t * (b.values[i] - a.values[i]);
  return r;
}

// Calls visit(i) for each bit i of `bits` that is set.
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
  explicit Clipped(const ClipValues<2>& values) : count_(3) {
    for (std::size_t i = 0; i < 3; ++i) corners_[i] = ClipCornerOf<2>(values, i);
  }

  // Keeps the part in half-space k; values up to `noise` may be 0. False if no part remains.
  bool By(std::size_t k, double noise) {
    bool any_in = false, any_out = false;
    for (std::size_t i = 0; i < count_; ++i) {
      any_in |= corners_[i].values[k] > noise, any_out |= corners_[i].values[k] < -noise;
    }
    if (!any_in) return false;
    if (!any_out) return true;
    std::array<ClipCorner<2>, kMost> kept;
    std::size_t kept_count = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      const ClipCorner<2>&corner = corners_[i], &next = corners_[i + 1 == count_ ? 0 : i + 1];
      const double value = corner.values[k], next_value = next.values[k];
      if (value >= -noise && kept_count < kMost) kept[kept_count++] = corner;
      const bool is_cut =
          std::min(value, next_value) < -noise && std::max(value, next_value) > noise;
      if (is_cut && kept_count < kMost) kept[kept_count++] = Between(corner, next, k);
    }
    corners_ = kept, count_ = kept_count;
    return count_ >= 3;
  }

  // Bits of corners.
  std::uint64_t in_use() const { return (std::uint64_t{1} << count_) - 1; }
  const ClipCorner<2>& corner(std::size_t i) const { return corners_[i]; }

  // Bits of the clipped simplex's faces on which the piece has a side: face k is opposite to corner
  // k.
  std::uint32_t Sides() const {
    // Cutting keeps a coordinate exactly 0 if it is 0 at both ends.
    std::array<std::uint32_t, 3> corners_on{};
    for (std::size_t i = 0; i < count_; ++i) {
      for (std::size_t k = 0; k < 3; ++k) corners_on[k] += corners_[i].lambda[k] == 0;
    }
    std::uint32_t sides = 0;
    for (std::size_t k = 0; k < 3; ++k) sides |= std::uint32_t{corners_on[k] >= 2} << k;
    return sides;
  }

  // Calls visit(indices of D + 1 corners) for each simplex of a triangulation.
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

// A convex polyhedron, by its edges. An edge has two corners and a face on either side. Seen from
// outside, the left face is to the left of the direction from the first end to the second. A cut
// shortens edges, and adds an edge of the new face on each face that it crosses. It removes a face
// of which only an edge or a corner is left.
template <>
class Clipped<3> {
 public:
  explicit Clipped(const ClipValues<3>& values)
      : edges_{{{{1, 2}, 0, 3},
                {{2, 3}, 0, 1},
                {{3, 1}, 0, 2},
                {{0, 3}, 1, 2},
                {{2, 0}, 1, 3},
                {{0, 1}, 2, 3}}},
        edge_count_(6),
        face_count_(4),
        count_(4),
        in_use_(0b1111) {
    for (std::size_t v = 0; v < 4; ++v) corners_[v] = ClipCornerOf<3>(values, v);
  }

  // Without unpredictable branches: an unwanted entry is overwritten.
  bool By(std::size_t k, double noise) {
    std::uint64_t in = 0, on = 0;
    ForEachBit(in_use_, [&](std::size_t v) {
      const double value = corners_[v].values[k];
      in |= std::uint64_t{value > noise} << v;
      on |= std::uint64_t{std::abs(value) <= noise} << v;
    });
    if (in == 0) return false;
    if ((in | on) == in_use_) return true;
    in_use_ = in | on;
    // Edges with one end that is removed: the cut makes a new corner on it, or the other end is on
    // the plane and the edge is removed. And edges on the plane.
    std::array<std::uint8_t, kMostEdges + 1> cut, flat;
    std::array<Edge, kMostEdges + 1> gone;
    std::size_t kept = 0, cut_count = 0, flat_count = 0, gone_count = 0;
    for (std::size_t e = 0; e < edge_count_; ++e) {
      const Edge edge = edges_[e];
      const std::uint64_t from_in = in >> edge.ends[0] & 1, to_in = in >> edge.ends[1] & 1;
      const std::uint64_t from_on = on >> edge.ends[0] & 1, to_on = on >> edge.ends[1] & 1;
      edges_[kept] = gone[gone_count] = edge;
      cut[cut_count] = flat[flat_count] = static_cast<std::uint8_t>(kept);
      kept += from_in | to_in | (from_on & to_on);
      cut_count += (from_in ^ to_in) & ~(from_on | to_on);
      flat_count += from_on & to_on;
      gone_count += (from_on ^ to_on) & ~(from_in | to_in);
    }
    Cap cap;
    cap[0].fill(kNone), cap[1].fill(kNone);
    for (std::size_t c = 0; c < cut_count; ++c) {
      Edge& edge = edges_[cut[c]];
      const auto [from, to] = edge.ends;
      const bool from_in = (in >> from & 1) != 0;
      const auto corner = static_cast<std::uint8_t>(count_++);
      in_use_ |= std::uint64_t{1} << corner;
      corners_[corner] = Between(corners_[from], corners_[to], k);
      cap[!from_in][edge.left] = cap[from_in][edge.right] = corner;
      edge.ends[from_in] = corner;
    }
    for (std::size_t g = 0; g < gone_count; ++g) {
      const Edge& edge = gone[g];
      const bool from_on = (on >> edge.ends[0] & 1) != 0;
      cap[!from_on][edge.left] = cap[from_on][edge.right] = edge.ends[!from_on];
    }
    for (std::size_t f = 0; f < flat_count; ++f) TurnToCap(cap, edges_[flat[f]]);
    for (std::uint8_t face = 0; face < face_count_; ++face) {
      const std::uint8_t from = cap[0][face], to = cap[1][face];
      edges_[kept] = {{from, to}, face, face_count_};
      kept += (from != kNone) & (to != kNone) & (from != to);
    }
    edge_count_ = kept;
    ++face_count_;
    return true;
  }

  // Bits of corners; indices of removed corners are not reused.
  std::uint64_t in_use() const { return in_use_; }
  const ClipCorner<3>& corner(std::size_t i) const { return corners_[i]; }

  std::uint32_t Sides() const {
    std::uint32_t faces = 0;
    for (std::size_t e = 0; e < edge_count_; ++e) faces |= edges_[e].faces();
    return faces & 0b1111;
  }

  // From one corner to all faces without it.
  template <class Visit>
  void ForEachSimplex(const Visit& visit) const {
    const std::uint8_t apex = edges_[0].ends[0];
    std::uint32_t has_apex = 0;  // bits of faces
    std::array<std::uint8_t, kMostFaces> corner_of;
    for (std::size_t e = 0; e < edge_count_; ++e) {
      const Edge& edge = edges_[e];
      has_apex |= edge.faces() & -std::uint32_t{edge.ends[0] == apex || edge.ends[1] == apex};
      corner_of[edge.left] = corner_of[edge.right] = edge.ends[0];
    }
    // Triangles of the other faces, each with one corner of its face.
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

  // A cut turns at most one corner into an edge, and one edge into a face: 4, 10, 15 and 21
  // corners.
  static constexpr std::size_t kMost = 54;

 private:
  static constexpr std::size_t kMostFaces = 8, kMostEdges = 28;
  static constexpr std::uint8_t kNone = 255;
  struct Edge {
    std::array<std::uint8_t, 2> ends;  // from, to
    std::uint8_t left, right;
    std::uint32_t faces() const { return 1U << left | 1U << right; }  // bits
  };

  // The new face's edge on each face: its begin and its end.
  using Cap = std::array<std::array<std::uint8_t, kMostFaces>, 2>;

  // If only an edge on the plane is left of a face, it becomes the new face's edge.
  void TurnToCap(Cap& cap, Edge& edge) const {
    const auto [from, to] = edge.ends;
    const auto turn = [&](std::uint8_t& face, std::uint8_t begin, std::uint8_t end) {
      if (cap[0][face] != begin || cap[1][face] != end) return;
      cap[0][face] = kNone;
      face = face_count_;
    };
    turn(edge.left, to, from), turn(edge.right, from, to);
  }

  std::array<ClipCorner<3>, kMost> corners_;
  std::array<Edge, kMostEdges + 1> edges_;
  std::size_t edge_count_;
  std::uint8_t face_count_;
  std::size_t count_;
  std::uint64_t in_use_;  // bits of corners
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIP_H_
