// Radius-edge ratio and angles, computed anew and in another way than
// dynmesh/quality.h: squared, in long double.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "client/cli/verify_internal.h"
#include "core/data/text.h"

namespace dynmesh::cli {
namespace {

struct Shape {
  double ratio = std::numeric_limits<double>::infinity();
  double shortest = 0;
  double min_angle = 0;
  double max_angle = 180;
};

Shape Measure(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) {
  using Real = long double;
  const auto& a = mesh.vertices[t[0]];
  const auto& b = mesh.vertices[t[1]];
  const auto& c = mesh.vertices[t[2]];
  const Real ux = Real{b.x} - a.x;
  const Real uy = Real{b.y} - a.y;
  const Real vx = Real{c.x} - a.x;
  const Real vy = Real{c.y} - a.y;
  const Real wx = Real{c.x} - b.x;
  const Real wy = Real{c.y} - b.y;
  const Real cross = ux * vy - uy * vx;
  Real squared[3] = {ux * ux + uy * uy, vx * vx + vy * vy, wx * wx + wy * wy};
  std::sort(squared, squared + 3);
  Shape shape;
  shape.shortest = static_cast<double>(std::sqrt(squared[0]));
  if (!(cross > 0)) return shape;
  // (R / e)^2 = product of the two greater squares / (2 cross)^2.
  shape.ratio = static_cast<double>(std::sqrt(squared[1] * squared[2] / (4 * cross * cross)));
  // The least angle is opposite the shortest edge, the greatest opposite the longest.
  const auto angle = [&](Real opposite, Real p, Real q) {
    return static_cast<double>(std::atan2(2 * cross, p + q - opposite) * 180 /
                               std::numbers::pi_v<Real>);
  };
  shape.min_angle = angle(squared[0], squared[1], squared[2]);
  shape.max_angle = angle(squared[2], squared[0], squared[1]);
  return shape;
}

// How far rounded coordinates may take a triangle over rho: 2e-9 + 8 u / e', e' the
// root of the largest power of two that is at most e^2.
double Slack(double shortest, double ulp) {
  if (!(shortest > 0)) return 0;
  double below = std::exp2(std::floor(std::log2(shortest)));
  while (below > shortest) below /= 2;
  while (2 * below <= shortest) below *= 2;
  if (std::numbers::sqrt2 * below <= shortest) below *= std::numbers::sqrt2;
  return 2e-9 + 8 * ulp / below;
}

}  // namespace

VerifyCheck CheckQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report) {
  Findings findings("quality");
  const double ulp = LargestUlp(mesh);
  report.min_angle_deg = mesh.triangles.empty() ? 0 : 180;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Shape shape = Measure(mesh, mesh.triangles[t]);
    report.worst_radius_edge = std::max(report.worst_radius_edge, shape.ratio);
    report.min_angle_deg = std::min(report.min_angle_deg, shape.min_angle);
    report.max_angle_deg = std::max(report.max_angle_deg, shape.max_angle);
    if (shape.ratio <= rho * (1 + Slack(shape.shortest, ulp))) continue;
    ++report.over_rho;
    findings.Add(data::Concat(TriangleName(t), " has circumradius / shortest edge ", shape.ratio));
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
