#include "client/cleaning/line_graph.h"

#include <algorithm>
#include <tuple>

namespace dynmesh::cleaning {

Place LineGraph::AddPlace(const Point& p, FeatureId id) {
  point_ids.push_back(id);
  place_born.push_back(round);
  return places.Add(p);
}

void LineGraph::Connect(Place a, Place b, FeatureId owner) {
  if (a == b) return;
  edges.push_back({std::min(a, b), std::max(a, b), owner, round});
}

void LineGraph::Settle() {
  std::vector<Edge> kept;
  kept.reserve(edges.size());
  for (const Edge& e : edges) {
    if (e.owner != kNoFeature) kept.push_back(e);
  }
  std::sort(kept.begin(), kept.end(), [](const Edge& e, const Edge& f) {
    return std::tie(e.a, e.b, e.owner) < std::tie(f.a, f.b, f.owner);
  });
  edges.clear();
  for (const Edge& e : kept) {
    if (edges.empty() || edges.back().a != e.a || edges.back().b != e.b) {
      edges.push_back(e);
      continue;
    }
    edges.back().born = std::max(edges.back().born, e.born);
    if (edges.back().owner == e.owner) continue;  // it met itself again
    changes.push_back(
        {ChangeKind::kDoubled, {e.owner, edges.back().owner}, places.at(e.a), places.at(e.b)});
  }
}

std::pair<Place, Place> LineGraph::Ordered(const Edge& e) const {
  return places.at(e.b) < places.at(e.a) ? std::pair(e.b, e.a) : std::pair(e.a, e.b);
}

bool LineGraph::IsShorter(Place a, Place b, const Edge& than) const {
  const double length2 = SquaredDistance(places.at(a), places.at(b));
  const double than2 = SquaredDistance(places.at(than.a), places.at(than.b));
  if (length2 != than2) return length2 < than2;
  return std::minmax(places.at(a), places.at(b)) <
         std::minmax(places.at(than.a), places.at(than.b));
}

}  // namespace dynmesh::cleaning
