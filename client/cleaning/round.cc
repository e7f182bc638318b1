#include "client/cleaning/round.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <tuple>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::cleaning {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Rational = CGAL::Exact_rational;

// sin^2 of 0.001 degrees and a margin, so that accepted angles pass the mesh's check.
constexpr double kAngleBound = 3.046174197557781e-10 * (1 + 1e-6);

int OrientationOf(const Point& a, const Point& b, const Point& c) {
  return CGAL::orientation(Kernel::Point_2(a[0], a[1]), Kernel::Point_2(b[0], b[1]),
                           Kernel::Point_2(c[0], c[1]));
}

// True if the open segments ab and cd cross. Exact.
bool DoCross(const Point& a, const Point& b, const Point& c, const Point& d) {
  for (std::size_t i = 0; i < 2; ++i) {
    if (std::max(a[i], b[i]) < std::min(c[i], d[i])) return false;
    if (std::max(c[i], d[i]) < std::min(a[i], b[i])) return false;
  }
  return OrientationOf(a, b, c) * OrientationOf(a, b, d) < 0 &&
         OrientationOf(c, d, a) * OrientationOf(c, d, b) < 0;
}

// The crossing point, computed exactly, each coordinate rounded to an adjacent double. So it does
// not depend on the order of the arguments and is within both bounding boxes.
Point CrossingOf(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Rational ax(a[0]), ay(a[1]), cx(c[0]), cy(c[1]);
  const Rational ux = Rational(b[0]) - ax, uy = Rational(b[1]) - ay;
  const Rational vx = Rational(d[0]) - cx, vy = Rational(d[1]) - cy;
  const Rational t = ((cx - ax) * vy - (cy - ay) * vx) / (ux * vy - uy * vx);
  return {CGAL::to_double(Rational(ax + t * ux)), CGAL::to_double(Rational(ay + t * uy))};
}

// True if p projects into the open segment lo-hi and is nearer to it than `reach`. In doubles;
// callers pass the ends in lexicographic order, so that the result depends on nothing else.
bool IsBeside(const Point& p, const Point& lo, const Point& hi, double reach) {
  const double dx = hi[0] - lo[0], dy = hi[1] - lo[1];
  const double px = p[0] - lo[0], py = p[1] - lo[1];
  const double length2 = dx * dx + dy * dy;
  const double along = dx * px + dy * py;
  if (along <= 0 || along >= length2) return false;
  const double cross = dx * py - dy * px;
  return cross * cross < reach * reach * length2;
}

Point Projection(const Point& p, const Point& lo, const Point& hi) {
  const double dx = hi[0] - lo[0], dy = hi[1] - lo[1];
  const double t = (dx * (p[0] - lo[0]) + dy * (p[1] - lo[1])) / (dx * dx + dy * dy);
  return {lo[0] + t * dx, lo[1] + t * dy};
}

bool ShareAnEnd(const Edge& e, const Edge& f) {
  return e.a == f.a || e.a == f.b || e.b == f.a || e.b == f.b;
}

}  // namespace

absl::StatusOr<bool> Rounds::Run() {
  ++graph_.round;
  if (std::vector<Split> touching = FindTouching(); !touching.empty()) {
    Found(touching.size(), graph_.nodes.at(touching.front().at));
    Apply(std::move(touching));
    return true;
  }
  const absl::StatusOr<std::vector<Crossing>> crossings = FindCrossings();
  if (!crossings.ok()) return crossings.status();
  if (crossings->empty()) return false;
  crossings_seen_ = graph_.round;
  Found(crossings->size(), crossings->front().at);
  Apply(JoinCrossings(*crossings));
  return true;
}

void Rounds::Found(std::size_t count, const Point& where) {
  found_ = count;
  where_ = where;
}

std::vector<Rounds::Split> Rounds::FindTouching() const {
  std::vector<Split> splits;
  const double reach = graph_.nodes.tolerance() / 2;
  VisitNodesNearEdges(graph_, reach, graph_.round - 1, [&](EdgeIndex index, Node v) {
    const Edge& e = graph_.edges[index];
    if (v == e.a || v == e.b) return;
    const auto [lo, hi] = graph_.Ordered(e);
    const NodeTable& nodes = graph_.nodes;
    if (IsBeside(nodes.at(v), nodes.at(lo), nodes.at(hi), reach)) splits.push_back({index, v});
  });
  FindSmallAngles(splits);
  return splits;
}

// Testing neighbours in angular order suffices.
void Rounds::FindSmallAngles(std::vector<Split>& splits) const {
  struct Spoke {
    Node hub;
    double angle;
    EdgeIndex edge;
  };
  std::vector<Spoke> spokes;
  spokes.reserve(2 * graph_.edges.size());
  const NodeTable& nodes = graph_.nodes;
  const auto far_end = [this](EdgeIndex e, Node hub) {
    return graph_.edges[e].a == hub ? graph_.edges[e].b : graph_.edges[e].a;
  };
  for (EdgeIndex e = 0; e < graph_.edges.size(); ++e) {
    for (const Node hub : {graph_.edges[e].a, graph_.edges[e].b}) {
      const Point &from = nodes.at(hub), &to = nodes.at(far_end(e, hub));
      spokes.push_back({hub, std::atan2(to[1] - from[1], to[0] - from[0]), e});
    }
  }
  std::sort(spokes.begin(), spokes.end(), [](const Spoke& s, const Spoke& t) {
    return std::tie(s.hub, s.angle, s.edge) < std::tie(t.hub, t.angle, t.edge);
  });
  const auto judge = [&](const Spoke& s, const Spoke& t) {
    if (s.edge == t.edge) return;
    const Point& hub = nodes.at(s.hub);
    const Node a = far_end(s.edge, s.hub), b = far_end(t.edge, s.hub);
    const double ux = nodes.at(a)[0] - hub[0], uy = nodes.at(a)[1] - hub[1];
    const double wx = nodes.at(b)[0] - hub[0], wy = nodes.at(b)[1] - hub[1];
    if (ux * wx + uy * wy <= 0) return;
    const double cross = ux * wy - uy * wx;
    if (cross * cross >= kAngleBound * ((ux * ux + uy * uy) * (wx * wx + wy * wy))) return;
    const bool a_is_shorter = graph_.IsShorter(s.hub, a, graph_.edges[t.edge]);
    const EdgeIndex longer = a_is_shorter ? t.edge : s.edge;
    const EdgeIndex shorter = a_is_shorter ? s.edge : t.edge;
    splits.push_back(
        {longer, a_is_shorter ? a : b, ChangeKind::kSmallAngle, graph_.edges[shorter].name()});
  };
  for (std::size_t begin = 0, end = 0; begin < spokes.size(); begin = end) {
    while (end < spokes.size() && spokes[end].hub == spokes[begin].hub) ++end;
    for (std::size_t i = begin; i + 1 < end; ++i) judge(spokes[i], spokes[i + 1]);
    if (end - begin > 2) judge(spokes[end - 1], spokes[begin]);
  }
}

absl::StatusOr<std::vector<Rounds::Crossing>> Rounds::FindCrossings() const {
  std::vector<Crossing> crossings;
  const auto drop_doubles = [&] {
    const auto key = [](const Crossing& c) { return std::pair(c.e, c.f); };
    std::sort(crossings.begin(), crossings.end(),
              [&](const Crossing& c, const Crossing& d) { return key(c) < key(d); });
    crossings.erase(
        std::unique(crossings.begin(), crossings.end(),
                    [&](const Crossing& c, const Crossing& d) { return key(c) == key(d); }),
        crossings.end());
  };
  const auto at = [this](Node v) -> const Point& { return graph_.nodes.at(v); };
  VisitEdgesThatMeet(graph_, crossings_seen_, [&](EdgeIndex e, EdgeIndex f) {
    const Edge &s = graph_.edges[e], &t = graph_.edges[f];
    if (ShareAnEnd(s, t) || !DoCross(at(s.a), at(s.b), at(t.a), at(t.b))) return true;
    crossings.push_back({e, f, {}});
    if (crossings.size() > 2 * max_crossings_) drop_doubles();
    return crossings.size() <= 2 * max_crossings_;
  });
  drop_doubles();
  if (crossings.size() > max_crossings_) {
    return absl::ResourceExhaustedError(text::Concat("segments cross in more than ", max_crossings_,
                                                     " nodes; clean the map in parts"));
  }
  for (Crossing& c : crossings) {
    const Edge &s = graph_.edges[c.e], &t = graph_.edges[c.f];
    c.at = CrossingOf(at(s.a), at(s.b), at(t.a), at(t.b));
  }
  return crossings;
}

std::vector<Rounds::Split> Rounds::JoinCrossings(const std::vector<Crossing>& crossings) {
  // Nodes are made in the order of coordinates.
  std::vector<Crossing> sorted = crossings;
  std::sort(sorted.begin(), sorted.end(), [](const Crossing& c, const Crossing& d) {
    return std::tie(c.at, c.e, c.f) < std::tie(d.at, d.e, d.f);
  });
  std::vector<Split> splits;
  for (const Crossing& c : sorted) {
    const std::optional<Node> near = graph_.nodes.Near(c.at);
    const Node v = near ? *near : graph_.AddNode(c.at, next_id_++);
    for (const EdgeIndex index : {c.e, c.f}) {
      const Edge& e = graph_.edges[index];
      if (v != e.a && v != e.b) splits.push_back({index, v, ChangeKind::kSegmentsCrossed});
    }
    graph_.changes.push_back(
        {ChangeKind::kSegmentsCrossed,
         {graph_.edges[c.e].name(), graph_.edges[c.f].name(), graph_.point_ids[v]},
         c.at,
         graph_.nodes.at(v)});
  }
  return splits;
}

void Rounds::Apply(std::vector<Split> splits) {
  std::sort(splits.begin(), splits.end(), [](const Split& s, const Split& t) {
    return std::tie(s.edge, s.at, s.kind, s.other) < std::tie(t.edge, t.at, t.kind, t.other);
  });
  for (std::size_t begin = 0, end = 0; begin < splits.size(); begin = end) {
    std::vector<Split> of_edge;
    for (; end < splits.size() && splits[end].edge == splits[begin].edge; ++end) {
      if (of_edge.empty() || of_edge.back().at != splits[end].at) of_edge.push_back(splits[end]);
    }
    ApplyToEdge(splits[begin].edge, std::move(of_edge));
  }
  graph_.Settle();
}

void Rounds::ApplyToEdge(EdgeIndex edge, std::vector<Split> splits) {
  const Edge e = graph_.edges[edge];
  const Point &lo = graph_.nodes.at(graph_.Ordered(e).first),
              &hi = graph_.nodes.at(graph_.Ordered(e).second);
  const auto along = [&](const Split& s) {
    const Point& p = graph_.nodes.at(s.at);
    return (hi[0] - lo[0]) * (p[0] - lo[0]) + (hi[1] - lo[1]) * (p[1] - lo[1]);
  };
  std::sort(splits.begin(), splits.end(), [&](const Split& s, const Split& t) {
    return std::pair(along(s), s.at) < std::pair(along(t), t.at);
  });
  if (TryChain(edge, splits)) return;
  // One split suffices for this round: its parts are checked again in the next one.
  for (const Split& split : splits) {
    if (TryChain(edge, {split})) return;
  }
  assert(false);  // impossible by the proof in round.h
}

// Replaces the edge by the chain through all of `splits`, if all parts precede it in the order.
bool Rounds::TryChain(EdgeIndex edge, const std::vector<Split>& splits) {
  const Edge e = graph_.edges[edge];
  std::vector<Node> chain = {graph_.Ordered(e).first};
  for (const Split& s : splits) chain.push_back(s.at);
  chain.push_back(graph_.Ordered(e).second);
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    if (!graph_.IsShorter(chain[i], chain[i + 1], e)) return false;
  }
  for (const Split& s : splits) Report(e, s);
  graph_.Kill(edge);
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    graph_.Connect(chain[i], chain[i + 1], e.owner, e.polygons);
  }
  return true;
}

void Rounds::Report(const Edge& e, const Split& split) {
  if (split.kind == ChangeKind::kSegmentsCrossed) return;  // reported when it was found
  const auto [lo, hi] = graph_.Ordered(e);
  const Point& to = graph_.nodes.at(split.at);
  Change change = {split.kind, {e.name()}, {}, to};
  change.from = Projection(to, graph_.nodes.at(lo), graph_.nodes.at(hi));
  if (split.kind == ChangeKind::kSmallAngle) change.ids.push_back(split.other);
  change.ids.push_back(graph_.point_ids[split.at]);
  graph_.changes.push_back(std::move(change));
}

}  // namespace dynmesh::cleaning
