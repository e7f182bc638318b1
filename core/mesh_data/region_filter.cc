#include "core/mesh_data/region_filter.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>

#include "absl/container/flat_hash_set.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/regions.h"

namespace dynmesh::mesh_data {
namespace {

// REQUIRES: `ids` and `polygons` ascend.
bool Meet(const std::vector<FeatureId>& ids, std::span<const FeatureId> polygons) {
  auto i = ids.begin();
  auto p = polygons.begin();
  while (i != ids.end() && p != polygons.end()) {
    if (*i == *p) return true;
    *i < *p ? static_cast<void>(++i) : static_cast<void>(++p);
  }
  return false;
}

void Normalize(std::vector<FeatureId>& ids) {
  std::ranges::sort(ids);
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// Copies the rows that `has(row)` chooses. Returns the sum of the hashes of the others.
template <class Has>
MeshHash Choose(int dimension, const SimplexColumn& simplices, const RegionColumn& regions, Has has,
                SimplexColumn& chosen, RegionColumn& chosen_regions) {
  const auto width = static_cast<std::size_t>(dimension) + 1;
  MeshHash hidden;
  for (std::size_t i = 0; i < simplices.size() / width; ++i) {
    const RegionId region = regions.empty() ? kNoRegion : regions[i];
    const VertexId* const ids = &simplices[i * width];
    if (has(i)) {
      chosen.insert(chosen.end(), ids, ids + width);
      if (!regions.empty()) chosen_regions.push_back(region);
    } else {
      hidden += HashSimplex(ids, dimension + 1, region);
    }
  }
  DropIfIdle(chosen_regions);
  return hidden;
}

// By region.
MeshHash Choose(int dimension, const SimplexColumn& simplices, const RegionColumn& regions,
                RegionFilter& filter, SimplexColumn& chosen, RegionColumn& chosen_regions) {
  const auto has = [&](std::size_t i) {
    return filter.Has(regions.empty() ? kNoRegion : regions[i]);
  };
  return Choose(dimension, simplices, regions, has, chosen, chosen_regions);
}

VertexColumns RowsOf(const absl::flat_hash_set<VertexId>& ids, std::size_t dimension,
                     const VertexColumns& from) {
  VertexColumns to;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!ids.contains(from.ids[i])) continue;
    to.ids.push_back(from.ids[i]);
    const double* const x = &from.coordinates[i * dimension];
    to.coordinates.insert(to.coordinates.end(), x, x + dimension);
    to.containing_dimensions.push_back(from.containing_dimensions[i]);
    to.owners.push_back(from.owners[i]);
  }
  return to;
}

// The constraints that are an edge, or a facet, of a simplex.
template <class Columns>
Columns ConstraintsOf(const SimplexColumn& simplices, std::size_t width, const Columns& from) {
  constexpr std::size_t kIds = kCorners<Columns>;
  using Corners = std::array<VertexId, kIds>;
  const auto corners_of = [&](std::size_t constraint) {
    const auto key = KeyOf(from, constraint);
    Corners corners;
    std::copy_n(key.begin(), kIds, corners.begin());
    return corners;
  };
  // A set of constraints, not of edges and facets, which are many more.
  absl::flat_hash_set<Corners> open;
  for (std::size_t i = 0; i < from.size(); ++i) open.insert(corners_of(i));
  if (open.empty()) return {};
  absl::flat_hash_set<Corners> found;
  for (std::size_t row = 0; row < simplices.size(); row += width) {
    for (unsigned choice = 0; choice < 1U << width; ++choice) {
      if (std::popcount(choice) != static_cast<int>(kIds)) continue;
      Corners corners;
      std::size_t k = 0;
      for (std::size_t i = 0; i < width; ++i) {
        if ((choice >> i & 1) != 0) corners[k++] = simplices[row + i];
      }
      std::sort(corners.begin(), corners.end());
      if (open.contains(corners)) found.insert(corners);
    }
  }
  Columns to;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (found.contains(corners_of(i))) Append(to, KeyOf(from, i));
  }
  return to;
}

}  // namespace

bool RegionChoice::Has(std::span<const FeatureId> polygons) const {
  if (Meet(out, polygons)) return false;
  if (in_any) return !polygons.empty();
  return in.empty() || Meet(in, polygons);
}

void Normalize(RegionChoice& choice) {
  Normalize(choice.in);
  Normalize(choice.out);
}

RegionFilter::RegionFilter(const RegionChoice& choice, std::span<const RegionSet> sets)
    : choice_(choice), sets_(sets), has_last_(choice.Has({})) {}

bool RegionFilter::Has(RegionId region) {
  if (region == last_) return has_last_;
  const auto [it, is_new] = known_.try_emplace(region, false);
  if (is_new) it->second = choice_.Has(PolygonsOf(region, sets_));
  last_ = region;
  return has_last_ = it->second;
}

Mesh OnlyInside(const Mesh& mesh, const RegionChoice& choice) {
  if (choice.IsEverything()) return mesh;
  RegionFilter filter(choice, mesh.region_sets);
  std::vector<bool> keep(mesh.simplex_count());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = filter.Has(mesh.region(i));
  return OnlyRows(mesh, keep);
}

Mesh OnlyRows(const Mesh& mesh, const std::vector<bool>& keep) {
  const auto dimension = static_cast<std::size_t>(mesh.dimension);
  Mesh part;
  part.dimension = mesh.dimension;
  part.revision = mesh.revision;
  Choose(
      mesh.dimension, mesh.simplices, mesh.regions, [&](std::size_t i) { return keep[i]; },
      part.simplices, part.regions);
  part.region_sets = mesh.region_sets;
  part.labels = mesh.labels;
  KeepNamed(part.region_sets, {&part.regions});
  const absl::flat_hash_set<VertexId> used(part.simplices.begin(), part.simplices.end());
  part.vertices = RowsOf(used, dimension, mesh.vertices);
  part.subsegments = ConstraintsOf(part.simplices, dimension + 1, mesh.subsegments);
  part.subfacets = ConstraintsOf(part.simplices, dimension + 1, mesh.subfacets);
  part.hash = ComputeHash(part);
  return part;
}

Mesh SimplicesInside(const Mesh& mesh, const RegionChoice& choice) {
  if (choice.IsEverything()) return mesh;
  Mesh part;
  part.dimension = mesh.dimension;
  part.revision = mesh.revision;
  part.vertices = mesh.vertices;
  part.subsegments = mesh.subsegments;
  part.subfacets = mesh.subfacets;
  part.region_sets = mesh.region_sets;
  part.labels = mesh.labels;
  part.hash = mesh.hash;
  RegionFilter filter(choice, mesh.region_sets);
  part.hash -=
      Choose(mesh.dimension, mesh.simplices, mesh.regions, filter, part.simplices, part.regions);
  KeepNamed(part.region_sets, {&part.regions});
  return part;
}

MeshDiff SimplicesInside(const MeshDiff& diff, const RegionChoice& choice, MeshHash& hidden) {
  if (choice.IsEverything()) return diff;
  MeshDiff part;
  part.dimension = diff.dimension;
  part.from_revision = diff.from_revision;
  part.to_revision = diff.to_revision;
  part.removed_vertices = diff.removed_vertices;
  part.removed_subsegments = diff.removed_subsegments;
  part.removed_subfacets = diff.removed_subfacets;
  part.added_vertices = diff.added_vertices;
  part.added_subsegments = diff.added_subsegments;
  part.added_subfacets = diff.added_subfacets;
  part.work = diff.work;
  part.region_sets = diff.region_sets;
  part.labels = diff.labels;
  RegionFilter filter(choice, diff.region_sets);
  hidden -= Choose(diff.dimension, diff.removed_simplices, diff.removed_regions, filter,
                   part.removed_simplices, part.removed_regions);
  hidden += Choose(diff.dimension, diff.added_simplices, diff.added_regions, filter,
                   part.added_simplices, part.added_regions);
  KeepNamed(part.region_sets, {&part.removed_regions, &part.added_regions});
  part.hash = diff.hash;
  part.hash -= hidden;
  return part;
}

}  // namespace dynmesh::mesh_data
