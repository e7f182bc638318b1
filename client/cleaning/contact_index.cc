#include "client/cleaning/contact_index.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "client/cleaning/box_tree.h"
#include "client/cleaning/patch_distance.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

namespace index = boost::geometry::index;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_3 ExactOf(const Point3& p) { return {p[0], p[1], p[2]}; }

Box3 BoxOf(std::span<const Point3> points, std::span<const Node> corners) {
  const Point3& first = points[corners[0]];
  Box3 box = {first, first};
  for (const Node n : corners) box.Add({points[n], points[n]});
  return box;
}
Box3 BoxOf(std::span<const Point3> points, const ContactElement& element) {
  return BoxOf(points, std::span(element.v).first(static_cast<std::size_t>(element.size)));
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

Kernel::Triangle_3 FaceOf(const Part& a) {
  return {ExactOf(a.p[0]), ExactOf(a.p[1]), ExactOf(a.p[2])};
}
Kernel::Segment_3 EdgeOf(const Part& a) { return {ExactOf(a.p[0]), ExactOf(a.p[1])}; }

bool DoMeet(const Part& face, const Part& other) {
  if (other.size == 3) return CGAL::do_intersect(FaceOf(face), FaceOf(other));
  if (other.size == 2) return CGAL::do_intersect(FaceOf(face), EdgeOf(other));
  return CGAL::do_intersect(FaceOf(face), ExactOf(other.p[0]));
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
  const auto a = ExactOf(s.p[0]), b = ExactOf(s.p[1]), c = ExactOf(s.p[2]), d = ExactOf(t.p[2]);
  return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
}

struct ContactIndex::Tree {
  BoxTree entries;
};

ContactIndex::ContactIndex(std::span<const Point3> points, double distance)
    : points_(points), distance_(distance), tree_(std::make_unique<Tree>()) {}

ContactIndex::~ContactIndex() = default;

void ContactIndex::Insert(std::uint32_t id, const ContactElement& element) {
  if (id >= elements_.size()) elements_.resize(id + 1);
  elements_[id] = element;
  tree_->entries.insert({TreeBoxOf(BoxOf(points_, element)), id});
}

void ContactIndex::Remove(std::uint32_t id, const ContactElement& element) {
  tree_->entries.remove({TreeBoxOf(BoxOf(points_, element)), id});
}

bool ContactIndex::HasContacts(std::span<const ContactElement> faces,
                               absl::FunctionRef<bool(std::uint32_t)> is_left_out) const {
  if (faces.empty()) return false;
  std::vector<Box3> boxes;
  boxes.reserve(faces.size());
  Box3 all = BoxOf(points_, faces[0]);
  for (const ContactElement& face : faces) all.Add(boxes.emplace_back(BoxOf(points_, face)));
  for (auto it = tree_->entries.qbegin(index::intersects(TreeBoxOf(all.Grown(distance_))));
       it != tree_->entries.qend(); ++it) {
    if (is_left_out(it->second)) continue;
    const ContactElement& other = elements_[it->second];
    const Box3 box = BoxOf(points_, other);
    for (std::size_t i = 0; i < faces.size(); ++i) {
      if (boxes[i].Meets(box, distance_) && HasContact(points_, faces[i], other, distance_)) {
        return true;
      }
    }
  }
  return false;
}

bool ContactIndex::HasCornersIn(std::span<const std::array<Node, 4>> tetrahedra,
                                absl::FunctionRef<bool(std::uint32_t)> is_left_out) const {
  for (const auto& tetrahedron : tetrahedra) {
    const Box3 box = BoxOf(points_, tetrahedron);
    std::array<Kernel::Point_3, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) corners[i] = ExactOf(points_[tetrahedron[i]]);
    const auto side = [](const std::array<Kernel::Point_3, 4>& c) {
      return CGAL::orientation(c[0], c[1], c[2], c[3]);
    };
    const CGAL::Orientation of_all = side(corners);
    if (of_all == CGAL::ZERO) continue;
    const auto is_inside = [&](Node n) {
      const Point3& p = points_[n];
      if (!box.Meets({p, p})) return false;
      if (std::find(tetrahedron.begin(), tetrahedron.end(), n) != tetrahedron.end()) return false;
      for (std::size_t i = 0; i < 4; ++i) {
        auto with = corners;
        with[i] = ExactOf(p);
        if (side(with) == -of_all) return false;
      }
      return true;
    };
    for (auto it = tree_->entries.qbegin(index::intersects(TreeBoxOf(box)));
         it != tree_->entries.qend(); ++it) {
      if (is_left_out(it->second)) continue;
      const ContactElement& other = elements_[it->second];
      if (std::any_of(other.v.begin(), other.v.begin() + other.size, is_inside)) return true;
    }
  }
  return false;
}

}  // namespace dynmesh::cleaning
