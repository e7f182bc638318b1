// Copies of a part's columns that are kept up to date by the rows that its updates name.
#ifndef DYNMESH_TESTS_CORE_DYNAMIC_MESH_PART_SHADOWS_H_
#define DYNMESH_TESTS_CORE_DYNAMIC_MESH_PART_SHADOWS_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "dynmesh/part.h"

namespace dynmesh::test {

// A copy of a column that is kept up to date by the rows that an update names.
template <class T>
class Shadow {
 public:
  void Follow(const SlotColumn<T>& column, std::size_t width, bool is_all,
              const std::vector<std::int32_t>& rows) {
    const auto copy = [&](std::size_t row) {
      std::copy_n(column.data() + row * width, width,
                  values_.begin() + static_cast<std::ptrdiff_t>(row * width));
    };
    const std::size_t before = std::min(values_.size(), column.size());
    values_.resize(column.size());
    std::copy(column.data() + before, column.data() + column.size(),
              values_.begin() + static_cast<std::ptrdiff_t>(before));
    if (is_all) values_.assign(column.data(), column.data() + column.size());
    for (const std::int32_t row : rows) {
      if (static_cast<std::size_t>(row) * width < column.size()) {
        copy(static_cast<std::size_t>(row));
      }
    }
    EXPECT_TRUE(std::ranges::equal(values_, column.span()));
  }

 private:
  std::vector<T> values_;
};

struct PartShadows {
  Shadow<double> points;
  Shadow<Slot> vertex_slots, origin, cell_slots, facet_cells, facet_twins, cells, facets,
      vertex_numbers, cell_numbers;
  Shadow<RegionId> regions;
  Shadow<FeatureId> owners;

  void Follow(const MeshPart& part) {
    const auto d = static_cast<std::size_t>(part.dimension());
    const MeshPart::Changes& c = part.changes();
    points.Follow(part.points(), d, c.is_all, c.vertices);
    vertex_slots.Follow(part.vertex_slots(), 1, c.is_all, c.vertices);
    origin.Follow(part.origin(), 1, c.is_all, c.vertices);
    cells.Follow(part.cells(), d + 1, c.is_all, c.cells);
    cell_slots.Follow(part.cell_slots(), 1, c.is_all, c.cells);
    regions.Follow(part.cell_regions(), 1, c.is_all, c.cells);
    facets.Follow(part.facets(), d, c.is_all, c.facets);
    owners.Follow(part.facet_owners(), 1, c.is_all, c.facets);
    facet_twins.Follow(part.facet_twins(), 1, c.is_all, c.facets);
    facet_cells.Follow(part.facet_cells(), 2, c.is_all, c.facets);
    vertex_numbers.Follow(part.vertex_numbers(), 1, c.is_all, c.vertex_slots);
    cell_numbers.Follow(part.cell_numbers(), 1, c.is_all, c.cell_slots);
  }
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CORE_DYNAMIC_MESH_PART_SHADOWS_H_
