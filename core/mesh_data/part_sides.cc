// The sides of a part's opened features.
#include <algorithm>
#include <array>

#include "core/base/feature_kinds.h"
#include "core/mesh_data/part_state.h"

namespace dynmesh {

using part_state::At;

namespace {

using Vector = std::array<double, 3>;

Vector Minus(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double Dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// By feature: along a segment, or to where a polygon's first ring is counter-clockwise.
absl::flat_hash_map<FeatureId, Vector> DirectionsOf(std::span<const Feature> features,
                                                    const absl::flat_hash_set<FeatureId>& open) {
  absl::flat_hash_map<FeatureId, Vector> position, directions;
  for (const Feature& f : features) {
    if (IsPoint(f)) position[f.id] = f.position;
  }
  const auto add_normal = [&](const APolygon& p) {
    if (p.rings.empty()) return;
    const std::vector<FeatureId>& ring = p.rings[0];
    Vector normal = {};
    for (std::size_t i = 2; i < ring.size(); ++i) {
      const Vector from = position[ring[0]];
      const Vector part = Cross(Minus(position[ring[i - 1]], from), Minus(position[ring[i]], from));
      for (std::size_t k = 0; k < 3; ++k) normal[k] += part[k];
    }
    directions[p.id] = normal;
  };
  for (const Feature& f : features) {
    if (!open.contains(f.id)) continue;
    Visit(
        f,
        [&](const ASegment& s) {
          directions[s.id] = Minus(position[s.ends[1]], position[s.ends[0]]);
        },
        add_normal, Ignore<APoint, ASize>);
  }
  return directions;
}

}  // namespace

absl::StatusOr<std::vector<std::int8_t>> MeshPart::FacetSides(
    const SlotMesh& mesh, std::span<const Feature> features) const {
  if (absl::Status s = state_->CheckIsAt(mesh); !s.ok()) return s;
  const State& state = *state_;
  const std::size_t d = state.facet_width();
  const auto directions = DirectionsOf(features, state.open);
  const std::vector<RegionSet> sets = mesh.region_sets();
  absl::flat_hash_set<FeatureId> areas;
  for (const Feature& f : features) {
    if (d == 2 && Is<APolygon>(f, Not<APoint, ASegment, ASize>)) areas.insert(f.id);
  }
  const auto position = [&](std::size_t row, std::size_t corner) {
    Vector at = {};
    std::copy_n(state.points.data() + At(state.facets[row * d + corner]) * d, d, at.begin());
    return at;
  };
  std::vector<std::int8_t> sides(state.facet_owners.size());
  for (std::size_t row = 0; row < sides.size(); ++row) {
    const FeatureId owner = state.facet_owners[row];
    if (state.facet_cells[2 * row + 1] != kNoSlot || !state.open.contains(owner)) continue;
    bool is_first = false;
    if (areas.contains(owner)) {
      const mesh_data::RegionChoice inside = {{owner}, false, {}};
      is_first =
          mesh_data::RegionFilter(inside, sets).Has(mesh.regions()[At(state.facet_cells[2 * row])]);
    } else if (const auto it = directions.find(owner); it != directions.end()) {
      const Vector along = Minus(position(row, 1), position(row, 0));
      // The cell is on the left of an edge, and behind a triangle.
      is_first = d == 2
                     ? Dot(along, it->second) > 0
                     : Dot(Cross(along, Minus(position(row, 2), position(row, 0))), it->second) < 0;
    } else {
      continue;
    }
    sides[row] = is_first ? 1 : -1;
  }
  return sides;
}

}  // namespace dynmesh
