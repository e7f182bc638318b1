// Fills slots from a whole mesh: every row gets its slot at once, without netting.
//
// Rows of a mesh are sorted by ids, which are hashes: neighbours are far apart. In slots they are
// near in memory: vertices are sorted along a Hilbert curve, simplices by the least slot of their
// corners. So a walk through the mesh hits the cache, here and in programs that use the slots.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/large_vector.h"
#include "core/geometry/hilbert_curve.h"
#include "core/mesh_data/slot_state.h"

namespace dynmesh {

using mesh_data::At;
using mesh_data::Lost;
using mesh_data::VertexName;
using text::Concat;

namespace {

// Random accesses are prefetched so many rows ahead.
constexpr std::size_t kAhead = 12;

// The rows of the vertices along the curve.
template <std::size_t D>
LargeVector<std::uint32_t> RowsAlongCurve(const std::vector<double>& coordinates) {
  constexpr int kLevels = 32 / D;
  const std::size_t count = coordinates.size() / D;
  std::array<double, D> low, scale;
  for (std::size_t k = 0; k < D; ++k) {
    double high = -INFINITY;
    low[k] = INFINITY;
    for (std::size_t i = k; i < coordinates.size(); i += D) {
      low[k] = std::min(low[k], coordinates[i]), high = std::max(high, coordinates[i]);
    }
    scale[k] = ((1 << kLevels) - 1) / (high - low[k]);
    if (!(scale[k] < INFINITY)) scale[k] = 0;  // no extent, or one that doubles cannot hold
  }
  LargeVector<std::uint64_t> keyed(count);  // the key, then the row
  for (std::size_t i = 0; i < count; ++i) {
    std::array<std::uint32_t, D> cell;
    for (std::size_t k = 0; k < D; ++k) {
      const double at = (coordinates[i * D + k] - low[k]) * scale[k];
      cell[k] = at > 0 ? static_cast<std::uint32_t>(at) : 0;  // also for NaN
    }
    keyed[i] = std::uint64_t{geometry::HilbertCurve<D>::Key(cell, kLevels)} << 32 | i;
  }
  std::sort(keyed.begin(), keyed.end());
  LargeVector<std::uint32_t> rows(count);
  for (std::size_t i = 0; i < count; ++i) rows[i] = static_cast<std::uint32_t>(keyed[i]);
  return rows;
}

// The rows of the simplices by the least slot of their corners.
LargeVector<std::uint32_t> RowsByLeastCorner(const LargeVector<Slot>& corners, std::size_t width,
                                             std::size_t vertex_count) {
  const std::size_t count = corners.size() / width;
  const auto least_of = [&](std::size_t row) {
    const Slot* const first = corners.data() + row * width;
    return At(*std::min_element(first, first + width));
  };
  LargeVector<std::uint32_t> begins(vertex_count + 1, 0), rows(count);
  for (std::size_t row = 0; row < count; ++row) ++begins[least_of(row) + 1];
  for (std::size_t v = 0; v < vertex_count; ++v) begins[v + 1] += begins[v];
  for (std::uint32_t row = 0; row < count; ++row) rows[begins[least_of(row)]++] = row;
  return rows;
}

}  // namespace

absl::Status SlotMesh::State::FillVertices(const Mesh& mesh, MeshHash& sum) {
  const VertexColumns& columns = mesh.vertices;
  const std::size_t count = columns.size();
  const auto rows = dimension == 2 ? RowsAlongCurve<2>(columns.coordinates)
                                   : RowsAlongCurve<3>(columns.coordinates);
  points.resize(count * d(), 0), ids.resize(count, 0);
  containing_dimensions.resize(count, 0), owners.resize(count, kNoFeature);
  vertices.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) vertices.prefetch(columns.ids[rows[i + kAhead]]);
    const std::size_t row = rows[i];
    const Slot slot = vertex_pool.Take();
    const VertexId id = columns.ids[row];
    if (id == 0) return Lost("a vertex", "has no id");
    if (!vertices.emplace(id, slot).second) return Lost(VertexName(id), "comes twice");
    PlaceVertex(slot, id, &columns.coordinates[row * d()], columns.containing_dimensions[row],
                columns.owners[row]);
    sum += HashOfVertex(slot);
  }
  return absl::OkStatus();
}

absl::Status SlotMesh::State::FillSimplices(const Mesh& mesh, MeshHash& sum) {
  const std::size_t count = mesh.simplex_count();
  LargeVector<Slot> corners(count * width());  // by row
  for (std::size_t i = 0; i < count; ++i) {
    const VertexId* row = &mesh.simplices[i * width()];
    if (i + kAhead < count) {
      for (std::size_t k = 0; k < width(); ++k) vertices.prefetch(row[kAhead * width() + k]);
    }
    SlotKey key;
    if (!SlotsOfRow(row, key)) return Lost("a simplex", "has a corner that is absent");
    std::copy_n(key.begin(), width(), &corners[i * width()]);
    sum += HashSimplex(row, dimension + 1, mesh.region(i));
  }
  const auto rows = RowsByLeastCorner(corners, width(), mesh.vertices.size());
  const auto key_of = [&](std::size_t i) {
    SlotKey key = {kNoSlot, kNoSlot, kNoSlot, kNoSlot};
    std::copy_n(&corners[rows[i] * width()], width(), key.begin());
    return key;
  };
  cells.resize(count * width(), kNoSlot), neighbours.resize(count * width(), kNoSlot);
  regions.resize(count, kNoRegion), simplices.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (i + kAhead < count) simplices.prefetch(key_of(i + kAhead));
    if (!PlaceSimplex(simplex_pool.Take(), key_of(i), mesh.region(rows[i]))) {
      return Lost("a simplex", "comes twice");
    }
  }
  mesh_data::LinkAllFaces(cells.span(), width(), mesh.vertices.size(), neighbours.data());
  return absl::OkStatus();
}

absl::Status SlotMesh::State::Fill(const Mesh& mesh) {
  if (std::max(mesh.vertices.size(), mesh.simplex_count()) >= std::size_t{1} << 31) {
    return absl::InvalidArgumentError("a mesh of 2^31 rows or more has no slots");
  }
  MeshHash sum;
  if (auto status = FillVertices(mesh, sum); !status.ok()) return status;
  if (auto status = FillSimplices(mesh, sum); !status.ok()) return status;

  MeshDiff rest;  // constraints and sets are added as by a diff
  rest.dimension = dimension;
  if (auto s = subsegments.Net({}, mesh.subsegments, sum); !s.ok()) return s;
  if (auto s = subfacets.Net({}, mesh.subfacets, sum); !s.ok()) return s;
  if (sum != mesh.hash) {
    return Lost("the mesh",
                Concat("has hash ", sum.ToHex(), " where ", mesh.hash.ToHex(), " was promised"));
  }
  for (const auto* ends : {&mesh.subsegments.ends, &mesh.subfacets.corners}) {
    for (const VertexId id : *ends) {
      if (!vertices.contains(id))
        return Lost("a subsegment or subfacet", "has a corner that is absent");
    }
  }
  const auto slot_of = [this](VertexId id) { return FindVertex(id); };
  subsegments.Commit({}, mesh.subsegments, slot_of);
  subfacets.Commit({}, mesh.subfacets, slot_of);
  rest.region_sets = mesh.region_sets, rest.added_regions = mesh.regions;
  CommitSets(rest);
  CommitLabels(mesh.labels);
  revision = patch.from_revision = patch.to_revision = mesh.revision;
  hash = mesh.hash;
  return absl::OkStatus();
}

}  // namespace dynmesh
