#include "core/plc/facet_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include "core/geometry/circumball.h"

namespace dynmesh::plc {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Point3;
using geometry::Vector3;

// The border of the inside, as loops of edges with the inside on their left.
class Border {
 public:
  explicit Border(const Facet& facet) : facet_(facet) {
    for (const geometry::Ring3& ring : facet.feature().positions) {
      first_.push_back(count_);
      count_ += ring.size();
    }
    forward_.resize(count_);
    for (const Facet::Corner& c : facet.corners()) {
      forward_[NumberOf(c)] = facet.IsInsideLeftOf(c);
    }
    next_.resize(count_);
    for (const Facet::Corner& c : facet.corners()) {
      const Facet::Corner before = facet.Beside(c, false);
      // Of the ring's two edges at the corner: those that lead to it.
      if (forward_[NumberOf(before)]) FindNext(NumberOf(before), c, before);
      if (!forward_[NumberOf(c)]) FindNext(NumberOf(c), c, facet.Beside(c, true));
    }
  }

  // The loops as positions, in order.
  std::vector<geometry::Ring3> Loops() const {
    std::vector<geometry::Ring3> loops;
    std::vector<bool> done(count_, false);
    for (std::size_t first = 0; first < count_; ++first) {
      if (done[first]) continue;
      geometry::Ring3& loop = loops.emplace_back();
      for (std::size_t e = first; !done[e]; e = next_[e].edge) {
        done[e] = true;
        loop.push_back(PositionOf(next_[e].at));
      }
    }
    return loops;
  }

 private:
  // The next edge after an edge, and the corner between them.
  struct Next {
    std::size_t edge = 0;
    Facet::Corner at;
  };

  const Point3& PositionOf(const Facet::Corner& c) const { return facet_.PositionOf(c); }
  // The number of the edge from a corner to the next one of its ring.
  std::size_t NumberOf(const Facet::Corner& c) const { return first_[c.ring] + c.at; }

  // `edge` leads from `from` to `at`, with the inside on its left. The next edge is the first one
  // clockwise from it.
  void FindNext(std::size_t edge, const Facet::Corner& at, const Facet::Corner& from) {
    const Vector3 back = Difference(PositionOf(from).c, PositionOf(at).c);
    const Vector3 aside = Cross(back, facet_.plane().normal);  // clockwise
    double least = std::numeric_limits<double>::infinity();
    for (const Facet::Corner& visit : facet_.At(at.id)) {
      for (const bool next : {true, false}) {
        const Facet::Corner to = facet_.Beside(visit, next);
        const std::size_t other = NumberOf(next ? visit : to);
        if (other == edge || forward_[other] != next) continue;
        const Vector3 way = Difference(PositionOf(to).c, PositionOf(at).c);
        double turn = std::atan2(Dot(way, aside), Dot(way, back));
        if (turn < 0) turn += 2 * std::numbers::pi;
        if (turn < least) least = turn, next_[edge] = {other, at};
      }
    }
  }

  const Facet& facet_;
  std::vector<std::size_t> first_;  // by ring: the number of its first edge
  std::size_t count_ = 0;
  std::vector<bool> forward_;  // by edge: is the inside on its left?
  std::vector<Next> next_;
};

// Along the normal; negative for a loop around a hole.
double AreaOf(const geometry::Ring3& loop, const Vector3& normal) {
  double area = 0;
  for (std::size_t i = 1; i + 1 < loop.size(); ++i) {
    area +=
        Dot(Cross(Difference(loop[i].c, loop[0].c), Difference(loop[i + 1].c, loop[0].c)), normal) /
        2;
  }
  return area;
}

}  // namespace

// A part has one outer loop, and one for each of its holes.
bool FallsApart(const Facet& facet) {
  if (facet.feature().rings.size() == 1) return false;
  const std::vector<geometry::Ring3> loops = Border(facet).Loops();
  return std::count_if(loops.begin(), loops.end(), [&](const geometry::Ring3& loop) {
           return AreaOf(loop, facet.plane().normal) > 0;
         }) > 1;
}

}  // namespace dynmesh::plc
