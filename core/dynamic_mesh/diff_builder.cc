#include "core/dynamic_mesh/diff_builder.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>

#include "core/delaunay/delaunay_insert_order.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/region_errors.h"
#include "core/dynamic_mesh/vertex_id_error.h"
#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/regions.h"
#include "core/mesh_data/whole_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

using mesh_data::InCanonicalOrder;
using meshing::SubsegmentIndex;
using meshing::VertexIndex;

template <std::size_t N>
bool IsFinite(const std::array<VertexIndex, N>& v) {
  return std::find(v.begin(), v.end(), delaunay::DelaunayTriangulation::kInfinite) == v.end();
}

template <int D>
auto FacetsIn(const meshing::MeshSource<D>& mesher) {
  return [&](VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) {
    return mesher.FacetAt(a, b, c, d);
  };
}

template <class Subsegment>
std::array<VertexIndex, 2> SideOf(const Subsegment& s) {
  return {std::min(s.a, s.b), std::max(s.a, s.b)};
}

}  // namespace

// --- Rows -----------------------------------------------------------------------------

template <int D>
VertexRow<D> DiffBuilder<D>::RowOf(VertexId id, const Vertex& v, const FeatureTable<D>& features) {
  return {id, v.p.c, v.dimension, features.IdOf(v.feature)};
}

// Clears columns without a region; lists the sets of polygons that the others name.
template <int D>
void DiffBuilder<D>::NameRegions(std::initializer_list<RegionColumn*> columns,
                                 std::vector<RegionSet>* sets) const {
  std::vector<RegionId> ids;
  for (RegionColumn* column : columns) {
    mesh_data::DropIfIdle(*column);
    for (const RegionId id : *column) {
      if (ids.empty() || ids.back() != id) ids.push_back(id);
    }
  }
  if (!ids.empty()) *sets = labels_.SetsOf(&ids);
}

template <int D>
void DiffBuilder<D>::AddWall(const typename Labels::Side& side, meshing::FeatureSlot slot,
                             const FeatureTable<D>& features) {
  const auto owners = features.OwnersOfWall(slot);
  if (!owners.empty()) labels_.AddWall(side, owners);
}

template <int D>
absl::Status DiffBuilder<D>::RegionStatus() const {
  if (triangulation_.is_full()) return SizeLimitError();
  if (const auto polygons = labels_.overfull(); !polygons.empty()) {
    return TooManyPolygonsError(D, polygons);
  }
  const auto collision = labels_.collision();
  return collision ? CollisionError(D, *collision) : absl::OkStatus();
}

template <int D>
absl::Status DiffBuilder<D>::NameStatus(const Source& mesher,
                                        const FeatureTable<D>& features) const {
  const Elements& elements = mesher.elements();
  const auto clash =
      names_.Clash([&](VertexIndex v) -> const Point& { return elements.vertex(v).p; });
  if (!clash) return absl::OkStatus();
  std::array<NamedVertex, 2> named;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vertex& vertex = elements.vertex((*clash)[i]);
    named[i] = {{vertex.p.c.begin(), vertex.p.c.end()}, features.IdOf(vertex.feature)};
  }
  return VertexIdError(named);
}

// --- The whole mesh -------------------------------------------------------------------

template <int D>
Mesh DiffBuilder<D>::Begin(Source& mesher, const FeatureTable<D>& features, Steps& steps) {
  mesher.TakeChanges([](VertexIndex, bool, bool) {}, [](SubsegmentIndex, bool, bool) {});
  const Elements& elements = mesher.elements();
  names_.Reserve(elements.vertex_count());
  std::vector<VertexIndex> all,
      missing;  // the triangulation may have been filled during refinement
  all.reserve(elements.vertex_count());
  elements.ForEachVertex([&](VertexIndex v, const Vertex&) {
    all.push_back(v);
    if (!triangulation_.Contains(v)) missing.push_back(v);
  });
  FillTriangulation(elements, missing, steps);
  if (triangulation_.is_full()) return {};
  ConstrainTriangulation(elements, steps);
  for (std::span<const VertexIndex> rest = all; !rest.empty() && !steps.Stop(Steps::kBetween);) {
    const std::size_t count = std::min(rest.size(), Steps::kBetween);
    names_.AddAll(rest.first(count),
                  [&](VertexIndex v) -> const Point& { return elements.vertex(v).p; });
    rest = rest.subspan(count);
  }
  if (steps.stopped()) return {};
  if constexpr (D == 2) {
    elements.ForEachSubsegment(
        [&](const Subsegment& s) { AddWall(SideOf(s), s.feature, features); });
  } else if (features.has_facets()) {
    triangulation_.ForEachSimplex(
        [&](Simplex t) { subfacets_.Add(triangulation_.vertices(t), FacetsIn(mesher)); });
    subfacets_.ClearChanges();
    subfacets_.ForEach([&](const SubfacetTable::Face& face, meshing::FeatureSlot slot) {
      AddWall(face, slot, features);
    });
  }
  labels_.LabelAll(steps);
  if (steps.stopped() || !RegionStatus().ok()) return {};
  Mesh mesh = Snapshot(mesher, features, steps);
  if (steps.stopped()) return {};
  subsegment_count_ = mesh.subsegments.size();
  hash_ = mesh.hash = mesh_data::ComputeHash(mesh, steps);
  return mesh;
}

// Steiner points of long edges first, the input last. This keeps the number of simplices per vertex
// small; it would be large among points of curves in 3D.
template <int D>
void DiffBuilder<D>::FillTriangulation(const Elements& elements, std::vector<VertexIndex>& missing,
                                       Steps& steps) {
  const auto bucket = [&](VertexIndex v) {
    return meshing::BucketOfEpoch(elements.vertex(v).epoch);
  };
  triangulation_.Reserve(elements.vertex_count());
  std::stable_sort(missing.begin(), missing.end(),
                   [&](VertexIndex a, VertexIndex b) { return bucket(a) > bucket(b); });
  std::vector<Point> points;
  std::vector<VertexIndex> ordered;
  for (std::size_t from = 0, to = 0; from < missing.size(); from = to) {
    points.clear();
    for (; to < missing.size() && bucket(missing[to]) == bucket(missing[from]); ++to) {
      points.push_back(elements.vertex(missing[to]).p);
    }
    // In chunks of neighbouring points.
    ordered.clear();
    for (const std::uint32_t i : delaunay::InsertOrder(points, steps)) {
      ordered.push_back(missing[from + i]);
    }
    for (std::size_t at = 0; at < ordered.size(); at += Steps::kBetween) {
      if (steps.Stop(Steps::kBetween)) return;
      const auto part =
          std::span(ordered).subspan(at, std::min(Steps::kBetween, ordered.size() - at));
      points.clear();
      for (const VertexIndex v : part) points.push_back(elements.vertex(v).p);
      triangulation_.InsertAll(part, points);
    }
  }
}

template <int D>
void DiffBuilder<D>::ConstrainTriangulation(const Elements& elements, Steps& steps) {
  if constexpr (D == 2) {
    if (!is_constrained_ || steps.stopped()) return;
    elements.ForEachSubsegment([&](const Subsegment& s) {
      if (!steps.Stop()) triangulation_.AddSegment(s.a, s.b);
    });
  }
}

template <int D>
Mesh DiffBuilder<D>::Snapshot(const Source& mesher, const FeatureTable<D>& features,
                              Steps& steps) const {
  Mesh mesh;
  mesh.dimension = D;
  Reserve(mesh.vertices, D, triangulation_.vertex_count());
  mesher.elements().ForEachTakenVertex([&](VertexIndex v, const Vertex& vertex) {
    if (!steps.Stop()) Append(mesh.vertices, RowOf(names_.at(v), vertex, features));
  });
  if (steps.stopped()) return mesh;
  mesh.simplices.resize((D + 1) * triangulation_.simplex_count());
  auto next = mesh.simplices.begin();
  triangulation_.ForEachSimplex([&](Simplex t) {
    if (steps.Stop()) return;
    next = std::ranges::copy(CanonicalIds(t), next).out;
  });
  if (steps.stopped()) return mesh;
  if (!labels_.empty()) {
    mesh.regions.reserve(triangulation_.simplex_count());
    triangulation_.ForEachSimplex([&](Simplex t) { mesh.regions.push_back(labels_.at(t)); });
    NameRegions({&mesh.regions}, &mesh.region_sets);
  }
  mesher.elements().ForEachTakenSubsegment([&](const Subsegment& s) {
    Append(mesh.subsegments,
           ConstraintRowOf(NewIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  });
  subfacets_.ForEach([&](const SubfacetTable::Face& face, meshing::FeatureSlot slot) {
    Append(mesh.subfacets, ConstraintRowOf(NewIds(face), features.IdOf(slot)));
  });
  mesh.hash = hash_;
  return mesh;
}

// --- Changes --------------------------------------------------------------------------

template <int D>
MeshDiff DiffBuilder<D>::Update(Source& mesher, const FeatureTable<D>& features) {
  const Elements& elements = mesher.elements();
  TakeChanges(mesher);
  UpdateNames(elements);
  UpdateTriangulation(mesher);
  if (triangulation_.is_full()) return {};
  UpdateSubfacets(mesher, features);
  UpdateWalls(elements, features);
  UpdateLabels(elements, features);
  if (!RegionStatus().ok()) return {};
  if (!renamed_.empty()) AddSimplicesOfRenamed();
  MeshDiff diff;
  diff.dimension = D;
  ReportVertices(elements, features, &diff);
  ReportSubsegments(elements, features, &diff);
  ReportSubfacets(features, &diff);
  ReportSimplices(&diff);
  diff.hash = hash_;
  labels_.Collect();
  return diff;
}

template <int D>
void DiffBuilder<D>::TakeChanges(Source& mesher) {
  vertices_.Clear();
  subsegments_.Clear();
  mesher.TakeChanges(
      [&](VertexIndex v, bool is, bool was) {
        if (is != was) (is ? vertices_.come : vertices_.gone).push_back(v);
      },
      [&](SubsegmentIndex s, bool is, bool was) {
        if (is != was) (is ? subsegments_.come : subsegments_.gone).push_back(s);
      });
}

// Ids of removed vertices stay readable by OldId, like those of renamed ones.
template <int D>
void DiffBuilder<D>::UpdateNames(const Elements& elements) {
  renamed_.Clear();
  const auto position = [&](VertexIndex v) -> const Point& { return elements.vertex(v).p; };
  const auto keep_old = [&](VertexIndex v) {
    if (triangulation_.Contains(v)) renamed_.Add(v, names_.at(v));  // was in the mesh
  };
  for (const VertexIndex v : vertices_.gone) names_.Remove(v, position, keep_old);
  for (const VertexIndex v : vertices_.come) names_.Add(v, position, keep_old);
  renamed_.Close([this](VertexIndex v) { return names_.at(v); });
}

// Removals first: an added vertex may have the same coordinates. Segments have their ends among the
// vertices.
template <int D>
void DiffBuilder<D>::UpdateTriangulation(const Source& mesher) {
  simplices_.Clear();
  fresh_.clear();
  [[maybe_unused]] const auto for_each_segment = [&](const std::vector<SubsegmentIndex>& segments,
                                                     auto change) {
    if (!is_constrained_) return;
    for (const SubsegmentIndex i : segments) {
      const Subsegment& s = mesher.elements().subsegment(i);
      (triangulation_.*change)(s.a, s.b);
      RecordSimplices();
    }
  };
  if constexpr (D == 2) for_each_segment(subsegments_.gone, &Triangulation::RemoveSegment);
  for (const VertexIndex v : vertices_.gone) {
    triangulation_.Remove(v);
    RecordSimplices();
  }
  if (triangulation_.is_full()) return;
  for (const VertexIndex v : vertices_.come) {
    InsertVertex(mesher, v);
    RecordSimplices();
  }
  if constexpr (D == 2) for_each_segment(subsegments_.come, &Triangulation::AddSegment);
  // Some were removed again, some indices were reused.
  std::erase_if(fresh_, [&](auto t) { return triangulation_.IsInfinite(t); });
  std::sort(fresh_.begin(), fresh_.end());
  fresh_.erase(std::unique(fresh_.begin(), fresh_.end()), fresh_.end());
}

// A vertex that was near when v was made is a good start of the search.
template <int D>
void DiffBuilder<D>::InsertVertex(const Source& mesher, VertexIndex v) {
  VertexIndex near = 0;
  mesher.ForSomeNeighbours(v, [&](VertexIndex u) {
    if (!triangulation_.Contains(u)) return false;
    near = u;
    return true;
  });
  triangulation_.Insert(v, mesher.elements().vertex(v).p, near);
}

// A simplex that the same update adds and removes does not appear.
template <int D>
void DiffBuilder<D>::RecordSimplices() {
  const auto deleted = triangulation_.deleted();
  const auto labels = triangulation_.deleted_tags();
  for (std::size_t i = 0; i < deleted.size(); ++i) {
    if (!IsFinite(deleted[i]) || labels[i] == Labels::kPending) continue;
    simplices_.gone.push_back({InCanonicalOrder(deleted[i]), labels[i]});
  }
  for (const auto t : triangulation_.created()) {
    if (triangulation_.IsInfinite(t)) continue;
    triangulation_.set_tag(t, Labels::kPending);
    fresh_.push_back(t);
  }
}

template <int D>
typename DiffBuilder<D>::IndexRow DiffBuilder<D>::RowOf(Simplex t) const {
  return {InCanonicalOrder(triangulation_.vertices(t)), labels_.at(t)};
}

// Subfacets that stay under other vertex ids are removed and added, too.
template <int D>
void DiffBuilder<D>::UpdateSubfacets(const Source& mesher, const FeatureTable<D>& features) {
  if constexpr (D == 3) {
    subfacets_.ClearChanges();
    if (!features.has_facets() && subfacets_.size() == 0) return;
    const auto facet_of = FacetsIn(mesher);
    const auto vertices = [&](Simplex t) { return triangulation_.vertices(t); };
    for (const meshing::FeatureSlot slot : features.gone_facets()) subfacets_.RemoveFacet(slot);
    for (const IndexRow& row : simplices_.gone) subfacets_.Remove(row.v);
    ForEachRenamed([&](Simplex t) { subfacets_.Remove(vertices(t)); });
    for (const Simplex t : fresh_) subfacets_.Add(vertices(t), facet_of);
    ForEachRenamed([&](Simplex t) { subfacets_.Add(vertices(t), facet_of); });
    for (const auto& facet : features.new_facets()) {
      subfacets_.AddFacet(facet.slot, facet.corners, triangulation_, facet_of);
    }
  }
}

// Removals first: an added subsegment may have the same ends.
template <int D>
void DiffBuilder<D>::UpdateWalls(const Elements& elements, const FeatureTable<D>& features) {
  if constexpr (D == 2) {
    for (const SubsegmentIndex i : subsegments_.gone) {
      const Subsegment& s = elements.subsegment(i);
      labels_.RemoveWall(SideOf(s));
    }
    for (const SubsegmentIndex i : subsegments_.come) {
      const Subsegment& s = elements.subsegment(i);
      AddWall(SideOf(s), s.feature, features);
    }
  } else {
    for (const auto& [face, slot] : subfacets_.gone()) labels_.RemoveWall(face);
    for (const auto& [face, slot] : subfacets_.come()) AddWall(face, slot, features);
    for (const meshing::FeatureSlot slot : features.resurfaced_facets()) {
      subfacets_.ForEachOf(slot, [&](const SubfacetTable::Face& face) {
        labels_.RemoveWall(face);
        AddWall(face, slot, features);
      });
    }
  }
}

template <int D>
void DiffBuilder<D>::UpdateLabels(const Elements& elements, const FeatureTable<D>& features) {
  const auto& relabelled = labels_.Update(fresh_, features.toggled_walls(), [&](VertexIndex v) {
    const int dimension = elements.vertex(v).dimension;
    return 0 < dimension && dimension < D;
  });
  for (const auto t : fresh_) simplices_.come.push_back(RowOf(t));
  for (const auto& [t, before] : relabelled) {
    simplices_.come.push_back(RowOf(t));
    simplices_.gone.push_back({simplices_.come.back().v, before});
  }
}

// Calls f(t) for the simplices at renamed vertices, for some of them several times.
template <int D>
template <class F>
void DiffBuilder<D>::ForEachRenamed(F f) const {
  for (const auto& r : renamed_) {
    if (!triangulation_.Contains(r.v)) continue;
    triangulation_.ForEachSimplexAround(r.v, [&](Simplex t) {
      if (!triangulation_.IsInfinite(t)) f(t);
    });
  }
}

// Simplices that stay under other vertex ids.
template <int D>
void DiffBuilder<D>::AddSimplicesOfRenamed() {
  simplices_.Net();
  stay_.clear();
  ForEachRenamed([&](Simplex t) { stay_.push_back(RowOf(t)); });
  std::sort(stay_.begin(), stay_.end());
  stay_.erase(std::unique(stay_.begin(), stay_.end()), stay_.end());
  std::erase_if(stay_, [&](const IndexRow& row) {
    return std::binary_search(simplices_.come.begin(), simplices_.come.end(), row);
  });
  simplices_.gone.insert(simplices_.gone.end(), stay_.begin(), stay_.end());
  simplices_.come.insert(simplices_.come.end(), stay_.begin(), stay_.end());
}

template class DiffBuilder<2>;
template class DiffBuilder<3>;

}  // namespace dynmesh
