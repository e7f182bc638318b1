// Vertices and cells of a part.
#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::AddRow;
using part_state::At;
using part_state::kNone;
using part_state::MoveLast;

std::int32_t MeshPart::State::AddVertex(const SlotMesh& mesh, Slot slot) {
  const auto number = static_cast<std::int32_t>(vertex_slots.size());
  vertex_slots.resize(vertex_slots.size() + 1, slot);
  const std::size_t row = AddRow(points, facet_width(), 0.0);
  for (std::size_t i = 0; i < facet_width(); ++i) {
    points[row * facet_width() + i] = mesh.points()[At(slot) * facet_width() + i];
  }
  uses.push_back(0);
  next_copy.push_back(kNone);
  const std::int32_t first = vertex_numbers[At(slot)];
  origin.resize(row + 1, first == kNone ? number : first);
  if (first == kNone) {
    SetVertexNumber(slot, number);
  } else {
    std::int32_t last = first;
    while (next_copy[At(last)] != kNone) last = next_copy[At(last)];
    next_copy[At(last)] = number;
  }
  changes.vertices.push_back(number);
  return number;
}

void MeshPart::State::SetVertexNumber(Slot slot, std::int32_t number) {
  vertex_numbers[At(slot)] = number;
  changes.vertex_slots.push_back(slot);
}

void MeshPart::State::SetCellNumber(Slot slot, std::int32_t number) {
  cell_numbers[At(slot)] = number;
  changes.cell_slots.push_back(slot);
}

void MeshPart::State::NoteCellAt(const SlotMesh& mesh, Slot cell) {
  for (std::size_t k = 0; k < width(); ++k) {
    cell_at[At(mesh.cells()[At(cell) * width() + k])] = cell;
  }
}

void MeshPart::State::AddCell(const SlotMesh& mesh, Slot slot) {
  const std::size_t row = AddRow(cells, width(), kNone);
  for (std::size_t k = 0; k < width(); ++k) {
    const Slot vertex = mesh.cells()[At(slot) * width() + k];
    if (IsAtSeam(mesh, vertex)) {
      seam_stars.push_back(vertex);
      continue;
    }
    std::int32_t number = vertex_numbers[At(vertex)];
    if (number == kNone) number = AddVertex(mesh, vertex);
    cells[row * width() + k] = number;
    ++uses[At(number)];
  }
  cell_slots.resize(row + 1, slot);
  cell_regions.resize(row + 1, mesh.regions()[At(slot)]);
  cell_facets.resize((row + 1) * width(), kNone);
  SetCellNumber(slot, static_cast<std::int32_t>(row));
  changes.cells.push_back(static_cast<std::int32_t>(row));
}

void MeshPart::State::RemoveCell(const SlotMesh& mesh, Slot slot, std::vector<Slot>& left) {
  const std::int32_t number = cell_numbers[At(slot)];
  const std::size_t row = At(number);
  for (std::size_t k = 0; k < width(); ++k) {
    const std::int32_t facet = cell_facets[row * width() + k];
    if (facet != kNone) {
      for (std::size_t i = 0; i < 2; ++i) {
        const Slot other = facet_cells[At(facet) * 2 + i];
        if (other != kNoSlot && other != slot) left.push_back(other);
      }
      RemoveFacet(facet);
    }
    const std::int32_t vertex = cells[row * width() + k];
    const Slot of = vertex_slots[At(vertex)];
    if (--uses[At(vertex)] == 0) unused.push_back(of);
    if (IsAtSeam(mesh, of)) seam_stars.push_back(of);
  }
  const std::size_t last = cell_slots.size() - 1;
  if (row != last) {
    SetCellNumber(cell_slots[last], number);
    changes.cells.push_back(number);
    std::copy_n(cell_facets.begin() + static_cast<std::ptrdiff_t>(last * width()), width(),
                cell_facets.begin() + static_cast<std::ptrdiff_t>(row * width()));
  }
  MoveLast(cells, width(), row);
  MoveLast(cell_slots, 1, row);
  MoveLast(cell_regions, 1, row);
  cell_facets.resize(last * width());
  SetCellNumber(slot, kNone);
}

void MeshPart::State::DropUnused(const SlotMesh& mesh) {
  for (const Slot slot : unused) {
    std::int32_t number = vertex_numbers[At(slot)];
    while (number != kNone) {
      if (uses[At(number)] != 0) {
        number = next_copy[At(number)];
        continue;
      }
      DropVertex(mesh, number);
      number = vertex_numbers[At(slot)];  // from the first one: numbers have changed
    }
  }
  unused.clear();
}

// The last one takes its number.
void MeshPart::State::DropVertex(const SlotMesh& mesh, std::int32_t number) {
  Unlink(number);
  const std::size_t row = At(number), last = vertex_slots.size() - 1;
  const Slot moved = vertex_slots[last];
  MoveLast(points, facet_width(), row);
  MoveLast(vertex_slots, 1, row);
  MoveLast(origin, 1, row);
  uses[row] = uses[last], next_copy[row] = next_copy[last];
  uses.pop_back(), next_copy.pop_back();
  if (row == last) return;
  changes.vertices.push_back(number);
  if (vertex_numbers[At(moved)] == static_cast<std::int32_t>(last)) {
    SetVertexNumber(moved, number);
    SetOrigins(moved);
  } else {
    std::int32_t before = vertex_numbers[At(moved)];
    while (next_copy[At(before)] != static_cast<std::int32_t>(last)) before = next_copy[At(before)];
    next_copy[At(before)] = number;
  }
  // One that has lost its last cell goes later.
  if (uses[row] != 0) Renumber(mesh, moved, static_cast<std::int32_t>(last), number);
}

// From the copies of its vertex.
void MeshPart::State::Unlink(std::int32_t number) {
  const Slot slot = vertex_slots[At(number)];
  std::int32_t before = vertex_numbers[At(slot)];
  if (before == number) {
    SetVertexNumber(slot, next_copy[At(number)]);
    return SetOrigins(slot);
  }
  while (next_copy[At(before)] != number) before = next_copy[At(before)];
  next_copy[At(before)] = next_copy[At(number)];
}

// Of all copies, after another one has become the first.
void MeshPart::State::SetOrigins(Slot slot) {
  const std::int32_t first = vertex_numbers[At(slot)];
  for (std::int32_t copy = first; copy != kNone; copy = next_copy[At(copy)]) {
    origin[At(copy)] = first;
    changes.vertices.push_back(copy);
  }
}

void MeshPart::State::Renumber(const SlotMesh& mesh, Slot vertex, std::int32_t from,
                               std::int32_t to) {
  ForEachCellAt(mesh, vertex, [&](Slot cell, std::size_t) {
    const std::int32_t number = cell_numbers[At(cell)];
    if (number == kNone) return false;
    const std::size_t row = At(number);
    std::int32_t* const corners = cells.data() + row * width();
    std::int32_t* const corner = std::find(corners, corners + width(), from);
    if (corner == corners + width()) return false;  // it has another copy
    *corner = to;
    for (std::size_t k = 0; k < width(); ++k) {
      const std::int32_t facet = cell_facets[row * width() + k];
      if (facet == kNone) continue;
      for (std::size_t i = 0; i < facet_width(); ++i) {
        std::int32_t& end = facets[At(facet) * facet_width() + i];
        if (end == from) {
          end = to;
          changes.facets.push_back(facet);
        }
      }
    }
    changes.cells.push_back(number);
    return false;
  });
}

}  // namespace dynmesh
