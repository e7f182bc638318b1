// Opened features of a part: copies of the vertices on them.
//
// The part's cells around a vertex fall into *sectors*: from cell to cell through facets that are
// not opened. Each has a copy of the vertex. So tips and crack fronts stay closed, and kinks,
// branches and mouths at the border open, without a rule for any of them.
#include <algorithm>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::At;
using part_state::kNone;

// ---- which features are opened

void MeshPart::State::ChooseOpen(const LabelColumn& labels) {
  open = {choice.open.begin(), choice.open.end()};
  for (const LabelOfFeature& of : labels) {
    if (!of.label.name.empty() && std::ranges::count(choice.open_names, of.label.name) > 0) {
      open.insert(of.id);
    }
  }
  open.erase(kNoFeature);
}

std::vector<FeatureId> MeshPart::State::FollowNames(const SlotMesh& mesh,
                                                    std::span<const MeshDiff* const> diffs) {
  std::vector<FeatureId> toggled;
  if (choice.open_names.empty()) return toggled;
  for (const MeshDiff* const diff : diffs) {
    for (const LabelOfFeature& of : diff->labels) {
      const std::string name = mesh.FindLabel(of.id).name;
      const bool is_open = std::ranges::count(choice.open, of.id) > 0 ||
                           (!name.empty() && std::ranges::count(choice.open_names, name) > 0);
      if (is_open == open.contains(of.id)) continue;
      is_open ? void(open.insert(of.id)) : void(open.erase(of.id));
      if (owned.contains(of.id)) toggled.push_back(of.id);
    }
  }
  return toggled;
}

void MeshPart::State::AddFacetsOf(std::vector<FeatureId> features,
                                  std::vector<FacetKey>& keys) const {
  // What has come with the diff, or has gone, is in it.
  std::erase_if(features, [&](FeatureId id) { return !owned.contains(id); });
  if (features.empty()) return;
  const std::size_t before = keys.size();
  for (const auto& [key, of] : owners) {
    for (const FeatureId id : of) {
      if (std::ranges::count(features, id) > 0) keys.push_back(key);
    }
  }
  std::sort(keys.begin() + static_cast<std::ptrdiff_t>(before), keys.end());
}

void MeshPart::State::SetOpen(const SlotMesh& mesh, std::span<const FacetKey> changed) {
  if (!HasSeams()) return;
  for (const FacetKey& key : changed) {
    const auto it = owners.find(key);
    const bool is_open = it != owners.end() && open.contains(*std::ranges::min_element(it->second));
    if (is_open == open_facets.contains(key)) continue;
    is_open ? void(open_facets.insert(key)) : void(open_facets.erase(key));
    for (std::size_t i = 0; i < facet_width(); ++i) {
      std::int32_t& count = seam_uses[key[i]];
      count += is_open ? 1 : -1;
      if (count == 0) seam_uses.erase(key[i]);
      const Slot slot = mesh.FindSlot(key[i]);
      if (slot != kNoSlot) seam_stars.push_back(slot);
    }
  }
}

// ---- copies

bool MeshPart::State::IsAtSeam(const SlotMesh& mesh, Slot vertex) const {
  if (!HasSeams()) return false;
  const std::int32_t first = vertex_numbers[At(vertex)];
  if (first != kNone && next_copy[At(first)] != kNone) return true;
  return seam_uses.contains(mesh.ids()[At(vertex)]);
}

void MeshPart::State::SetCopies(const SlotMesh& mesh) {
  // By slot: new copies get their numbers in this order.
  std::ranges::sort(seam_stars);
  const auto rest = std::ranges::unique(seam_stars);
  seam_stars.erase(rest.begin(), rest.end());
  for (const Slot vertex : seam_stars) SetCopiesOf(mesh, vertex);
  seam_stars.clear();
}

void MeshPart::State::SetCopiesOf(const SlotMesh& mesh, Slot vertex) {
  struct Corner {
    Slot cell;
    std::size_t k;
    std::size_t sector;
  };
  std::vector<Corner> star;
  ForEachCellAt(mesh, vertex, [&](Slot cell, std::size_t k) {
    if (Has(cell)) star.push_back({cell, k, 0});
    return false;
  });
  std::ranges::sort(star, {}, &Corner::cell);
  absl::flat_hash_map<Slot, std::size_t> place;
  for (std::size_t i = 0; i < star.size(); ++i) place[star[i].cell] = i;

  // Sectors, by their least cell.
  bool is_crossed = false;  // is there an opened facet with the part on both sides?
  std::size_t sectors = 0;
  std::vector<bool> is_known(star.size());
  std::vector<std::size_t> found;
  for (std::size_t i = 0; i < star.size(); ++i) {
    if (is_known[i]) continue;
    found.assign(1, i);
    is_known[i] = true;
    for (std::size_t n = 0; n < found.size(); ++n) {
      Corner& corner = star[found[n]];
      corner.sector = sectors;
      for (std::size_t k = 0; k < width(); ++k) {
        if (k == corner.k) continue;
        const auto beyond = place.find(mesh.neighbours()[At(corner.cell) * width() + k]);
        if (beyond == place.end()) continue;
        if (open_facets.contains(FacetOf(mesh, corner.cell, k))) {
          is_crossed = true;
        } else if (!is_known[beyond->second]) {
          is_known[beyond->second] = true;
          found.push_back(beyond->second);
        }
      }
    }
    ++sectors;
  }
  if (!is_crossed && sectors > 0) {
    // Parts of the part that only touch here are not taken apart.
    for (Corner& corner : star) corner.sector = 0;
    sectors = 1;
  }

  // A copy stays with the sector that has most of its cells; the others take what is left.
  std::vector<std::int32_t> number_of(sectors, kNone), free;
  std::vector<std::tuple<std::ptrdiff_t, std::int32_t, std::size_t>> claims;  // - cells, copy, ...
  for (std::int32_t copy = vertex_numbers[At(vertex)]; copy != kNone; copy = next_copy[At(copy)]) {
    for (std::size_t sector = 0; sector < sectors; ++sector) {
      const auto cells_here = std::ranges::count_if(star, [&](const Corner& c) {
        return c.sector == sector && cells[At(cell_numbers[At(c.cell)]) * width() + c.k] == copy;
      });
      if (cells_here > 0) claims.emplace_back(-cells_here, copy, sector);
    }
    free.push_back(copy);
  }
  std::ranges::sort(claims);
  const auto take = [&](std::size_t sector, std::vector<std::int32_t>::iterator copy) {
    if (number_of[sector] != kNone || copy == free.end()) return;
    number_of[sector] = *copy;
    free.erase(copy);
  };
  for (const auto& [cells_here, copy, sector] : claims) {
    take(sector, std::ranges::find(free, copy));
  }
  for (std::size_t sector = 0; sector < sectors; ++sector) {
    take(sector, free.begin());
    if (number_of[sector] == kNone) number_of[sector] = AddVertex(mesh, vertex);
  }
  for (const Corner& corner : star) SetCorner(corner.cell, corner.k, number_of[corner.sector]);
}

void MeshPart::State::SetCorner(Slot cell, std::size_t k, std::int32_t number) {
  const std::size_t row = At(cell_numbers[At(cell)]);
  const std::int32_t former = std::exchange(cells[row * width() + k], number);
  if (former == number) return;
  ++uses[At(number)];
  changes.cells.push_back(static_cast<std::int32_t>(row));
  if (former == kNone) return;  // a new cell has no facets yet
  if (--uses[At(former)] == 0) unused.push_back(vertex_slots[At(former)]);
  for (std::size_t j = 0; j < width(); ++j) {
    const std::int32_t facet = cell_facets[row * width() + j];
    if (facet == kNone || facet_cells[At(facet) * 2] != cell) continue;
    std::int32_t* const corners = facets.data() + At(facet) * facet_width();
    std::int32_t* const corner = std::find(corners, corners + facet_width(), former);
    if (corner == corners + facet_width()) continue;
    *corner = number;
    changes.facets.push_back(facet);
  }
}

void MeshPart::State::SetTwins(std::int32_t a, std::int32_t b) {
  const auto set = [&](std::int32_t facet, std::int32_t twin) {
    if (facet == kNone || facet_twins[At(facet)] == twin) return;
    facet_twins[At(facet)] = twin;
    changes.facets.push_back(facet);
  };
  if (facet_twins[At(a)] != b) set(facet_twins[At(a)], kNone);
  if (b != kNone && facet_twins[At(b)] != a) set(facet_twins[At(b)], kNone);
  set(a, b);
  set(b, a);
}

}  // namespace dynmesh
