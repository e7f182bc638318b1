#include "client/cleaning/contact_index.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <boost/geometry.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <limits>
#include <utility>

#include "client/cleaning/patch_distance.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

namespace bg = boost::geometry;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using BoxCorner = bg::model::point<double, 3, bg::cs::cartesian>;
using Box = bg::model::box<BoxCorner>;
using Entry = std::pair<Box, std::uint32_t>;

Kernel::Point_3 Exact(const Point3& p) { return {p[0], p[1], p[2]}; }

struct Bounds {
  Point3 lo, hi;
};

Bounds BoundsOf(std::span<const Point3> points, const ContactElement& element) {
  Bounds b = {points[element.v[0]], points[element.v[0]]};
  for (int i = 1; i < element.size; ++i) {
    const Point3& p = points[element.v[static_cast<std::size_t>(i)]];
    for (std::size_t k = 0; k < 3; ++k) {
      b.lo[k] = std::min(b.lo[k], p[k]);
      b.hi[k] = std::max(b.hi[k], p[k]);
    }
  }
  return b;
}

Box BoxOf(const Bounds& b, double reach) {
  return {BoxCorner(b.lo[0] - reach, b.lo[1] - reach, b.lo[2] - reach),
          BoxCorner(b.hi[0] + reach, b.hi[1] + reach, b.hi[2] + reach)};
}

bool BoxesMeet(const Bounds& a, const Bounds& b, double reach) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (a.lo[k] - reach > b.hi[k] || b.lo[k] - reach > a.hi[k]) return false;
  }
  return true;
}

// C. Ericson, Real-Time Collision Detection, 2005, 5.1.9. Ends may be equal.
double SquaredDistanceOfEdges(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const Point3 u = Minus(b, a), w = Minus(d, c), r = Minus(a, c);
  const double uu = Dot(u, u), ww = Dot(w, w), uw = Dot(u, w), wr = Dot(w, r), ur = Dot(u, r);
  const double det = uu * ww - uw * uw;
  double s = det > 0 ? std::clamp((uw * wr - ur * ww) / det, 0.0, 1.0) : 0;
  double t = ww > 0 ? (uw * s + wr) / ww : 0;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = uu > 0 ? std::clamp((t * uw - ur) / uu, 0.0, 1.0) : 0;
  }
  return SquaredDistance<3>(Along(a, s, u), Along(c, t, w));
}

// Corners of one or two elements.
struct Part {
  std::array<Point3, 3> p;
  std::size_t size = 0;
};

double SquaredDistanceOf(const Part& a, const Part& b) {
  double least = std::numeric_limits<double>::infinity();
  const auto take = [&](double d2) { least = std::min(least, d2); };
  for (const auto& [of, to] : {std::pair(&a, &b), std::pair(&b, &a)}) {
    for (std::size_t i = 0; to->size == 3 && i < of->size; ++i) {
      take(SquaredDistance<3>(of->p[i], NearestOn(to->p, of->p[i])));
    }
  }
  for (std::size_t i = 0; i < a.size; ++i) {
    for (std::size_t j = 0; j < b.size; ++j) {
      take(SquaredDistanceOfEdges(a.p[i], a.p[(i + 1) % a.size], b.p[j], b.p[(j + 1) % b.size]));
    }
  }
  return least;
}

Kernel::Triangle_3 FaceOf(const Part& a) { return {Exact(a.p[0]), Exact(a.p[1]), Exact(a.p[2])}; }
Kernel::Segment_3 EdgeOf(const Part& a) { return {Exact(a.p[0]), Exact(a.p[1])}; }

bool DoMeet(const Part& face, const Part& other) {
  if (other.size == 3) return CGAL::do_intersect(FaceOf(face), FaceOf(other));
  if (other.size == 2) return CGAL::do_intersect(FaceOf(face), EdgeOf(other));
  return CGAL::do_intersect(FaceOf(face), Exact(other.p[0]));
}

bool AreTooNear(const Part& face, const Part& other, double distance) {
  return !(SquaredDistanceOf(face, other) >= distance * distance) || DoMeet(face, other);
}

}  // namespace

bool HasContact(std::span<const Point3> points, const ContactElement& face,
                const ContactElement& other, double distance) {
  // Common corners first.
  const auto order = [&](const ContactElement& of, const ContactElement& by) {
    Part part;
    std::size_t common = 0;
    for (const bool is_common : {true, false}) {
      for (int i = 0; i < of.size; ++i) {
        const Node n = of.v[static_cast<std::size_t>(i)];
        if ((std::find(by.v.begin(), by.v.begin() + by.size, n) != by.v.begin() + by.size) !=
            is_common) {
          continue;
        }
        common += is_common ? 1 : 0;
        part.p[part.size++] = points[n];
      }
    }
    return std::pair(part, common);
  };
  const auto [s, common] = order(face, other);
  const Part t = order(other, face).first;
  const auto opposite = [](const Part& part, std::size_t from) {
    Part rest;
    for (std::size_t i = from; i < part.size; ++i) rest.p[rest.size++] = part.p[i];
    return rest;
  };
  if (common == 0) return AreTooNear(s, t, distance);
  if (common == t.size) return t.size == 3;  // the same face, or an edge or corner of it
  if (common == 1) {
    // Both are convex: what they have in common, besides the corner, ends opposite to it in one.
    const Part edge = opposite(s, 1), rest = opposite(t, 1);
    if (AreTooNear(s, rest, distance)) return true;
    if (t.size == 3) return AreTooNear(t, edge, distance);
    return CGAL::do_intersect(EdgeOf(edge), EdgeOf(t));
  }
  // Two faces at an edge: in one plane, and on one side of it?
  const auto a = Exact(s.p[0]), b = Exact(s.p[1]), c = Exact(s.p[2]), d = Exact(t.p[2]);
  return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
}

struct ContactIndex::Tree {
  bg::index::rtree<Entry, bg::index::quadratic<16>> entries;
};

ContactIndex::ContactIndex(std::span<const Point3> points, double distance)
    : points_(points), distance_(distance), tree_(std::make_unique<Tree>()) {}

ContactIndex::~ContactIndex() = default;

void ContactIndex::Insert(std::uint32_t id, const ContactElement& element) {
  if (id >= elements_.size()) elements_.resize(id + 1);
  elements_[id] = element;
  tree_->entries.insert({BoxOf(BoundsOf(points_, element), 0), id});
}

void ContactIndex::Remove(std::uint32_t id, const ContactElement& element) {
  tree_->entries.remove({BoxOf(BoundsOf(points_, element), 0), id});
}

bool ContactIndex::HasContacts(std::span<const ContactElement> faces,
                               absl::FunctionRef<bool(std::uint32_t)> is_left_out) const {
  if (faces.empty()) return false;
  std::vector<Bounds> bounds;
  bounds.reserve(faces.size());
  Bounds all = BoundsOf(points_, faces[0]);
  for (const ContactElement& face : faces) {
    const Bounds& b = bounds.emplace_back(BoundsOf(points_, face));
    for (std::size_t k = 0; k < 3; ++k) {
      all.lo[k] = std::min(all.lo[k], b.lo[k]);
      all.hi[k] = std::max(all.hi[k], b.hi[k]);
    }
  }
  for (auto it = tree_->entries.qbegin(bg::index::intersects(BoxOf(all, distance_)));
       it != tree_->entries.qend(); ++it) {
    if (is_left_out(it->second)) continue;
    const ContactElement& other = elements_[it->second];
    const Bounds b = BoundsOf(points_, other);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (BoxesMeet(bounds[i], b, distance_) && HasContact(points_, faces[i], other, distance_)) {
        return true;
      }
    }
  }
  return false;
}

bool ContactIndex::HasCornersIn(std::span<const std::array<Node, 4>> tetrahedra,
                                absl::FunctionRef<bool(std::uint32_t)> is_left_out) const {
  for (const auto& tetrahedron : tetrahedra) {
    std::array<Kernel::Point_3, 4> corners;
    Bounds box = {points_[tetrahedron[0]], points_[tetrahedron[0]]};
    for (std::size_t i = 0; i < 4; ++i) {
      const Point3& p = points_[tetrahedron[i]];
      corners[i] = Exact(p);
      for (std::size_t k = 0; k < 3; ++k) {
        box.lo[k] = std::min(box.lo[k], p[k]);
        box.hi[k] = std::max(box.hi[k], p[k]);
      }
    }
    const auto side = [](const std::array<Kernel::Point_3, 4>& c) {
      return CGAL::orientation(c[0], c[1], c[2], c[3]);
    };
    const CGAL::Orientation of_all = side(corners);
    if (of_all == CGAL::ZERO) continue;
    const auto is_inside = [&](Node n) {
      const Point3& p = points_[n];
      if (!BoxesMeet(box, {p, p}, 0)) return false;
      if (std::find(tetrahedron.begin(), tetrahedron.end(), n) != tetrahedron.end()) return false;
      for (std::size_t i = 0; i < 4; ++i) {
        auto with = corners;
        with[i] = Exact(p);
        if (side(with) == -of_all) return false;
      }
      return true;
    };
    for (auto it = tree_->entries.qbegin(bg::index::intersects(BoxOf(box, 0)));
         it != tree_->entries.qend(); ++it) {
      if (is_left_out(it->second)) continue;
      const ContactElement& other = elements_[it->second];
      if (std::any_of(other.v.begin(), other.v.begin() + other.size, is_inside)) return true;
    }
  }
  return false;
}

}  // namespace dynmesh::cleaning
