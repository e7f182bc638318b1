#include "dynmesh/quality.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "absl/container/flat_hash_map.h"
#include "core/data/guarded_gaps.h"
#include "core/data/seditious_edges.h"

namespace dynmesh {
namespace {

struct Vector {
  double x, y;
};

// u.x v.y - u.y v.x with two roundings in place of three and no cancellation
// (Kahan): the error of the first product is added back.
double Cross(const Vector& u, const Vector& v) {
  const double p = u.y * v.x;
  const double error = std::fma(-u.y, v.x, p);
  return std::fma(u.x, v.y, -p) + error;
}

double Dot(const Vector& u, const Vector& v) { return u.x * v.x + u.y * v.y; }

double Degrees(double radians) { return radians * (180 / std::numbers::pi); }

absl::flat_hash_map<VertexId, std::size_t> RowsById(const Mesh& mesh) {
  absl::flat_hash_map<VertexId, std::size_t> row_of;
  row_of.reserve(mesh.vertices.size());
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) row_of.emplace(mesh.vertices.ids[i], i);
  return row_of;
}

TriangleQuality Flat() {
  TriangleQuality flat;
  flat.radius_edge = std::numeric_limits<double>::infinity();
  flat.max_angle_deg = 180;
  flat.angles_deg = {0, 0, 180};
  return flat;
}

}  // namespace

TriangleQuality MeasureTriangle(const double* a, const double* b, const double* c) {
  // edge[i] runs opposite corner i, counter-clockwise.
  Vector edge[3] = {
      {c[0] - b[0], c[1] - b[1]}, {a[0] - c[0], a[1] - c[1]}, {b[0] - a[0], b[1] - a[1]}};
  double largest = 0;
  for (const Vector& e : edge) largest = std::max({largest, std::abs(e.x), std::abs(e.y)});
  if (!(largest > 0) || !std::isfinite(largest)) return Flat();
  // Scaled by a power of two, exactly: no product below overflows, and none that
  // matters underflows.
  const int scale = std::ilogb(largest);
  for (Vector& e : edge) e = {std::scalbn(e.x, -scale), std::scalbn(e.y, -scale)};
  double length[3];
  for (int i = 0; i < 3; ++i) length[i] = std::sqrt(Dot(edge[i], edge[i]));
  const int longest = static_cast<int>(std::max_element(length, length + 3) - length);
  const int shortest = static_cast<int>(std::min_element(length, length + 3) - length);
  // The two shorter edges have the smallest relative error.
  const double cross = Cross(edge[(longest + 1) % 3], edge[(longest + 2) % 3]);
  if (!(cross > 0)) return Flat();
  TriangleQuality q;
  q.shortest_edge = std::scalbn(length[shortest], scale);
  // R = abc / (2 cross); over the shortest edge two factors are left.
  q.radius_edge = length[(shortest + 1) % 3] * length[(shortest + 2) % 3] / (2 * cross);
  for (int i = 0; i < 3; ++i) {
    const double dot = -Dot(edge[(i + 1) % 3], edge[(i + 2) % 3]);
    q.angles_deg[static_cast<std::size_t>(i)] = Degrees(std::atan2(cross, dot));
  }
  q.min_angle_deg = *std::min_element(q.angles_deg.begin(), q.angles_deg.end());
  q.max_angle_deg = *std::max_element(q.angles_deg.begin(), q.angles_deg.end());
  return q;
}

double CoordinateUnit(std::span<const double> coordinates) {
  double largest = 0;
  for (const double c : coordinates) largest = std::max(largest, std::abs(c));
  if (!(largest > 0) || !std::isfinite(largest)) return 0;
  return std::scalbn(1.0, std::ilogb(largest) - 52);
}

double QualitySlack(double shortest_edge, double unit) {
  if (!(shortest_edge > 0)) return 0;
  // 2^k <= e^2 < 2^(k+1) with e = m 2^j, 1 <= m < 2: k is 2j or 2j + 1. By m, not by
  // e^2, which may underflow.
  const int j = std::ilogb(shortest_edge);
  const double m = std::scalbn(shortest_edge, -j);
  const double below = std::scalbn(m * m >= 2 ? std::numbers::sqrt2 : 1.0, j);
  return 2e-9 + 8 * unit / below;
}

bool IsOverRho(const TriangleQuality& triangle, double rho, double unit) {
  if (std::isinf(triangle.radius_edge)) return true;
  return triangle.radius_edge > rho * (1 + QualitySlack(triangle.shortest_edge, unit));
}

namespace {

// Calls f(triangle's index, its quality, verdict) for each.
template <class F>
void ForEachTriangle(const Mesh& mesh, const MeshOptions& options, F f) {
  const auto row_of = RowsById(mesh);
  const data::SeditiousEdges seditious(mesh, row_of);
  data::GuardedGaps guarded(mesh, row_of, options.quality);
  const std::vector<double>& coordinates = mesh.vertices.coordinates;
  const double unit = CoordinateUnit(coordinates);
  const auto judge = [&](const std::array<std::size_t, 3>& rows, const TriangleQuality& q) {
    using enum SimplexVerdict;
    if (!IsOverRho(q, options.quality, unit)) return kGood;
    double shortest = std::numeric_limits<double>::infinity();  // of the others
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t p = rows[k], r = rows[(k + 1) % 3];
      if (seditious.Has(p, r)) continue;
      const double dx = coordinates[2 * p] - coordinates[2 * r];
      const double dy = coordinates[2 * p + 1] - coordinates[2 * r + 1];
      shortest = std::min(shortest, std::sqrt(dx * dx + dy * dy));
    }
    const double circumradius = q.radius_edge * q.shortest_edge;
    const double most = options.quality * (1 + QualitySlack(shortest, unit)) * shortest;
    if (shortest > q.shortest_edge && (circumradius <= most || std::isinf(shortest))) {
      return kSmallInputAngle;
    }
    return guarded.Has(rows) ? kTerminationGuard : kOverRho;
  };
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) {
    std::array<std::size_t, 3> rows = {};
    bool known = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto it = row_of.find(mesh.simplices[3 * t + k]);
      known = known && it != row_of.end();
      if (known) rows[k] = it->second;
    }
    if (!known) {
      f(t, Flat(), SimplexVerdict::kOverRho);
      continue;
    }
    const TriangleQuality q = MeasureTriangle(&coordinates[2 * rows[0]], &coordinates[2 * rows[1]],
                                              &coordinates[2 * rows[2]]);
    f(t, q, judge(rows, q));
  }
}

}  // namespace

std::vector<SimplexVerdict> JudgeSimplices(const Mesh& mesh, const MeshOptions& options) {
  std::vector<SimplexVerdict> verdicts;
  if (mesh.dimension != 2) return verdicts;
  verdicts.resize(mesh.simplex_count());
  ForEachTriangle(mesh, options, [&](std::size_t t, const TriangleQuality&, SimplexVerdict v) {
    verdicts[t] = v;
  });
  return verdicts;
}

QualityReport MeasureQuality(const Mesh& mesh, const MeshOptions& options) {
  QualityReport report;
  if (mesh.dimension != 2 || mesh.simplex_count() == 0) return report;
  report.min_angle_deg = 180;
  ForEachTriangle(
      mesh, options, [&](std::size_t, const TriangleQuality& q, SimplexVerdict verdict) {
        report.worst_radius_edge = std::max(report.worst_radius_edge, q.radius_edge);
        report.min_angle_deg = std::min(report.min_angle_deg, q.min_angle_deg);
        report.max_angle_deg = std::max(report.max_angle_deg, q.max_angle_deg);
        if (verdict != SimplexVerdict::kGood) ++report.over_rho;
        if (IsExempt(verdict)) ++report.exempt;
        if (verdict == SimplexVerdict::kTerminationGuard) ++report.exempt_by_guard;
        for (const double angle : q.angles_deg) {
          ++report.angle_histogram[std::min<std::size_t>(17, static_cast<std::size_t>(angle / 10))];
        }
      });
  return report;
}

}  // namespace dynmesh
