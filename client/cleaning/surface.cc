#include "client/cleaning/surface.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

namespace dynmesh::cleaning {

std::array<Node, 3> Simplex::Key() const {
  std::array<Node, 3> key = v;
  if (size > 1 && key[1] < key[0]) std::swap(key[0], key[1]);
  if (size > 2 && key[2] < key[1]) std::swap(key[1], key[2]);
  if (size > 2 && key[1] < key[0]) std::swap(key[0], key[1]);
  return key;
}

bool Simplex::Has(Node n) const {
  return std::find(v.begin(), v.begin() + size, n) != v.begin() + size;
}

Node Surface::AddNode(const Point3& p, FeatureId id) {
  point_ids.push_back(id);
  return nodes.Add(p);
}

Node Surface::NodeAt(const Point3& p) {
  const std::optional<Node> near = Near(p);
  return near ? *near : AddNode(p, next_id++);
}

void Surface::Join(const std::vector<NodePair>& pairs) {
  const auto find = [&](Node v) {
    for (auto it = joined.find(v); it != joined.end(); it = joined.find(v)) v = it->second;
    return v;
  };
  std::vector<Node> gone;
  for (const auto& [a, b] : pairs) {
    Node stays = find(a), goes = find(b);
    if (stays == goes) continue;
    if (at(goes) < at(stays)) std::swap(stays, goes);
    joined[goes] = stays;
    gone.push_back(goes);
  }
  for (auto& [from, to] : joined) to = find(to);
  for (const Node v : gone) {
    const Node to = joined.at(v);
    changes.push_back(
        {SurfaceChangeKind::kPointMerged, {point_ids[v], point_ids[to]}, at(v), at(to)});
  }
  const std::vector<Simplex> before = std::exchange(simplices, {});
  for (const Simplex& s : before) {
    std::array<Node, 3> v = s.v;
    for (Node& corner : v) corner = find(corner);
    if (v == s.v) {
      simplices.push_back(s);
    } else {
      Add(std::span(v).first(static_cast<std::size_t>(s.size)), s.sources);
    }
  }
}

double Surface::ToleranceOf(const Simplex& s) const {
  double most = field.least();
  for (int k = 0; k < s.size; ++k) {
    most = std::max(most, field.At(at(s.v[static_cast<std::size_t>(k)])));
  }
  return most;
}

void Surface::Add(std::span<const Node> corners, const Sources& sources) {
  Simplex s;
  for (const Node v : corners) {
    if (s.Has(v)) return;
    s.v[static_cast<std::size_t>(s.size++)] = v;
  }
  s.born = round;
  s.sources = sources;
  simplices.push_back(std::move(s));
}

void Surface::Settle() {
  std::erase_if(simplices, [](const Simplex& s) { return s.sources.empty(); });
  struct Entry {
    std::array<Node, 3> key;
    std::uint32_t index;
  };
  std::vector<Entry> order;
  order.reserve(simplices.size());
  for (std::uint32_t i = 0; i < simplices.size(); ++i) order.push_back({simplices[i].Key(), i});
  std::sort(order.begin(), order.end(), [this](const Entry& a, const Entry& b) {
    const Simplex &s = simplices[a.index], &t = simplices[b.index];
    return std::tie(s.size, a.key, s.sources, s.v) < std::tie(t.size, b.key, t.sources, t.v);
  });
  std::vector<Simplex> kept;
  kept.reserve(simplices.size());
  for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
    Simplex s = std::move(simplices[order[begin].index]);
    const FeatureId first = s.sources.front();
    for (end = begin + 1; end < order.size() && order[end].key == order[begin].key &&
                          simplices[order[end].index].size == s.size;
         ++end) {
      const Simplex& t = simplices[order[end].index];
      s.born = std::max(s.born, t.born);
      Sources both;
      std::set_symmetric_difference(s.sources.begin(), s.sources.end(), t.sources.begin(),
                                    t.sources.end(), std::back_inserter(both));
      if (t.sources.front() != first && s.size > 1) {
        const auto kind =
            s.size == 3 ? SurfaceChangeKind::kFaceDoubled : SurfaceChangeKind::kSegmentDoubled;
        changes.push_back({kind, {t.sources.front(), first}, at(s.v[0]), at(s.v[1])});
      }
      s.sources = std::move(both);
    }
    if (!s.sources.empty()) kept.push_back(std::move(s));
  }
  simplices = std::move(kept);
}

Surface::EdgeMap Surface::EdgesOf() const {
  EdgeMap edges;
  edges.reserve(simplices.size() * 2);
  for (std::uint32_t i = 0; i < simplices.size(); ++i) {
    for (int k = 0; k < simplices[i].edge_count(); ++k) edges[simplices[i].Edge(k)].push_back(i);
  }
  return edges;
}

bool Surface::IsShorter(NodePair a, NodePair b) const {
  const double a2 = SquaredDistance<3>(at(a.first), at(a.second));
  const double b2 = SquaredDistance<3>(at(b.first), at(b.second));
  if (a2 != b2) return a2 < b2;
  return std::minmax(at(a.first), at(a.second)) < std::minmax(at(b.first), at(b.second));
}

std::array<Node, 3> Surface::CornersOf(const Simplex& face) const {
  int longest = 0;
  for (const int k : {1, 2}) {
    if (IsShorter(face.Edge(longest), face.Edge(k))) longest = k;
  }
  const auto [a, b] = face.Edge(longest);
  const Node apex = face.v[static_cast<std::size_t>((longest + 2) % 3)];
  return at(a) < at(b) ? std::array{apex, a, b} : std::array{apex, b, a};
}

}  // namespace dynmesh::cleaning
