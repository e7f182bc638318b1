#include "client/cleaning/surface_polygons.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "client/cleaning/plane_triangulation.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

using Vertex = PlaneTriangulation::Vertex;

// From the least node towards the lesser neighbour; `forward` says whether that is the ring's way.
NodeRing Canonical(NodeRing ring, bool* forward) {
  std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
  *forward = ring.size() < 3 || ring[1] <= ring.back();
  if (!*forward) std::reverse(ring.begin() + 1, ring.end());
  return ring;
}

Point3 AreaOf(const Surface& surface, const NodeRing& ring) {
  Point3 area = {0, 0, 0};  // twice
  const Point3& origin = surface.at(ring.front());
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const Point3 part = NormalOf(origin, surface.at(ring[i]), surface.at(ring[i + 1]));
    for (std::size_t k = 0; k < 3; ++k) area[k] += part[k];
  }
  return area;
}

class Triangulator {
 public:
  Triangulator(const Surface& surface, std::size_t axis) : surface_(surface), axis_(axis) {}

  // False if edges cross, or pass through corners, in the shadow.
  bool Run(const std::vector<NodePair>& edges) {
    std::vector<Node> nodes;
    for (const NodePair& e : edges) nodes.insert(nodes.end(), {e.first, e.second});
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    Surround(nodes);
    absl::flat_hash_map<Node, Vertex> vertex_of;
    for (const Node v : nodes) {
      const Vertex vertex = plane_.AddVertex(ShadowOf(surface_.at(v), axis_), v);
      vertex_of[v] = vertex;
      if (!plane_.InsertDelaunay(vertex)) return false;
    }
    for (const NodePair& e : edges) {
      if (!plane_.Fix(vertex_of.at(e.first), vertex_of.at(e.second), true)) return false;
    }
    plane_.MakeDelaunay();
    KeepInside();
    return true;
  }

  const std::vector<std::array<Node, 3>>& inside() const { return inside_; }

 private:
  void Surround(const std::vector<Node>& nodes) {
    Point lo = ShadowOf(surface_.at(nodes.front()), axis_), hi = lo;
    for (const Node v : nodes) {
      const Point p = ShadowOf(surface_.at(v), axis_);
      for (std::size_t i = 0; i < 2; ++i) {
        lo[i] = std::min(lo[i], p[i]);
        hi[i] = std::max(hi[i], p[i]);
      }
    }
    const double size = 16 * std::max(hi[0] - lo[0], hi[1] - lo[1]);
    constexpr std::uint32_t kLast = ~std::uint32_t{0};
    plane_.AddVertex({lo[0] - size, lo[1] - size}, kLast);
    plane_.AddVertex({hi[0] + 2 * size, lo[1] - size}, kLast);
    plane_.AddVertex({lo[0] - size, hi[1] + 2 * size}, kLast);
    plane_.AddTriangle(0, 1, 2);
  }

  void KeepInside() {
    std::set<std::array<Vertex, 3>> seen;
    struct Step {
      Vertex x, y;
      bool inside;
    };
    // Enters the triangle left of xy.
    std::vector<Step> steps = {{0, 1, false}};
    while (!steps.empty()) {
      const auto [x, y, inside] = steps.back();
      steps.pop_back();
      const std::optional<Vertex> z = plane_.Opposite(x, y);
      if (!z) continue;
      std::array<Vertex, 3> t = {x, y, *z};
      std::rotate(t.begin(), std::min_element(t.begin(), t.end()), t.end());
      if (!seen.insert(t).second) continue;
      if (inside) {
        inside_.push_back({plane_.RankOf(t[0]), plane_.RankOf(t[1]), plane_.RankOf(t[2])});
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const Vertex p = t[k], q = t[(k + 1) % 3];
        steps.push_back({q, p, inside != plane_.IsFixed(p, q)});
      }
    }
  }

  const Surface& surface_;
  const std::size_t axis_;
  PlaneTriangulation plane_;
  std::vector<std::array<Node, 3>> inside_;
};

}  // namespace

PolygonPieces PiecesOf(const Surface& surface, const std::vector<NodeRing>& rings, double flat) {
  PolygonPieces pieces;
  std::vector<NodeRing> canonical;
  bool forward = true, is_first = true;
  NodeRing first;
  for (NodeRing ring : rings) {
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    while (ring.size() > 1 && ring.back() == ring.front()) ring.pop_back();
    if (ring.size() < 3) continue;
    bool way = true;
    canonical.push_back(Canonical(std::move(ring), &way));
    if (std::exchange(is_first, false)) {
      forward = way;
      first = canonical.back();
    }
  }
  if (canonical.empty()) return pieces;
  std::sort(canonical.begin(), canonical.end());
  std::vector<NodePair> all, edges;
  for (const NodeRing& ring : canonical) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      all.push_back(Ordered(ring[i], ring[(i + 1) % ring.size()]));
    }
  }
  std::sort(all.begin(), all.end());
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end] == all[begin]) ++end;
    if ((end - begin) % 2 == 1) edges.push_back(all[begin]);
  }
  if (edges.empty()) return pieces;
  if (canonical.size() == 1 && first.size() == 3) {
    if (!forward) std::swap(first[1], first[2]);
    pieces.triangles.push_back({first[0], first[1], first[2]});
    pieces.is_regular = pieces.is_flat = true;
    return pieces;
  }
  // The plane of the largest ring.
  Point3 normal = {0, 0, 0};
  const NodeRing* largest = &canonical.front();
  for (const NodeRing& ring : canonical) {
    const Point3 area = AreaOf(surface, ring);
    if (!(Dot(area, area) > Dot(normal, normal))) continue;
    normal = area;
    largest = &ring;
  }
  const double length = std::sqrt(Dot(normal, normal));
  pieces.is_flat = length > 0;
  for (const NodePair& e : edges) {
    for (const Node v : {e.first, e.second}) {
      const Point3 d = Minus(surface.at(v), surface.at(largest->front()));
      if (!(std::abs(Dot(normal, d)) <= flat * length)) pieces.is_flat = false;
    }
  }
  const std::size_t axis = AxisOf(normal);
  Triangulator plane(surface, axis);
  if (length > 0 && plane.Run(edges)) {
    pieces.is_regular = all.size() == edges.size();
    pieces.triangles = plane.inside();
    // Counter-clockwise in the shadow; the first ring may not be.
    if ((AreaOf(surface, first)[axis] < 0) == forward) {
      for (auto& t : pieces.triangles) std::swap(t[1], t[2]);
    }
    return pieces;
  }
  for (const NodeRing& ring : canonical) {
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
      std::array<Node, 3> t = {ring[0], ring[i], ring[i + 1]};
      if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
      if (!forward) std::swap(t[1], t[2]);
      pieces.triangles.push_back(t);
    }
  }
  return pieces;
}

}  // namespace dynmesh::cleaning
