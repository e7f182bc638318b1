#include "client/cleaning/line_graph.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace dynmesh::cleaning {

Node LineGraph::AddNode(const Point& p, FeatureId id) {
  point_ids.push_back(id);
  node_born.push_back(round);
  return nodes.Add(p);
}

void LineGraph::Connect(Node a, Node b, FeatureId owner, const EdgePolygons& polygons) {
  if (a == b) return;
  edges.push_back({std::min(a, b), std::max(a, b), owner, round, polygons});
}

void LineGraph::Settle() {
  std::erase_if(edges, [](const Edge& e) { return e.IsDead(); });
  std::sort(edges.begin(), edges.end(), [](const Edge& e, const Edge& f) {
    return std::tie(e.a, e.b, e.owner, e.polygons) < std::tie(f.a, f.b, f.owner, f.polygons);
  });
  std::vector<Edge> kept;
  kept.reserve(edges.size());
  for (Edge& e : edges) {
    if (kept.empty() || kept.back().a != e.a || kept.back().b != e.b) {
      if (!kept.empty() && kept.back().IsDead()) kept.pop_back();
      kept.push_back(std::move(e));
    } else {
      Lay(e, kept.back());
    }
  }
  if (!kept.empty() && kept.back().IsDead()) kept.pop_back();
  edges = std::move(kept);
}

// Merges two edges with the same ends. The owner of `on`, which is the least, is kept.
void LineGraph::Lay(const Edge& e, Edge& on) {
  const auto report = [&](ChangeKind kind, std::vector<FeatureId> ids) {
    changes.push_back({kind, std::move(ids), nodes.at(e.a), nodes.at(e.b)});
  };
  on.born = std::max(on.born, e.born);
  if (on.owner == kNoFeature) {
    on.owner = e.owner;
  } else if (e.owner != on.owner && e.owner != kNoFeature) {  // or a segment folded onto itself
    report(ChangeKind::kDoubled, {e.owner, on.owner});
  }
  for (const FeatureId polygon : e.polygons) {
    const auto it = std::lower_bound(on.polygons.begin(), on.polygons.end(), polygon);
    if (it == on.polygons.end() || *it != polygon) {
      on.polygons.insert(it, polygon);
      continue;
    }
    on.polygons.erase(it);
    report(ChangeKind::kCancelled, {polygon});
  }
}

std::pair<Node, Node> LineGraph::Ordered(const Edge& e) const {
  return nodes.at(e.b) < nodes.at(e.a) ? std::pair(e.b, e.a) : std::pair(e.a, e.b);
}

bool LineGraph::IsShorter(Node a, Node b, const Edge& than) const {
  const double length2 = SquaredDistance<2>(nodes.at(a), nodes.at(b));
  const double than2 = SquaredDistance<2>(nodes.at(than.a), nodes.at(than.b));
  if (length2 != than2) return length2 < than2;
  return std::minmax(nodes.at(a), nodes.at(b)) < std::minmax(nodes.at(than.a), nodes.at(than.b));
}

}  // namespace dynmesh::cleaning
