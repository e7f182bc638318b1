// The intersection of two simplices, cut into simplices: what a supermesh is made of.
//
// One of them is clipped by the half-spaces of the other, in doubles (Sutherland and Hodgman 1974;
// in space face by face, with the cut closed by a new face). Each corner keeps its barycentric
// coordinates in the simplex that is clipped. Half-spaces are taken wider by a slack of some units
// of rounding: old and new simplices often have faces in one plane, and signs of places on it are
// noise, which makes no ring. So pieces are a little too large or too small, and what uses them
// allows for that. O(1), no allocation.
#ifndef DYNMESH_CORE_TRANSFER_CLIP_H_
#define DYNMESH_CORE_TRANSFER_CLIP_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

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

// A convex polyhedron: faces as rings of corners, counter-clockwise seen from outside.
template <>
class Clipped<3> {
 public:
  explicit Clipped(const Corners<3>& c) : count_(4), face_count_(4) {
    for (std::size_t k = 0; k < 4; ++k) corners_[k] = {c[k], {}}, corners_[k].lambda[k] = 1;
    Face* const faces = faces_[0].data();
    faces[0] = {3, {1, 2, 3}}, faces[1] = {3, {0, 3, 2}};
    faces[2] = {3, {0, 1, 3}}, faces[3] = {3, {0, 2, 1}};
  }

  bool By(const HalfSpace<3>& half, double slack) {
    std::array<double, kMost> value;
    bool any_in = false, any_out = false;
    for (std::size_t i = 0; i < count_; ++i) {
      value[i] = half(corners_[i].place) + slack;
      any_in |= value[i] > 0, any_out |= value[i] < 0;
    }
    if (!any_in) return false;
    if (!any_out) return true;
    Cut cut;
    const std::size_t old_count = count_;
    const FaceList& faces = faces_[current_];
    current_ = 1 - current_;
    std::size_t kept = 0;
    for (std::size_t f = 0; f < face_count_; ++f) {
      Face& clipped = faces_[current_][kept];
      ClipFace(faces[f], value, cut, clipped);
      kept += clipped.size >= 3;
    }
    face_count_ = kept;
    Close(cut, old_count);
    return face_count_ >= 4;
  }

  std::size_t size() const { return count_; }
  const ClipCorner<3>& corner(std::size_t i) const { return corners_[i]; }

  // From a corner to all faces that do not have it.
  template <class Visit>
  void ForEachSimplex(const Visit& visit) const {
    if (face_count_ == 0) return;
    const FaceList& faces = faces_[current_];
    const std::uint8_t apex = faces[0].ring[0];
    for (std::size_t f = 1; f < face_count_; ++f) {
      const Face& face = faces[f];
      bool has_apex = false;
      for (std::size_t i = 0; i < face.size; ++i) has_apex |= face.ring[i] == apex;
      if (has_apex) continue;
      for (std::size_t i = 1; i + 1 < face.size; ++i) {
        visit(std::array<std::size_t, 4>{apex, face.ring[0], face.ring[i], face.ring[i + 1]});
      }
    }
  }

  // Four cuts of a convex polyhedron with 4 corners, three edges at each: at most 12 in use, and
  // those that were cut off keep their places.
  static constexpr std::size_t kMost = 40;

 private:
  static constexpr std::size_t kMostFaces = 12, kMostSides = 14;
  struct Face {
    std::uint8_t size;
    std::array<std::uint8_t, kMostSides> ring;
  };
  // New corners by the edge that they are on, and the sides of the new face.
  struct Cut {
    std::size_t count = 0;
    std::array<std::array<std::uint8_t, 3>, kMost> edges;  // two ends, new corner
    std::array<std::uint8_t, kMost> next;                  // along the new face, by new corner
  };

  // kMost where there is no room, which rounding alone can bring about.
  std::uint8_t CornerOn(std::uint8_t a, std::uint8_t b, const std::array<double, kMost>& value,
                        Cut& cut) {
    if (b < a) std::swap(a, b);
    for (std::size_t i = 0; i < cut.count; ++i) {
      if (cut.edges[i][0] == a && cut.edges[i][1] == b) return cut.edges[i][2];
    }
    if (count_ == kMost) return kMost;
    const auto made = static_cast<std::uint8_t>(count_++);
    corners_[made] = Between(corners_[a], value[a], corners_[b], value[b]);
    cut.edges[cut.count++] = {a, b, made};
    cut.next[made] = kMost;
    return made;
  }

  void ClipFace(const Face& face, const std::array<double, kMost>& value, Cut& cut, Face& clipped) {
    clipped.size = 0;
    std::uint8_t left_at = kMost, came_at = kMost;
    const auto add = [&](std::uint8_t corner) {
      if (corner != kMost && clipped.size < kMostSides) clipped.ring[clipped.size++] = corner;
    };
    for (std::size_t i = 0; i < face.size; ++i) {
      const std::uint8_t a = face.ring[i], b = face.ring[i + 1 == face.size ? 0 : i + 1];
      if (value[a] >= 0) add(a);
      if ((value[a] < 0) == (value[b] < 0)) continue;
      const std::uint8_t on = CornerOn(a, b, value, cut);
      add(on);
      (value[a] < 0 ? came_at : left_at) = on;
    }
    // The new face goes along the same side the other way.
    if (left_at != kMost && came_at != kMost) cut.next[came_at] = left_at;
  }

  void Close(const Cut& cut, std::size_t first_new) {
    if (first_new >= count_ || face_count_ == kMostFaces) return;
    Face& cap = faces_[current_][face_count_];
    cap.size = 0;
    auto at = static_cast<std::uint8_t>(first_new);
    do {
      cap.ring[cap.size++] = at;
      at = cut.next[at];
    } while (at != kMost && at != first_new && cap.size < kMostSides);
    face_count_ += cap.size >= 3;
  }

  std::array<ClipCorner<3>, kMost> corners_;
  // Faces are read from one list and written to the other.
  using FaceList = std::array<Face, kMostFaces>;
  std::array<FaceList, 2> faces_;
  std::size_t current_ = 0;
  std::size_t count_, face_count_;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CLIP_H_
