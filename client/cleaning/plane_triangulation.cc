#include "client/cleaning/plane_triangulation.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <deque>

namespace dynmesh::cleaning {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

Kernel::Point_2 At(const Point& p) { return {p[0], p[1]}; }

}  // namespace

PlaneTriangulation::Vertex PlaneTriangulation::AddVertex(const Point& at, std::uint32_t rank) {
  points_.push_back(at);
  ranks_.push_back(rank);
  at_.push_back(0);
  return static_cast<Vertex>(points_.size() - 1);
}

int PlaneTriangulation::Orientation(Vertex a, Vertex b, Vertex c) const {
  return CGAL::orientation(At(points_[a]), At(points_[b]), At(points_[c]));
}

void PlaneTriangulation::Put(std::size_t t, Vertex a, Vertex b, Vertex c) {
  if (t == triangles_.size()) triangles_.emplace_back();
  triangles_[t] = {a, b, c};
  of_edge_[Key(a, b)] = of_edge_[Key(b, c)] = of_edge_[Key(c, a)] = t;
  at_[a] = at_[b] = at_[c] = t;
}

std::optional<std::size_t> PlaneTriangulation::Left(Vertex x, Vertex y) const {
  const auto it = of_edge_.find(Key(x, y));
  if (it == of_edge_.end()) return std::nullopt;
  return it->second;
}

std::optional<PlaneTriangulation::Vertex> PlaneTriangulation::Opposite(Vertex x, Vertex y) const {
  const std::optional<std::size_t> t = Left(x, y);
  if (!t) return std::nullopt;
  for (const Vertex v : triangles_[*t]) {
    if (v != x && v != y) return v;
  }
  return std::nullopt;
}

void PlaneTriangulation::AddTriangle(Vertex a, Vertex b, Vertex c) {
  Put(triangles_.size(), a, b, c);
}

void PlaneTriangulation::SplitFace(std::size_t t, Vertex v) {
  const auto [a, b, c] = triangles_[t];
  Put(t, a, b, v);
  Put(triangles_.size(), b, c, v);
  Put(triangles_.size(), c, a, v);
}

void PlaneTriangulation::SplitEdge(Vertex x, Vertex y, Vertex v) {
  for (const auto& [from, to] : {std::pair(x, y), std::pair(y, x)}) {
    const std::optional<std::size_t> t = Left(from, to);
    if (!t) continue;
    const Vertex opposite = *Opposite(from, to);
    Take(from, to);
    Put(*t, from, v, opposite);
    Put(triangles_.size(), v, to, opposite);
  }
  if (fixed_.erase(Undirected(x, y)) != 0) {
    FixEdge(x, v);
    FixEdge(v, y);
  }
}

PlaneTriangulation::Vertex PlaneTriangulation::SplitBorder(Vertex x, Vertex y, Vertex v) {
  // The border may have the triangle on either side.
  const bool forward = Left(x, y).has_value();
  if (!forward && !Left(y, x)) {  // the triangle there has gone
    AddTriangle(x, v, y);
    return v;
  }
  const Vertex from = forward ? x : y, to = forward ? y : x;
  const std::optional<Vertex> opposite = Opposite(from, to);
  if (!opposite || ranks_[*opposite] != ranks_[v]) {
    SplitEdge(x, y, v);
    return v;
  }
  const std::size_t t = *Left(from, to);
  Take(from, to);
  Take(to, *opposite);
  Take(*opposite, from);
  triangles_[t] = {0, 0, 0};
  for (const Vertex w : {from, to, *opposite}) {
    if (at_[w] != t) continue;
    for (std::size_t other = 0; other < triangles_.size(); ++other) {
      if (!IsDead(other) && std::find(triangles_[other].begin(), triangles_[other].end(), w) !=
                                triangles_[other].end()) {
        at_[w] = other;
      }
    }
  }
  return *opposite;
}

bool PlaneTriangulation::PutIntoTriangle(std::size_t t, Vertex v) {
  const auto [a, b, c] = triangles_[t];
  const std::array<std::pair<Vertex, Vertex>, 3> edges = {{{a, b}, {b, c}, {c, a}}};
  int on = 0;
  std::pair<Vertex, Vertex> edge;
  for (const auto& e : edges) {
    if (Orientation(e.first, e.second, v) != 0) continue;
    ++on;
    edge = e;
  }
  if (on > 1) return false;
  if (on == 1 && Left(edge.second, edge.first)) {
    SplitEdge(edge.first, edge.second, v);
  } else {
    SplitFace(t, v);
  }
  return true;
}

bool PlaneTriangulation::Insert(Vertex v) {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (IsDead(t)) continue;
    const auto [a, b, c] = triangles_[t];
    if (Orientation(a, b, v) >= 0 && Orientation(b, c, v) >= 0 && Orientation(c, a, v) >= 0 &&
        Orientation(a, b, c) > 0) {
      return PutIntoTriangle(t, v);
    }
  }
  return false;
}

std::optional<std::size_t> PlaneTriangulation::Walk(Vertex v) const {
  std::size_t t = last_;
  for (std::size_t steps = 0; steps <= triangles_.size(); ++steps) {
    const auto [a, b, c] = triangles_[t];
    bool moved = false;
    for (const auto& [x, y] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
      if (Orientation(x, y, v) >= 0) continue;
      const std::optional<std::size_t> next = Left(y, x);
      if (!next) return std::nullopt;
      t = *next;
      moved = true;
      break;
    }
    if (!moved) return t;
  }
  return std::nullopt;
}

bool PlaneTriangulation::InsertDelaunay(Vertex v) {
  const std::optional<std::size_t> t = Walk(v);
  if (!t || !PutIntoTriangle(*t, v)) return false;
  last_ = at_[v];
  Legalise(LinkOf(v));
  last_ = at_[v];
  return true;
}

// The edges opposite to v in its triangles, in order around it.
std::vector<std::pair<PlaneTriangulation::Vertex, PlaneTriangulation::Vertex>>
PlaneTriangulation::LinkOf(Vertex v) const {
  std::vector<std::pair<Vertex, Vertex>> link;
  const auto opposite_edge = [&](std::size_t t) {
    const Triangle& corners = triangles_[t];
    const std::size_t i =
        static_cast<std::size_t>(std::find(corners.begin(), corners.end(), v) - corners.begin());
    return std::pair(corners[(i + 1) % 3], corners[(i + 2) % 3]);
  };
  const std::size_t first = at_[v];
  if (IsDead(first) ||
      std::find(triangles_[first].begin(), triangles_[first].end(), v) == triangles_[first].end()) {
    return link;
  }
  std::optional<std::size_t> t = first;
  do {
    link.push_back(opposite_edge(*t));
    t = Left(v, link.back().second);
  } while (t && *t != first);
  if (t) return link;
  std::vector<std::pair<Vertex, Vertex>> before;
  Vertex last = link.front().first;
  while ((t = Left(last, v))) {
    before.push_back(opposite_edge(*t));
    last = before.back().first;
  }
  link.insert(link.begin(), before.rbegin(), before.rend());
  return link;
}

bool PlaneTriangulation::IsConvex(Vertex x, Vertex y) const {
  const std::optional<Vertex> c = Opposite(x, y), d = Opposite(y, x);
  if (!c || !d || *c == *d) return false;
  return Orientation(x, y, *c) > 0 && Orientation(y, x, *d) > 0 && Orientation(x, *d, *c) > 0 &&
         Orientation(*d, y, *c) > 0 && !Left(*d, *c) && !Left(*c, *d);
}

void PlaneTriangulation::Flip(Vertex x, Vertex y) {
  const std::size_t t = *Left(x, y), u = *Left(y, x);
  const Vertex c = *Opposite(x, y), d = *Opposite(y, x);
  Take(x, y);
  Take(y, x);
  Put(t, x, d, c);
  Put(u, d, y, c);
}

bool PlaneTriangulation::IsThin(Vertex a, Vertex b, Vertex c) const {
  if (least_height_ == 0) return false;
  std::array<double, 3> squares = {SquaredDistance<2>(points_[a], points_[b]),
                                   SquaredDistance<2>(points_[b], points_[c]),
                                   SquaredDistance<2>(points_[c], points_[a])};
  std::sort(squares.begin(), squares.end());
  const double area = (points_[b][0] - points_[a][0]) * (points_[c][1] - points_[a][1]) -
                      (points_[b][1] - points_[a][1]) * (points_[c][0] - points_[a][0]);
  // The shortest edge is opposite to the least angle, whose sine is area / the product of the
  // others.
  return area * area < least_height_ * least_height_ * squares[2] ||
         area * area < least_sine_ * least_sine_ * squares[1] * squares[2];
}

bool PlaneTriangulation::WantsFlip(Vertex x, Vertex y) const {
  if (IsFixed(x, y) || !IsConvex(x, y)) return false;
  const Vertex c = *Opposite(x, y), d = *Opposite(y, x);
  if (IsThin(x, d, c) || IsThin(d, y, c)) return false;
  const auto side =
      CGAL::side_of_oriented_circle(At(points_[x]), At(points_[y]), At(points_[c]), At(points_[d]));
  if (side != CGAL::ON_ORIENTED_BOUNDARY) return side == CGAL::ON_POSITIVE_SIDE;
  return std::min(ranks_[c], ranks_[d]) < std::min(ranks_[x], ranks_[y]);
}

void PlaneTriangulation::Legalise(std::vector<std::pair<Vertex, Vertex>> edges) {
  while (!edges.empty()) {
    const auto [x, y] = edges.back();
    edges.pop_back();
    if (!Left(x, y) || !WantsFlip(x, y)) continue;
    const Vertex c = *Opposite(x, y), d = *Opposite(y, x);
    Flip(x, y);
    for (const auto& edge : {std::pair(x, d), std::pair(d, y), std::pair(y, c), std::pair(c, x)}) {
      edges.push_back(edge);
    }
  }
}

void PlaneTriangulation::MakeDelaunay() {
  std::vector<std::pair<Vertex, Vertex>> edges;
  for (const Triangle& t : Triangles()) {
    for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t[i], t[(i + 1) % 3]);
  }
  Legalise(std::move(edges));
}

PlaneTriangulation::Way PlaneTriangulation::FindWay(Vertex a, Vertex b) const {
  Way way;
  std::optional<std::pair<Vertex, Vertex>> next;  // right and left of ab
  for (const auto& [p, q] : LinkOf(a)) {
    if (p == b || q == b) {
      way.is_edge = true;
      return way;
    }
  }
  for (const auto& [p, q] : LinkOf(a)) {
    if (Orientation(a, p, q) <= 0) continue;
    const int right = Orientation(a, b, p), left = Orientation(a, b, q);
    if (right < 0 && left > 0) next = {p, q};
    for (const auto& [v, side] : {std::pair(p, right), std::pair(q, left)}) {
      if (side != 0) continue;
      const double ahead = (points_[b][0] - points_[a][0]) * (points_[v][0] - points_[a][0]) +
                           (points_[b][1] - points_[a][1]) * (points_[v][1] - points_[a][1]);
      if (ahead > 0) way.through = v;
    }
  }
  if (way.through) return way;
  way.is_blocked = !next;
  while (next && !way.is_blocked) {
    const auto [p, q] = *next;
    way.edges.push_back(*next);
    const std::optional<Vertex> d = Opposite(q, p);
    if (d && *d == b) return way;
    way.is_blocked = !d || IsFixed(p, q) || Orientation(q, p, *d) <= 0;
    if (way.is_blocked) break;
    const int side = Orientation(a, b, *d);
    if (side == 0) {
      way.through = d;
      return way;
    }
    next = side > 0 ? std::pair(p, *d) : std::pair(*d, q);
  }
  return way;
}

bool PlaneTriangulation::Fix(Vertex a, Vertex b, bool whole) {
  while (a != b) {
    Way way = FindWay(a, b);
    if (way.is_edge) {
      FixEdge(a, b);
      return true;
    }
    if (way.is_blocked) return false;
    const Vertex to = way.through.value_or(b);
    if (to != b) {
      if (whole || SquaredDistance<2>(points_[a], points_[to]) >=
                       SquaredDistance<2>(points_[a], points_[b])) {
        return false;
      }
      if (!way.edges.empty()) {  // as far as that vertex
        if (!Fix(a, to)) return false;
      } else {
        FixEdge(a, to);
      }
      a = to;
      continue;
    }
    if (IsFixed(way.edges.back().first, way.edges.back().second)) return false;
    std::deque<std::pair<Vertex, Vertex>> crossed(way.edges.begin(), way.edges.end());
    // More steps than a strip of so many edges ever takes, unless triangles are folded.
    for (std::size_t left = 16 + 4 * crossed.size() * crossed.size(); !crossed.empty(); --left) {
      if (left == 0) return false;
      const auto [x, y] = crossed.front();
      crossed.pop_front();
      if (!IsConvex(x, y)) {
        crossed.emplace_back(x, y);
        continue;
      }
      const Vertex c = *Opposite(x, y), d = *Opposite(y, x);
      Flip(x, y);
      if (c == a || c == b || d == a || d == b) continue;
      if (Orientation(a, b, c) * Orientation(a, b, d) < 0) crossed.emplace_back(c, d);
    }
    FixEdge(a, b);
    return true;
  }
  return true;
}

std::vector<PlaneTriangulation::Triangle> PlaneTriangulation::Triangles() const {
  std::vector<Triangle> alive;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (!IsDead(t)) alive.push_back(triangles_[t]);
  }
  return alive;
}

}  // namespace dynmesh::cleaning
