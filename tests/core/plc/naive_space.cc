#include "tests/core/plc/naive_space.h"

#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <vector>

namespace dynmesh::plc {
namespace {

using Q = CGAL::Exact_rational;
using Kernel = CGAL::Simple_cartesian<Q>;
using P = Kernel::Point_3;
using V = Kernel::Vector_3;
using Pair = std::pair<FeatureId, FeatureId>;

const Q kStep = Q(1) / (1 << 20);

struct Edge {
  FeatureId p_id, q_id;
  P p, q;
  std::set<FeatureId> ids;
  bool is_segment = false;
};

Q Distance2(const P& x, const P& a, const P& b) {
  const V d = b - a, w = x - a;
  Q t = (d * w) / (d * d);
  t = std::max(Q(0), std::min(Q(1), t));
  return (x - (a + t * d)).squared_length();
}

// Of two segments: at ends, or where both lines are nearest to each other.
Q Distance2(const Edge& s, const Edge& t) {
  Q least = std::min({Distance2(s.p, t.p, t.q), Distance2(s.q, t.p, t.q), Distance2(t.p, s.p, s.q),
                      Distance2(t.q, s.p, s.q)});
  const V u = s.q - s.p, v = t.q - t.p, w = t.p - s.p;
  const Q det = (u * u) * (v * v) - (u * v) * (u * v);
  if (det == 0) return least;
  const Q at_s = ((w * u) * (v * v) - (u * v) * (w * v)) / det;
  const Q at_t = ((u * v) * (w * u) - (u * u) * (w * v)) / det;
  if (at_s < 0 || at_s > 1 || at_t < 0 || at_t > 1) return least;
  return std::min(least, ((s.p + at_s * u) - (t.p + at_t * v)).squared_length());
}

// True if the angle between u and v is below the one with that squared cosine.
bool IsBelow(const V& u, const V& v, double squared_cosine) {
  const Q d = u * v;
  return d > 0 && d * d > Q(squared_cosine) * (u * u) * (v * v);
}
constexpr double kLeast = 1 - 3.046174197557781e-10 * (1 - 1e-6);         // 0.001 degrees
constexpr double kLeastAtEdges = 1 - 7.615433561505986e-07 * (1 - 1e-6);  // 0.05 degrees

class Face {
 public:
  Face(FeatureId id, const Rings& rings, const std::map<FeatureId, P>& at) : id_(id) {
    for (const auto& ring : rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const FeatureId p = ring[i], q = ring[(i + 1) % ring.size()];
        edges_.push_back({p, q, at.at(p), at.at(q), {id}});
        corners_[p] = at.at(p);
      }
    }
    const P& o = edges_[0].p;
    for (const Edge& e : edges_) {
      for (const Edge& f : edges_) {
        if (normal_ == V(0, 0, 0)) normal_ = CGAL::cross_product(e.p - o, f.p - o);
      }
    }
    while (axis_ < 2 && normal_[axis_] == 0) ++axis_;
  }
  bool IsFlat() const {
    return normal_ != V(0, 0, 0) &&
           std::all_of(edges_.begin(), edges_.end(), [&](const Edge& e) { return Side(e.p) == 0; });
  }
  bool HasEdgeOfNoLength() const {
    return std::any_of(edges_.begin(), edges_.end(), [](const Edge& e) { return e.p == e.q; });
  }
  FeatureId id() const { return id_; }
  const std::vector<Edge>& edges() const { return edges_; }
  const std::map<FeatureId, P>& corners() const { return corners_; }
  const V& normal() const { return normal_; }
  Q Side(const P& x) const { return normal_ * (x - edges_[0].p); }
  P Foot(const P& x) const { return x - Side(x) / (normal_ * normal_) * normal_; }
  bool HasEdge(FeatureId p, FeatureId q) const {
    return std::any_of(edges_.begin(), edges_.end(), [&](const Edge& e) {
      return std::minmax(e.p_id, e.q_id) == std::minmax(p, q);
    });
  }
  bool IsOnBoundary(const P& x) const {
    return std::any_of(edges_.begin(), edges_.end(),
                       [&](const Edge& e) { return Distance2(x, e.p, e.q) == 0; });
  }
  // True if `x`, a point of the plane, is in the open inside. By crossings of a ray.
  bool Holds(const P& x) const {
    if (IsOnBoundary(x)) return false;
    const int i = (axis_ + 1) % 3, j = (axis_ + 2) % 3;
    bool inside = false;
    for (const Edge& e : edges_) {
      if ((e.p[j] > x[j]) == (e.q[j] > x[j])) continue;
      const Q at = e.p[i] + (x[j] - e.p[j]) * (e.q[i] - e.p[i]) / (e.q[j] - e.p[j]);
      if (at > x[i]) inside = !inside;
    }
    return inside;
  }
  // True if d, from the corner, rises over the inside at less than 0.001 degrees.
  bool IsSharpOver(const P& corner, const V& d) const {
    const V flat = d - (d * normal_) / (normal_ * normal_) * normal_;
    return Holds(corner + kStep * flat) && IsBelow(d, flat, kLeast);
  }
  // From the middle of an edge into the inside.
  V Inward(const Edge& e) const {
    const V across = CGAL::cross_product(normal_, e.q - e.p);
    return Holds(CGAL::midpoint(e.p, e.q) + kStep * across) ? across : -across;
  }

 private:
  FeatureId id_;
  std::vector<Edge> edges_;
  std::map<FeatureId, P> corners_;
  V normal_{0, 0, 0};
  int axis_ = 0;
};

// Where the segment from a to b meets the edges' lines and planes, as parameters, 0 and 1 too.
std::vector<Q> Cuts(const P& a, const P& b, const Face& f) {
  std::vector<Q> cuts = {0, 1};
  const V d = b - a;
  for (const Edge& e : f.edges()) {
    // The plane through the edge across the face.
    const V n = CGAL::cross_product(f.normal(), e.q - e.p);
    if (n * d != 0) cuts.push_back((n * (e.p - a)) / (n * d));
  }
  std::sort(cuts.begin(), cuts.end());
  return cuts;
}

// True if the open segment has a point in the inside, or on the boundary except common corners.
bool Meets(const Edge& s, const Face& f) {
  const Q at_p = f.Side(s.p), at_q = f.Side(s.q);
  if (at_p == 0 && at_q == 0) {
    const std::vector<Q> cuts = Cuts(s.p, s.q, f);
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
      const Q t = (cuts[i] + cuts[i + 1]) / 2;
      if (t > 0 && t < 1 && f.Holds(s.p + t * (s.q - s.p))) return true;
    }
    return false;
  }
  if ((at_p > 0 && at_q > 0) || (at_p < 0 && at_q < 0)) return false;
  return f.Holds(s.p + at_p / (at_p - at_q) * (s.q - s.p));
}

// True if the insides of two faces have a common point.
bool Overlap(const Face& f, const Face& g) {
  const V line = CGAL::cross_product(f.normal(), g.normal());
  if (line == V(0, 0, 0)) {
    if (g.Side(f.edges()[0].p) != 0) return false;
    const auto one_way = [](const Face& a, const Face& b) {
      return std::any_of(a.edges().begin(), a.edges().end(), [&](const Edge& e) {
        const std::vector<Q> cuts = Cuts(e.p, e.q, b);
        for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
          const Q t = (cuts[i] + cuts[i + 1]) / 2;
          const P x = e.p + t * (e.q - e.p);
          if (t <= 0 || t >= 1) continue;
          const V in = kStep * a.Inward(e);
          if (b.Holds(x + in) && a.Holds(x + in)) return true;
        }
        return false;
      });
    };
    return one_way(f, g) || one_way(g, f);
  }
  // Along the line where the planes meet.
  const V a = CGAL::cross_product(f.normal(), line);
  const P& o = f.edges()[0].p;
  const P x = o - g.Side(o) / (g.normal() * a) * a;
  std::vector<Q> cuts = Cuts(x, x + line, f), more = Cuts(x, x + line, g);
  cuts.insert(cuts.end(), more.begin(), more.end());
  std::sort(cuts.begin(), cuts.end());
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const P middle = x + (cuts[i] + cuts[i + 1]) / 2 * line;
    if (f.Holds(middle) && g.Holds(middle)) return true;
  }
  return false;
}

bool IsSharp(const Face& f, const Face& g) {
  std::set<FeatureId> joined;
  for (const Edge& e : f.edges()) {
    if (!g.HasEdge(e.p_id, e.q_id)) continue;
    joined.insert({e.p_id, e.q_id});
    for (const Edge& h : g.edges()) {
      if (std::minmax(e.p_id, e.q_id) != std::minmax(h.p_id, h.q_id)) continue;
      if (IsBelow(f.Inward(e), g.Inward(h), kLeastAtEdges)) return true;
    }
  }
  const auto rises = [&](const Face& a, const Face& b) {
    return std::any_of(b.edges().begin(), b.edges().end(), [&](const Edge& e) {
      const auto at = [&](FeatureId id, const V& d) {
        return a.corners().contains(id) && !joined.contains(id) &&
               a.IsSharpOver(a.corners().at(id), d);
      };
      return at(e.p_id, e.q - e.p) || at(e.q_id, e.p - e.q);
    });
  };
  return rises(f, g) || rises(g, f);
}

}  // namespace

std::vector<Offence> FindOffences(const FeatureMap& features, double limit) {
  std::vector<Offence> found;
  const Q limit2 = Q(limit) * Q(limit);
  std::map<FeatureId, P> at;
  std::vector<Face> faces;
  std::vector<Edge> edges;
  std::map<Pair, Edge> by_ends;
  for (const auto& [id, f] : features) {
    if (f.kind == FeatureKind::kPoint) at[id] = P(f.position[0], f.position[1], f.position[2]);
  }
  for (const auto& [id, f] : features) {
    if (f.kind == FeatureKind::kSegment) {
      edges.push_back({f.ends[0], f.ends[1], at[f.ends[0]], at[f.ends[1]], {id}, true});
    } else if (f.kind == FeatureKind::kPolygon) {
      faces.emplace_back(id, f.rings, at);
      for (const Edge& e : faces.back().edges()) {
        by_ends.try_emplace(std::minmax(e.p_id, e.q_id), e).first->second.ids.insert(id);
      }
    }
  }
  for (Edge& s : edges) {
    const auto it = by_ends.find(std::minmax(s.p_id, s.q_id));
    if (it == by_ends.end()) continue;
    s.ids.insert(it->second.ids.begin(), it->second.ids.end());
    by_ends.erase(it);
  }
  for (const auto& [ends, e] : by_ends) edges.push_back(e);

  for (auto p = at.begin(); p != at.end(); ++p) {
    for (auto q = at.begin(); q != p; ++q) {
      if ((p->second - q->second).squared_length() < limit2) {
        found.push_back({"points", {p->first}, {q->first}});
      }
    }
    for (const Edge& s : edges) {
      if (p->first == s.p_id || p->first == s.q_id || s.p == s.q) continue;
      if (Distance2(p->second, s.p, s.q) < limit2) {
        found.push_back({"point and segment", {p->first}, s.ids});
      }
    }
  }
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Edge &s = edges[i], &t = edges[j];
      if (s.p == s.q || t.p == t.q) continue;
      std::optional<std::string> what;
      const bool shares_p = s.p_id == t.p_id || s.p_id == t.q_id;
      const bool shares_q = s.q_id == t.p_id || s.q_id == t.q_id;
      if (shares_p && shares_q) {
        what = "same segment";
      } else if (shares_p || shares_q) {
        const P& apex = shares_p ? s.p : s.q;
        const FeatureId id = shares_p ? s.p_id : s.q_id;
        if (IsBelow((shares_p ? s.q : s.p) - apex, (t.p_id == id ? t.q : t.p) - apex, kLeast)) {
          what = "angle of segments";
        }
      } else if (Distance2(s, t) < limit2) {
        what = "segments";
      }
      if (what) found.push_back({*what, s.ids, t.ids});
    }
  }
  // Invalid facets are reported, here or above, and not compared.
  std::erase_if(faces, [&](const Face& f) {
    if (f.HasEdgeOfNoLength()) return true;
    if (f.IsFlat()) return false;
    found.push_back({"not flat", {f.id()}, {}});
    return true;
  });
  for (const Face& f : faces) {
    for (const auto& [id, p] : at) {
      if (f.corners().contains(id) || !f.Holds(f.Foot(p))) continue;
      if ((p - f.Foot(p)).squared_length() < limit2) {
        found.push_back({"point and polygon", {id}, {f.id()}});
      }
    }
    for (const Edge& s : edges) {
      if (f.HasEdge(s.p_id, s.q_id)) continue;
      if (Meets(s, f)) found.push_back({"segment and polygon", s.ids, {f.id()}});
      const auto sharp = [&](FeatureId id, const P& p, const V& d) {
        return f.corners().contains(id) && f.IsSharpOver(p, d);
      };
      if (s.is_segment && (sharp(s.p_id, s.p, s.q - s.p) || sharp(s.q_id, s.q, s.p - s.q))) {
        found.push_back({"angle of segment and polygon", s.ids, {f.id()}});
      }
    }
    for (const Face& g : faces) {
      if (&g == &f) break;
      if (Overlap(f, g)) found.push_back({"polygons", {f.id()}, {g.id()}});
      if (IsSharp(f, g)) found.push_back({"angle of polygons", {f.id()}, {g.id()}});
    }
  }
  return found;
}

}  // namespace dynmesh::plc
