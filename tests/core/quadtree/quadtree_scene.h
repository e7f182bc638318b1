// Random scenes for quadtrees: clusters of features in disjoint balls of very different sizes. In a
// cluster: a point, two near points, a segment, a star, a polyline; in 3D facets, too.
#ifndef DYNMESH_TESTS_CORE_QUADTREE_QUADTREE_SCENE_H_
#define DYNMESH_TESTS_CORE_QUADTREE_QUADTREE_SCENE_H_

#include <cmath>
#include <cstdint>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "core/quadtree/shape.h"

namespace dynmesh::quadtree::testing {

template <int D>
Grid<D> UnitGrid() {
  geometry::Point<D> lo, hi;
  lo.c.fill(0);
  hi.c.fill(1);
  return Grid<D>(lo, hi);
}

template <int D>
class Scene {
 public:
  using Point = geometry::Point<D>;

  Scene(std::uint64_t seed, int clusters, bool with_facets = true)
      : random_(seed), with_facets_(with_facets) {
    std::vector<std::pair<Point, double>> balls;
    for (int tries = 0; tries < 100 * clusters && static_cast<int>(balls.size()) < clusters;
         ++tries) {
      const double radius = 0.1 * std::exp2(-Uniform(0, 12));
      Point centre;
      for (int k = 0; k < D; ++k) centre[k] = Uniform(radius, 1 - radius);
      bool is_free = true;
      for (const auto& [other, far] : balls) {
        is_free = is_free && std::sqrt(geometry::SquaredDistance(centre, other)) > far + radius;
      }
      if (!is_free) continue;
      balls.emplace_back(centre, radius);
      Fill(centre, 0.9 * radius);
    }
  }

  // All features that may come and go.
  const std::vector<Shape<D>>& shapes() const { return shapes_; }
  // The ends of each; of a point twice the point, of a facet nothing.
  struct Ends {
    bool is_facet = false;
    Point p{}, q{};
  };
  const std::vector<Ends>& ends() const { return ends_; }
  int Below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  double Uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random_);
  }

 private:
  Point Near(const Point& centre, double radius) {
    Point p;
    do {
      for (int k = 0; k < D; ++k) p[k] = centre[k] + Uniform(-radius, radius);
    } while (geometry::SquaredDistance(p, centre) > radius * radius);
    // Some coordinates are borders of cells.
    if (Below(4) == 0) {
      const double unit = std::exp2(std::floor(std::log2(radius)) - 2);
      for (int k = 0; k < D; ++k) p[k] = std::round(p[k] / unit) * unit;
    }
    return p;
  }
  PointIndex AddPoint(const Point& p) {
    shapes_.push_back(Shape<D>::OfPoint(p, next_));
    ends_.push_back({false, p, p});
    return next_++;
  }
  void AddSegment(const Point& p, const Point& q, PointIndex a, PointIndex b) {
    if constexpr (D <= 3) {
      if (p == q) return;
      shapes_.push_back(Shape<D>::OfSegment(p, q, a, b));
      ends_.push_back({false, p, q});
    }
  }

  void Fill(const Point& centre, double radius) {
    const PointIndex a = AddPoint(centre);
    const int kind = Below(D == 2 || (D == 3 && !with_facets_) ? 5 : D == 3 ? 7 : 2);
    if (kind == 1) AddPoint(Near(centre, radius));
    if (kind == 2) {
      const Point p = Near(centre, radius);
      AddSegment(centre, p, a, AddPoint(p));
    }
    if (kind == 3) {  // a star
      const int n = 2 + Below(6);
      for (int i = 0; i < n; ++i) {
        Point p = centre;
        const double angle = 2 * M_PI * (i + Uniform(0, 0.5)) / n, r = Uniform(0.3, 1) * radius;
        p[0] += r * std::cos(angle);
        p[1] += r * std::sin(angle);
        AddSegment(centre, p, a, AddPoint(p));
      }
    }
    if (kind == 4) {  // a polyline, ascending
      Point p = centre;
      PointIndex at = a;
      const int n = 2 + Below(4);
      for (int i = 1; i <= n; ++i) {
        Point q = p;
        q[0] = centre[0] + 0.9 * radius * i / n;
        q[1] = centre[1] + Uniform(-0.3, 0.3) * radius;
        const PointIndex next = AddPoint(q);
        AddSegment(p, q, at, next);
        p = q;
        at = next;
      }
    }
    if constexpr (D == 3) {
      if (kind >= 5) {  // a fan of triangles around an edge, or one
        Point top = centre;
        top[2] += 0.5 * radius;
        const PointIndex b = AddPoint(top);
        AddSegment(centre, top, a, b);
        const int n = kind == 5 ? 1 : 2 + Below(3);
        for (int i = 0; i < n; ++i) {
          Point p = centre;
          const double angle = 2 * M_PI * (i + Uniform(0, 0.3)) / n;
          p[0] += 0.7 * radius * std::cos(angle);
          p[1] += 0.7 * radius * std::sin(angle);
          const PointIndex c = AddPoint(p);
          AddSegment(centre, p, a, c);
          AddSegment(top, p, b, c);
          shapes_.push_back(Shape<3>::OfFacet(std::make_shared<const FacetShape>(
              std::vector<geometry::Ring3>{{centre, top, p}}, std::vector<PointIndex>{a, b, c})));
          ends_.push_back({true, {}, {}});
        }
      }
    }
  }

  std::mt19937_64 random_;
  const bool with_facets_;
  std::vector<Shape<D>> shapes_;
  std::vector<Ends> ends_;
  PointIndex next_ = 0;
};

}  // namespace dynmesh::quadtree::testing

#endif  // DYNMESH_TESTS_CORE_QUADTREE_QUADTREE_SCENE_H_
