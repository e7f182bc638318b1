#include "core/mesh_data/diff_meshes.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/labels.h"
#include "core/mesh_data/regions.h"
#include "core/mesh_data/whole_mesh.h"

namespace dynmesh::mesh_data {
namespace {

// Merges two sorted sequences of rows. `order(i, j)` is negative if old row i comes before new row
// j, 0 if they are the same item, else positive. Calls gone(i), both(i, j), come(j).
template <class Order, class Gone, class Both, class Come>
void Merge(std::size_t old_rows, std::size_t new_rows, Steps& steps, Order order, Gone gone,
           Both both, Come come) {
  std::size_t i = 0;
  std::size_t j = 0;
  while ((i < old_rows || j < new_rows) && !steps.Stop()) {
    const int sign = i == old_rows ? 1 : j == new_rows ? -1 : order(i, j);
    if (sign < 0) {
      gone(i++);
    } else if (sign > 0) {
      come(j++);
    } else {
      both(i++, j++);
    }
  }
}

// Keeps some rows of a column in place, in their order, without a second copy.
template <class T>
class RowKeeper {
 public:
  RowKeeper(std::vector<T>* column, std::size_t width) : column_(*column), width_(width) {}
  void Keep(std::size_t row) {
    const auto from = column_.begin() + static_cast<std::ptrdiff_t>(row * width_);
    std::copy(from, from + static_cast<std::ptrdiff_t>(width_),
              column_.begin() + static_cast<std::ptrdiff_t>(kept_++ * width_));
  }
  std::vector<T> Take() {
    column_.resize(kept_ * width_);
    return std::move(column_);
  }

 private:
  std::vector<T>& column_;
  const std::size_t width_;
  std::size_t kept_ = 0;
};

// Same coordinates, containing dimension and owner (-0 equals +0, as in ids and hashes).
bool SameVertex(std::size_t d, const VertexColumns& a, std::size_t i, const VertexColumns& b,
                std::size_t j) {
  for (std::size_t k = 0; k < d; ++k) {
    const double x = a.coordinates[i * d + k] + 0.0;
    const double y = b.coordinates[j * d + k] + 0.0;
    if (std::bit_cast<std::uint64_t>(x) != std::bit_cast<std::uint64_t>(y)) return false;
  }
  return a.containing_dimensions[i] == b.containing_dimensions[j] && a.owners[i] == b.owners[j];
}

void DiffVertices(std::size_t d, const VertexColumns& from, VertexColumns& to, Steps& steps,
                  MeshDiff& diff) {
  absl::flat_hash_map<VertexId, std::size_t> row_of;
  row_of.reserve(from.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (steps.Stop()) return;
    row_of.emplace(from.ids[i], i);
  }
  std::vector<bool> stays(from.size(), false);
  std::vector<std::size_t> added;
  for (std::size_t j = 0; j < to.size(); ++j) {
    if (steps.Stop()) return;
    const auto it = row_of.find(to.ids[j]);
    if (it != row_of.end() && SameVertex(d, from, it->second, to, j)) {
      stays[it->second] = true;
    } else {
      added.push_back(j);
    }
  }
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (!stays[i]) diff.removed_vertices.push_back(from.ids[i]);
  }
  const auto keep = [&](auto& column, std::size_t width) {
    RowKeeper keeper(&column, width);
    for (const std::size_t row : added) keeper.Keep(row);
    return keeper.Take();
  };
  diff.added_vertices.ids = keep(to.ids, 1);
  diff.added_vertices.coordinates = keep(to.coordinates, d);
  diff.added_vertices.containing_dimensions = keep(to.containing_dimensions, 1);
  diff.added_vertices.owners = keep(to.owners, 1);
}

struct Simplices {
  SimplexColumn rows;
  RegionColumn regions;
};

// Removes from the mesh the simplices with a vertex that is not among `ids`, and returns them.
// These are nearly all, so they stay in place and the others are copied.
Simplices TakeSimplicesNotOn(const std::vector<VertexId>& ids, std::size_t width, Mesh& mesh,
                             Steps& steps) {
  absl::flat_hash_set<VertexId> known;
  known.reserve(ids.size());
  for (std::size_t i = 0; i < ids.size() && !steps.Stop(); ++i) known.insert(ids[i]);
  Simplices all{std::exchange(mesh.simplices, {}), std::exchange(mesh.regions, {})};
  const bool labelled = !all.regions.empty();
  RowKeeper rows(&all.rows, width);
  RowKeeper regions(&all.regions, 1);
  const std::size_t count = all.rows.size() / width;
  for (std::size_t i = 0; i < count && !steps.Stop(); ++i) {
    const auto row = all.rows.begin() + static_cast<std::ptrdiff_t>(i * width);
    const auto end = row + static_cast<std::ptrdiff_t>(width);
    if (std::all_of(row, end, [&](VertexId id) { return known.contains(id); })) {
      mesh.simplices.insert(mesh.simplices.end(), row, end);
      if (labelled) mesh.regions.push_back(all.regions[i]);
    } else {
      rows.Keep(i);
      if (labelled) regions.Keep(i);
    }
  }
  return {rows.Take(), regions.Take()};
}

// Appends to the larger column: rows are in no particular order.
void AppendAlone(Simplices alone, bool labelled, SimplexColumn& rows, RegionColumn& regions,
                 std::size_t width) {
  if (labelled) {
    alone.regions.resize(alone.rows.size() / width, kNoRegion);
    regions.resize(rows.size() / width, kNoRegion);
  }
  if (rows.size() < alone.rows.size()) {
    rows.swap(alone.rows);
    regions.swap(alone.regions);
  }
  rows.insert(rows.end(), alone.rows.begin(), alone.rows.end());
  regions.insert(regions.end(), alone.regions.begin(), alone.regions.end());
}

// Ids of different sets of polygons in `from` and `to`; only crafted input has such. Both are
// sorted by id.
absl::flat_hash_set<RegionId> OtherSets(const std::vector<RegionSet>& from,
                                        const std::vector<RegionSet>& to) {
  absl::flat_hash_set<RegionId> others;
  auto set = to.begin();
  for (const RegionSet& before : from) {
    while (set != to.end() && set->id < before.id) ++set;
    if (set == to.end()) break;
    if (set->id == before.id && set->polygons != before.polygons) others.insert(before.id);
  }
  return others;
}

// A simplex with the same corners in another region is removed and added. `from_alone` and
// `to_alone` occur in one mesh only, and are no longer in it.
void DiffSimplices(const Mesh& from, Mesh& to, Simplices from_alone, Simplices to_alone,
                   Steps& steps, MeshDiff& diff) {
  const std::size_t width = static_cast<std::size_t>(to.dimension) + 1;
  const bool labelled = !from.regions.empty() || !to.regions.empty() ||
                        !from_alone.regions.empty() || !to_alone.regions.empty();
  RowKeeper added(&to.simplices, width);
  const auto order = [&](std::size_t i, std::size_t j) {
    for (std::size_t k = 0; k < width; ++k) {
      const VertexId a = from.simplices[i * width + k], b = to.simplices[j * width + k];
      if (a != b) return a < b ? -1 : 1;
    }
    return 0;
  };
  const auto gone = [&](std::size_t i) {
    const auto row = from.simplices.begin() + static_cast<std::ptrdiff_t>(i * width);
    diff.removed_simplices.insert(diff.removed_simplices.end(), row,
                                  row + static_cast<std::ptrdiff_t>(width));
    if (labelled) diff.removed_regions.push_back(from.region(i));
  };
  const auto come = [&](std::size_t j) {
    added.Keep(j);
    if (labelled) diff.added_regions.push_back(to.region(j));
  };
  const auto others = OtherSets(from.region_sets, to.region_sets);
  const auto both = [&](std::size_t i, std::size_t j) {
    if (!labelled) return;
    const RegionId region = to.region(j);
    if (from.region(i) == region && (others.empty() || !others.contains(region))) return;
    gone(i);
    come(j);
  };
  Merge(from.simplex_count(), to.simplex_count(), steps, order, gone, both, come);
  diff.added_simplices = added.Take();
  AppendAlone(std::move(from_alone), labelled, diff.removed_simplices, diff.removed_regions, width);
  AppendAlone(std::move(to_alone), labelled, diff.added_simplices, diff.added_regions, width);
  DropIfIdle(diff.removed_regions);
  DropIfIdle(diff.added_regions);
}

template <class Columns>
void DiffConstraints(const Columns& from, Columns& to, Steps& steps, Columns& removed,
                     Columns& added) {
  RowKeeper ids(&IdsOf(to), kCorners<Columns>);
  RowKeeper owners(&to.owners, 1);
  const auto order = [&](std::size_t i, std::size_t j) {
    const auto a = KeyOf(from, i), b = KeyOf(to, j);
    return a < b ? -1 : b < a ? 1 : 0;
  };
  Merge(
      from.size(), to.size(), steps, order, [&](std::size_t i) { Append(removed, KeyOf(from, i)); },
      [](std::size_t, std::size_t) {},
      [&](std::size_t j) {
        ids.Keep(j);
        owners.Keep(j);
      });
  IdsOf(added) = ids.Take();
  added.owners = owners.Take();
}

}  // namespace

// Sorting dominates the time, so vertices are looked up instead. A simplex with a vertex that the
// other mesh lacks needs no sorting. If one mesh is much smaller, these are nearly all of the
// larger one.
MeshDiff DiffMeshes(Mesh from, Mesh to, Steps& steps) {
  const std::size_t width = static_cast<std::size_t>(to.dimension) + 1;
  Simplices from_alone, to_alone;
  constexpr std::size_t kMuch = 4;
  if (kMuch * from.vertices.size() < to.vertices.size()) {
    to_alone = TakeSimplicesNotOn(from.vertices.ids, width, to, steps);
  } else if (kMuch * to.vertices.size() < from.vertices.size()) {
    from_alone = TakeSimplicesNotOn(to.vertices.ids, width, from, steps);
  }
  MeshDiff diff;
  diff.region_sets = to.region_sets;
  AppendSets(diff.region_sets, from.region_sets);  // if sets with one id differ, the latter is kept
  const VertexColumns from_vertices = std::exchange(from.vertices, {});
  VertexColumns to_vertices = std::exchange(to.vertices, {});
  DiffVertices(width - 1, from_vertices, to_vertices, steps, diff);
  for (Mesh* mesh : {&from, &to}) {
    Canonicalize(*mesh, steps);
    if (steps.stopped()) return {};
  }
  diff.dimension = to.dimension;
  diff.from_revision = from.revision;
  diff.to_revision = to.revision;
  diff.hash = to.hash;
  DiffSimplices(from, to, std::move(from_alone), std::move(to_alone), steps, diff);
  KeepNamed(diff.region_sets, {&diff.removed_regions, &diff.added_regions});
  DiffConstraints(from.subsegments, to.subsegments, steps, diff.removed_subsegments,
                  diff.added_subsegments);
  DiffConstraints(from.subfacets, to.subfacets, steps, diff.removed_subfacets,
                  diff.added_subfacets);
  diff.labels = DiffLabels(from.labels, to.labels);
  return diff;
}

MeshDiff DiffMeshes(Mesh from, Mesh to) {
  AllSteps all;
  return DiffMeshes(std::move(from), std::move(to), all);
}

}  // namespace dynmesh::mesh_data
