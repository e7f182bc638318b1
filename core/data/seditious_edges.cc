#include "core/data/seditious_edges.h"

#include <cmath>

#include "core/geometry/angles.h"
#include "core/geometry/point.h"
#include "dynmesh/quality.h"

namespace dynmesh::data {
namespace {

constexpr std::size_t kNoRow = ~std::size_t{0};
// Coordinates of vertices on segments are off by a few spacings of doubles.
constexpr double kToleranceUnits = 16;

}  // namespace

SeditiousEdges::SeditiousEdges(const Mesh& mesh,
                               const absl::flat_hash_map<VertexId, std::size_t>& row_of)
    : mesh_(mesh), tolerance_(kToleranceUnits * CoordinateUnit(mesh.vertices.coordinates)) {
  for (std::size_t s = 0; s < mesh.subsegments.size(); ++s) {
    const FeatureId owner = mesh.subsegments.owners[s];
    if (owner == kBoxFeature) continue;
    for (const VertexId id : {mesh.subsegments.ends[2 * s], mesh.subsegments.ends[2 * s + 1]}) {
      const auto row = row_of.find(id);
      if (row == row_of.end() || mesh.vertices.containing_dimensions[row->second] != 0) continue;
      auto& ends = ends_.try_emplace(owner, std::array{kNoRow, kNoRow}).first->second;
      ends[ends[0] == kNoRow ? 0 : 1] = row->second;
    }
  }
}

bool SeditiousEdges::Has(std::size_t p, std::size_t q) const {
  const VertexColumns& v = mesh_.vertices;
  if (v.containing_dimensions[p] != 1 || v.containing_dimensions[q] != 1) return false;
  const auto s = ends_.find(v.owners[p]), t = ends_.find(v.owners[q]);
  if (s == t || s == ends_.end() || t == ends_.end()) return false;
  const auto at = [&](std::size_t row) {
    return geometry::Point2{{v.coordinates[2 * row], v.coordinates[2 * row + 1]}};
  };
  const auto distance = [&](std::size_t a, std::size_t b) {
    return std::sqrt(geometry::SquaredDistance(at(a), at(b)));
  };
  for (const std::size_t i : {0, 1}) {
    for (const std::size_t j : {0, 1}) {
      const std::size_t apex = s->second[i], other_s = s->second[1 - i], other_t = t->second[1 - j];
      if (apex == kNoRow || apex != t->second[j] || other_s == kNoRow || other_t == kNoRow) {
        continue;
      }
      if (geometry::IsSmallAngle(at(apex), at(other_s), at(other_t)) &&
          std::fabs(distance(apex, p) - distance(apex, q)) <= tolerance_) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace dynmesh::data
