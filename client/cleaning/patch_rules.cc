#include "client/cleaning/patch_rules.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "client/cleaning/hole_triangulation.h"
#include "client/cleaning/vectors3.h"

namespace dynmesh::cleaning {
namespace {

// Angles of faces that are larger may become as small as 20 degrees, in a plane at last as small as
// 10; those between faces at a sharp edge 20. Angles of faces may become as large as 125 degrees,
// at last in a plane any. Their cotangents. (Six equal triangles around a point become four with
// one angle of 120 degrees at least.)
constexpr double kCotangent = 2.7474774194546225;
constexpr double kPlaneCotangent = 5.671281819617709;
constexpr double kLargeCotangent = -0.7002075382097097;
// What is taken for a plane, in degrees.
constexpr double kPlaneAngle = 0.01;

// Of the least angle between faces with these normals as seen along their edge, 0 for none below a
// right angle. Of two faces that make a plane the normals are opposite.
double LargestCotangentOf(const std::vector<Point3>& normals) {
  double most = 0;
  for (std::size_t i = 0; i < normals.size(); ++i) {
    for (std::size_t j = i + 1; j < normals.size(); ++j) {
      const Point3 cross = Cross(normals[i], normals[j]);
      most = std::max(most, Dot(normals[i], normals[j]) / std::sqrt(Dot(cross, cross)));
    }
  }
  return most;
}

void SortUnique(std::vector<std::uint32_t>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

void Insert(std::vector<std::uint32_t>& list, std::uint32_t x) {
  const auto it = std::lower_bound(list.begin(), list.end(), x);
  if (it == list.end() || *it != x) list.insert(it, x);
}

void Erase(std::vector<std::uint32_t>& list, std::uint32_t x) {
  const auto it = std::lower_bound(list.begin(), list.end(), x);
  if (it != list.end() && *it == x) list.erase(it);
}

ContactElement ElementOf(const PatchFace& face) { return {face.v, 3}; }

}  // namespace

bool PatchChange::HasOld(std::uint32_t f) const {
  return std::binary_search(old.begin(), old.end(), f);
}

PatchRules::PatchRules(PatchMesh& mesh, std::span<const ContactElement> obstacles,
                       const PatchLimits& limits)
    : mesh_(mesh),
      limits_(limits),
      angle_(limits.angle),
      half_angle_(limits.angle / 2),
      plane_angle_(kPlaneAngle),
      contacts_(mesh.points(), limits.tolerance) {
  const std::uint32_t n = static_cast<std::uint32_t>(mesh.faces().size());
  for (std::uint32_t f = 0; f < n; ++f) {
    originals_.push_back(mesh.CornersOf(mesh.faces()[f].v));
    stands_for_.push_back({f});
    carriers_.push_back({f});
    contacts_.Insert(f, ElementOf(mesh.faces()[f]));
  }
  for (std::uint32_t i = 0; i < obstacles.size(); ++i) contacts_.Insert(n + i, obstacles[i]);
}

bool PatchRules::MayKeep(const PatchChange& change) const {
  return IsNear(change) && KeepsShape(change);
}

bool PatchRules::Try(const PatchChange& change) {
  if (!MayKeep(change) || !KeepsEdges(change) || !KeepsChain(change)) return false;
  Uses uses;
  if (HasContacts(change) || !KeepsDistance(change, uses)) return false;
  Apply(change, std::move(uses));
  return true;
}

bool PatchRules::IsNear(const PatchChange& change) const {
  if (!change.dropped) return true;
  const Point3& p = mesh_.at(*change.dropped);
  return std::any_of(change.now.begin(), change.now.end(), [&](const PatchFace& face) {
    return SquaredDistance<3>(NearestOn(mesh_.CornersOf(face.v), p), p) <=
           limits_.within * limits_.within;
  });
}

bool PatchRules::KeepsShape(const PatchChange& change) const {
  double narrowest = kCotangent, widest = kLargeCotangent;
  absl::flat_hash_map<NodePair, Node> apexes;
  for (const std::uint32_t f : change.old) {
    const PatchFace& face = mesh_.faces()[f];
    const TriangleCorners corners = mesh_.CornersOf(face.v);
    narrowest = std::max(narrowest, LargestCotangent(corners));
    widest = std::min(widest, LeastCotangent(corners));
    VisitEdges(face, [&](NodePair edge, Node apex) {
      if (!change.dropped || (edge.first != *change.dropped && edge.second != *change.dropped)) {
        apexes[edge] = apex;
      }
    });
  }
  bool is_plane = true, has_shape = true;
  double now = 0;
  for (const PatchFace& face : change.now) {
    const TriangleCorners corners = mesh_.CornersOf(face.v);
    now = std::max(now, LargestCotangent(corners));
    has_shape = has_shape && LeastCotangent(corners) >= widest;
    if (!(HeightOf(corners) >= limits_.tolerance)) return false;
    bool is_kept = true;
    VisitEdges(face, [&](NodePair edge, Node apex) {
      const auto it = apexes.find(edge);
      if (it == apexes.end()) return;
      const Point3 old = mesh_.NormalBeside(edge, it->second);
      const Point3 own = mesh_.NormalBeside(edge, apex);
      is_kept = is_kept && half_angle_.IsKept(old, own);
      is_plane = is_plane && plane_angle_.IsKept(old, own);
    });
    if (!is_kept) return false;
  }
  return (now <= narrowest && has_shape) || (allows_narrow_ && is_plane && now <= kPlaneCotangent);
}

bool PatchRules::KeepsEdges(const PatchChange& change) const {
  double narrowest = kCotangent;  // of what is between faces at sharp edges
  std::set<NodePair> old_edges, edges;
  for (const std::uint32_t f : change.old) {
    VisitEdges(mesh_.faces()[f], [&](NodePair edge, Node) { old_edges.insert(edge); });
  }
  for (const NodePair& edge : old_edges) {
    if (!mesh_.IsSharp(edge.first, edge.second)) continue;
    std::vector<Point3> normals;
    for (const Node apex : mesh_.ApexesOf(edge.first, edge.second)) {
      normals.push_back(mesh_.NormalBeside(edge, apex));
    }
    narrowest = std::max(narrowest, LargestCotangentOf(normals));
  }
  for (const PatchFace& face : change.now) {
    VisitEdges(face, [&](NodePair edge, Node) { edges.insert(edge); });
  }
  return std::all_of(edges.begin(), edges.end(), [&](const NodePair& edge) {
    return KeepsEdge(edge, change, old_edges, narrowest);
  });
}

// With the numbers of faces, and no edge twice, the surface stays what it is (the link condition:
// T. Dey, H. Edelsbrunner, S. Guha, D. Nekhayev, Topology preserving edge contraction, 1999).
bool PatchRules::KeepsEdge(NodePair edge, const PatchChange& change,
                           const std::set<NodePair>& old_edges, double narrowest) const {
  Nodes apexes;
  bool is_there = false;
  for (const std::uint32_t f : mesh_.FacesAt(edge.first)) {
    const PatchFace& face = mesh_.faces()[f];
    if (!face.Has(edge.second)) continue;
    is_there = true;
    if (!change.HasOld(f)) apexes.push_back(face.ApexOf(edge.first, edge.second));
  }
  if (is_there && !old_edges.contains(edge)) return false;
  for (const PatchFace& face : change.now) {
    if (face.Has(edge.first) && face.Has(edge.second)) {
      apexes.push_back(face.ApexOf(edge.first, edge.second));
    }
  }
  std::sort(apexes.begin(), apexes.end());
  std::vector<Point3> normals;
  for (const Node apex : apexes) normals.push_back(mesh_.NormalBeside(edge, apex));
  const bool is_joint = !change.ends.empty() && edge == Ordered(change.ends[0], change.ends[1]);
  if (is_joint && is_there) return false;
  if (is_joint || mesh_.IsSharp(edge.first, edge.second)) {
    const Nodes before = is_joint ? mesh_.ApexesOf(*change.dropped, edge.first)
                                  : mesh_.ApexesOf(edge.first, edge.second);
    return apexes.size() == before.size() && LargestCotangentOf(normals) <= narrowest;
  }
  return apexes.size() == 2 && angle_.IsKept(normals[0], Opposite(normals[1]));
}

bool PatchRules::KeepsChain(const PatchChange& change) const {
  if (change.ends.empty()) return true;
  const Node v = *change.dropped, u = change.ends[0], w = change.ends[1];
  const auto direction = [&](Node from, Node to) {
    return UnitOf(Minus(mesh_.at(to), mesh_.at(from)));
  };
  const Point3 along = direction(u, w);
  if (!half_angle_.IsKept(along, direction(u, v)) || !half_angle_.IsKept(along, direction(v, w))) {
    return false;
  }
  for (const auto& [end, other] : {std::pair(u, w), std::pair(w, u)}) {
    if (mesh_.IsCorner(end)) continue;
    for (const Node n : mesh_.SharpNeighboursOf(end)) {
      if (n != v && !angle_.IsKept(direction(n, end), direction(end, other))) return false;
    }
  }
  // All points of the chain are near if its nodes are; and the edge is near the chain, which goes
  // from end to end through every plane that is square to the edge.
  const auto is_near = [&](Node n) {
    const Point3& p = mesh_.at(n);
    return SquaredDistance<3>(FootOn(mesh_.at(u), mesh_.at(w), p), p) <=
           limits_.within * limits_.within;
  };
  if (!is_near(v)) return false;
  for (const Node end : change.ends) {
    const std::vector<Node>& hidden = mesh_.HiddenIn(v, end);
    if (!std::all_of(hidden.begin(), hidden.end(), is_near)) return false;
  }
  return true;
}

bool PatchRules::HasContacts(const PatchChange& change) const {
  std::vector<ContactElement> faces;
  for (const PatchFace& now : change.now) {
    const ContactElement face = ElementOf(now);
    for (const ContactElement& other : faces) {
      if (HasContact(mesh_.points(), face, other, limits_.tolerance)) return true;
    }
    faces.push_back(face);
  }
  const auto is_old = [&](std::uint32_t id) { return change.HasOld(id); };
  if (contacts_.HasContacts(faces, is_old)) return true;
  // What is between the old faces and the new ones would be on the other side afterwards. All of
  // that is in tetrahedra, as the old faces have a common corner.
  std::vector<std::array<Node, 4>> between;
  for (const PatchFace& now : change.now) {
    if (!now.Has(change.pivot)) between.push_back({change.pivot, now.v[0], now.v[1], now.v[2]});
  }
  return contacts_.HasCornersIn(between, is_old);
}

bool PatchRules::KeepsDistance(const PatchChange& change, Uses& uses) const {
  std::vector<DistanceTarget> now;
  for (const PatchFace& face : change.now) now.emplace_back(mesh_.CornersOf(face.v));
  std::vector<std::uint32_t> originals;
  for (const std::uint32_t f : change.old) {
    originals.insert(originals.end(), stands_for_[f].begin(), stands_for_[f].end());
  }
  SortUnique(originals);
  uses.assign(change.now.size(), {});
  std::vector<std::uint32_t> used;
  const std::size_t own = now.size();
  for (const std::uint32_t original : originals) {
    now.erase(now.begin() + static_cast<std::ptrdiff_t>(own), now.end());
    for (const std::uint32_t f : carriers_[original]) {
      if (!change.HasOld(f)) now.emplace_back(mesh_.CornersOf(mesh_.faces()[f].v));
    }
    used.clear();
    if (!IsWithin(originals_[original], now, limits_.within, used)) return false;
    for (const std::uint32_t i : used) {
      if (i < own) uses[i].push_back(original);
    }
  }
  std::vector<DistanceTarget> before;
  before.reserve(originals.size());
  for (const std::uint32_t original : originals) before.emplace_back(originals_[original]);
  for (std::size_t i = 0; i < own; ++i) {
    used.clear();
    if (!IsWithin(now[i].corners, before, limits_.within, used)) return false;
    for (const std::uint32_t k : used) uses[i].push_back(originals[k]);
    SortUnique(uses[i]);
  }
  return true;
}

void PatchRules::Apply(const PatchChange& change, Uses uses) {
  for (const std::uint32_t f : change.old) {
    for (const std::uint32_t original : stands_for_[f]) Erase(carriers_[original], f);
    stands_for_[f].clear();
    contacts_.Remove(f, ElementOf(mesh_.faces()[f]));
  }
  if (!change.ends.empty()) mesh_.JoinSharp(*change.dropped, change.ends[0], change.ends[1]);
  mesh_.Exchange(change.old, change.moved, change.now);
  for (std::size_t i = 0; i < change.moved.size(); ++i) {
    const std::uint32_t f = change.moved[i];
    for (const std::uint32_t original : uses[i]) Insert(carriers_[original], f);
    stands_for_[f] = std::move(uses[i]);
    contacts_.Insert(f, ElementOf(mesh_.faces()[f]));
  }
}

}  // namespace dynmesh::cleaning
