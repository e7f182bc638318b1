#include "client/cleaning/collapses.h"

#include <algorithm>
#include <utility>

#include "client/cleaning/hole_triangulation.h"

namespace dynmesh::cleaning {
namespace {

// Larger holes get triangulations from a neighbour only.
constexpr std::size_t kMostCorners = 32;

}  // namespace

std::vector<Node> Collapses::Run() {
  std::vector<Node> dropped;
  DropAll(dropped);
  // Points are left in planes that only smaller angles let go.
  rules_.AllowNarrow();
  DropAll(dropped);
  return dropped;
}

void Collapses::DropAll(std::vector<Node>& dropped) {
  for (Node v = 0; v < mesh_.node_count(); ++v) Offer(v);
  while (!queue_.empty()) {
    const Candidate next = queue_.top();
    // Offered twice, it is looked at once.
    while (!queue_.empty() && queue_.top() == next) queue_.pop();
    const auto change = next.is_fan ? FanOf(next.v, next.u) : RemovalOf(next.v);
    // If its faces have changed since then, it was offered again.
    if (!change || CostOf(*change) != next.cost || !rules_.Try(*change)) continue;
    dropped.push_back(next.v);
    std::set<Node> near;
    for (const PatchFace& face : change->now) near.insert(face.v.begin(), face.v.end());
    FlipEdges(change->now, near);
    for (const Node n : near) Offer(n);
  }
}

void Collapses::Offer(Node v) {
  if (mesh_.IsCorner(v)) return;
  const auto offer = [&](const std::optional<PatchChange>& change, bool is_fan, Node u) {
    if (change && rules_.MayKeep(*change)) queue_.push({CostOf(*change), v, is_fan, u});
  };
  offer(RemovalOf(v), false, v);
  for (const Node u : mesh_.NeighboursOf(v)) offer(FanOf(v, u), true, u);
}

double Collapses::CostOf(const PatchChange& change) const {
  double most = 0;
  for (const PatchFace& face : change.now) {
    most = std::max(most, SquaredCircumradius(mesh_.CornersOf(face.v)));
  }
  return most;
}

std::optional<PatchChange> Collapses::StarOf(Node v) const {
  const FaceIndices& star = mesh_.FacesAt(v);
  if (star.empty()) return std::nullopt;
  PatchChange change;
  change.old.assign(star.begin(), star.end());
  change.pivot = v;
  change.dropped = v;
  const Nodes ends = mesh_.SharpNeighboursOf(v);
  change.ends.assign(ends.begin(), ends.end());
  return change;
}

std::optional<PatchChange> Collapses::FanOf(Node v, Node u) const {
  std::optional<PatchChange> change = StarOf(v);
  if (!change || (!change->ends.empty() && !mesh_.IsSharp(v, u))) return std::nullopt;
  for (const std::uint32_t f : change->old) {
    PatchFace face = mesh_.faces()[f];
    if (face.Has(u)) continue;
    face.Replace(v, u);
    change->moved.push_back(f);
    change->now.push_back(face);
  }
  if (change->moved.size() == change->old.size()) return std::nullopt;  // no longer an edge
  return change;
}

std::optional<PatchChange> Collapses::RemovalOf(Node v) const {
  std::optional<PatchChange> change = StarOf(v);
  if (!change) return std::nullopt;
  for (const Nodes& hole : mesh_.HolesAt(v)) {
    if (!Fill(hole, v, *change)) return std::nullopt;
  }
  return change;
}

bool Collapses::Fill(const Nodes& hole, Node v, PatchChange& change) const {
  const std::size_t n = hole.size();
  if (n < 3 || n > kMostCorners) return false;
  std::vector<Point3> chain;
  for (const Node h : hole) chain.push_back(mesh_.at(h));
  // By side: the face there, one more than its number; 0 for none. The side from i to i + 1.
  std::vector<std::uint32_t> at_side(n, 0);
  std::set<std::uint32_t> left;
  for (std::size_t i = 0; i < n; ++i) {
    const Node a = hole[i], b = hole[(i + 1) % n];
    for (const std::uint32_t f : change.old) {
      const PatchFace& face = mesh_.faces()[f];
      if (!face.Has(a) || !face.Has(b)) continue;
      at_side[i] = f + 1;
      left.insert(f);
    }
  }
  struct Place {
    std::array<std::size_t, 3> corners;
    std::optional<std::uint32_t> face;
  };
  std::vector<Place> places;
  for (const auto& t : TriangulateHole(chain)) {
    Place& place = places.emplace_back(Place{t, std::nullopt});
    for (const auto& [from, to] :
         {std::pair(t[0], t[1]), std::pair(t[1], t[2]), std::pair(t[2], t[0])}) {
      if ((from + 1) % n != to || at_side[from] == 0) continue;
      const std::uint32_t f = at_side[from] - 1;
      if (!place.face || f < *place.face) place.face = f;
    }
    if (place.face) left.erase(*place.face);
  }
  for (Place& place : places) {
    if (!place.face) place.face = left.extract(left.begin()).value();
    PatchFace face = mesh_.faces()[*place.face];
    const auto side = std::find(at_side.begin(), at_side.end(), *place.face + 1) - at_side.begin();
    const auto i = static_cast<std::size_t>(side);
    const bool is_forward = face.IsOriented(hole[i], hole[(i + 1) % n], v);
    const auto& [a, b, c] = place.corners;
    face.Orient(hole[a], hole[is_forward ? b : c], hole[is_forward ? c : b]);
    change.moved.push_back(*place.face);
    change.now.push_back(face);
  }
  return true;
}

void Collapses::FlipEdges(const std::vector<PatchFace>& faces, std::set<Node>& near) {
  std::set<NodePair> edges;
  const auto add = [&](NodePair edge, Node) { edges.insert(edge); };
  for (const PatchFace& face : faces) VisitEdges(face, add);
  // It ends: each flip makes the list of all faces' least angles, in ascending order, larger.
  while (!edges.empty()) {
    const NodePair edge = edges.extract(edges.begin()).value();
    const auto change = FlipOf(edge);
    if (!change || !rules_.Try(*change)) continue;
    for (const PatchFace& face : change->now) {
      VisitEdges(face, add);
      near.insert(face.v.begin(), face.v.end());
    }
  }
}

std::optional<PatchChange> Collapses::FlipOf(NodePair edge) const {
  const auto [a, b] = edge;
  if (mesh_.IsSharp(a, b)) return std::nullopt;
  PatchChange change;
  for (const std::uint32_t f : mesh_.FacesAt(a)) {
    if (mesh_.faces()[f].Has(b)) change.old.push_back(f);
  }
  if (change.old.size() != 2) return std::nullopt;
  change.moved = change.old;
  change.pivot = a;
  const PatchFace &f = mesh_.faces()[change.old[0]], &g = mesh_.faces()[change.old[1]];
  const Node of_f = f.ApexOf(a, b), of_g = g.ApexOf(a, b);
  change.now = {f, g};
  change.now[0].Replace(a, of_g);
  change.now[1].Replace(b, of_f);
  const auto narrowest = [&](const PatchFace& s, const PatchFace& t) {
    return std::max(LargestCotangent(mesh_.CornersOf(s.v)), LargestCotangent(mesh_.CornersOf(t.v)));
  };
  if (!(narrowest(change.now[0], change.now[1]) < narrowest(f, g))) return std::nullopt;
  return change;
}

}  // namespace dynmesh::cleaning
