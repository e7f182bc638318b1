#include "core/dynamic_mesh/diff_builder.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <string>

#include "core/data/canonical_order.h"
#include "core/data/regions.h"
#include "core/data/whole_mesh.h"
#include "core/dynamic_mesh/limits.h"
#include "core/mesh/delaunay_insert_order.h"
#include "core/meshing/facet_membership.h"
#include "core/meshing/neighbours.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

using data::InCanonicalOrder;
using meshing::SubsegmentIndex;
using meshing::VertexIndex;

template <std::size_t N>
bool IsFinite(const std::array<VertexIndex, N>& v) {
  return std::find(v.begin(), v.end(), mesh::DelaunayTriangulation::kInfinite) == v.end();
}

template <class Refinement>
auto FacetsOf(const Refinement& refinement) {
  return [&](VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) {
    const meshing::FacetIndex facet = meshing::FacetOf(refinement.complex(), a, b, c, d);
    return facet == meshing::kNil ? meshing::kNil : refinement.complex().facets[facet].feature();
  };
}

std::string Shortest(double x) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

// "{1, 2, 5, and 3 more}"
std::string ListOf(const std::vector<FeatureId>& polygons) {
  constexpr std::size_t kMost = 4;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMost, polygons.size()); ++i) {
    list += (i == 0 ? "{" : ", ") + std::to_string(polygons[i]);
  }
  if (polygons.size() > kMost) list += ", and " + std::to_string(polygons.size() - kMost) + " more";
  return list + "}";
}

absl::Status CollisionError(int dimension, const RegionSets::Collision& collision) {
  const auto& [first, second] = collision;
  // A polygon that is not in both.
  std::vector<FeatureId> either;
  std::ranges::set_symmetric_difference(first, second, std::back_inserter(either));
  const FeatureId id = either.back();
  const std::string what = dimension == 2 ? "polygons " : "closed surfaces ";
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      (second.empty() ? "the region of " + what + ListOf(first) + " would have a reserved id"
                      : "the regions of " + what + ListOf(first) + " and " + ListOf(second) +
                            " would have the same id") +
          ", a hash of polygons' ids; give polygon " + std::to_string(id) + " another id",
      {reason::kIdCollision, {id}, {}});
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

template <int D>
void DiffBuilder<D>::AppendAll(const std::vector<SimplexRow<D>>& rows, SimplexColumn* simplices,
                               RegionColumn* regions) {
  simplices->reserve((D + 1) * rows.size());
  if (!labels_.empty()) regions->reserve(rows.size());
  for (const SimplexRow<D>& row : rows) {
    simplices->insert(simplices->end(), row.ids.begin(), row.ids.end());
    if (!labels_.empty()) regions->push_back(row.region);
  }
}

// Clears columns without a region; lists the sets of polygons that the others name.
template <int D>
void DiffBuilder<D>::NameRegions(std::initializer_list<RegionColumn*> columns,
                                 std::vector<RegionSet>* sets) const {
  std::vector<RegionId> ids;
  for (RegionColumn* column : columns) {
    data::DropIfIdle(*column);
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
  const auto polygons = labels_.overfull();
  if (polygons.empty()) {
    const auto collision = labels_.collision();
    return collision ? CollisionError(D, *collision) : absl::OkStatus();
  }
  const FeatureId last = polygons.back();
  return MakeError(absl::StatusCode::kResourceExhausted,
                   (D == 2 ? "polygon " : "the closed surface of polygon ") + std::to_string(last) +
                       " lies over " + std::to_string(polygons.size() - 1) + " others, " +
                       std::to_string(polygons[0]) + " and " + std::to_string(polygons[1]) +
                       " among them, and no place may lie in more than " +
                       std::to_string(kMostPolygonsAtAPlace) +
                       " polygons; move or remove some of them",
                   {reason::kPolygonLimit, {last}, {}});
}

template <int D>
template <class Refinement>
absl::Status DiffBuilder<D>::NameStatus(const Refinement& refinement,
                                        const FeatureTable<D>& features) const {
  const auto clash =
      names_.Clash([&](VertexIndex v) -> const Point& { return refinement.vertex(v).p; });
  if (!clash) return absl::OkStatus();
  std::string places;
  std::vector<FeatureId> owners;
  for (const VertexIndex v : *clash) {
    places += places.empty() ? "the vertices at (" : " and (";
    const Point& p = refinement.vertex(v).p;
    for (int k = 0; k < D; ++k) places += (k == 0 ? "" : ", ") + Shortest(p[k]);
    places += ")";
    const FeatureId owner = features.IdOf(refinement.vertex(v).feature);
    if (owner == kNoFeature || owner == kBoxFeature) continue;
    places += " on feature " + std::to_string(owner);
    if (std::ranges::find(owners, owner) == owners.end()) owners.push_back(owner);
  }
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   places +
                       " would have the same id, a hash of coordinates; move one of the "
                       "features a little",
                   {reason::kIdCollision, owners, {}});
}

// --- The whole mesh -------------------------------------------------------------------

template <int D>
template <class Refinement>
Mesh DiffBuilder<D>::Begin(Refinement& refinement, const FeatureTable<D>& features, Steps& steps) {
  refinement.TakeChanges([](VertexIndex, bool, bool) {}, [](SubsegmentIndex, bool, bool) {});
  names_.Reserve(refinement.vertex_count());
  std::vector<VertexIndex> all,
      missing;  // the triangulation may have been filled during refinement
  all.reserve(refinement.vertex_count());
  refinement.elements().ForEachVertex([&](VertexIndex v, const Vertex&) {
    all.push_back(v);
    if (!triangulation_.Contains(v)) missing.push_back(v);
  });
  FillTriangulation(refinement, missing, steps);
  if (triangulation_.is_full()) return {};
  for (std::span<const VertexIndex> rest = all; !rest.empty() && !steps.Stop(Steps::kBetween);) {
    const std::size_t count = std::min(rest.size(), Steps::kBetween);
    names_.AddAll(rest.first(count),
                  [&](VertexIndex v) -> const Point& { return refinement.vertex(v).p; });
    rest = rest.subspan(count);
  }
  if (steps.stopped()) return {};
  if constexpr (D == 2) {
    refinement.elements().ForEachSubsegment(
        [&](const Subsegment& s) { AddWall(SideOf(s), s.feature, features); });
  } else if (features.has_facets()) {
    triangulation_.ForEachSimplex(
        [&](Simplex t) { subfacets_.Add(triangulation_.vertices(t), FacetsOf(refinement)); });
    subfacets_.ClearChanges();
    subfacets_.ForEach([&](const SubfacetTable::Face& face, meshing::FeatureSlot slot) {
      AddWall(face, slot, features);
    });
  }
  labels_.LabelAll(steps);
  if (steps.stopped() || !RegionStatus().ok()) return {};
  Mesh mesh = Snapshot(refinement, features, steps);
  if (steps.stopped()) return {};
  subsegment_count_ = mesh.subsegments.size();
  hash_ = mesh.hash = data::ComputeHash(mesh, steps);
  return mesh;
}

// Steiner points of long edges first, the input last. This keeps the number of simplices per vertex
// small; it would be large among points of curves in 3D.
template <int D>
template <class Refinement>
void DiffBuilder<D>::FillTriangulation(const Refinement& refinement,
                                       std::vector<VertexIndex>& missing, Steps& steps) {
  const auto bucket = [&](VertexIndex v) {
    return meshing::BucketOfEpoch(refinement.vertex(v).epoch);
  };
  triangulation_.Reserve(refinement.vertex_count());
  std::stable_sort(missing.begin(), missing.end(),
                   [&](VertexIndex a, VertexIndex b) { return bucket(a) > bucket(b); });
  std::vector<Point> places;
  std::vector<VertexIndex> ordered;
  for (std::size_t from = 0, to = 0; from < missing.size(); from = to) {
    places.clear();
    for (; to < missing.size() && bucket(missing[to]) == bucket(missing[from]); ++to) {
      places.push_back(refinement.vertex(missing[to]).p);
    }
    // In chunks of neighbouring points.
    ordered.clear();
    for (const std::uint32_t i : mesh::InsertOrder(places, steps)) {
      ordered.push_back(missing[from + i]);
    }
    for (std::size_t at = 0; at < ordered.size(); at += Steps::kBetween) {
      if (steps.Stop(Steps::kBetween)) return;
      const auto piece =
          std::span(ordered).subspan(at, std::min(Steps::kBetween, ordered.size() - at));
      places.clear();
      for (const VertexIndex v : piece) places.push_back(refinement.vertex(v).p);
      triangulation_.InsertAll(piece, places);
    }
  }
}

template <int D>
template <class Refinement>
Mesh DiffBuilder<D>::Snapshot(const Refinement& refinement, const FeatureTable<D>& features,
                              Steps& steps) const {
  Mesh mesh;
  mesh.dimension = D;
  Reserve(mesh.vertices, D, triangulation_.vertex_count());
  refinement.elements().ForEachTakenVertex([&](VertexIndex v, const Vertex& vertex) {
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
  refinement.elements().ForEachTakenSubsegment([&](const Subsegment& s) {
    Append(mesh.subsegments, PieceRowOf(NewIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  });
  subfacets_.ForEach([&](const SubfacetTable::Face& face, meshing::FeatureSlot slot) {
    Append(mesh.subfacets, PieceRowOf(NewIds(face), features.IdOf(slot)));
  });
  mesh.hash = hash_;
  return mesh;
}

// --- Changes --------------------------------------------------------------------------

template <int D>
template <class Refinement>
MeshDiff DiffBuilder<D>::Update(Refinement& refinement, const FeatureTable<D>& features) {
  TakeChanges(refinement);
  UpdateNames(refinement);
  UpdateTriangulation(refinement);
  if (triangulation_.is_full()) return {};
  UpdateSubfacets(refinement, features);
  UpdateWalls(refinement, features);
  UpdateLabels(refinement, features);
  if (!RegionStatus().ok()) return {};
  if (!renamed_.empty()) AddSimplicesOfRenamed();
  MeshDiff diff;
  diff.dimension = D;
  ReportVertices(refinement, features, &diff);
  ReportSubsegments(refinement, features, &diff);
  ReportSubfacets(features, &diff);
  ReportSimplices(&diff);
  diff.hash = hash_;
  labels_.Collect();
  return diff;
}

template <int D>
template <class Refinement>
void DiffBuilder<D>::TakeChanges(Refinement& refinement) {
  vertices_.Clear();
  subsegments_.Clear();
  refinement.TakeChanges(
      [&](VertexIndex v, bool is, bool was) {
        if (is != was) (is ? vertices_.come : vertices_.gone).push_back(v);
      },
      [&](SubsegmentIndex s, bool is, bool was) {
        if (is != was) (is ? subsegments_.come : subsegments_.gone).push_back(s);
      });
}

// Ids of removed vertices stay readable by OldId, like those of renamed ones.
template <int D>
template <class Refinement>
void DiffBuilder<D>::UpdateNames(const Refinement& refinement) {
  renamed_.clear();
  const auto position = [&](VertexIndex v) -> const Point& { return refinement.vertex(v).p; };
  const auto keep_old = [&](VertexIndex v) {
    if (triangulation_.Contains(v)) renamed_.push_back({v, names_.at(v)});  // was in the mesh
  };
  for (const VertexIndex v : vertices_.gone) names_.Remove(v, position, keep_old);
  for (const VertexIndex v : vertices_.come) names_.Add(v, position, keep_old);
  if (renamed_.empty()) return;
  // Of a vertex renamed several times, the first entry counts.
  std::stable_sort(renamed_.begin(), renamed_.end(),
                   [](const Renamed& a, const Renamed& b) { return a.v < b.v; });
  const auto again = std::unique(renamed_.begin(), renamed_.end(),
                                 [](const Renamed& a, const Renamed& b) { return a.v == b.v; });
  renamed_.erase(again, renamed_.end());
  std::erase_if(renamed_, [&](const Renamed& r) { return names_.at(r.v) == r.old_id; });
}

// Removals first: an added vertex may have the same coordinates.
template <int D>
template <class Refinement>
void DiffBuilder<D>::UpdateTriangulation(const Refinement& refinement) {
  simplices_.Clear();
  fresh_.clear();
  for (const VertexIndex v : vertices_.gone) {
    triangulation_.Remove(v);
    RecordSimplices();
  }
  if (triangulation_.is_full()) return;
  for (const VertexIndex v : vertices_.come) {
    InsertVertex(refinement, v);
    RecordSimplices();
  }
  // Some were removed again, some indices were reused.
  std::erase_if(fresh_, [&](auto t) { return triangulation_.IsInfinite(t); });
  std::sort(fresh_.begin(), fresh_.end());
  fresh_.erase(std::unique(fresh_.begin(), fresh_.end()), fresh_.end());
}

// A neighbour in the refinement is a good start of the search.
template <int D>
template <class Refinement>
void DiffBuilder<D>::InsertVertex(const Refinement& refinement, VertexIndex v) {
  VertexIndex near = 0;
  meshing::ForSomeNeighbours(refinement.complex(), v, [&](VertexIndex u) {
    if (!triangulation_.Contains(u)) return false;
    near = u;
    return true;
  });
  triangulation_.Insert(v, refinement.vertex(v).p, near);
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
template <class Refinement>
void DiffBuilder<D>::UpdateSubfacets(const Refinement& refinement,
                                     const FeatureTable<D>& features) {
  if constexpr (D == 3) {
    subfacets_.ClearChanges();
    if (!features.has_facets() && subfacets_.size() == 0) return;
    const auto facet_of = FacetsOf(refinement);
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
template <class Refinement>
void DiffBuilder<D>::UpdateWalls(const Refinement& refinement, const FeatureTable<D>& features) {
  if constexpr (D == 2) {
    for (const SubsegmentIndex i : subsegments_.gone) {
      const Subsegment& s = refinement.subsegment(i);
      labels_.RemoveWall(SideOf(s));
    }
    for (const SubsegmentIndex i : subsegments_.come) {
      const Subsegment& s = refinement.subsegment(i);
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
template <class Refinement>
void DiffBuilder<D>::UpdateLabels(const Refinement& refinement, const FeatureTable<D>& features) {
  const auto& relabelled = labels_.Update(fresh_, features.toggled_walls(), [&](VertexIndex v) {
    const int dimension = refinement.vertex(v).dimension;
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
  for (const Renamed& r : renamed_) {
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

template <int D>
bool DiffBuilder<D>::IsRenamed(VertexIndex v) const {
  return std::binary_search(renamed_.begin(), renamed_.end(), Renamed{v, 0},
                            [](const Renamed& a, const Renamed& b) { return a.v < b.v; });
}

template <int D>
VertexId DiffBuilder<D>::OldIdOfRenamed(VertexIndex v) const {
  const auto it = std::lower_bound(renamed_.begin(), renamed_.end(), v,
                                   [](const Renamed& r, VertexIndex w) { return r.v < w; });
  return it != renamed_.end() && it->v == v ? it->old_id : names_.at(v);
}

template <int D>
template <class Row>
void DiffBuilder<D>::NetAndHash(Rows<Row>* rows) {
  rows->Net();
  for (const Row& row : rows->gone) hash_ -= HashOf(row);
  for (const Row& row : rows->come) hash_ += HashOf(row);
}

template <int D>
template <int N, class Columns>
void DiffBuilder<D>::Report(Rows<PieceRow<N>>* rows, Columns* removed, Columns* added) {
  NetAndHash(rows);
  for (const PieceRow<N>& row : rows->gone) Append(*removed, row);
  for (const PieceRow<N>& row : rows->come) Append(*added, row);
}

// Vertices with equal rows before and after are not reported.
template <int D>
template <class Refinement>
void DiffBuilder<D>::ReportVertices(const Refinement& refinement, const FeatureTable<D>& features,
                                    MeshDiff* diff) {
  vertex_rows_.Clear();
  for (const VertexIndex v : vertices_.gone) {
    vertex_rows_.gone.push_back(RowOf(OldId(v), refinement.vertex(v), features));
  }
  for (const VertexIndex v : vertices_.come) {
    vertex_rows_.come.push_back(RowOf(names_.at(v), refinement.vertex(v), features));
  }
  for (const Renamed& r : renamed_) {
    if (!triangulation_.Contains(r.v)) continue;
    vertex_rows_.gone.push_back(RowOf(r.old_id, refinement.vertex(r.v), features));
    vertex_rows_.come.push_back(RowOf(names_.at(r.v), refinement.vertex(r.v), features));
  }
  NetAndHash(&vertex_rows_);
  diff->removed_vertices.reserve(vertex_rows_.gone.size());
  Reserve(diff->added_vertices, D, vertex_rows_.come.size());
  for (const VertexRow<D>& row : vertex_rows_.gone) diff->removed_vertices.push_back(row.id);
  for (const VertexRow<D>& row : vertex_rows_.come) Append(diff->added_vertices, row);
}

template <int D>
template <class Refinement>
void DiffBuilder<D>::ReportSubsegments(const Refinement& refinement,
                                       const FeatureTable<D>& features, MeshDiff* diff) {
  subsegment_rows_.Clear();
  const auto goes = [&](const Subsegment& s) {
    subsegment_rows_.gone.push_back(
        PieceRowOf(OldIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  };
  const auto comes = [&](const Subsegment& s) {
    subsegment_rows_.come.push_back(
        PieceRowOf(NewIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  };
  for (const SubsegmentIndex s : subsegments_.gone) goes(refinement.subsegment(s));
  for (const SubsegmentIndex s : subsegments_.come) comes(refinement.subsegment(s));
  if (!renamed_.empty()) {
    refinement.elements().ForEachSubsegment([&](const Subsegment& s) {
      if (!IsRenamed(s.a) && !IsRenamed(s.b)) return;
      for (const SubsegmentIndex i : subsegments_.come) {
        if (&refinement.subsegment(i) == &s) return;
      }
      goes(s);
      comes(s);
    });
  }
  Report(&subsegment_rows_, &diff->removed_subsegments, &diff->added_subsegments);
  subsegment_count_ += subsegment_rows_.come.size();
  subsegment_count_ -= subsegment_rows_.gone.size();
}

template <int D>
void DiffBuilder<D>::ReportSubfacets(const FeatureTable<D>& features, MeshDiff* diff) {
  if constexpr (D == 3) {
    subfacet_rows_.Clear();
    for (const auto& [face, slot] : subfacets_.gone()) {
      subfacet_rows_.gone.push_back(PieceRowOf(OldIds(face), features.IdOf(slot)));
    }
    for (const auto& [face, slot] : subfacets_.come()) {
      subfacet_rows_.come.push_back(PieceRowOf(NewIds(face), features.IdOf(slot)));
    }
    Report(&subfacet_rows_, &diff->removed_subfacets, &diff->added_subfacets);
  }
}

// Nets again by ids: an added vertex may have the id of a removed one.
template <int D>
void DiffBuilder<D>::ReportSimplices(MeshDiff* diff) {
  simplex_rows_.Clear();
  for (const auto& [v, region] : simplices_.gone) {
    simplex_rows_.gone.push_back({InCanonicalOrder(OldIds(v)), region});
  }
  for (const auto& [v, region] : simplices_.come) {
    simplex_rows_.come.push_back({InCanonicalOrder(NewIds(v)), region});
  }
  NetAndHash(&simplex_rows_);
  AppendAll(simplex_rows_.gone, &diff->removed_simplices, &diff->removed_regions);
  AppendAll(simplex_rows_.come, &diff->added_simplices, &diff->added_regions);
  NameRegions({&diff->removed_regions, &diff->added_regions}, &diff->region_sets);
}

template class DiffBuilder<2>;
template class DiffBuilder<3>;

template <int D>
using Traced = meshing::Refinement<D, sac::Engine>;
template <int D>
using Untraced = meshing::Refinement<D, sac::UntracedEngine>;
template Mesh DiffBuilder<2>::Begin(Traced<2>&, const FeatureTable<2>&, Steps&);
template absl::Status DiffBuilder<2>::NameStatus(const Traced<2>&, const FeatureTable<2>&) const;
template Mesh DiffBuilder<2>::Begin(Untraced<2>&, const FeatureTable<2>&, Steps&);
template absl::Status DiffBuilder<2>::NameStatus(const Untraced<2>&, const FeatureTable<2>&) const;
template MeshDiff DiffBuilder<2>::Update(Traced<2>&, const FeatureTable<2>&);
template Mesh DiffBuilder<2>::Snapshot(const Traced<2>&, const FeatureTable<2>&, Steps&) const;
template Mesh DiffBuilder<3>::Begin(Traced<3>&, const FeatureTable<3>&, Steps&);
template absl::Status DiffBuilder<3>::NameStatus(const Traced<3>&, const FeatureTable<3>&) const;
template Mesh DiffBuilder<3>::Begin(Untraced<3>&, const FeatureTable<3>&, Steps&);
template absl::Status DiffBuilder<3>::NameStatus(const Untraced<3>&, const FeatureTable<3>&) const;
template MeshDiff DiffBuilder<3>::Update(Traced<3>&, const FeatureTable<3>&);
template Mesh DiffBuilder<3>::Snapshot(const Traced<3>&, const FeatureTable<3>&, Steps&) const;

}  // namespace dynmesh
