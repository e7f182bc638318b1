#include "core/quality/sharp_corners.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/circumball.h"

namespace dynmesh::quality {
namespace {

using geometry::Cross;
using geometry::Dot;
using Vector = geometry::Vector3;
using Triangle = std::array<std::size_t, 3>;

// Facets that meet at 70 degrees or more need no vertices at equal distances.
constexpr double kLeastCosine = 0.342;

Vector Between(const Mesh& mesh, std::size_t p, std::size_t q) {
  Vector d;
  for (std::size_t k = 0; k < 3; ++k) {
    d[k] = mesh.vertices.coordinates[3 * q + k] - mesh.vertices.coordinates[3 * p + k];
  }
  return d;
}

// Does the way from the corner t[0] to the vertex `next` rise over the triangle, or over a side
// inside the facet, at a small angle?
bool RisesOver(const Mesh& mesh, std::size_t next, const Triangle& t) {
  if (next == t[1] || next == t[2]) return false;  // it is a side
  const Vector d = Between(mesh, t[0], next);
  const Vector u = Between(mesh, t[0], t[1]), w = Between(mesh, t[0], t[2]), n = Cross(u, w);
  const double up = Dot(d, n), n2 = Dot(n, n), d2 = Dot(d, d);
  if (!(d2 - up * up / n2 > kLeastCosine * kLeastCosine * d2)) return false;
  // The foot of d is a u + b w.
  const double a = Dot(Cross(d, w), n), b = Dot(Cross(u, d), n);
  return a > -1e-9 * n2 * std::sqrt(d2 / Dot(u, u)) && b > -1e-9 * n2 * std::sqrt(d2 / Dot(w, w));
}

// Do two triangles with the corner t[0] = s[0] have an edge there in common, at a small angle?
bool MeetSharply(const Mesh& mesh, const Triangle& t, const Triangle& s) {
  for (const std::size_t i : {1, 2}) {
    for (const std::size_t j : {1, 2}) {
      if (t[i] != s[j]) continue;
      const Vector e = Between(mesh, t[0], t[i]);
      const Vector n = Cross(e, Between(mesh, t[0], t[3 - i]));
      const Vector m = Cross(e, Between(mesh, t[0], s[3 - j]));
      return Dot(n, m) > kLeastCosine * std::sqrt(Dot(n, n) * Dot(m, m));
    }
  }
  return false;
}

}  // namespace

SharpCorners::SharpCorners(const Mesh& mesh, const IdTable& row_of,
                           const std::vector<std::pair<Row, Row>>& ways) {
  struct Fan {
    std::vector<Row> ways;
    std::vector<std::pair<Triangle, FeatureId>> triangles;
  };
  absl::flat_hash_map<Row, Fan> fans;
  absl::flat_hash_map<Row, std::vector<FeatureId>> facets_of;
  absl::flat_hash_map<FeatureId, std::vector<Row>> corners_of;
  for (const auto& [corner, next] : ways) fans[corner].ways.push_back(next);
  for (std::size_t f = 0; f < mesh.subfacets.size(); ++f) {
    Triangle t;
    bool is_known = true;
    for (std::size_t k = 0; k < 3; ++k) {
      t[k] = row_of.Find(mesh.subfacets.corners[3 * f + k]);
      is_known = is_known && t[k] != IdTable::kNone;
    }
    if (!is_known) continue;
    const FeatureId owner = mesh.subfacets.owners[f];
    for (std::size_t k = 0; k < 3; ++k) {
      std::vector<FeatureId>& facets = facets_of[t[k]];
      if (std::ranges::find(facets, owner) == facets.end()) facets.push_back(owner);
      if (mesh.vertices.containing_dimensions[t[k]] != 0) continue;
      fans[t[k]].triangles.push_back({{t[k], t[(k + 1) % 3], t[(k + 2) % 3]}, owner});
      corners_of[owner].push_back(t[k]);
    }
  }
  for (const auto& entry : fans) {
    const Fan& fan = entry.second;  // no structured binding: clang's lambdas cannot capture one
    const bool is_sharp = std::ranges::any_of(fan.triangles, [&](const auto& triangle) {
      return std::ranges::any_of(fan.ways,
                                 [&](Row next) { return RisesOver(mesh, next, triangle.first); }) ||
             std::ranges::any_of(fan.triangles, [&](const auto& other) {
               return triangle.second < other.second &&
                      MeetSharply(mesh, triangle.first, other.first);
             });
    });
    if (is_sharp) sharp_.insert(entry.first);
  }
  if (sharp_.empty()) return;
  for (const auto& [row, facets] : facets_of) {
    std::vector<Row> corners;
    for (const FeatureId facet : facets) {
      for (const Row c : corners_of[facet]) {
        if (sharp_.contains(c)) corners.push_back(c);
      }
    }
    std::ranges::sort(corners);
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    if (!corners.empty()) corners_.emplace(row, std::move(corners));
  }
}

const std::vector<SharpCorners::Row>& SharpCorners::Of(Row vertex) const {
  static const std::vector<Row> kNone;
  const auto it = corners_.find(vertex);
  return it == corners_.end() ? kNone : it->second;
}

}  // namespace dynmesh::quality
