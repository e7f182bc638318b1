#include "core/mesh_data/chambers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/geometry/point.h"
#include "core/mesh_data/constraints.h"
#include "core/mesh_data/face_links.h"
#include "core/mesh_data/point_location.h"

namespace dynmesh::mesh_data {
namespace {

using geometry::Point;

// Is there anything but polygons around?
enum class Wall : std::uint8_t { kOfPolygon, kOfSegment };

template <int D>
class ChamberSearch {
 public:
  explicit ChamberSearch(const Mesh& mesh) : mesh_(mesh), rows_(mesh.simplex_count()) {
    IndexCorners();
    if constexpr (D == 2) {
      FindWalls(mesh.subsegments);
    } else {
      FindWalls(mesh.subfacets);
    }
    neighbours_.assign(rows_ * kWidth, kNoSlot);
    LinkAllFaces(cells_, kWidth, mesh.vertices.size(), neighbours_.data());
  }

  Chambers Run() {
    Chambers chambers;
    constexpr std::uint32_t kNone = PlaceInChambers::kNone;
    chambers.of.assign(rows_, kNone);
    std::vector<std::size_t> open;
    for (std::size_t first = 0; first < rows_; ++first) {
      if (chambers.of[first] != kNone) continue;
      const auto number = static_cast<std::uint32_t>(chambers.count());
      bool is_outside = false;
      chambers.of[first] = number;
      open.push_back(first);
      while (!open.empty()) {
        const std::size_t row = open.back();
        open.pop_back();
        for (std::size_t k = 0; k < kWidth; ++k) {
          const Slot next = neighbours_[row * kWidth + k];
          const bool is_border = next == kNoSlot;
          // Most sides are of simplices that are known already. To look for a wall takes longer.
          if (is_border ? is_outside : chambers.of[static_cast<std::size_t>(next)] != kNone) {
            continue;
          }
          if (IsWall(row, k)) continue;
          if (is_border) {
            is_outside = true;
            continue;
          }
          chambers.of[static_cast<std::size_t>(next)] = number;
          open.push_back(static_cast<std::size_t>(next));
        }
      }
      chambers.is_outside.push_back(is_outside);
      chambers.is_hole.push_back(D == 2 && !is_outside && mesh_.region(first) == kNoRegion);
    }
    if constexpr (D == 2) ExceptBehindSegments(chambers);
    chambers.corners = std::move(cells_);
    return chambers;
  }

 private:
  static constexpr std::size_t kWidth = D + 1;
  using Side = std::array<Slot, D>;

  void IndexCorners() {
    number_of_.reserve(mesh_.vertices.size());
    for (std::size_t i = 0; i < mesh_.vertices.size(); ++i) {
      number_of_.emplace(mesh_.vertices.ids[i], static_cast<Slot>(i));
    }
    cells_.reserve(mesh_.simplices.size());
    for (const VertexId id : mesh_.simplices) cells_.push_back(number_of_.at(id));
  }

  template <class Columns>
  void FindWalls(const Columns& constraints) {
    absl::flat_hash_set<FeatureId> polygons;
    for (const RegionId region : mesh_.regions) {
      if (region <= kLastPolygonId) polygons.insert(region);
    }
    for (const RegionSet& set : mesh_.region_sets) {
      polygons.insert(set.polygons.begin(), set.polygons.end());
    }
    is_at_wall_.assign(mesh_.vertices.size(), false);
    for (std::size_t i = 0; i < constraints.size(); ++i) {
      const auto key = KeyOf(constraints, i);
      const FeatureId owner = key.back();
      if (owner == kBoxFeature) continue;
      Side side;
      for (std::size_t k = 0; k < D; ++k) side[k] = number_of_.at(key[k]);
      std::sort(side.begin(), side.end());
      for (const Slot v : side) is_at_wall_[static_cast<std::size_t>(v)] = true;
      walls_.emplace(side, polygons.contains(owner) ? Wall::kOfPolygon : Wall::kOfSegment);
    }
  }

  // What has a segment around it is no hole. A segment with the same chamber on both sides is in
  // it.
  void ExceptBehindSegments(Chambers& chambers) const {
    for (std::size_t row = 0; row < rows_; ++row) {
      const std::uint32_t of = chambers.of[row];
      if (!chambers.is_hole[of]) continue;
      for (std::size_t k = 0; k < kWidth; ++k) {
        const Slot next = neighbours_[row * kWidth + k];
        if (next != kNoSlot && chambers.of[static_cast<std::size_t>(next)] == of) continue;
        const auto wall = walls_.find(SideOf(row, k));
        if (wall != walls_.end() && wall->second == Wall::kOfSegment) chambers.is_hole[of] = false;
      }
    }
  }

  bool IsWall(std::size_t row, std::size_t k) const {
    for (std::size_t j = 0; j < kWidth; ++j) {
      if (j != k && !is_at_wall_[static_cast<std::size_t>(cells_[row * kWidth + j])]) return false;
    }
    return walls_.contains(SideOf(row, k));
  }

  // The side opposite to corner k.
  Side SideOf(std::size_t row, std::size_t k) const {
    Side side;
    std::size_t count = 0;
    for (std::size_t j = 0; j < kWidth; ++j) {
      if (j != k) side[count++] = cells_[row * kWidth + j];
    }
    std::sort(side.begin(), side.end());
    return side;
  }

  const Mesh& mesh_;
  const std::size_t rows_;
  absl::flat_hash_map<VertexId, Slot> number_of_;
  std::vector<Slot> cells_, neighbours_;
  absl::flat_hash_map<Side, Wall> walls_;
  std::vector<bool> is_at_wall_;  // by vertex
};

// Predicates need 0 or magnitudes in their domain; what is in the mesh's box is not too large.
double InDomain(double value) { return std::abs(value) < 0x1p-200 ? 0 : value; }

template <int D>
std::vector<PlaceInChambers> Locate(const Mesh& mesh, const Chambers& chambers,
                                    std::span<const std::array<double, 3>> positions) {
  std::vector<PlaceInChambers> places(positions.size());
  std::vector<Point<D>> points(positions.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t k = 0; k < D; ++k) points[i].c[k] = InDomain(positions[i][k]);
  }
  const auto corners_of = [&](std::size_t row) {
    std::array<Point<D>, D + 1> corners;
    for (std::size_t j = 0; j <= D; ++j) {
      const auto v = static_cast<std::size_t>(chambers.corners[row * (D + 1) + j]);
      for (std::size_t k = 0; k < D; ++k) corners[j].c[k] = mesh.vertices.coordinates[D * v + k];
    }
    return corners;
  };
  ForEachContaining<D>(mesh.simplex_count(), corners_of, std::span<const Point<D>>(points),
                       [&](std::size_t row, std::size_t i) {
                         PlaceInChambers& place = places[i];
                         if (place.chamber == PlaceInChambers::kNone) {
                           place.chamber = chambers.of[row];
                         }
                         place.is_between |= place.chamber != chambers.of[row];
                       });
  return places;
}

}  // namespace

Chambers FindChambers(const Mesh& mesh) {
  return mesh.dimension == 2 ? ChamberSearch<2>(mesh).Run() : ChamberSearch<3>(mesh).Run();
}

std::vector<PlaceInChambers> LocateInChambers(const Mesh& mesh, const Chambers& chambers,
                                              std::span<const std::array<double, 3>> positions) {
  if (positions.empty()) return {};
  return mesh.dimension == 2 ? Locate<2>(mesh, chambers, positions)
                             : Locate<3>(mesh, chambers, positions);
}

}  // namespace dynmesh::mesh_data
