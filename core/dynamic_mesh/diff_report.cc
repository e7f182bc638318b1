// What an update reports: rows by public ids, netted and hashed.
#include <algorithm>
#include <array>

#include "core/dynamic_mesh/diff_builder.h"
#include "core/mesh_data/canonical_order.h"

namespace dynmesh {

using mesh_data::InCanonicalOrder;
using meshing::SubsegmentIndex;
using meshing::VertexIndex;

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

// Vertices with equal rows before and after are not reported.
template <int D>
void DiffBuilder<D>::ReportVertices(const Elements& elements, const FeatureTable<D>& features,
                                    MeshDiff* diff) {
  vertex_rows_.Clear();
  for (const VertexIndex v : vertices_.gone) {
    vertex_rows_.gone.push_back(RowOf(OldId(v), elements.vertex(v), features));
  }
  for (const VertexIndex v : vertices_.come) {
    vertex_rows_.come.push_back(RowOf(names_.at(v), elements.vertex(v), features));
  }
  for (const auto& r : renamed_) {
    if (!triangulation_.Contains(r.v)) continue;
    vertex_rows_.gone.push_back(RowOf(r.old_id, elements.vertex(r.v), features));
    vertex_rows_.come.push_back(RowOf(names_.at(r.v), elements.vertex(r.v), features));
  }
  NetAndHash(&vertex_rows_, &hash_);
  diff->removed_vertices.reserve(vertex_rows_.gone.size());
  Reserve(diff->added_vertices, D, vertex_rows_.come.size());
  for (const VertexRow<D>& row : vertex_rows_.gone) diff->removed_vertices.push_back(row.id);
  for (const VertexRow<D>& row : vertex_rows_.come) Append(diff->added_vertices, row);
}

template <int D>
void DiffBuilder<D>::ReportSubsegments(const Elements& elements, const FeatureTable<D>& features,
                                       MeshDiff* diff) {
  subsegment_rows_.Clear();
  const auto goes = [&](const Subsegment& s) {
    subsegment_rows_.gone.push_back(
        ConstraintRowOf(OldIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  };
  const auto comes = [&](const Subsegment& s) {
    subsegment_rows_.come.push_back(
        ConstraintRowOf(NewIds(std::array{s.a, s.b}), features.IdOf(s.feature)));
  };
  for (const SubsegmentIndex s : subsegments_.gone) goes(elements.subsegment(s));
  for (const SubsegmentIndex s : subsegments_.come) comes(elements.subsegment(s));
  if (!renamed_.empty()) {
    elements.ForEachSubsegment([&](const Subsegment& s) {
      if (renamed_.Find(s.a) == nullptr && renamed_.Find(s.b) == nullptr) return;
      for (const SubsegmentIndex i : subsegments_.come) {
        if (&elements.subsegment(i) == &s) return;
      }
      goes(s);
      comes(s);
    });
  }
  NetAndHash(&subsegment_rows_, &hash_);
  Report(subsegment_rows_, &diff->removed_subsegments, &diff->added_subsegments);
  subsegment_count_ += subsegment_rows_.come.size();
  subsegment_count_ -= subsegment_rows_.gone.size();
}

template <int D>
void DiffBuilder<D>::ReportSubfacets(const FeatureTable<D>& features, MeshDiff* diff) {
  if constexpr (D == 3) {
    subfacet_rows_.Clear();
    for (const auto& [face, slot] : subfacets_.gone()) {
      subfacet_rows_.gone.push_back(ConstraintRowOf(OldIds(face), features.IdOf(slot)));
    }
    for (const auto& [face, slot] : subfacets_.come()) {
      subfacet_rows_.come.push_back(ConstraintRowOf(NewIds(face), features.IdOf(slot)));
    }
    NetAndHash(&subfacet_rows_, &hash_);
    Report(subfacet_rows_, &diff->removed_subfacets, &diff->added_subfacets);
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
  NetAndHash(&simplex_rows_, &hash_);
  AppendAll(simplex_rows_.gone, &diff->removed_simplices, &diff->removed_regions);
  AppendAll(simplex_rows_.come, &diff->added_simplices, &diff->added_regions);
  NameRegions({&diff->removed_regions, &diff->added_regions}, &diff->region_sets);
}

template void DiffBuilder<2>::ReportVertices(const meshing::ElementStore<2>&,
                                             const FeatureTable<2>&, MeshDiff*);
template void DiffBuilder<2>::ReportSubsegments(const meshing::ElementStore<2>&,
                                                const FeatureTable<2>&, MeshDiff*);
template void DiffBuilder<2>::ReportSubfacets(const FeatureTable<2>&, MeshDiff*);
template void DiffBuilder<2>::ReportSimplices(MeshDiff*);
template void DiffBuilder<3>::ReportVertices(const meshing::ElementStore<3>&,
                                             const FeatureTable<3>&, MeshDiff*);
template void DiffBuilder<3>::ReportSubsegments(const meshing::ElementStore<3>&,
                                                const FeatureTable<3>&, MeshDiff*);
template void DiffBuilder<3>::ReportSubfacets(const FeatureTable<3>&, MeshDiff*);
template void DiffBuilder<3>::ReportSimplices(MeshDiff*);

}  // namespace dynmesh
