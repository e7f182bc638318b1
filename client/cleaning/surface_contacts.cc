#include "client/cleaning/surface_contacts.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <tuple>

#include "absl/functional/function_ref.h"
#include "client/cleaning/box_tree.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Rational = CGAL::Exact_rational;

constexpr double kBeyondFold = 1.01;  // for rounding

int Orientation(const Point& a, const Point& b, const Point& c) {
  return CGAL::orientation(Kernel::Point_2(a[0], a[1]), Kernel::Point_2(b[0], b[1]),
                           Kernel::Point_2(c[0], c[1]));
}

int Orientation(const Point3& a, const Point3& b, const Point3& c, const Point3& d) {
  const auto at = [](const Point3& p) { return Kernel::Point_3(p[0], p[1], p[2]); };
  return CGAL::orientation(at(a), at(b), at(c), at(d));
}

Box3 BoxOf(std::initializer_list<Point3> points, double reach) {
  return Box3::Of({points.begin(), points.size()}).Grown(reach);
}

// What tests of a simplex need, once.
struct Shape {
  Box3 box;
  Point3 normal{};       // of a face, of any length; through its first corner
  double length = 0;     // of the normal
  double deviation = 0;  // of the corners from the plane, by rounding
  Node first = 0;        // of Surface::CornersOf
};

class Search {
 public:
  Search(const Surface& surface, int since)
      : surface_(surface), since_(since), most_(surface.field.most() / 2) {
    reaches_.reserve(surface.nodes.size());
    for (Node v = 0; v < surface.nodes.size(); ++v) {
      reaches_.push_back(surface.field.At(surface.at(v)) / 2);
    }
    shapes_.reserve(surface.simplices.size());
    for (const Simplex& s : surface.simplices) shapes_.push_back(ShapeOf(s));
  }

  const Shape& shape(std::uint32_t i) const { return shapes_[i]; }
  const Point3& at(Node v) const { return surface_.at(v); }
  bool IsNew(std::uint32_t i) const { return surface_.simplices[i].born >= since_; }

  // Calls visit(i, j) with i < j for pairs with boxes that meet, of which one is new, until it
  // returns false.
  void VisitPairs(absl::FunctionRef<bool(std::uint32_t, std::uint32_t)> visit) const {
    std::vector<BoxEntry> entries;
    entries.reserve(shapes_.size());
    for (std::uint32_t i = 0; i < shapes_.size(); ++i) {
      entries.emplace_back(TreeBoxOf(shapes_[i].box), i);
    }
    const BoxTree tree(entries);
    std::vector<BoxEntry> near;
    for (std::uint32_t i = 0; i < shapes_.size(); ++i) {
      if (!IsNew(i)) continue;
      near.clear();
      tree.query(boost::geometry::index::intersects(entries[i].first), std::back_inserter(near));
      for (const BoxEntry& entry : near) {
        const std::uint32_t j = entry.second;
        if (j == i || (j < i && IsNew(j))) continue;
        if (!visit(std::min(i, j), std::max(i, j))) return;
      }
    }
  }

  // What is folded onto the other one at a common corner touches up to this distance, and is to
  // become one; 0 if that is nothing. REQUIRES: i != j.
  double FoldOf(std::uint32_t i, std::uint32_t j) const {
    double fold = 0;
    if (surface_.least_sine == 0) return fold;
    const Simplex &s = surface_.simplices[i], &t = surface_.simplices[j];
    for (int k = 0; k < s.size; ++k) {
      const Node v = s.v[static_cast<std::size_t>(k)];
      if (t.Has(v)) fold = std::max({fold, FoldAt(v, s, t, j), FoldAt(v, t, s, i)});
    }
    return fold;
  }

  // As FoldOf, of a face's edges at a corner.
  double FoldOf(std::uint32_t i) const {
    double fold = 0;
    if (surface_.least_sine == 0) return fold;
    const Simplex& s = surface_.simplices[i];
    for (std::size_t k = 0; k < 3; ++k) {
      fold = std::max(fold, FoldOfEdges(Minus(at(s.v[(k + 1) % 3]), at(s.v[k])),
                                        Minus(at(s.v[(k + 2) % 3]), at(s.v[k]))));
    }
    return fold;
  }

  // The corner v of `from` is on that part of simplex i: nearer than half of the tolerance, or than
  // the fold.
  std::optional<int> PartAt(std::uint32_t i, Node v, const Simplex& from, double fold) const {
    const Simplex& s = surface_.simplices[i];
    const Shape& shape = shapes_[i];
    const Point3& p = at(v);
    const double reach = std::max(reaches_[v], fold);
    if (s.size < 2 || s.Has(v) || !shape.box.Meets({p, p}, reach)) return std::nullopt;
    std::optional<int> beside;
    for (int k = 0; k < s.edge_count(); ++k) {
      if (IsOn(v, s.Edge(k), from, fold) && (!beside || s.Edge(k) < s.Edge(*beside))) beside = k;
    }
    if (beside) return beside;
    if (s.size < 3) return std::nullopt;
    const double height = std::abs(Dot(shape.normal, Minus(p, at(shape.first)))) / shape.length;
    if (!(height < reach + 2 * shape.deviation) || !IsOver(surface_, s, p)) return std::nullopt;
    return kFaceItself;
  }

  // The node projects into the open edge and is nearer to it than `reach`.
  bool IsBeside(Node v, NodePair edge, double reach) const {
    if (v == edge.first || v == edge.second) return false;
    const Point3& p = at(v);
    const auto [lo, hi] = EndsOf(edge);
    const Point3 d = Minus(hi, lo), w = Minus(p, lo);
    const double length2 = Dot(d, d), along = Dot(d, w);
    if (along <= 0 || along >= length2) return false;
    const Point3 cross = Cross(d, w);
    return Dot(cross, cross) < reach * reach * length2;
  }

  // The corner v of `from` is on the edge. Of two edges that are folded onto each other the longer
  // one goes through the end of the other.
  bool IsOn(Node v, NodePair edge, const Simplex& from, double fold) const {
    if (IsBeside(v, edge, reaches_[v])) return true;
    if (!(fold > reaches_[v]) || !IsBeside(v, edge, fold)) return false;
    for (const Node end : {edge.first, edge.second}) {
      if (from.Has(end) && !surface_.IsShorter(Ordered(end, v), edge)) return false;
    }
    return true;
  }

  // Where two edges without a common end meet.
  std::optional<Point3> Meeting(NodePair e, NodePair f, double fold) const {
    if (e.first == f.first || e.first == f.second || e.second == f.first || e.second == f.second) {
      return std::nullopt;
    }
    if (EndsOf(f) < EndsOf(e)) std::swap(e, f);
    const auto [a, b] = EndsOf(e);
    const auto [c, d] = EndsOf(f);
    if (!BoxOf({a, b}, std::max(fold, most_)).Meets(BoxOf({c, d}, 0))) return std::nullopt;
    const Point3 u = Minus(b, a), w = Minus(d, c), r = Minus(c, a);
    const double uu = Dot(u, u), ww = Dot(w, w), uw = Dot(u, w);
    const Point3 n = Cross(u, w);
    const double nn = Dot(n, n);
    if (!(nn > 0)) return std::nullopt;
    double s = Dot(Cross(r, w), n) / nn;
    if (!(s > 0 && s < 1)) return std::nullopt;
    // Nearest to that place, and back: so rounding in the first step matters less.
    const double t = (s * uw - Dot(r, w)) / ww;
    if (!(t > 0 && t < 1)) return std::nullopt;
    s = (t * uw + Dot(r, u)) / uu;
    if (!(s > 0 && s < 1)) return std::nullopt;
    const Point3 x = Along(a, s, u), y = Along(c, t, w);
    const double reach = std::max(fold, surface_.field.At(x) / 2);
    if (!(SquaredDistance<3>(x, y) < reach * reach)) return std::nullopt;
    if (const auto exact = ExactMeeting(a, b, c, d, AxisOf(n))) return exact;
    return Point3{(x[0] + y[0]) / 2, (x[1] + y[1]) / 2, (x[2] + y[2]) / 2};
  }

  // Where the edge passes through the inside of face i. Exact, rounded once.
  std::optional<Point3> Passage(NodePair e, std::uint32_t i) const {
    const Simplex& s = surface_.simplices[i];
    if (s.Has(e.first) || s.Has(e.second)) return std::nullopt;
    const Point3 &p = at(e.first), &q = at(e.second);
    if (!BoxOf({p, q}, 0).Meets(shapes_[i].box)) return std::nullopt;
    const std::array<Node, 3> v = s.Key();
    const Point3 &a = at(v[0]), &b = at(v[1]), &c = at(v[2]);
    const int at_p = Orientation(a, b, c, p);
    if (at_p == 0) return std::nullopt;
    if (at_p * Orientation(a, b, c, q) >= 0) return std::nullopt;
    const int side = Orientation(p, q, a, b);
    if (side == 0 || Orientation(p, q, b, c) != side || Orientation(p, q, c, a) != side) {
      return std::nullopt;
    }
    using Vector = std::array<Rational, 3>;
    const auto minus = [](const Point3& to, const Point3& from) {
      Vector d;
      for (std::size_t k = 0; k < 3; ++k) d[k] = Rational(to[k]) - Rational(from[k]);
      return d;
    };
    const Vector u = minus(b, a), w = minus(c, a), ap = minus(p, a), pq = minus(q, p);
    const Vector n = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2],
                      u[0] * w[1] - u[1] * w[0]};
    const auto dot = [&](const Vector& d) -> Rational {
      return n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
    };
    const Rational t = -dot(ap) / dot(pq);
    Point3 place;
    for (std::size_t k = 0; k < 3; ++k) {
      place[k] = CGAL::to_double(Rational(Rational(p[k]) + t * pq[k]));
    }
    return place;
  }

  // Touches first: what these split is looked at again in the next round.
  void FindOfPair(std::uint32_t i, std::uint32_t j, std::vector<Contact>& found) const {
    const Simplex &s = surface_.simplices[i], &t = surface_.simplices[j];
    const double fold = FoldOf(i, j);
    std::array<bool, 3> s_touches{}, t_touches{};  // by corner
    for (int k = 0; k < s.size; ++k) {
      const Node v = s.v[static_cast<std::size_t>(k)];
      const std::optional<int> part = PartAt(j, v, s, fold);
      s_touches[static_cast<std::size_t>(k)] = part.has_value();
      if (part) found.push_back({i, j, kFirstCorner + k, *part, at(v), v, fold});
    }
    for (int l = 0; l < t.size; ++l) {
      const Node v = t.v[static_cast<std::size_t>(l)];
      const std::optional<int> part = PartAt(i, v, t, fold);
      t_touches[static_cast<std::size_t>(l)] = part.has_value();
      if (part) found.push_back({i, j, *part, kFirstCorner + l, at(v), v, fold});
    }
    for (int k = 0; k < s.edge_count(); ++k) {
      for (int l = 0; l < t.edge_count(); ++l) {
        const NodePair e = s.Edge(k), f = t.Edge(l);
        const auto place = Meeting(e, f, fold);
        if (!place || IsNear(e.first, f, fold) || IsNear(e.second, f, fold) ||
            IsNear(f.first, e, fold) || IsNear(f.second, e, fold)) {
          continue;
        }
        found.push_back({i, j, k, l, *place, 0, fold});
      }
    }
    const auto is_free = [](const std::array<bool, 3>& touches, int edge, int size) {
      const auto k = static_cast<std::size_t>(edge);
      return !touches[k] && !touches[(k + 1) % static_cast<std::size_t>(size)];
    };
    for (int k = 0; t.size == 3 && k < s.edge_count(); ++k) {
      if (!is_free(s_touches, k, s.size)) continue;
      if (const auto place = Passage(s.Edge(k), j)) {
        found.push_back({i, j, k, kFaceItself, *place, 0, fold});
      }
    }
    for (int l = 0; s.size == 3 && l < t.edge_count(); ++l) {
      if (!is_free(t_touches, l, t.size)) continue;
      if (const auto place = Passage(t.Edge(l), i)) {
        found.push_back({i, j, kFaceItself, l, *place, 0, fold});
      }
    }
  }

 private:
  bool IsNear(Node v, NodePair edge, double fold) const {
    return IsBeside(v, edge, std::max(reaches_[v], fold));
  }

  // How far the end of the shorter one of two edges from a corner is from the longer one; 0 if they
  // meet at more than the least angle.
  double FoldOfEdges(const Point3& u, const Point3& w) const {
    const double uu = Dot(u, u), ww = Dot(w, w);
    if (!(Dot(u, w) > 0)) return 0;
    const Point3 cross = Cross(u, w);
    const double cc = Dot(cross, cross);
    if (!(cc < surface_.least_sine * surface_.least_sine * uu * ww)) return 0;
    return kBeyondFold * std::sqrt(cc / std::max(uu, ww));
  }

  // As FoldOf, at a common corner: of edges of s and what t has there. At a common edge only edges
  // count: a mesh takes faces that meet there at small angles.
  double FoldAt(Node v, const Simplex& s, const Simplex& t, std::uint32_t j) const {
    double fold = 0;
    const Point3& p = at(v);
    bool has_edge = false;
    for (int l = 0; l < t.size; ++l) {
      const Node b = t.v[static_cast<std::size_t>(l)];
      has_edge = has_edge || (b != v && s.Has(b));
    }
    for (int k = 0; k < s.size; ++k) {
      const Node a = s.v[static_cast<std::size_t>(k)];
      if (t.Has(a)) continue;
      const Point3 u = Minus(at(a), p);
      for (int l = 0; l < t.size; ++l) {
        const Node b = t.v[static_cast<std::size_t>(l)];
        if (b != v) fold = std::max(fold, FoldOfEdges(u, Minus(at(b), p)));
      }
      if (t.size == 3 && !has_edge) fold = std::max(fold, FoldOver(v, u, t, shapes_[j]));
    }
    return fold;
  }

  // How far the end of an edge from a corner v of t, by u, is from t's plane; 0 if the edge does
  // not lead over the face, or at more than the least angle.
  double FoldOver(Node v, const Point3& u, const Simplex& t, const Shape& shape) const {
    const double up = Dot(shape.normal, u) / shape.length;
    if (!(up * up < surface_.least_sine * surface_.least_sine * Dot(u, u))) return 0;
    std::array<Point3, 2> sides;
    std::size_t count = 0;
    for (const Node b : t.v) {
      if (b != v) sides[count++] = Minus(at(b), at(v));
    }
    const Point3 turn = Cross(sides[0], sides[1]);
    if (!(Dot(Cross(sides[0], u), turn) > 0) || !(Dot(Cross(u, sides[1]), turn) > 0)) return 0;
    return kBeyondFold * std::abs(up);
  }

  // In the order of coordinates.
  std::pair<const Point3&, const Point3&> EndsOf(NodePair edge) const {
    return std::minmax(at(edge.first), at(edge.second));
  }

  // By the greatest tolerance in what results.
  Box3 Grown(const Box3& box) const {
    return box.Grown(surface_.field.MostIn(box.Grown(2 * most_)));
  }

  Shape ShapeOf(const Simplex& s) const {
    Shape shape;
    if (s.size == 3) {
      const std::array<Node, 3> v = surface_.CornersOf(s);
      const Point3 &a = at(v[0]), &b = at(v[1]), &c = at(v[2]);
      shape.normal = NormalOf(a, b, c);
      shape.length = std::sqrt(Dot(shape.normal, shape.normal));
      shape.first = v[0];
      for (const Point3* p : {&b, &c}) {
        const double height = std::abs(Dot(shape.normal, Minus(*p, a))) / shape.length;
        if (height > shape.deviation) shape.deviation = height;
      }
      shape.box = Grown(BoxOf({a, b, c}, 2 * shape.deviation));
    } else {
      shape.box = Grown(BoxOf({at(s.v[0]), at(s.v[s.size == 2 ? 1 : 0])}, 0));
    }
    return shape;
  }

  // If the four points are in a plane: the crossing, exact, rounded once.
  static std::optional<Point3> ExactMeeting(const Point3& a, const Point3& b, const Point3& c,
                                            const Point3& d, std::size_t axis) {
    if (Orientation(a, b, c, d) != 0) return std::nullopt;
    const std::size_t i = (axis + 1) % 3, j = (axis + 2) % 3;
    const Rational ux = Rational(b[i]) - Rational(a[i]), uy = Rational(b[j]) - Rational(a[j]);
    const Rational wx = Rational(d[i]) - Rational(c[i]), wy = Rational(d[j]) - Rational(c[j]);
    const Rational det = ux * wy - uy * wx;
    if (det == 0) return std::nullopt;
    const Rational rx = Rational(c[i]) - Rational(a[i]), ry = Rational(c[j]) - Rational(a[j]);
    const Rational s = (rx * wy - ry * wx) / det, t = (rx * uy - ry * ux) / det;
    if (s <= 0 || s >= 1 || t <= 0 || t >= 1) return std::nullopt;
    Point3 place;
    for (std::size_t k = 0; k < 3; ++k) {
      place[k] = CGAL::to_double(Rational(Rational(a[k]) + s * (Rational(b[k]) - Rational(a[k]))));
    }
    return place;
  }

  const Surface& surface_;
  const int since_;
  const double most_;            // half of the greatest tolerance
  std::vector<double> reaches_;  // by node: half of the tolerance there
  std::vector<Shape> shapes_;
};

}  // namespace

FaceView ViewOf(const Surface& surface, const Simplex& face) {
  const std::array<Node, 3> key = face.Key();
  const std::array<Node, 3> v = surface.CornersOf(face);
  const std::size_t axis = AxisOf(NormalOf(surface.at(v[0]), surface.at(v[1]), surface.at(v[2])));
  const int turn =
      Orientation(ShadowOf(surface.at(key[0]), axis), ShadowOf(surface.at(key[1]), axis),
                  ShadowOf(surface.at(key[2]), axis));
  // Without area it goes round as its nodes do, so that its orientation does not matter.
  return {axis, IsEven(face.v) == (turn >= 0)};
}

bool IsOver(const Surface& surface, const Simplex& face, const Point3& p) {
  const FaceView view = ViewOf(surface, face);
  const Point shadow = ShadowOf(p, view.axis);
  for (std::size_t k = 0; k < 3; ++k) {
    const int side = Orientation(ShadowOf(surface.at(face.v[k]), view.axis),
                                 ShadowOf(surface.at(face.v[(k + 1) % 3]), view.axis), shadow);
    if ((view.is_counter_clockwise ? side : -side) <= 0) return false;
  }
  return true;
}

Point3 FootOn(const Surface& surface, NodePair edge, const Point3& p) {
  return FootOn(surface.at(edge.first), surface.at(edge.second), p);
}

bool AreCoplanar(const Surface& surface, const Simplex& s, const Simplex& t) {
  const double tolerance = std::max(surface.ToleranceOf(s), surface.ToleranceOf(t));
  for (const auto& [of, on] : {std::pair(&s, &t), std::pair(&t, &s)}) {
    const std::array<Node, 3> v = surface.CornersOf(*on);
    const Point3& a = surface.at(v[0]);
    const Point3 n = NormalOf(a, surface.at(v[1]), surface.at(v[2]));
    const double reach = tolerance * std::sqrt(Dot(n, n));
    if (std::all_of(of->v.begin(), of->v.end(),
                    [&](Node c) { return std::abs(Dot(n, Minus(surface.at(c), a))) < reach; })) {
      return true;
    }
  }
  return false;
}

Contacts FindContacts(const Surface& surface, int since, std::size_t most, Effort& effort) {
  Contacts contacts;
  const Search search(surface, since);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  search.VisitPairs([&](std::uint32_t i, std::uint32_t j) {
    pairs.emplace_back(i, j);
    contacts.is_crowded = pairs.size() > effort.left();
    return !contacts.is_crowded;
  });
  if (contacts.is_crowded) {
    contacts.crowd = surface.at(surface.simplices[pairs.back().first].v[0]);
    pairs.clear();
  }
  effort.Take(pairs.size());
  for (const auto& [i, j] : pairs) {
    search.FindOfPair(i, j, contacts.pairs);
    contacts.is_cut_off = contacts.pairs.size() > most;
    if (contacts.is_cut_off) break;
  }
  // A face's own corner beside its opposite edge.
  for (std::uint32_t i = 0; i < surface.simplices.size(); ++i) {
    const Simplex& s = surface.simplices[i];
    if (s.size < 3 || !search.IsNew(i)) continue;
    const double fold = search.FoldOf(i);
    for (int k = 0; k < 3; ++k) {
      const Node v = s.v[static_cast<std::size_t>((k + 2) % 3)];
      if (search.IsOn(v, s.Edge(k), s, fold)) contacts.thin.push_back({s.Edge(k), v, fold});
    }
  }
  return contacts;
}

}  // namespace dynmesh::cleaning
