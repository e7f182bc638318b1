#include "core/dynamic_mesh/diff_builder.h"

#include <algorithm>
#include <utility>

namespace dynmesh {
namespace {

using meshing::Subsegment;
using meshing::SubsegmentIndex;
using meshing::Vertex;
using meshing::VertexIndex;
using Triangulation = mesh::DelaunayTriangulation;

// How a vertex counts in the hash and looks to a client.
struct Appearance {
  const double* coordinates;
  int dimension;
  FeatureId owner;
};

Appearance AppearanceOf(const Vertex& v, const FeatureTable& features) {
  return {v.p.c.data(), v.dimension, features.IdOf(v.feature)};
}

MeshHash HashOf(const Appearance& a) { return HashVertex(a.coordinates, 2, a.dimension, a.owner); }

void Append(VertexColumns& to, VertexId id, const Appearance& a) {
  to.ids.push_back(id);
  to.coordinates.insert(to.coordinates.end(), a.coordinates, a.coordinates + 2);
  to.containing_dimensions.push_back(static_cast<std::uint8_t>(a.dimension));
  to.owners.push_back(a.owner);
}

void Append(SubsegmentColumns& to, std::array<VertexId, 2> ends, FeatureId owner) {
  to.ends.insert(to.ends.end(), {std::min(ends[0], ends[1]), std::max(ends[0], ends[1])});
  to.owners.push_back(owner);
}

struct NamedSubsegment {
  std::array<VertexId, 2> ends;
  FeatureId owner;
  friend auto operator<=>(const NamedSubsegment&, const NamedSubsegment&) = default;
};

// Takes away what stands in both sorted lists.
template <class T>
void Cancel(std::vector<T>& a, std::vector<T>& b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  std::vector<T> only_a, only_b;
  std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(only_a));
  std::set_difference(b.begin(), b.end(), a.begin(), a.end(), std::back_inserter(only_b));
  a.swap(only_a);
  b.swap(only_b);
}

}  // namespace

DiffBuilder::Simplex DiffBuilder::CanonicalIds(const std::array<VertexIndex, 3>& v) const {
  const Simplex ids = {names_.at(v[0]), names_.at(v[1]), names_.at(v[2])};
  const auto least = std::min_element(ids.begin(), ids.end()) - ids.begin();
  return {ids[least], ids[(least + 1) % 3], ids[(least + 2) % 3]};
}

void DiffBuilder::RecordCreated() {
  for (const auto t : triangulation_.created()) {
    if (!triangulation_.IsInfinite(t)) added_.push_back(CanonicalIds(t));
  }
}

void DiffBuilder::RecordDeleted() {
  for (const auto& v : triangulation_.deleted()) {
    if (std::find(v.begin(), v.end(), Triangulation::kInfinite) == v.end()) {
      removed_.push_back(CanonicalIds(v));
    }
  }
}

// A neighbour that refinement saw is a good place to start looking from.
template <class Refinement>
void DiffBuilder::InsertVertex(const Refinement& refinement, VertexIndex v) {
  VertexIndex near = 0;
  refinement.ForSomeNeighbours(v, [&](VertexIndex u) {
    if (!triangulation_.Contains(u)) return false;
    near = u;
    return true;
  });
  triangulation_.Insert(v, refinement.vertex(v).p, near);
  RecordDeleted();
  RecordCreated();
}

template <class Refinement>
Mesh DiffBuilder::Begin(Refinement& refinement, const FeatureTable& features) {
  refinement.TakeChanges([](VertexIndex, bool, bool) {}, [](SubsegmentIndex, bool, bool) {});
  const auto position = [&](VertexIndex v) -> const geometry::Point2& {
    return refinement.vertex(v).p;
  };
  names_.Reserve(refinement.vertex_count());
  refinement.ForEachVertex([&](VertexIndex v, const Vertex&) {
    names_.Add(v, position, [](VertexIndex) {});
    if (!triangulation_.Contains(v)) InsertVertex(refinement, v);
  });
  removed_.clear();
  added_.clear();
  Mesh mesh = Snapshot(refinement, features);
  subsegment_count_ = mesh.subsegments.size();
  hash_ = mesh.hash = ComputeHash(mesh);
  return mesh;
}

template <class Refinement>
MeshDiff DiffBuilder::Update(Refinement& refinement, const FeatureTable& features) {
  MeshDiff diff;
  removed_.clear();
  added_.clear();
  const auto position = [&](VertexIndex v) -> const geometry::Point2& {
    return refinement.vertex(v).p;
  };

  std::vector<VertexIndex> come, gone;
  std::vector<SubsegmentIndex> pieces_come, pieces_gone;
  refinement.TakeChanges(
      [&](VertexIndex v, bool is, bool was) {
        if (is != was) (is ? come : gone).push_back(v);
      },
      [&](SubsegmentIndex s, bool is, bool was) {
        if (is != was) (is ? pieces_come : pieces_gone).push_back(s);
      });

  // Names of what goes, before any is given away.
  std::vector<NamedSubsegment> removed_pieces, added_pieces;
  for (const SubsegmentIndex s : pieces_gone) {
    const Subsegment& sub = refinement.subsegment(s);
    std::array<VertexId, 2> ends = {names_.at(sub.a), names_.at(sub.b)};
    std::sort(ends.begin(), ends.end());
    removed_pieces.push_back({ends, features.IdOf(sub.feature)});
  }
  std::vector<std::pair<VertexId, VertexIndex>> gone_named;
  for (const VertexIndex v : gone) gone_named.push_back({names_.at(v), v});

  // A vertex whose id changes because one that collides came or went leaves under
  // the old name and comes back under the new; so does all that it is part of.
  std::vector<std::pair<VertexId, VertexIndex>> renamed;
  const auto rename = [&](VertexIndex v) {
    for (const auto& [id, w] : renamed) {
      if (w == v) return;
    }
    if (!triangulation_.Contains(v)) return;
    renamed.push_back({names_.at(v), v});
    const auto first = triangulation_.Around(v);
    auto corner = first;
    do {
      if (!triangulation_.IsInfinite(corner.triangle)) {
        removed_.push_back(CanonicalIds(corner.triangle));
      }
      corner = triangulation_.NextAround(corner);
    } while (corner.triangle != first.triangle);
  };

  std::vector<VertexIndex> same_place;
  for (const VertexIndex v : come) {
    const VertexIndex w = names_.Find(position(v), position);
    if (w == meshing::kNil) {
      names_.Add(v, position, rename);
    } else {
      // Another vertex at the place of one that goes.
      names_.Replace(w, v, position(v));
      same_place.push_back(w);
      triangulation_.Remove(w);
      RecordDeleted();
      RecordCreated();
    }
  }
  for (const VertexIndex v : come) InsertVertex(refinement, v);
  for (const VertexIndex v : gone) {
    if (std::find(same_place.begin(), same_place.end(), v) != same_place.end()) continue;
    triangulation_.Remove(v);
    RecordDeleted();
    RecordCreated();
  }
  for (const VertexIndex v : gone) {
    if (std::find(same_place.begin(), same_place.end(), v) != same_place.end()) continue;
    names_.Remove(v, position, rename);
  }
  for (const auto& [id, v] : renamed) {
    const auto first = triangulation_.Around(v);
    auto corner = first;
    do {
      if (!triangulation_.IsInfinite(corner.triangle)) added_.push_back(CanonicalIds(corner.triangle));
      corner = triangulation_.NextAround(corner);
    } while (corner.triangle != first.triangle);
  }
  Net(removed_, added_);

  // Vertices: those that look the same before and after are not reported.
  struct NamedVertex {
    VertexId id;
    Appearance look;
  };
  std::vector<NamedVertex> was, is;
  for (const auto& [id, v] : gone_named) {
    was.push_back({id, AppearanceOf(refinement.vertex(v), features)});
  }
  for (const VertexIndex v : come) {
    is.push_back({names_.at(v), AppearanceOf(refinement.vertex(v), features)});
  }
  for (const auto& [id, v] : renamed) {
    was.push_back({id, AppearanceOf(refinement.vertex(v), features)});
    is.push_back({names_.at(v), AppearanceOf(refinement.vertex(v), features)});
  }
  const auto by_id = [](const NamedVertex& a, const NamedVertex& b) { return a.id < b.id; };
  std::sort(was.begin(), was.end(), by_id);
  std::sort(is.begin(), is.end(), by_id);
  const auto same = [](const NamedVertex& a, const NamedVertex& b) {
    return a.id == b.id && a.look.dimension == b.look.dimension && a.look.owner == b.look.owner &&
           a.look.coordinates[0] == b.look.coordinates[0] &&
           a.look.coordinates[1] == b.look.coordinates[1];
  };
  const auto find_same = [&](const std::vector<NamedVertex>& in, const NamedVertex& x) {
    const auto [lo, hi] = std::equal_range(in.begin(), in.end(), x, by_id);
    return std::any_of(lo, hi, [&](const NamedVertex& y) { return same(x, y); });
  };
  for (const NamedVertex& v : was) {
    if (find_same(is, v)) continue;
    diff.removed_vertices.push_back(v.id);
    hash_ -= HashOf(v.look);
  }
  for (const NamedVertex& v : is) {
    if (find_same(was, v)) continue;
    Append(diff.added_vertices, v.id, v.look);
    hash_ += HashOf(v.look);
  }

  for (const SubsegmentIndex s : pieces_come) {
    const Subsegment& sub = refinement.subsegment(s);
    std::array<VertexId, 2> ends = {names_.at(sub.a), names_.at(sub.b)};
    std::sort(ends.begin(), ends.end());
    added_pieces.push_back({ends, features.IdOf(sub.feature)});
  }
  if (!renamed.empty()) {
    for (const auto& [id, v] : renamed) {
      refinement.ForSubsegmentsAt(v, [&](const Subsegment& sub) {
        if (!sub.in_mesh) return;
        const auto name = [&](VertexIndex w, bool before) {
          for (const auto& [old_id, r] : renamed) {
            if (before && r == w) return old_id;
          }
          return names_.at(w);
        };
        for (const bool before : {true, false}) {
          std::array<VertexId, 2> ends = {name(sub.a, before), name(sub.b, before)};
          std::sort(ends.begin(), ends.end());
          (before ? removed_pieces : added_pieces).push_back({ends, features.IdOf(sub.feature)});
        }
      });
    }
  }
  Cancel(removed_pieces, added_pieces);
  for (const NamedSubsegment& s : removed_pieces) {
    Append(diff.removed_subsegments, s.ends, s.owner);
    hash_ -= HashSubsegment(s.ends[0], s.ends[1], s.owner);
  }
  for (const NamedSubsegment& s : added_pieces) {
    Append(diff.added_subsegments, s.ends, s.owner);
    hash_ += HashSubsegment(s.ends[0], s.ends[1], s.owner);
  }
  subsegment_count_ += added_pieces.size();
  subsegment_count_ -= removed_pieces.size();

  const auto append_simplices = [](SimplexColumn& to, const std::vector<Simplex>& from) {
    to.reserve(3 * from.size());
    for (const Simplex& s : from) to.insert(to.end(), s.begin(), s.end());
  };
  append_simplices(diff.removed_simplices, removed_);
  append_simplices(diff.added_simplices, added_);
  for (const Simplex& s : removed_) hash_ -= HashSimplex(s.data(), 3);
  for (const Simplex& s : added_) hash_ += HashSimplex(s.data(), 3);
  diff.hash = hash_;
  return diff;
}

void DiffBuilder::Net(std::vector<Simplex>& removed, std::vector<Simplex>& added) {
  Cancel(removed, added);
}

template <class Refinement>
Mesh DiffBuilder::Snapshot(const Refinement& refinement, const FeatureTable& features) const {
  Mesh mesh;
  mesh.vertices.ids.reserve(refinement.vertex_count());
  mesh.vertices.coordinates.reserve(2 * refinement.vertex_count());
  mesh.vertices.containing_dimensions.reserve(refinement.vertex_count());
  mesh.vertices.owners.reserve(refinement.vertex_count());
  refinement.ForEachVertex([&](VertexIndex v, const Vertex& vertex) {
    Append(mesh.vertices, names_.at(v), AppearanceOf(vertex, features));
  });
  mesh.simplices.reserve(3 * triangulation_.triangle_count());
  triangulation_.ForEachTriangle([&](auto t) {
    const Simplex ids = CanonicalIds(t);
    mesh.simplices.insert(mesh.simplices.end(), ids.begin(), ids.end());
  });
  refinement.ForEachSubsegment([&](const Subsegment& s) {
    Append(mesh.subsegments, {names_.at(s.a), names_.at(s.b)}, features.IdOf(s.feature));
  });
  mesh.hash = hash_;
  return mesh;
}

template Mesh DiffBuilder::Begin(meshing::Refinement<sac::Engine>&, const FeatureTable&);
template MeshDiff DiffBuilder::Update(meshing::Refinement<sac::Engine>&, const FeatureTable&);
template Mesh DiffBuilder::Snapshot(const meshing::Refinement<sac::Engine>&,
                                    const FeatureTable&) const;
template Mesh DiffBuilder::Begin(meshing::Refinement<sac::UntracedEngine>&, const FeatureTable&);
template Mesh DiffBuilder::Snapshot(const meshing::Refinement<sac::UntracedEngine>&,
                                    const FeatureTable&) const;

}  // namespace dynmesh
