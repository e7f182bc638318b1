// MeasureTetrahedron of dynmesh/quality.h, and its exact parts.
#include "core/quality/tetrahedron_quality.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/circumball.h"
#include "core/geometry/products.h"
#include "core/geometry/tetrahedron_shape.h"
#include "core/quality/degrees.h"

namespace dynmesh {
namespace {

using geometry::Point3;
using geometry::Vector3;

constexpr double kRatioError = 1e-10;  // as promised

// Edges in the order of TetrahedronQuality::angles_deg: the two ends, then the two other corners.
constexpr std::size_t kEdges[6][4] = {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2},
                                      {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}};

// Are exact integers possible?
bool IsInDomain(const Point3& p) {
  return std::all_of(p.c.begin(), p.c.end(), [](double x) {
    return x == 0 || (std::fabs(x) >= 0x1p-250 && std::fabs(x) <= 0x1p250);
  });
}

bool AreInDomain(const std::array<Point3, 4>& corners) {
  return std::all_of(corners.begin(), corners.end(), IsInDomain);
}

double Length(const Vector3& v) { return std::hypot(v[0], v[1], v[2]); }

// A tetrahedron scaled by a power of two, exactly, so that its largest extent is about 1: no
// product overflows, and no relevant one underflows.
struct Scaled {
  int scale = 0;
  bool valid = false;     // the extent is positive and finite
  Vector3 to[4][4] = {};  // from corner i to corner j

  explicit Scaled(const std::array<Point3, 4>& corners) {
    double largest = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        to[i][j] = geometry::Difference(corners[j].c, corners[i].c);
        for (const double x : to[i][j]) {
          if (!std::isfinite(x)) return;
          largest = std::max(largest, std::fabs(x));
        }
      }
    }
    if (!(largest > 0)) return;
    valid = true;
    scale = std::ilogb(largest);
    for (auto& row : to) {
      for (Vector3& v : row) {
        for (double& x : v) x = std::scalbn(x, -scale);
      }
    }
  }
};

// The determinant of the scaled tetrahedron (not positive: flat or inverted) and the ratio.
geometry::TetrahedronShape MeasureShape(const std::array<Point3, 4>& corners, const Scaled& s,
                                        double shortest) {
  const Vector3 &u = s.to[0][1], &v = s.to[0][2], &w = s.to[0][3];
  const geometry::Circumball ball(u, geometry::Dot(u, u), v, geometry::Dot(v, v), w,
                                  geometry::Dot(w, w), false);
  const double radius = std::sqrt(ball.r2);
  // Shorter edges may make products underflow, which the ball's error bound ignores. So small an
  // error also bounds the error of the determinant: it increases with the determinant's loss.
  if (shortest > 0x1p-250 && ball.error < kRatioError / 4 * radius) {
    return {geometry::Dot(u, geometry::AccurateCross(v, w)), radius / shortest};
  }
  if (!AreInDomain(corners)) return {0, 0};
  auto shape = geometry::ShapeOf(corners[0], corners[1], corners[2], corners[3]);
  shape.determinant = std::scalbn(shape.determinant, -3 * s.scale);
  return shape;
}

}  // namespace

TetrahedronQuality MeasureTetrahedron(const double* a, const double* b, const double* c,
                                      const double* d) {
  std::array<Point3, 4> corners;
  const double* const given[4] = {a, b, c, d};
  for (std::size_t i = 0; i < 4; ++i) corners[i] = {{given[i][0], given[i][1], given[i][2]}};
  const Scaled s(corners);
  if (!s.valid) return quality::FlatTetrahedron();
  double length[6];
  for (std::size_t e = 0; e < 6; ++e) length[e] = Length(s.to[kEdges[e][0]][kEdges[e][1]]);
  const double shortest = *std::min_element(length, length + 6);
  const auto [det, ratio] = MeasureShape(corners, s, shortest);
  if (!(det > 0)) return quality::FlatTetrahedron();
  TetrahedronQuality q;
  q.shortest_edge = std::scalbn(shortest, s.scale);
  q.radius_edge = ratio;
  for (std::size_t e = 0; e < 6; ++e) {
    const auto& [i, j, k, l] = kEdges[e];
    Vector3 along = s.to[i][j];
    for (double& x : along) x /= length[e];
    // The inner and the outer product of the heights of k and l over the edge.
    const double cosine = geometry::Dot(geometry::AccurateCross(along, s.to[i][k]),
                                        geometry::AccurateCross(along, s.to[i][l]));
    q.angles_deg[e] = quality::Degrees(std::atan2(det / length[e], cosine));
  }
  q.min_angle_deg = *std::min_element(q.angles_deg.begin(), q.angles_deg.end());
  q.max_angle_deg = *std::max_element(q.angles_deg.begin(), q.angles_deg.end());
  return q;
}

namespace quality {

TetrahedronQuality FlatTetrahedron() {
  TetrahedronQuality flat;
  flat.radius_edge = std::numeric_limits<double>::infinity();
  flat.max_angle_deg = 180;
  flat.angles_deg = {0, 0, 180, 180, 0, 0};
  return flat;
}

bool IsOverBound(const std::array<Point3, 4>& corners, const TetrahedronQuality& q, double bound) {
  if (std::isinf(q.radius_edge)) return true;
  if (std::fabs(q.radius_edge - bound) > 2 * kRatioError * bound || !AreInDomain(corners)) {
    return q.radius_edge > bound;
  }
  return geometry::CompareRadiusEdge(corners[0], corners[1], corners[2], corners[3], bound) > 0;
}

}  // namespace quality
}  // namespace dynmesh
