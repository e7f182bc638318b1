#include "core/quality/seditious_edges.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/geometry/angles.h"
#include "core/geometry/point.h"
#include "dynmesh/quality.h"

namespace dynmesh::quality {
namespace {

// Vertices on segments are off by a few ulps.
constexpr double kToleranceUnits = 16;
// In 3D vertices of shells are beside them on purpose, each by less than half of this part of the
// distance (meshing/shells.h).
constexpr double kSkew = 0x1p-17;

}  // namespace

// A polygon owns many segments. Which vertices lie on one segment follows from the chains of
// subsegments.
SeditiousEdges::SeditiousEdges(const Mesh& mesh, const IdTable& row_of)
    : mesh_(mesh), tolerance_(kToleranceUnits * CoordinateUnit(mesh.vertices.coordinates)) {
  using Row = std::size_t;
  const auto is_inner = [&](Row row) { return mesh.vertices.containing_dimensions[row] == 1; };
  // Each vertex inside a segment has a neighbour on either side.
  absl::flat_hash_map<Row, std::array<Row, 2>> beside;
  std::vector<std::array<Row, 2>> starts;  // the end of a segment, and the vertex next to it
  const bool has_facets = mesh.dimension == 3 && mesh.subfacets.size() > 0;
  std::vector<std::pair<Row, Row>> ways;  // the same of all segments; for facets
  for (std::size_t s = 0; s < mesh.subsegments.size(); ++s) {
    if (mesh.subsegments.owners[s] == kBoxFeature) continue;
    const Row a = row_of.Find(mesh.subsegments.ends[2 * s]);
    const Row b = row_of.Find(mesh.subsegments.ends[2 * s + 1]);
    if (a == IdTable::kNone || b == IdTable::kNone) continue;
    for (const auto& [from, to] : {std::pair(a, b), {b, a}}) {
      if (has_facets && !is_inner(from)) ways.emplace_back(from, to);
      if (is_inner(from)) {
        const auto [it, is_first] = beside.try_emplace(from, std::array{to, to});
        if (!is_first) it->second[1] = to;
      } else if (is_inner(to)) {
        starts.push_back({from, to});
      }
    }
  }
  for (const auto& [end, next] : starts) {
    if (segment_of_.contains(next)) continue;  // found from the other end
    const auto segment = static_cast<std::uint32_t>(ends_.size());
    Row before = end, row = next;
    while (is_inner(row) && segment_of_.try_emplace(row, segment).second) {
      const auto& [p, q] = beside.at(row);
      const Row after = p == before ? q : p;
      before = row;
      row = after;
    }
    ends_.push_back({end, row});
  }
  if (has_facets) corners_ = SharpCorners(mesh, row_of, ways);
}

bool SeditiousEdges::Has(std::size_t p, std::size_t q) const {
  return IsOfSegments(p, q) || (!corners_.empty() && IsOfFacets(p, q));
}

bool SeditiousEdges::IsOfFacets(std::size_t p, std::size_t q) const {
  const auto at = [&](std::size_t row) {
    const double* const x = &mesh_.vertices.coordinates[3 * row];
    return geometry::Point3{{x[0], x[1], x[2]}};
  };
  const double chord = std::sqrt(geometry::SquaredDistance(at(p), at(q)));
  const auto is_common = [&](std::size_t corner) {
    const double to_p = std::sqrt(geometry::SquaredDistance(at(corner), at(p)));
    const double to_q = std::sqrt(geometry::SquaredDistance(at(corner), at(q)));
    return chord < to_p && std::fabs(to_p - to_q) <= tolerance_ + kSkew * to_p;
  };
  // The sharp corners of the features of a vertex: of its facets, and the ends of its segment.
  const auto of = [&](std::size_t row) {
    std::vector<std::size_t> corners = corners_.Of(row);
    if (const auto s = segment_of_.find(row); s != segment_of_.end()) {
      for (const std::size_t end : ends_[s->second]) {
        if (corners_.Has(end)) corners.push_back(end);
      }
    }
    return corners;
  };
  const std::vector<std::size_t> of_q = of(q);
  if (of_q.empty()) return false;
  return std::ranges::any_of(of(p), [&](std::size_t corner) {
    return std::ranges::find(of_q, corner) != of_q.end() && is_common(corner);
  });
}

bool SeditiousEdges::IsOfSegments(std::size_t p, std::size_t q) const {
  const VertexColumns& v = mesh_.vertices;
  const auto s = segment_of_.find(p), t = segment_of_.find(q);
  if (s == segment_of_.end() || t == segment_of_.end() || s->second == t->second) return false;
  const auto d = static_cast<std::size_t>(mesh_.dimension);
  const auto at = [&](std::size_t row) {
    const double* const x = &v.coordinates[d * row];
    return geometry::Point3{{x[0], x[1], d == 3 ? x[2] : 0}};
  };
  const auto distance = [&](std::size_t a, std::size_t b) {
    return std::sqrt(geometry::SquaredDistance(at(a), at(b)));
  };
  for (const std::size_t i : {0, 1}) {
    for (const std::size_t j : {0, 1}) {
      const auto &of_s = ends_[s->second], &of_t = ends_[t->second];
      const std::size_t apex = of_s[i], other_s = of_s[1 - i], other_t = of_t[1 - j];
      if (apex != of_t[j]) continue;
      const double to_p = distance(apex, p);
      if (geometry::IsSmallAngle(at(apex), at(other_s), at(other_t)) &&
          std::fabs(to_p - distance(apex, q)) <= tolerance_ + (d == 3 ? kSkew * to_p : 0)) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace dynmesh::quality
