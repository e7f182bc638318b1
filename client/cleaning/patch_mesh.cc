#include "client/cleaning/patch_mesh.h"

#include <algorithm>
#include <utility>

namespace dynmesh::cleaning {
namespace {

void Insert(Nodes& nodes, Node n) {
  const auto it = std::lower_bound(nodes.begin(), nodes.end(), n);
  if (it == nodes.end() || *it != n) nodes.insert(it, n);
}

}  // namespace

void PatchFace::Orient(Node a, Node b, Node c) {
  v = {a, b, c};
  std::sort(v.begin(), v.end());
  is_flipped = !IsEven({a, b, c});
}

void PatchFace::Replace(Node old, Node n) {
  std::array<Node, 3> w = v;
  if (is_flipped) std::swap(w[1], w[2]);
  *std::find(w.begin(), w.end(), old) = n;
  Orient(w[0], w[1], w[2]);
}

PatchMesh::PatchMesh(std::vector<Point3> points, std::vector<PatchFace> faces,
                     const std::vector<NodePair>& kept, const DeviationLimit& limit)
    : points_(std::move(points)),
      faces_(std::move(faces)),
      faces_at_(points_.size()),
      is_corner_(points_.size(), false) {
  for (std::uint32_t i = 0; i < faces_.size(); ++i) {
    for (const Node v : faces_[i].v) faces_at_[v].push_back(i);
  }
  FindSharp(kept, limit);
}

void PatchMesh::FindSharp(const std::vector<NodePair>& kept, const DeviationLimit& limit) {
  for (const NodePair& edge : kept) {
    sharp_[edge];
    is_corner_[edge.first] = is_corner_[edge.second] = true;
  }
  for (const PatchFace& face : faces_) {
    VisitEdges(face, [&](NodePair edge, Node) {
      absl::InlinedVector<const PatchFace*, 2> both;
      for (const std::uint32_t f : faces_at_[edge.first]) {
        if (faces_[f].Has(edge.second)) both.push_back(&faces_[f]);
      }
      if (both.size() == 2 && both[0]->group == both[1]->group) {
        const Nodes apexes = ApexesOf(edge.first, edge.second);
        if (limit.IsKept(NormalBeside(edge, apexes[0]), Opposite(NormalBeside(edge, apexes[1])))) {
          return;
        }
      }
      sharp_[edge];
    });
  }
  for (Node v = 0; v < points_.size(); ++v) {
    if (is_corner_[v]) continue;
    const Nodes sharp = SharpNeighboursOf(v);
    is_corner_[v] = !IsRegular(v, sharp) ||
                    (sharp.size() == 2 && !limit.IsKept(UnitOf(Minus(at(v), at(sharp[0]))),
                                                        UnitOf(Minus(at(sharp[1]), at(v)))));
  }
}

Nodes PatchMesh::Walk(Node v, Node first, std::uint32_t face) const {
  const FaceIndices& star = faces_at_[v];
  Nodes passed = {first};
  for (;;) {
    const Node edge = faces_[face].ApexOf(v, passed.back());
    passed.push_back(edge);
    if (edge == first || IsSharp(v, edge)) return passed;
    // An edge that is not sharp has two faces.
    face = *std::find_if(star.begin(), star.end(),
                         [&](std::uint32_t f) { return f != face && faces_[f].Has(edge); });
  }
}

bool PatchMesh::IsRegular(Node v, const Nodes& sharp) const {
  const FaceIndices& star = faces_at_[v];
  if (star.empty() || (!sharp.empty() && sharp.size() != 2)) return false;
  if (sharp.empty()) {
    const auto& corners = faces_[star[0]].v;
    return Walk(v, corners[0] == v ? corners[1] : corners[0], star[0]).size() == star.size() + 1;
  }
  std::size_t seen = 0;
  for (const std::uint32_t face : star) {
    if (!faces_[face].Has(sharp[0])) continue;
    const Nodes passed = Walk(v, sharp[0], face);
    if (passed.back() != sharp[1]) return false;
    seen += passed.size() - 1;
  }
  return seen == star.size();
}

std::vector<Nodes> PatchMesh::HolesAt(Node v) const {
  const Nodes sharp = SharpNeighboursOf(v);
  std::vector<Nodes> holes;
  if (!sharp.empty()) {
    for (const std::uint32_t face : faces_at_[v]) {
      if (faces_[face].Has(sharp[0])) holes.push_back(Walk(v, sharp[0], face));
    }
    return holes;
  }
  const Node first = NeighboursOf(v).front();
  const Nodes apexes = ApexesOf(v, first);
  for (const std::uint32_t face : faces_at_[v]) {
    if (!faces_[face].Has(first) || !faces_[face].Has(apexes[0])) continue;
    Nodes passed = Walk(v, first, face);
    passed.pop_back();
    holes.push_back(std::move(passed));
    break;
  }
  return holes;
}

Nodes PatchMesh::NeighboursOf(Node v) const {
  Nodes nodes;
  for (const std::uint32_t f : faces_at_[v]) {
    for (const Node n : faces_[f].v) {
      if (n != v) Insert(nodes, n);
    }
  }
  return nodes;
}

Nodes PatchMesh::SharpNeighboursOf(Node v) const {
  Nodes nodes = NeighboursOf(v);
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), [&](Node n) { return !IsSharp(v, n); }),
              nodes.end());
  return nodes;
}

Nodes PatchMesh::ApexesOf(Node a, Node b) const {
  Nodes nodes;
  for (const std::uint32_t f : faces_at_[a]) {
    if (!faces_[f].Has(b)) continue;
    for (const Node n : faces_[f].v) {
      if (n != a && n != b) Insert(nodes, n);
    }
  }
  return nodes;
}

void PatchMesh::Exchange(std::span<const std::uint32_t> old, std::span<const std::uint32_t> moved,
                         std::span<const PatchFace> now) {
  for (const std::uint32_t f : old) {
    faces_[f].is_alive = false;
    for (const Node n : faces_[f].v) {
      faces_at_[n].erase(std::find(faces_at_[n].begin(), faces_at_[n].end(), f));
    }
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    const std::uint32_t f = moved[i];
    faces_[f] = now[i];
    faces_[f].is_alive = faces_[f].is_changed = true;
    for (const Node n : faces_[f].v) {
      faces_at_[n].insert(std::lower_bound(faces_at_[n].begin(), faces_at_[n].end(), f), f);
    }
  }
}

void PatchMesh::JoinSharp(Node v, Node a, Node b) {
  std::vector<Node> hidden = {v};
  for (const Node end : {a, b}) {
    const auto it = sharp_.find(Ordered(v, end));
    hidden.insert(hidden.end(), it->second.begin(), it->second.end());
    sharp_.erase(it);
  }
  std::sort(hidden.begin(), hidden.end());
  sharp_[Ordered(a, b)] = std::move(hidden);
}

}  // namespace dynmesh::cleaning
