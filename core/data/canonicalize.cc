// The canonical order of rows: what makes two equal meshes equal byte by byte.
// O(n lg n) in the number of rows.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <utility>
#include <vector>

#include "core/data/pieces.h"
#include "core/data/regions.h"
#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

// Rows of `width` entries, rearranged so that row i is the former row order[i].
template <class T>
void Permute(const std::vector<std::uint32_t>& order, std::size_t width, std::vector<T>& column) {
  std::vector<T> sorted;
  sorted.reserve(column.size());
  for (const std::size_t row : order) {
    const auto begin = column.begin() + static_cast<std::ptrdiff_t>(row * width);
    sorted.insert(sorted.end(), begin, begin + static_cast<std::ptrdiff_t>(width));
  }
  column = std::move(sorted);
}

// Sorts items by a leading key that is an id, hence a uniform hash, and what `less` adds to
// it: dealt out, in place, to about as many slots as there are items, by leading bits, they
// stand nearly in order.
template <class Item, class KeyOf, class Less>
void SortByHash(std::span<Item> items, KeyOf key_of, Less less) {
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

void SortVertices(int dimension, VertexColumns& v) {
  struct Row {
    VertexId id;
    std::uint32_t at;
  };
  std::vector<Row> rows(v.size());
  for (std::uint32_t i = 0; i < rows.size(); ++i) rows[i] = {v.ids[i], i};
  SortByHash(
      std::span(rows), [](const Row& r) { return r.id; },
      [](const Row& a, const Row& b) { return a.id < b.id; });
  std::vector<std::uint32_t> order(rows.size());
  std::transform(rows.begin(), rows.end(), order.begin(), [](const Row& r) { return r.at; });
  Permute(order, 1, v.ids);
  Permute(order, static_cast<std::size_t>(dimension), v.coordinates);
  Permute(order, 1, v.containing_dimensions);
  Permute(order, 1, v.owners);
}

// Whole rows are sorted, where they are: no cache miss per comparison, no copy of the
// largest column.
template <std::size_t kWidth>
void SortRows(SimplexColumn& simplices) {
  using Row = std::array<VertexId, kWidth>;
  static_assert(sizeof(Row) == kWidth * sizeof(VertexId));
  const std::span rows(reinterpret_cast<Row*>(simplices.data()), simplices.size() / kWidth);
  SortByHash(
      rows, [](const Row& r) { return r[0]; }, std::less<Row>());
}

// The same with a region at the end of each row.
template <std::size_t kWidth>
void SortRows(SimplexColumn& simplices, RegionColumn& regions) {
  SimplexColumn rows(regions.size() * (kWidth + 1));
  for (std::size_t i = 0; i < regions.size(); ++i) {
    std::copy_n(&simplices[i * kWidth], kWidth, &rows[i * (kWidth + 1)]);
    rows[i * (kWidth + 1) + kWidth] = regions[i];
  }
  SortRows<kWidth + 1>(rows);
  for (std::size_t i = 0; i < regions.size(); ++i) {
    std::copy_n(&rows[i * (kWidth + 1)], kWidth, &simplices[i * kWidth]);
    regions[i] = rows[i * (kWidth + 1) + kWidth];
  }
}

void SortSimplices(int dimension, SimplexColumn& simplices, RegionColumn& regions) {
  data::DropIfIdle(regions);
  if (regions.empty()) return dimension == 2 ? SortRows<3>(simplices) : SortRows<4>(simplices);
  dimension == 2 ? SortRows<3>(simplices, regions) : SortRows<4>(simplices, regions);
}

template <class Columns>
void SortPieces(Columns& pieces) {
  std::vector<data::PieceKey<Columns>> rows(pieces.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = data::KeyOf(pieces, i);
  std::sort(rows.begin(), rows.end());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::copy(rows[i].begin(), rows[i].end() - 1, &data::IdsOf(pieces)[i * (rows[i].size() - 1)]);
    pieces.owners[i] = rows[i].back();
  }
}

}  // namespace

void Canonicalize(Mesh& mesh) {
  SortVertices(mesh.dimension, mesh.vertices);
  SortSimplices(mesh.dimension, mesh.simplices, mesh.regions);
  data::KeepNamed(mesh.region_sets, {&mesh.regions});
  SortPieces(mesh.subsegments);
  SortPieces(mesh.subfacets);
}

void Canonicalize(MeshDiff& diff) {
  std::sort(diff.removed_vertices.begin(), diff.removed_vertices.end());
  SortSimplices(diff.dimension, diff.removed_simplices, diff.removed_regions);
  SortPieces(diff.removed_subsegments);
  SortPieces(diff.removed_subfacets);
  SortVertices(diff.dimension, diff.added_vertices);
  SortSimplices(diff.dimension, diff.added_simplices, diff.added_regions);
  data::KeepNamed(diff.region_sets, {&diff.removed_regions, &diff.added_regions});
  SortPieces(diff.added_subsegments);
  SortPieces(diff.added_subfacets);
}

}  // namespace dynmesh
