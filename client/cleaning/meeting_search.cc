#include "client/cleaning/meeting_search.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace dynmesh::cleaning {
namespace {

// A square, given by its centre.
struct Cell {
  double x = 0;
  double y = 0;
  double half = 0;

  Cell Quarter(int q) const {
    const double h = half / 2;
    return {x + ((q & 1) != 0 ? h : -h), y + ((q & 2) != 0 ? h : -h), h};
  }
};

// Conservative test by separating axes in doubles whether segment pq is nearer than `reach` to the
// cell: may return true needlessly. The callers' reach includes a margin for rounding.
bool Meets(const Point& p, const Point& q, const Cell& cell, double reach) {
  const double half = cell.half + reach;
  const double cx = cell.x - p[0], cy = cell.y - p[1];
  const double dx = q[0] - p[0], dy = q[1] - p[1];
  if (cx + half < std::min(0.0, dx) || cx - half > std::max(0.0, dx)) return false;
  if (cy + half < std::min(0.0, dy) || cy - half > std::max(0.0, dy)) return false;
  return std::abs(dx * cy - dy * cx) <= (std::abs(dx) + std::abs(dy)) * half;
}

class Walk {
 public:
  // For edges, cells overlap by `reach`.
  Walk(const LineGraph& graph, double reach, int since)
      : graph_(graph), reach_(reach), since_(since) {}

  void Nodes(absl::FunctionRef<void(EdgeIndex, Node)> visit) {
    std::vector<Node> nodes(graph_.nodes.size());
    std::iota(nodes.begin(), nodes.end(), Node{0});
    WalkNodes(Root(), nodes, AllEdges(), visit);
  }

  void Edges(absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit) {
    WalkEdges(Root(), AllEdges(), 0, visit);
  }

 private:
  using EdgeList = std::vector<EdgeIndex>;
  using NodeList = std::vector<Node>;

  Cell Root() const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    Point lo = {kInfinity, kInfinity}, hi = {-kInfinity, -kInfinity};
    for (Node v = 0; v < graph_.nodes.size(); ++v) {
      for (std::size_t i = 0; i < 2; ++i) {
        lo[i] = std::min(lo[i], graph_.nodes.at(v)[i]);
        hi[i] = std::max(hi[i], graph_.nodes.at(v)[i]);
      }
    }
    if (lo[0] > hi[0]) return {};
    return {lo[0] + (hi[0] - lo[0]) / 2, lo[1] + (hi[1] - lo[1]) / 2,
            std::max(hi[0] - lo[0], hi[1] - lo[1])};  // twice as large as necessary
  }

  EdgeList AllEdges() const {
    EdgeList all(graph_.edges.size());
    for (EdgeIndex e = 0; e < all.size(); ++e) all[e] = e;
    return all;
  }

  EdgeList EdgesIn(const Cell& cell, const EdgeList& edges) const {
    EdgeList in;
    for (const EdgeIndex e : edges) {
      const Edge& edge = graph_.edges[e];
      if (Meets(graph_.nodes.at(edge.a), graph_.nodes.at(edge.b), cell, reach_)) in.push_back(e);
    }
    return in;
  }

  bool IsFresh(EdgeIndex e) const { return graph_.edges[e].born >= since_; }
  bool IsFreshNode(Node v) const { return graph_.node_born[v] >= since_; }
  bool AnyFresh(const EdgeList& edges) const {
    return std::any_of(edges.begin(), edges.end(), [this](EdgeIndex e) { return IsFresh(e); });
  }
  // Nodes are at least a tolerance apart, so such a cell has few.
  bool IsSmall(const Cell& cell) const { return cell.half <= 2 * graph_.nodes.tolerance(); }

  void WalkNodes(const Cell& cell, const NodeList& nodes, const EdgeList& edges,
                 absl::FunctionRef<void(EdgeIndex, Node)> visit) {
    constexpr std::size_t kFewPairs = 64;
    if (nodes.empty() || edges.empty()) return;
    const bool any_fresh_node =
        std::any_of(nodes.begin(), nodes.end(), [this](Node v) { return IsFreshNode(v); });
    if (!any_fresh_node && !AnyFresh(edges)) return;
    if (nodes.size() == 1 || nodes.size() * edges.size() <= kFewPairs || IsSmall(cell)) {
      for (const EdgeIndex e : edges) {
        for (const Node v : nodes) {
          if (IsFresh(e) || IsFreshNode(v)) visit(e, v);
        }
      }
      return;
    }
    std::array<NodeList, 4> quarters;
    for (const Node v : nodes) {
      const Point& p = graph_.nodes.at(v);
      quarters[(p[0] >= cell.x ? 1U : 0U) + (p[1] >= cell.y ? 2U : 0U)].push_back(v);
    }
    for (int q = 0; q < 4; ++q) {
      const NodeList& in = quarters[static_cast<std::size_t>(q)];
      if (in.empty()) continue;
      const Cell quarter = cell.Quarter(q);
      WalkNodes(quarter, in, EdgesIn(quarter, edges), visit);
    }
  }

  // True if all edges share an end: then they intersect nowhere else.
  bool AreAStar(const EdgeList& edges) const {
    const Edge& first = graph_.edges[edges[0]];
    for (const Node hub : {first.a, first.b}) {
      if (std::all_of(edges.begin(), edges.end(), [&](EdgeIndex e) {
            return graph_.edges[e].a == hub || graph_.edges[e].b == hub;
          })) {
        return true;
      }
    }
    return false;
  }

  bool VisitPairs(const EdgeList& edges, absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit) {
    for (std::size_t i = 0; i < edges.size(); ++i) {
      for (std::size_t k = i + 1; k < edges.size(); ++k) {
        if (!IsFresh(edges[i]) && !IsFresh(edges[k])) continue;
        if (!visit(edges[i], edges[k])) return false;
      }
    }
    return true;
  }

  // Segments that cross the whole cell are in about two of its quarters each: four times the pairs
  // of half as many edges, without a gain. `futile` counts such consecutive levels.
  bool WalkEdges(const Cell& cell, const EdgeList& edges, int futile,
                 absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit) {
    constexpr std::size_t kFewEdges = 12;
    constexpr int kMaxFutile = 3;
    if (edges.size() < 2 || !AnyFresh(edges) || AreAStar(edges)) return true;
    if (edges.size() <= kFewEdges || futile == kMaxFutile || IsSmall(cell)) {
      return VisitPairs(edges, visit);
    }
    std::array<EdgeList, 4> quarters;
    double pairs = 0;
    std::size_t most = 0;
    for (int q = 0; q < 4; ++q) {
      EdgeList& in = quarters[static_cast<std::size_t>(q)];
      in = EdgesIn(cell.Quarter(q), edges);
      pairs += static_cast<double>(in.size()) * static_cast<double>(in.size());
      most = std::max(most, in.size());
    }
    const double size = static_cast<double>(edges.size());
    // Nearly all are in one quarter: there may be a dense spot deeper.
    const bool zooms = static_cast<double>(most) > 0.9 * size;
    if (!zooms) futile = pairs > 0.75 * size * size ? futile + 1 : 0;
    for (int q = 0; q < 4; ++q) {
      if (!WalkEdges(cell.Quarter(q), quarters[static_cast<std::size_t>(q)], futile, visit)) {
        return false;
      }
    }
    return true;
  }

  const LineGraph& graph_;
  const double reach_;
  const int since_;
};

}  // namespace

void VisitNodesNearEdges(const LineGraph& graph, double reach, int since,
                         absl::FunctionRef<void(EdgeIndex, Node)> visit) {
  // The tolerance is at least 2^11 ulps of the coordinates, so an eighth of it covers all rounding.
  Walk(graph, reach + graph.nodes.tolerance() / 8, since).Nodes(visit);
}

void VisitEdgesThatMeet(const LineGraph& graph, int since,
                        absl::FunctionRef<bool(EdgeIndex, EdgeIndex)> visit) {
  Walk(graph, graph.nodes.tolerance() / 8, since).Edges(visit);
}

}  // namespace dynmesh::cleaning
