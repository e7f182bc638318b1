// The facets of a part: its border, and subsegments and subfacets in it.
#include <utility>

#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::AddRow;
using part_state::At;
using part_state::KeyOf;
using part_state::kNone;
using part_state::MoveLast;

namespace {

// The corners of the facet opposite to each corner, such that the cell is on its left or below it.
constexpr std::size_t kEdgesOf[3][3] = {{1, 2}, {2, 0}, {0, 1}};
constexpr std::size_t kFacesOf[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

}  // namespace

part_state::FacetKey MeshPart::State::FacetOf(const SlotMesh& mesh, Slot cell,
                                              std::size_t k) const {
  VertexId ids[3] = {};
  std::size_t n = 0;
  for (std::size_t i = 0; i < width(); ++i) {
    if (i != k) ids[n++] = mesh.ids()[At(mesh.cells()[At(cell) * width() + i])];
  }
  return KeyOf(ids, n);
}

void MeshPart::State::RemoveFacet(std::int32_t facet) {
  const auto set = [&](std::size_t row, std::int32_t value) {
    for (std::size_t i = 0; i < 2; ++i) {
      const Slot cell = facet_cells[row * 2 + i];
      if (cell != kNoSlot) {
        cell_facets[At(cell_numbers[At(cell)]) * width() + facet_sides[row][i]] = value;
      }
    }
  };
  const std::size_t row = At(facet), last = facet_owners.size() - 1;
  set(row, kNone);
  SetTwins(facet, kNone);
  const std::int32_t twin = facet_twins[last];
  SetTwins(static_cast<std::int32_t>(last), kNone);
  if (row != last) {
    set(last, facet);
    changes.facets.push_back(facet);
  }
  MoveLast(facets, facet_width(), row);
  MoveLast(facet_owners, 1, row);
  MoveLast(facet_twins, 1, row);
  MoveLast(facet_cells, 2, row);
  if (row != last) SetTwins(facet, twin);
  facet_sides[row] = facet_sides[last];
  facet_sides.pop_back();
}

void MeshPart::State::AddFacet(Slot cell, std::size_t k, Slot other, std::size_t side,
                               FeatureId owner) {
  const auto facet = static_cast<std::int32_t>(facet_owners.size());
  facet_owners.resize(facet_owners.size() + 1, owner);
  facet_twins.resize(facet_owners.size(), kNone);
  AddRow(facets, facet_width(), kNone);
  const std::size_t row = AddRow(facet_cells, 2, kNoSlot);
  facet_cells[row * 2] = cell, facet_cells[row * 2 + 1] = other;
  facet_sides.push_back({static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(side)});
  const std::size_t number = At(cell_numbers[At(cell)]);
  for (std::size_t i = 0; i < facet_width(); ++i) {
    const std::size_t corner = dimension == 2 ? kEdgesOf[k][i] : kFacesOf[k][i];
    facets[row * facet_width() + i] = cells[number * width() + corner];
  }
  cell_facets[number * width() + k] = facet;
  if (other != kNoSlot) cell_facets[At(cell_numbers[At(other)]) * width() + side] = facet;
  changes.facets.push_back(facet);
}

void MeshPart::State::SetFacet(const SlotMesh& mesh, Slot cell, std::size_t k) {
  const Slot beyond = mesh.neighbours()[At(cell) * width() + k];
  const auto facet_here = [&] { return cell_facets[At(cell_numbers[At(cell)]) * width() + k]; };
  std::size_t side = 0;
  const auto facet_there = [&] {
    return Has(beyond) ? cell_facets[At(cell_numbers[At(beyond)]) * width() + side] : kNone;
  };
  if (Has(beyond)) {
    while (mesh.neighbours()[At(beyond) * width() + side] != cell) ++side;
  }
  const FacetKey key = FacetOf(mesh, cell, k);
  const auto it = owners.find(key);
  const bool is_constraint = it != owners.end();
  const FeatureId owner = is_constraint ? *std::ranges::min_element(it->second) : kNoFeature;
  const bool is_opened = Has(beyond) && open_facets.contains(key);
  const Slot other = is_opened || !Has(beyond) ? kNoSlot : beyond;
  // Until now it may have been at the border, or opened.
  if (other != kNoSlot && facet_there() != kNone && facet_there() != facet_here()) {
    RemoveFacet(facet_there());
  }
  const auto set_owner = [&](std::int32_t facet) {
    if (std::exchange(facet_owners[At(facet)], owner) != owner) changes.facets.push_back(facet);
  };
  const bool is_facet = is_constraint || other == kNoSlot;
  if (const std::int32_t facet = facet_here(); facet != kNone) {
    const Slot* const sides = facet_cells.data() + At(facet) * 2;
    const bool is_same = (sides[0] == cell && sides[1] == other) ||
                         (other != kNoSlot && sides[0] == other && sides[1] == cell);
    if (is_facet && is_same) {
      set_owner(facet);
    } else {
      RemoveFacet(facet);
    }
  }
  if (!is_facet) return;
  if (facet_here() == kNone) AddFacet(cell, k, other, side, owner);
  if (!is_opened) return;
  // The other side has a facet of its own. If it is still to come, it calls back.
  if (facet_there() == kNone) return SetFacet(mesh, beyond, side);
  set_owner(facet_there());
  SetTwins(facet_here(), facet_there());
}

void MeshPart::State::SetFacetsOf(const SlotMesh& mesh, Slot cell) {
  for (std::size_t k = 0; k < width(); ++k) SetFacet(mesh, cell, k);
}

void MeshPart::State::SetFacetsBeside(const SlotMesh& mesh, Slot cell) {
  if (Has(cell)) return SetFacetsOf(mesh, cell);
  for (std::size_t k = 0; k < width(); ++k) {
    const Slot beyond = mesh.neighbours()[At(cell) * width() + k];
    if (!Has(beyond)) continue;
    std::size_t side = 0;
    while (mesh.neighbours()[At(beyond) * width() + side] != cell) ++side;
    SetFacet(mesh, beyond, side);
  }
}

void MeshPart::State::SetFacetBetween(const SlotMesh& mesh, const FacetKey& key) {
  Slot slots[3] = {};
  for (std::size_t i = 0; i < facet_width(); ++i) {
    slots[i] = mesh.FindSlot(key[i]);
    if (slots[i] == kNoSlot) return;
  }
  ForEachCellAt(mesh, slots[0], [&](Slot cell, std::size_t) {
    if (!Has(cell)) return false;
    const Slot* const corners = mesh.cells().data() + At(cell) * width();
    std::size_t missing = width(), found = 0;
    for (std::size_t k = 0; k < width(); ++k) {
      if (std::find(slots, slots + facet_width(), corners[k]) != slots + facet_width()) {
        ++found;
      } else {
        missing = k;
      }
    }
    if (found != facet_width()) return false;
    SetFacet(mesh, cell, missing);
    return true;
  });
}

}  // namespace dynmesh
