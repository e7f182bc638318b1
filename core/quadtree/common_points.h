// The input points that all features of a set have in common.
//
// Sets are merged by Add: the value of a union is the value of both values, in any order. Of two
// features or more only common points are kept, hardly ever more than two.
#ifndef DYNMESH_CORE_QUADTREE_COMMON_POINTS_H_
#define DYNMESH_CORE_QUADTREE_COMMON_POINTS_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/quadtree/shape.h"

namespace dynmesh::quadtree {

// The same in 8 bytes, as long as there are at most two points.
struct PackedPoints {
  static constexpr std::uint32_t kLone = kNone - 1, kApart = kNone - 2, kMany = kNone - 3;

  std::uint32_t a = kNone;
  std::uint32_t b = kNone;  // or one of the above: what `a` is

  bool has_features() const { return a != kNone || b != kNone; }
  bool is_lone() const { return b == kLone; }
  bool are_apart() const { return b == kApart; }
  friend bool operator==(const PackedPoints&, const PackedPoints&) = default;
};

// A value. `shapes`: the table; shapes[i].points() are sorted. O(points of the shapes) if one of
// two different shapes is alone, else O(common points).
class CommonPoints {
 public:
  bool has_features() const { return any_; }
  // There are features, and they have no point in common.
  bool are_apart() const { return any_ && only_ == kNone && count_ == 0; }

  template <class Shapes>
  void Add(ShapeIndex shape, const Shapes& shapes) {
    if (!any_) {
      any_ = true;
      only_ = shape;
    } else if (only_ != shape) {
      Intersect(Points(shapes), shapes[shape].points());
    }
  }
  template <class Shapes>
  void Add(const CommonPoints& other, const Shapes& shapes) {
    if (!other.any_) return;
    if (other.only_ != kNone) return Add(other.only_, shapes);
    if (!any_) {
      *this = other;
    } else {
      Intersect(Points(shapes), other.Kept());
    }
  }
  friend bool operator==(const CommonPoints&, const CommonPoints&) = default;

  // kMany, with `a` to be filled in, if there are more than two points. O(1).
  PackedPoints Packed() const {
    if (!any_) return {};
    if (only_ != kNone) return {only_, PackedPoints::kLone};
    if (count_ == 0) return {kNone, PackedPoints::kApart};
    if (count_ > few_.size()) return {kNone, PackedPoints::kMany};
    return {few_[0], count_ == 1 ? kNone : few_[1]};
  }
  // `many`: the points, if `packed` says so.
  static CommonPoints Of(const PackedPoints& packed, std::span<const PointIndex> many) {
    CommonPoints common;
    common.any_ = packed.has_features();
    if (packed.b == PackedPoints::kLone) {
      common.only_ = packed.a;
    } else if (packed.b == PackedPoints::kMany) {
      common.count_ = static_cast<std::uint32_t>(many.size());
      common.many_.assign(many.begin(), many.end());
    } else if (common.any_ && packed.b != PackedPoints::kApart) {
      common.count_ = packed.b == kNone ? 1 : 2;
      common.few_ = {packed.a, packed.b == kNone ? 0 : packed.b};
    }
    return common;
  }
  std::span<const PointIndex> many() const { return many_; }

 private:
  std::span<const PointIndex> Kept() const {
    return count_ <= few_.size() ? std::span(few_).first(count_) : std::span(many_);
  }
  template <class Shapes>
  std::span<const PointIndex> Points(const Shapes& shapes) const {
    return only_ != kNone ? shapes[only_].points() : Kept();
  }
  // Keeps what both have. They may be what is kept.
  void Intersect(std::span<const PointIndex> a, std::span<const PointIndex> b) {
    std::array<PointIndex, 2> few = {};
    std::vector<PointIndex> many;
    std::uint32_t count = 0;
    for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
      if (a[i] != b[j]) {
        ++(a[i] < b[j] ? i : j);
        continue;
      }
      if (count < few.size()) few[count] = a[i];
      if (count == few.size()) many.assign(few.begin(), few.end());
      if (count >= few.size()) many.push_back(a[i]);
      ++count, ++i, ++j;
    }
    if (count > few.size()) few = {};
    only_ = kNone;
    count_ = count;
    few_ = few;
    many_ = std::move(many);
  }

  bool any_ = false;
  ShapeIndex only_ = kNone;  // the one feature, if there is only one
  // Of two features or more: sorted, in few_ if it has room, else in many_.
  std::uint32_t count_ = 0;
  std::array<PointIndex, 2> few_ = {};
  std::vector<PointIndex> many_;
};

}  // namespace dynmesh::quadtree

#endif  // DYNMESH_CORE_QUADTREE_COMMON_POINTS_H_
