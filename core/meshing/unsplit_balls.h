// The diametral balls of segments that must stay whole (SegmentShape::unsplit), by position. The
// query: which of them hold a point?
//
// Segments of like length are in one tree of features (input_features.h): a ball that holds x
// belongs to a segment no farther from x than its radius. O(depth + segments as near) for each
// octave of lengths that occurs. Answers are a function of the segments present. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_UNSPLIT_BALLS_H_
#define DYNMESH_CORE_MESHING_UNSPLIT_BALLS_H_

#include <cmath>
#include <cstddef>
#include <map>

#include "core/geometry/constructions.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segment_distance.h"
#include "core/meshing/input_features.h"

namespace dynmesh::meshing {

template <int D>
class UnsplitBalls {
 public:
  using Point = geometry::Point<D>;
  using Feature = InputFeature<D>;

  UnsplitBalls(const Point& lo, const Point& hi) : lo_(lo), hi_(hi) {}

  void Add(const Feature& segment) {
    Level& level = levels_.try_emplace(LevelOf(segment), lo_, hi_).first->second;
    level.segments.Add(segment);
    ++level.count;
  }
  // REQUIRES: it is there.
  void Remove(const Feature& segment) {
    const auto level = levels_.find(LevelOf(segment));
    level->second.segments.Remove(segment);
    if (--level->second.count == 0) levels_.erase(level);
  }
  bool empty() const { return levels_.empty(); }

  // Is x in a ball, or on its surface?
  bool Hold(const Point& x) const {
    return Any(x, x,
               [&](const Feature& f) { return geometry::DiametralBallSign(f.p, f.q, x) <= 0; });
  }
  // Does the segment from x to y meet a ball? In doubles.
  bool Meet(const Point& x, const Point& y) const {
    return Any(x, y, [&](const Feature& f) {
      return geometry::SquaredDistance(geometry::Midpoint(f.p, f.q), x, y) <=
             0.25 * kWider * geometry::SquaredDistance(f.p, f.q);
    });
  }

  std::size_t bytes() const {
    std::size_t bytes = 0;
    for (const auto& [exponent, level] : levels_) bytes += sizeof(Level) + level.segments.bytes();
    return bytes;
  }

 private:
  struct Level {
    Level(const Point& lo, const Point& hi) : segments(lo, hi) {}
    InputFeatures<D> segments;
    std::size_t count = 0;
  };

  static int LevelOf(const Feature& segment) {
    return std::ilogb(geometry::SquaredDistance(segment.p, segment.q));
  }

  // True if accept(segment) is, for one whose ball may meet that from x to y.
  template <class Accept>
  bool Any(const Point& x, const Point& y, Accept accept) const {
    const Point middle = geometry::Midpoint(x, y);
    const double half = 0.5 * std::sqrt(geometry::SquaredDistance(x, y));
    bool found = false;
    for (const auto& [exponent, level] : levels_) {
      const double reach = (0.5 * std::sqrt(std::ldexp(1.0, exponent + 1)) + half) * kWider;
      double reach2 = reach * reach;
      level.segments.VisitNear(
          middle, reach2, {level.segments.kNone, level.segments.kNone},
          [](const Point&, double) { return true; },
          [&](const Feature& f) {
            if (found || !accept(f)) return;
            found = true;
            reach2 = 0;
          });
      if (found) return true;
    }
    return false;
  }

  const Point lo_, hi_;
  std::map<int, Level> levels_;  // by the exponent of the squared length
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_UNSPLIT_BALLS_H_
