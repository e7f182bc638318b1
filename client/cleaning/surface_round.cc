#include "client/cleaning/surface_round.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <tuple>

#include "absl/container/flat_hash_set.h"
#include "client/cleaning/plane_triangulation.h"
#include "client/cleaning/vectors3.h"
#include "core/base/text.h"

namespace dynmesh::cleaning {
namespace {

using Vertex = PlaneTriangulation::Vertex;

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

// Tests of two lines, or of a node and a triangle, that take as long as one of two simplices.
constexpr std::size_t kPerStep = 16;

template <class T>
void SortUnique(std::vector<T>& items) {
  std::sort(items.begin(), items.end());
  items.erase(std::unique(items.begin(), items.end()), items.end());
}

// Where the shadows of two lines cross strictly inside of both, on the first one.
std::optional<Point3> CrossingOf(const Point3& a, const Point3& b, const Point3& c, const Point3& d,
                                 std::size_t axis) {
  const Point sa = ShadowOf(a, axis), sb = ShadowOf(b, axis), sc = ShadowOf(c, axis),
              sd = ShadowOf(d, axis);
  for (std::size_t i = 0; i < 2; ++i) {
    if (std::max(sa[i], sb[i]) < std::min(sc[i], sd[i])) return std::nullopt;
    if (std::max(sc[i], sd[i]) < std::min(sa[i], sb[i])) return std::nullopt;
  }
  const auto side = [](const Point& p, const Point& q, const Point& r) {
    return CGAL::orientation(Kernel::Point_2(p[0], p[1]), Kernel::Point_2(q[0], q[1]),
                             Kernel::Point_2(r[0], r[1]));
  };
  if (side(sa, sb, sc) * side(sa, sb, sd) >= 0 || side(sc, sd, sa) * side(sc, sd, sb) >= 0) {
    return std::nullopt;
  }
  const double ux = sb[0] - sa[0], uy = sb[1] - sa[1], wx = sd[0] - sc[0], wy = sd[1] - sc[1];
  const double det = ux * wy - uy * wx;
  if (det == 0) return std::nullopt;
  const double t = ((sc[0] - sa[0]) * wy - (sc[1] - sa[1]) * wx) / det;
  return Along(a, std::clamp(t, 0.0, 1.0), Minus(b, a));
}

}  // namespace

absl::StatusOr<bool> SurfaceRounds::Run() {
  ++surface_.round;
  edge_nodes_.clear();
  chains_.clear();
  faces_.clear();
  concerned_.clear();
  contractions_.clear();
  told_.clear();
  edges_ = surface_.EdgesOf();
  Contacts contacts = FindContacts(surface_, seen_, max_crossings_, effort_);
  if (contacts.is_crowded) {
    effort_.Spend();
    found_ = contacts.thin.size();
    where_ = contacts.crowd;
    return SpentError();
  }
  if (contacts.pairs.empty() && contacts.thin.empty()) return false;
  seen_ = surface_.round;
  if (contacts.is_cut_off) {
    return absl::ResourceExhaustedError(text::Concat("faces meet in more than ", max_crossings_,
                                                     " places; clean the surface in parts"));
  }
  found_ = contacts.pairs.size() + contacts.thin.size();
  places_.clear();
  for (const Contact& c : contacts.pairs) places_.push_back({c.place, c.fold});
  for (const ThinFace& face : contacts.thin) places_.push_back({surface_.at(face.at), face.fold});
  if (surface_.most_contraction > 0) Postpone(contacts);
  Take(contacts.thin);
  Take(contacts.pairs);
  JoinLines();
  MakeChains();
  const bool has_changed = !effort_.is_spent() && (Apply() || !contractions_.empty());
  if (effort_.is_spent()) return SpentError();
  if (!contractions_.empty()) surface_.Join(contractions_);
  if (!has_changed) {
    return absl::ResourceExhaustedError(text::Concat(
        found_, " contacts cannot be mended, one at (", where_[0], ", ", where_[1], ", ", where_[2],
        "); choose another tolerance than ", surface_.nodes.tolerance()));
  }
  surface_.Settle();
  return true;
}

absl::Status SurfaceRounds::SpentError() const {
  return absl::ResourceExhaustedError(
      text::Concat("cleaning takes too many steps: in round ", surface_.round, " ",
                   surface_.simplices.size(), " triangles and edges meet in ", found_,
                   " places or more, one at (", where_[0], ", ", where_[1], ", ", where_[2],
                   "); clean the surface in parts, with a larger tolerance, or allow more steps"));
}

FeatureId SurfaceRounds::NameOf(NodePair edge) const {
  const auto it = edges_.find(edge);
  if (it == edges_.end()) return kNoFeature;
  FeatureId least = kNoFeature;
  for (const std::uint32_t s : it->second) {
    const FeatureId source = surface_.simplices[s].sources.front();
    if (least == kNoFeature || source < least) least = source;
  }
  return least;
}

Point3 SurfaceRounds::NormalOf(const Simplex& face) const {
  const std::array<Node, 3> v = surface_.CornersOf(face);
  return cleaning::NormalOf(surface_.at(v[0]), surface_.at(v[1]), surface_.at(v[2]));
}

void SurfaceRounds::SortAlong(std::vector<Node>& nodes, const Point3& direction) const {
  std::sort(nodes.begin(), nodes.end(), [&](Node a, Node b) {
    return std::pair(Dot(direction, surface_.at(a)), a) <
           std::pair(Dot(direction, surface_.at(b)), b);
  });
}

void SurfaceRounds::PutOnEdge(NodePair edge, Node at, SurfaceChangeKind kind) {
  if (at == edge.first || at == edge.second) return;
  edge_nodes_.push_back({edge, at, kind});
}

// A node that is not over the inside goes on the nearest edge.
void SurfaceRounds::PutInFace(std::uint32_t face, Node at) {
  const Simplex& s = surface_.simplices[face];
  if (s.Has(at)) return;
  const Point3& p = surface_.at(at);
  if (IsOver(surface_, s, p)) {
    faces_[face].nodes.push_back(at);
    return;
  }
  NodePair nearest = s.Edge(0);
  double least = -1;
  for (int k = 0; k < 3; ++k) {
    const double distance = SquaredDistance<3>(p, FootOn(surface_, s.Edge(k), p));
    if (least >= 0 && (distance > least || (distance == least && nearest < s.Edge(k)))) continue;
    least = distance;
    nearest = s.Edge(k);
  }
  PutOnEdge(nearest, at, SurfaceChangeKind::kEdgeSplit);
}

// Crossings of edges that have nodes on them are looked for again in the next round.
void SurfaceRounds::Postpone(Contacts& contacts) {
  absl::flat_hash_set<NodePair> touched;
  for (const ThinFace& face : contacts.thin) touched.insert(face.edge);
  const auto edge_of = [&](std::uint32_t simplex, int part) {
    return surface_.simplices[simplex].Edge(part);
  };
  for (const Contact& c : contacts.pairs) {
    if (std::max(c.part_of_s, c.part_of_t) < kFirstCorner) continue;
    if (c.part_of_s < kFaceItself) touched.insert(edge_of(c.s, c.part_of_s));
    if (c.part_of_t < kFaceItself) touched.insert(edge_of(c.t, c.part_of_t));
  }
  std::erase_if(contacts.pairs, [&](const Contact& c) {
    if (std::max(c.part_of_s, c.part_of_t) >= kFirstCorner) return false;
    const auto waits = [&](std::uint32_t simplex, int part) {
      return part < kFaceItself && touched.contains(edge_of(simplex, part));
    };
    if (!waits(c.s, c.part_of_s) && !waits(c.t, c.part_of_t)) return false;
    concerned_.push_back(c.s);
    concerned_.push_back(c.t);
    return true;
  });
}

bool SurfaceRounds::TakeContraction(const ThinFace& thin) {
  if (!(surface_.most_contraction > 0) || surface_.round < 2) return false;
  const NodePair a = Ordered(thin.at, thin.edge.first), b = Ordered(thin.at, thin.edge.second);
  const NodePair edge = surface_.IsShorter(a, b) ? a : b;
  const double most = surface_.most_contraction * surface_.most_contraction;
  if (!(SquaredDistance<3>(surface_.at(edge.first), surface_.at(edge.second)) < most)) return false;
  contractions_.push_back(edge);
  return true;
}

void SurfaceRounds::Take(const std::vector<ThinFace>& thin) {
  if (!thin.empty()) where_ = surface_.at(thin.front().at);
  for (const ThinFace& face : thin) {
    const std::vector<std::uint32_t>& simplices = edges_.at(face.edge);
    concerned_.insert(concerned_.end(), simplices.begin(), simplices.end());
    if (TakeContraction(face)) continue;
    PutOnEdge(face.edge, face.at, SurfaceChangeKind::kEdgeSplit);
  }
}

void SurfaceRounds::TakePart(std::uint32_t simplex, int part, Node at, SurfaceChangeKind kind) {
  concerned_.push_back(simplex);
  if (part == kFaceItself) {
    PutInFace(simplex, at);
  } else if (part < kFaceItself) {
    PutOnEdge(surface_.simplices[simplex].Edge(part), at, kind);
  }
}

void SurfaceRounds::Take(std::vector<Contact>& contacts) {
  if (contacts.empty()) return;
  // Nodes are made in the order of coordinates.
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.place, a.s, a.t, a.part_of_s, a.part_of_t) <
           std::tie(b.place, b.s, b.t, b.part_of_s, b.part_of_t);
  });
  where_ = contacts.front().place;
  for (Contact& c : contacts) {
    const bool is_touch = std::max(c.part_of_s, c.part_of_t) >= kFirstCorner;
    if (!is_touch) c.at = surface_.NodeAt(c.place);
    const auto kind = is_touch ? SurfaceChangeKind::kEdgeSplit : SurfaceChangeKind::kEdgesCrossed;
    TakePart(c.s, c.part_of_s, c.at, kind);
    TakePart(c.t, c.part_of_t, c.at, kind);
    Report(c);
  }
  std::sort(contacts.begin(), contacts.end(), [](const Contact& a, const Contact& b) {
    return std::tie(a.s, a.t, a.part_of_s, a.part_of_t, a.at) <
           std::tie(b.s, b.t, b.part_of_s, b.part_of_t, b.at);
  });
  for (std::size_t begin = 0, end = 0; begin < contacts.size(); begin = end) {
    while (end < contacts.size() && contacts[end].s == contacts[begin].s &&
           contacts[end].t == contacts[begin].t) {
      ++end;
    }
    TakeLines(&contacts[begin], &contacts[begin] + (end - begin));
  }
}

// Nodes on edges are told when the edge is split.
void SurfaceRounds::Report(const Contact& c) {
  const bool in_face = c.part_of_s == kFaceItself || c.part_of_t == kFaceItself;
  const bool is_touch = std::max(c.part_of_s, c.part_of_t) >= kFirstCorner;
  if (is_touch && !in_face) return;
  const bool s_first = c.part_of_t == kFaceItself;  // the edge's feature comes first
  const auto name = [&](bool of_s) {
    const Simplex& simplex = surface_.simplices[of_s ? c.s : c.t];
    const int part = of_s ? c.part_of_s : c.part_of_t;
    return part < kFaceItself ? NameOf(simplex.Edge(part)) : simplex.sources.front();
  };
  std::vector<FeatureId> ids;
  if (!is_touch) ids.push_back(name(s_first));
  ids.push_back(name(!s_first));
  ids.push_back(surface_.point_ids[c.at]);
  const auto kind = is_touch  ? SurfaceChangeKind::kFaceSplit
                    : in_face ? SurfaceChangeKind::kFaceCrossed
                              : SurfaceChangeKind::kEdgesCrossed;
  if (kind == SurfaceChangeKind::kEdgesCrossed) std::sort(ids.begin(), ids.begin() + 2);
  if (told_.emplace(kind, ids).second) {
    surface_.changes.push_back({kind, std::move(ids), c.place, surface_.at(c.at)});
  }
}

// The lines that two simplices have in common.
void SurfaceRounds::TakeLines(const Contact* begin, const Contact* end) {
  const Simplex &s = surface_.simplices[begin->s], &t = surface_.simplices[begin->t];
  std::vector<Node> shared, all;
  for (int k = 0; k < s.size; ++k) {
    const Node v = s.v[static_cast<std::size_t>(k)];
    if (t.Has(v)) shared.push_back(v);
  }
  all = shared;
  for (const Contact* c = begin; c != end; ++c) all.push_back(c->at);
  SortUnique(all);
  if (all.size() < 2) return;
  const auto add = [&](std::vector<Node> on, const Point3& direction, std::uint32_t into) {
    SortUnique(on);
    SortAlong(on, direction);
    for (std::size_t i = 0; i + 1 < on.size(); ++i) {
      faces_[into].lines.push_back(Ordered(on[i], on[i + 1]));
    }
  };
  const bool are_faces = s.size == 3 && t.size == 3;
  if (all.size() == 2 || (are_faces && !AreCoplanar(surface_, s, t))) {
    const Point3 direction = all.size() == 2 ? Point3{} : Cross(NormalOf(s), NormalOf(t));
    if (s.size == 3) add(all, direction, begin->s);
    if (t.size == 3) add(all, direction, begin->t);
    return;
  }
  // Along the edges of each in the other.
  for (const bool of_s : {true, false}) {
    const Simplex& from = of_s ? s : t;
    const std::uint32_t into = of_s ? begin->t : begin->s;
    if (surface_.simplices[into].size < 3) continue;
    for (int k = 0; k < from.edge_count(); ++k) {
      const NodePair edge = from.Edge(k);
      std::vector<Node> on;
      for (const Node v : shared) {
        if (v == edge.first || v == edge.second) on.push_back(v);
      }
      for (const Contact* c = begin; c != end; ++c) {
        const int part = of_s ? c->part_of_s : c->part_of_t;
        const bool is_end = part >= kFirstCorner && (c->at == edge.first || c->at == edge.second);
        if (part == k || is_end) on.push_back(c->at);
      }
      add(std::move(on), Minus(surface_.at(edge.second), surface_.at(edge.first)), into);
    }
  }
}

// Nodes where the lines of a face cross.
void SurfaceRounds::JoinLines() {
  std::vector<std::uint32_t> order;
  for (auto& [face, work] : faces_) {
    SortUnique(work.lines);
    if (work.lines.size() > 1) order.push_back(face);
  }
  std::sort(order.begin(), order.end());
  struct Joint {
    Point3 place;
    std::uint32_t face;
    NodePair first, second;
  };
  std::vector<Joint> joints;
  for (const std::uint32_t face : order) {
    const std::vector<NodePair>& lines = faces_[face].lines;
    if (!effort_.Take(lines.size() * lines.size() / kPerStep)) {
      where_ = surface_.at(surface_.simplices[face].v[0]);
      return;
    }
    const std::size_t axis = ViewOf(surface_, surface_.simplices[face]).axis;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      for (std::size_t j = i + 1; j < lines.size(); ++j) {
        const auto place =
            CrossingOf(surface_.at(lines[i].first), surface_.at(lines[i].second),
                       surface_.at(lines[j].first), surface_.at(lines[j].second), axis);
        if (place) joints.push_back({*place, face, lines[i], lines[j]});
      }
    }
  }
  std::sort(joints.begin(), joints.end(), [](const Joint& a, const Joint& b) {
    return std::tie(a.place, a.face, a.first, a.second) <
           std::tie(b.place, b.face, b.first, b.second);
  });
  absl::flat_hash_map<std::pair<std::uint32_t, NodePair>, std::vector<Node>> cuts;
  for (const Joint& joint : joints) {
    const Node v = surface_.NodeAt(joint.place);
    PutInFace(joint.face, v);
    for (const NodePair& line : {joint.first, joint.second}) {
      if (v != line.first && v != line.second) cuts[{joint.face, line}].push_back(v);
    }
  }
  for (const std::uint32_t face : order) {
    std::vector<NodePair> parts;
    for (const NodePair& line : faces_[face].lines) {
      const auto it = cuts.find({face, line});
      if (it == cuts.end()) {
        parts.push_back(line);
        continue;
      }
      std::vector<Node>& on = it->second;
      SortUnique(on);
      SortAlong(on, Minus(surface_.at(line.second), surface_.at(line.first)));
      Node last = line.first;
      for (const Node v : on) parts.push_back(Ordered(std::exchange(last, v), v));
      parts.push_back(Ordered(last, line.second));
    }
    SortUnique(parts);
    faces_[face].lines = std::move(parts);
  }
}

// An edge becomes the chain through its nodes, if all parts are shorter; else it gets one of them:
// the next round finds the rest again.
void SurfaceRounds::MakeChains() {
  std::sort(edge_nodes_.begin(), edge_nodes_.end(), [](const EdgeNode& a, const EdgeNode& b) {
    return std::tie(a.edge, a.at, a.kind) < std::tie(b.edge, b.at, b.kind);
  });
  edge_nodes_.erase(std::unique(edge_nodes_.begin(), edge_nodes_.end(),
                                [](const EdgeNode& a, const EdgeNode& b) {
                                  return a.edge == b.edge && a.at == b.at;
                                }),
                    edge_nodes_.end());
  for (std::size_t begin = 0, end = 0; begin < edge_nodes_.size(); begin = end) {
    const NodePair edge = edge_nodes_[begin].edge;
    while (end < edge_nodes_.size() && edge_nodes_[end].edge == edge) ++end;
    std::vector<EdgeNode> on(edge_nodes_.begin() + static_cast<std::ptrdiff_t>(begin),
                             edge_nodes_.begin() + static_cast<std::ptrdiff_t>(end));
    const Point3& from = surface_.at(edge.first);
    const Point3 d = Minus(surface_.at(edge.second), from);
    std::sort(on.begin(), on.end(), [&](const EdgeNode& a, const EdgeNode& b) {
      return std::pair(Dot(d, Minus(surface_.at(a.at), from)), a.at) <
             std::pair(Dot(d, Minus(surface_.at(b.at), from)), b.at);
    });
    const auto fits = [&](const std::vector<EdgeNode>& nodes) {
      Node last = edge.first;
      for (const EdgeNode& node : nodes) {
        if (!surface_.IsShorter(Ordered(std::exchange(last, node.at), node.at), edge)) return false;
      }
      return surface_.IsShorter(Ordered(last, edge.second), edge);
    };
    if (!fits(on)) {
      const auto one =
          std::find_if(on.begin(), on.end(), [&](const EdgeNode& node) { return fits({node}); });
      if (one == on.end()) continue;
      on = {*one};
    }
    std::vector<Node>& chain = chains_[edge];
    for (const EdgeNode& node : on) {
      chain.push_back(node.at);
      if (node.kind == SurfaceChangeKind::kEdgesCrossed) continue;  // told already
      const Point3& to = surface_.at(node.at);
      surface_.changes.push_back(
          {node.kind, {NameOf(edge), surface_.point_ids[node.at]}, FootOn(surface_, edge, to), to});
    }
  }
}

bool SurfaceRounds::Apply() {
  std::vector<std::uint32_t> concerned = concerned_;
  for (const auto& [edge, chain] : chains_) {
    const auto it = edges_.find(edge);
    if (it != edges_.end()) concerned.insert(concerned.end(), it->second.begin(), it->second.end());
  }
  for (const auto& [face, work] : faces_) concerned.push_back(face);
  SortUnique(concerned);
  bool changed = false;
  for (const std::uint32_t s : concerned) {
    if (effort_.is_spent()) return changed;
    if (ApplyTo(s)) {
      changed = true;
    } else {
      surface_.simplices[s].born = surface_.round;  // to be looked at again
    }
  }
  return changed;
}

bool SurfaceRounds::ApplyTo(std::uint32_t index) {
  const Simplex s = surface_.simplices[index];
  if (s.size == 1) return false;
  if (s.size == 2) {
    const auto chain = chains_.find(s.Edge(0));
    if (chain == chains_.end()) return false;
    surface_.simplices[index].sources.clear();
    Node last = s.Edge(0).first;
    for (const Node v : chain->second) {
      surface_.Add(std::array{std::exchange(last, v), v}, s.sources);
    }
    surface_.Add(std::array{last, s.Edge(0).second}, s.sources);
    return true;
  }
  const auto work = faces_.find(index);
  if (work != faces_.end()) {
    const std::size_t nodes = work->second.nodes.size() + work->second.lines.size();
    if (!effort_.Take(nodes * nodes / kPerStep)) {
      where_ = surface_.at(s.v[0]);
      return false;
    }
  }
  std::vector<std::array<Node, 3>> pieces =
      PiecesOf(s, work == faces_.end() ? FaceWork() : work->second);
  if (pieces.size() == 1 && Simplex{pieces[0], 3, 0, {}}.Key() == s.Key()) return false;
  surface_.simplices[index].sources.clear();
  for (const auto& piece : pieces) surface_.Add(piece, s.sources);
  return true;
}

std::vector<std::array<Node, 3>> SurfaceRounds::PiecesOf(const Simplex& face,
                                                         const FaceWork& work) const {
  const FaceView view = ViewOf(surface_, face);
  // The shadow makes angles smaller.
  PlaneTriangulation pieces(surface_.ToleranceOf(face),
                            std::max(PlaneTriangulation::kLeastSine, 2 * surface_.least_sine));
  absl::flat_hash_map<Node, Vertex> vertex_of;
  const auto add = [&](Node v) {
    const Vertex vertex = pieces.AddVertex(ShadowOf(surface_.at(v), view.axis), v);
    vertex_of.emplace(v, vertex);
    return vertex;
  };
  // Begins at the least corner, so that its orientation does not matter.
  std::array<Node, 3> v = face.v;
  std::rotate(v.begin(), std::min_element(v.begin(), v.end()), v.end());
  if (!view.is_counter_clockwise) std::swap(v[1], v[2]);
  const std::array<Vertex, 3> corners = {add(v[0]), add(v[1]), add(v[2])};
  pieces.AddTriangle(corners[0], corners[1], corners[2]);
  for (std::size_t k = 0; k < 3; ++k) {
    const Vertex from = corners[k], to = corners[(k + 1) % 3];
    const NodePair edge = Ordered(v[k], v[(k + 1) % 3]);
    Vertex last = from;
    if (const auto it = chains_.find(edge); it != chains_.end()) {
      std::vector<Node> chain = it->second;
      if (edge.first != v[k]) std::reverse(chain.begin(), chain.end());
      for (const Node n : chain) {
        const Vertex next = pieces.SplitBorder(last, to, add(n));
        pieces.FixEdge(last, next);
        last = next;
      }
    }
    pieces.FixEdge(last, to);
  }
  std::vector<Node> inner = work.nodes;
  SortUnique(inner);
  for (const Node n : inner) {
    if (vertex_of.contains(n)) continue;
    const Vertex vertex = add(n);
    if (!pieces.Insert(vertex)) vertex_of.erase(n);
  }
  const auto fix = [&](Node p, Node q) {
    const auto a = vertex_of.find(p), b = vertex_of.find(q);
    if (a != vertex_of.end() && b != vertex_of.end()) pieces.Fix(a->second, b->second);
  };
  for (const NodePair& line : work.lines) {
    Node last = line.first;
    if (const auto it = chains_.find(line); it != chains_.end()) {
      for (const Node n : it->second) fix(std::exchange(last, n), n);
    }
    fix(last, line.second);
  }
  pieces.MakeDelaunay();
  // What is there twice cancels.
  std::vector<std::pair<std::array<Node, 3>, std::array<Node, 3>>> keyed;
  for (const auto& t : pieces.Triangles()) {
    std::array<Node, 3> nodes;
    for (std::size_t k = 0; k < 3; ++k) nodes[k] = pieces.RankOf(t[k]);
    if (nodes[0] == nodes[1] || nodes[1] == nodes[2] || nodes[2] == nodes[0]) continue;
    if (!view.is_counter_clockwise) std::swap(nodes[1], nodes[2]);
    keyed.emplace_back(Simplex{nodes, 3, 0, {}}.Key(), nodes);
  }
  std::sort(keyed.begin(), keyed.end());
  std::vector<std::array<Node, 3>> result;
  for (std::size_t begin = 0, end = 0; begin < keyed.size(); begin = end) {
    while (end < keyed.size() && keyed[end].first == keyed[begin].first) ++end;
    if ((end - begin) % 2 == 1) result.push_back(keyed[begin].second);
  }
  return result;
}

}  // namespace dynmesh::cleaning
