// The canonical order of rows: equal meshes become equal byte by byte. O(n lg n) for n rows.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/steps.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/regions.h"
#include "core/mesh_data/whole_mesh.h"
#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

// Rearranges rows of `width` entries: row i becomes the former row order[i].
template <class T>
void Permute(const std::vector<std::uint32_t>& order, std::size_t width, Steps& steps,
             std::vector<T>& column) {
  std::vector<T> sorted;
  sorted.reserve(column.size());
  for (const std::size_t row : order) {
    if (steps.Stop()) return;
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(row * width);
    sorted.insert(sorted.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  column = std::move(sorted);
}

// Sorts items by a leading key (an id, hence a uniform hash) and by `less`. First distributes them
// in place, by leading bits, to about as many buckets as there are items: then they are nearly in
// order.
template <class Item, class KeyOf, class Less>
void SortByHash(std::span<Item> items, Steps& steps, KeyOf key_of, Less less) {
  const int bits = std::bit_width(items.size() / 2);
  if (bits < 4) return std::sort(items.begin(), items.end(), less);
  const auto slot_of = [&](const Item& item) { return key_of(item) >> (64 - bits); };
  std::vector<std::uint32_t> ends(std::size_t{1} << bits, 0);
  for (const Item& item : items) ++ends[slot_of(item)];
  std::uint32_t sum = 0;
  for (std::uint32_t& end : ends) sum = end += sum;
  std::vector<std::uint32_t> next(ends.size(), 0);
  std::copy(ends.begin(), ends.end() - 1, next.begin() + 1);
  for (std::size_t slot = 0, begin = 0; slot < ends.size(); begin = ends[slot++]) {
    while (next[slot] < ends[slot]) {
      if (steps.Stop()) return;
      Item& item = items[next[slot]];
      const std::size_t home = slot_of(item);
      if (home == slot) {
        ++next[slot];
      } else {
        std::swap(item, items[next[home]++]);
      }
    }
    std::sort(items.data() + begin, items.data() + ends[slot], less);
  }
}

void SortVertices(int dimension, Steps& steps, VertexColumns& v) {
  struct Row {
    VertexId id;
    std::uint32_t at;
  };
  std::vector<Row> rows(v.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) rows[i] = {v.ids[i], i};
  SortByHash(
      std::span(rows), steps, [](const Row& r) { return r.id; },
      [](const Row& a, const Row& b) { return a.id < b.id; });
  std::vector<std::uint32_t> order(rows.size());
  std::transform(rows.begin(), rows.end(), order.begin(), [](const Row& r) { return r.at; });
  Permute(order, 1, steps, v.ids);
  Permute(order, static_cast<std::size_t>(dimension), steps, v.coordinates);
  Permute(order, 1, steps, v.containing_dimensions);
  Permute(order, 1, steps, v.owners);
}

// Sorts whole rows in place: no cache miss per comparison, no copy of the largest column.
template <std::size_t kWidth>
void SortRows(Steps& steps, SimplexColumn& simplices) {
  using Row = std::array<VertexId, kWidth>;
  static_assert(sizeof(Row) == kWidth * sizeof(VertexId));
  const std::span rows(reinterpret_cast<Row*>(simplices.data()), simplices.size() / kWidth);
  SortByHash(
      rows, steps, [](const Row& r) { return r[0]; }, std::less<Row>());
}

// The same with a region at the end of each row.
template <std::size_t kWidth>
void SortRows(Steps& steps, SimplexColumn& simplices, RegionColumn& regions) {
  SimplexColumn rows(regions.size() * (kWidth + 1));
  for (std::size_t i = 0; i < regions.size(); ++i) {
    std::copy_n(&simplices[i * kWidth], kWidth, &rows[i * (kWidth + 1)]);
    rows[i * (kWidth + 1) + kWidth] = regions[i];
  }
  SortRows<kWidth + 1>(steps, rows);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    std::copy_n(&rows[i * (kWidth + 1)], kWidth, &simplices[i * kWidth]);
    regions[i] = rows[i * (kWidth + 1) + kWidth];
  }
}

void SortSimplices(int dimension, Steps& steps, SimplexColumn& simplices, RegionColumn& regions) {
  mesh_data::DropIfIdle(regions);
  if (regions.empty()) {
    return dimension == 2 ? SortRows<3>(steps, simplices) : SortRows<4>(steps, simplices);
  }
  dimension == 2 ? SortRows<3>(steps, simplices, regions) : SortRows<4>(steps, simplices, regions);
}

template <class Columns>
void SortConstraints(Steps& steps, Columns& constraints) {
  using Row = mesh_data::ConstraintKey<Columns>;
  std::vector<Row> rows(constraints.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = mesh_data::KeyOf(constraints, i);
  SortByHash(
      std::span(rows), steps, [](const Row& r) { return r[0]; }, std::less<Row>());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy(rows[i].begin(), rows[i].end() - 1,
              &mesh_data::IdsOf(constraints)[i * (rows[i].size() - 1)]);
    constraints.owners[i] = rows[i].back();
  }
}

}  // namespace

void mesh_data::Canonicalize(Mesh& mesh, Steps& steps) {
  SortVertices(mesh.dimension, steps, mesh.vertices);
  SortSimplices(mesh.dimension, steps, mesh.simplices, mesh.regions);
  KeepNamed(mesh.region_sets, {&mesh.regions});
  SortConstraints(steps, mesh.subsegments);
  SortConstraints(steps, mesh.subfacets);
}

void Canonicalize(Mesh& mesh) {
  AllSteps all;
  mesh_data::Canonicalize(mesh, all);
}

void Canonicalize(MeshDiff& diff) {
  AllSteps all;
  std::sort(diff.removed_vertices.begin(), diff.removed_vertices.end());
  SortSimplices(diff.dimension, all, diff.removed_simplices, diff.removed_regions);
  SortConstraints(all, diff.removed_subsegments);
  SortConstraints(all, diff.removed_subfacets);
  SortVertices(diff.dimension, all, diff.added_vertices);
  SortSimplices(diff.dimension, all, diff.added_simplices, diff.added_regions);
  mesh_data::KeepNamed(diff.region_sets, {&diff.removed_regions, &diff.added_regions});
  SortConstraints(all, diff.added_subsegments);
  SortConstraints(all, diff.added_subfacets);
}

}  // namespace dynmesh
