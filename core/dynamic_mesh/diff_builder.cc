#include "core/dynamic_mesh/diff_builder.h"

#include <algorithm>
#include <string>

#include "core/data/canonical_order.h"
#include "core/data/regions.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

using data::InCanonicalOrder;
using Subsegment = meshing::Subsegment<2>;
using meshing::SubsegmentIndex;
using Vertex = meshing::Vertex<2>;
using meshing::VertexIndex;
using Triangulation = mesh::DelaunayTriangulation;

void Reserve(VertexColumns& columns, std::size_t rows) {
  columns.ids.reserve(rows);
  columns.coordinates.reserve(2 * rows);
  columns.containing_dimensions.reserve(rows);
  columns.owners.reserve(rows);
}

bool IsFinite(const std::array<VertexIndex, 3>& v) {
  return v[0] != Triangulation::kInfinite && v[1] != Triangulation::kInfinite &&
         v[2] != Triangulation::kInfinite;
}

// Takes away what stands in both, and leaves the rest sorted.
template <class T>
void Cancel(std::vector<T>& a, std::vector<T>& b) {
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  auto i = a.begin(), j = b.begin(), only_a = a.begin(), only_b = b.begin();
  while (i != a.end() && j != b.end()) {
    if (*i < *j) {
      *only_a++ = *i++;
    } else if (*j < *i) {
      *only_b++ = *j++;
    } else {
      ++i, ++j;
    }
  }
  a.erase(std::copy(i, a.end(), only_a), a.end());
  b.erase(std::copy(j, b.end(), only_b), b.end());
}

}  // namespace

template <class Row>
void DiffBuilder::Rows<Row>::Net() {
  Cancel(gone, come);
}

// --- Rows -----------------------------------------------------------------------------

DiffBuilder::VertexRow DiffBuilder::RowOf(VertexId id, const Vertex& v,
                                          const FeatureTable& features) {
  return {id, v.p.c, v.dimension, features.IdOf(v.feature)};
}

DiffBuilder::SubsegmentRow DiffBuilder::RowOf(VertexId a, VertexId b, FeatureId owner) {
  return {{std::min(a, b), std::max(a, b)}, owner};
}

void DiffBuilder::Append(VertexColumns& to, const VertexRow& row) {
  to.ids.push_back(row.id);
  for (const double c : row.coordinates) to.coordinates.push_back(c);
  to.containing_dimensions.push_back(static_cast<std::uint8_t>(row.dimension));
  to.owners.push_back(row.owner);
}

void DiffBuilder::Append(SubsegmentColumns& to, const SubsegmentRow& row) {
  for (const VertexId end : row.ends) to.ends.push_back(end);
  to.owners.push_back(row.owner);
}

MeshHash DiffBuilder::HashOf(const VertexRow& row) {
  return HashVertex(row.coordinates.data(), 2, row.dimension, row.owner);
}

void DiffBuilder::Append(const std::vector<SimplexRow>& rows, SimplexColumn* simplices,
                         RegionColumn* regions) {
  simplices->reserve(3 * rows.size());
  if (!labels_.empty()) regions->reserve(rows.size());
  for (const SimplexRow& row : rows) {
    simplices->insert(simplices->end(), row.ids.begin(), row.ids.end());
    if (!labels_.empty()) regions->push_back(row.region);
  }
}

// Drops columns that say nothing; lists the sets of polygons that the others name.
void DiffBuilder::NameRegions(std::initializer_list<RegionColumn*> columns,
                              std::vector<RegionSet>* sets) const {
  std::vector<RegionId> ids;
  for (RegionColumn* column : columns) {
    data::DropIfIdle(*column);
    for (const RegionId id : *column) {
      if (ids.empty() || ids.back() != id) ids.push_back(id);
    }
  }
  if (!ids.empty()) *sets = labels_.sets().SetsOf(&ids);
}

MeshHash DiffBuilder::HashOf(const SimplexRow& row) {
  return HashSimplex(row.ids.data(), 3, row.region);
}

MeshHash DiffBuilder::HashOf(const SubsegmentRow& row) {
  return HashSubsegment(row.ends[0], row.ends[1], row.owner);
}

std::array<VertexId, 3> DiffBuilder::CanonicalIds(Triangulation::TriangleIndex t) const {
  const Corners& v = triangulation_.vertices(t);
  return InCanonicalOrder(
      std::array<VertexId, 3>{names_.at(v[0]), names_.at(v[1]), names_.at(v[2])});
}

absl::Status DiffBuilder::RegionStatus() const {
  const auto polygons = labels_.overfull();
  if (polygons.empty()) return absl::OkStatus();
  const FeatureId last = polygons.back();
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      "polygon " + std::to_string(last) + " lies over " + std::to_string(polygons.size() - 1) +
          " others, " + std::to_string(polygons[0]) + " and " + std::to_string(polygons[1]) +
          " among them, and no place may lie in more than " +
          std::to_string(kMostPolygonsAtAPlace) + " polygons; move or remove some of them",
      {reason::kPolygonLimit, {last}, {}});
}

// --- The whole mesh -------------------------------------------------------------------

template <class Refinement>
Mesh DiffBuilder::Begin(Refinement& refinement, const FeatureTable& features) {
  refinement.TakeChanges([](VertexIndex, bool, bool) {}, [](SubsegmentIndex, bool, bool) {});
  refinement.ForEachSubsegment([&](const Subsegment& s) {
    const auto polygons = features.PolygonsOf(s.feature);
    if (!polygons.empty()) labels_.AddWall(s.a, s.b, polygons);
  });
  names_.Reserve(refinement.vertex_count());
  const auto position = [&](VertexIndex v) -> const geometry::Point2& {
    return refinement.vertex(v).p;
  };
  std::vector<VertexIndex> all;
  all.reserve(refinement.vertex_count());
  refinement.ForEachVertex([&](VertexIndex v, const Vertex&) {
    all.push_back(v);
    if (!triangulation_.Contains(v)) InsertVertex(refinement, v);  // else it has grown along
  });
  names_.AddAll(all, position);
  labels_.LabelAll();
  if (!labels_.overfull().empty()) return {};
  Mesh mesh = Snapshot(refinement, features);
  subsegment_count_ = mesh.subsegments.size();
  hash_ = mesh.hash = ComputeHash(mesh);
  return mesh;
}

template <class Refinement>
Mesh DiffBuilder::Snapshot(const Refinement& refinement, const FeatureTable& features) const {
  Mesh mesh;
  Reserve(mesh.vertices, refinement.vertex_count());
  refinement.ForEachVertex([&](VertexIndex v, const Vertex& vertex) {
    Append(mesh.vertices, RowOf(names_.at(v), vertex, features));
  });
  mesh.simplices.reserve(3 * triangulation_.triangle_count());
  triangulation_.ForEachTriangle([&](auto t) {
    for (const VertexId id : CanonicalIds(t)) mesh.simplices.push_back(id);
  });
  if (!labels_.empty()) {
    mesh.regions.reserve(triangulation_.triangle_count());
    triangulation_.ForEachTriangle([&](auto t) { mesh.regions.push_back(labels_.at(t)); });
    NameRegions({&mesh.regions}, &mesh.region_sets);
  }
  refinement.ForEachSubsegment([&](const Subsegment& s) {
    Append(mesh.subsegments, RowOf(names_.at(s.a), names_.at(s.b), features.IdOf(s.feature)));
  });
  mesh.hash = hash_;
  return mesh;
}

// --- What has changed -----------------------------------------------------------------

template <class Refinement>
MeshDiff DiffBuilder::Update(Refinement& refinement, const FeatureTable& features) {
  TakeChanges(refinement);
  UpdateNames(refinement);
  UpdateTriangulation(refinement);
  UpdateLabels(refinement, features);
  if (!labels_.overfull().empty()) return {};
  if (!renamed_.empty()) AddTrianglesOfRenamed();
  MeshDiff diff;
  ReportVertices(refinement, features, &diff);
  ReportSubsegments(refinement, features, &diff);
  ReportSimplices(&diff);
  diff.hash = hash_;
  labels_.Collect();
  return diff;
}

template <class Refinement>
void DiffBuilder::TakeChanges(Refinement& refinement) {
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

// Names of what goes stay readable: by OldId, like those of the renamed.
template <class Refinement>
void DiffBuilder::UpdateNames(const Refinement& refinement) {
  renamed_.clear();
  const auto position = [&](VertexIndex v) -> const geometry::Point2& {
    return refinement.vertex(v).p;
  };
  const auto keep_old = [&](VertexIndex v) {
    if (triangulation_.Contains(v)) renamed_.push_back({v, names_.at(v)});  // was in the mesh
  };
  for (const VertexIndex v : vertices_.gone) names_.Remove(v, position, keep_old);
  for (const VertexIndex v : vertices_.come) names_.Add(v, position, keep_old);
  if (renamed_.empty()) return;
  // Of one renamed several times, the first entry counts.
  std::stable_sort(renamed_.begin(), renamed_.end(),
                   [](const Renamed& a, const Renamed& b) { return a.v < b.v; });
  const auto again = std::unique(renamed_.begin(), renamed_.end(),
                                 [](const Renamed& a, const Renamed& b) { return a.v == b.v; });
  renamed_.erase(again, renamed_.end());
  std::erase_if(renamed_, [&](const Renamed& r) { return names_.at(r.v) == r.old_id; });
}

// First what goes: what comes may lie at the same place.
template <class Refinement>
void DiffBuilder::UpdateTriangulation(const Refinement& refinement) {
  triangles_.Clear();
  fresh_.clear();
  for (const VertexIndex v : vertices_.gone) {
    triangulation_.Remove(v);
    RecordTriangles();
  }
  for (const VertexIndex v : vertices_.come) {
    InsertVertex(refinement, v);
    RecordTriangles();
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
}

// What is made and unmade again in the same update never shows.
void DiffBuilder::RecordTriangles() {
  const auto deleted = triangulation_.deleted();
  const auto labels = triangulation_.deleted_tags();
  for (std::size_t i = 0; i < deleted.size(); ++i) {
    if (!IsFinite(deleted[i]) || labels[i] == RegionLabels::kPending) continue;
    triangles_.gone.push_back({InCanonicalOrder(deleted[i]), labels[i]});
  }
  for (const auto t : triangulation_.created()) {
    if (triangulation_.IsInfinite(t)) continue;
    triangulation_.set_tag(t, RegionLabels::kPending);
    fresh_.push_back(t);
  }
}

DiffBuilder::TriangleRow DiffBuilder::RowOf(Triangulation::TriangleIndex t) const {
  return {InCanonicalOrder(triangulation_.vertices(t)), labels_.at(t)};
}

template <class Refinement>
void DiffBuilder::UpdateLabels(const Refinement& refinement, const FeatureTable& features) {
  for (const SubsegmentIndex i : subsegments_.gone) {
    const Subsegment& s = refinement.subsegment(i);
    labels_.RemoveWall(s.a, s.b);
  }
  for (const SubsegmentIndex i : subsegments_.come) {
    const Subsegment& s = refinement.subsegment(i);
    const auto polygons = features.PolygonsOf(s.feature);
    if (!polygons.empty()) labels_.AddWall(s.a, s.b, polygons);
  }
  // Some were unmade again, some indices used twice.
  std::erase_if(fresh_, [&](auto t) { return triangulation_.IsInfinite(t); });
  std::sort(fresh_.begin(), fresh_.end());
  fresh_.erase(std::unique(fresh_.begin(), fresh_.end()), fresh_.end());
  const auto& relabelled = labels_.Update(fresh_, features.toggled_walls(), [&](VertexIndex v) {
    return refinement.vertex(v).dimension == 1;
  });
  for (const auto t : fresh_) triangles_.come.push_back(RowOf(t));
  for (const auto& [t, before] : relabelled) {
    triangles_.come.push_back(RowOf(t));
    triangles_.gone.push_back({triangles_.come.back().v, before});
  }
}

// Triangles that stay, under other names.
void DiffBuilder::AddTrianglesOfRenamed() {
  triangles_.Net();
  stay_.clear();
  for (const Renamed& r : renamed_) {
    if (!triangulation_.Contains(r.v)) continue;
    const auto first = triangulation_.Around(r.v);
    auto corner = first;
    do {
      if (!triangulation_.IsInfinite(corner.triangle)) stay_.push_back(RowOf(corner.triangle));
      corner = triangulation_.NextAround(corner);
    } while (corner.triangle != first.triangle);
  }
  std::sort(stay_.begin(), stay_.end());
  stay_.erase(std::unique(stay_.begin(), stay_.end()), stay_.end());
  std::erase_if(stay_, [&](const TriangleRow& row) {
    return std::binary_search(triangles_.come.begin(), triangles_.come.end(), row);
  });
  triangles_.gone.insert(triangles_.gone.end(), stay_.begin(), stay_.end());
  triangles_.come.insert(triangles_.come.end(), stay_.begin(), stay_.end());
}

bool DiffBuilder::IsRenamed(VertexIndex v) const {
  return std::binary_search(renamed_.begin(), renamed_.end(), Renamed{v, 0},
                            [](const Renamed& a, const Renamed& b) { return a.v < b.v; });
}

VertexId DiffBuilder::OldIdOfRenamed(VertexIndex v) const {
  const auto it = std::lower_bound(renamed_.begin(), renamed_.end(), v,
                                   [](const Renamed& r, VertexIndex w) { return r.v < w; });
  return it != renamed_.end() && it->v == v ? it->old_id : names_.at(v);
}

// Those that look the same before and after are not reported.
template <class Refinement>
void DiffBuilder::ReportVertices(const Refinement& refinement, const FeatureTable& features,
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
  vertex_rows_.Net();
  diff->removed_vertices.reserve(vertex_rows_.gone.size());
  Reserve(diff->added_vertices, vertex_rows_.come.size());
  for (const VertexRow& row : vertex_rows_.gone) {
    diff->removed_vertices.push_back(row.id);
    hash_ -= HashOf(row);
  }
  for (const VertexRow& row : vertex_rows_.come) {
    Append(diff->added_vertices, row);
    hash_ += HashOf(row);
  }
}

template <class Refinement>
void DiffBuilder::ReportSubsegments(const Refinement& refinement, const FeatureTable& features,
                                    MeshDiff* diff) {
  subsegment_rows_.Clear();
  const auto goes = [&](const Subsegment& s) {
    subsegment_rows_.gone.push_back(RowOf(OldId(s.a), OldId(s.b), features.IdOf(s.feature)));
  };
  const auto comes = [&](const Subsegment& s) {
    subsegment_rows_.come.push_back(
        RowOf(names_.at(s.a), names_.at(s.b), features.IdOf(s.feature)));
  };
  for (const SubsegmentIndex s : subsegments_.gone) goes(refinement.subsegment(s));
  for (const SubsegmentIndex s : subsegments_.come) comes(refinement.subsegment(s));
  if (!renamed_.empty()) {
    refinement.ForEachSubsegment([&](const Subsegment& s) {
      if (!IsRenamed(s.a) && !IsRenamed(s.b)) return;
      for (const SubsegmentIndex i : subsegments_.come) {
        if (&refinement.subsegment(i) == &s) return;
      }
      goes(s);
      comes(s);
    });
  }
  subsegment_rows_.Net();
  for (const SubsegmentRow& row : subsegment_rows_.gone) {
    Append(diff->removed_subsegments, row);
    hash_ -= HashOf(row);
  }
  for (const SubsegmentRow& row : subsegment_rows_.come) {
    Append(diff->added_subsegments, row);
    hash_ += HashOf(row);
  }
  subsegment_count_ += subsegment_rows_.come.size();
  subsegment_count_ -= subsegment_rows_.gone.size();
}

// Once more netted, as the client sees them: a vertex may have come where one has gone.
void DiffBuilder::ReportSimplices(MeshDiff* diff) {
  simplex_rows_.Clear();
  for (const auto& [v, region] : triangles_.gone) {
    simplex_rows_.gone.push_back(
        {InCanonicalOrder(std::array<VertexId, 3>{OldId(v[0]), OldId(v[1]), OldId(v[2])}), region});
  }
  for (const auto& [v, region] : triangles_.come) {
    simplex_rows_.come.push_back({InCanonicalOrder(std::array<VertexId, 3>{
                                      names_.at(v[0]), names_.at(v[1]), names_.at(v[2])}),
                                  region});
  }
  simplex_rows_.Net();
  Append(simplex_rows_.gone, &diff->removed_simplices, &diff->removed_regions);
  Append(simplex_rows_.come, &diff->added_simplices, &diff->added_regions);
  NameRegions({&diff->removed_regions, &diff->added_regions}, &diff->region_sets);
  for (const SimplexRow& row : simplex_rows_.gone) hash_ -= HashOf(row);
  for (const SimplexRow& row : simplex_rows_.come) hash_ += HashOf(row);
}

using Traced = meshing::Refinement<2, sac::Engine>;
using Untraced = meshing::Refinement<2, sac::UntracedEngine>;
template Mesh DiffBuilder::Begin(Traced&, const FeatureTable&);
template Mesh DiffBuilder::Begin(Untraced&, const FeatureTable&);
template MeshDiff DiffBuilder::Update(Traced&, const FeatureTable&);
template Mesh DiffBuilder::Snapshot(const Traced&, const FeatureTable&) const;
template Mesh DiffBuilder::Snapshot(const Untraced&, const FeatureTable&) const;

}  // namespace dynmesh
