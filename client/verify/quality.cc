// Radius-edge ratio and angles, computed independently of dynmesh/quality.h: squared, in long
// double. Also finds the triangles that may exceed rho since a small angle of the input makes their
// edges short.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "client/verify/excuses.h"
#include "client/verify/unsplit.h"
#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

Shape Measure(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t) {
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
  // The least angle is opposite the shortest edge, the greatest one opposite the longest.
  const auto angle = [&](Real opposite, Real p, Real q) {
    return static_cast<double>(std::atan2(2 * cross, p + q - opposite) * 180 /
                               std::numbers::pi_v<Real>);
  };
  shape.min_angle = angle(squared[0], squared[1], squared[2]);
  shape.max_angle = angle(squared[2], squared[0], squared[1]);
  return shape;
}

// (circumradius / shortest edge that is not excused)^2; 0 if all are excused.
long double RatioSquared(const io::IndexedMesh& mesh, const Excuses& excuses,
                         const io::IndexedMesh::Triangle& t, long double* shortest) {
  Real product = 1;
  for (int i = 0; i < 3; ++i) product *= excuses.Distance(t[i], t[(i + 1) % 3]);
  *shortest = excuses.ShortestOf(t);
  const auto &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
  const Real cross = (Real{b.x} - a.x) * (Real{c.y} - a.y) - (Real{b.y} - a.y) * (Real{c.x} - a.x);
  const Real radius = product / (2 * cross);
  return radius / *shortest * (radius / *shortest);
}

// The termination guard accepts a bad triangle if its repair point (its circumcenter, or the point
// nearer to an edge at which that edge's triangle is just good) lies in the diametral circle of a
// subsegment of at most four times the edge's length. So the remaining triangle is about as fine as
// the subsegment. Tested by the angle at the point: at least a right one.
class Guarded {
 public:
  Guarded(const io::IndexedMesh& mesh, double rho) : mesh_(mesh), rho_(rho) {}

  bool Excuses(const io::IndexedMesh::Triangle& t) {
    constexpr int kMost = 1000;  // the guard affects few triangles; O(edges) each
    if (++asked_ > kMost) return false;
    const Point a = At(t[0]), b = At(t[1]), c = At(t[2]);
    const Real bx = b.x - a.x, by = b.y - a.y, cx = c.x - a.x, cy = c.y - a.y;
    const Real twice = 2 * (bx * cy - by * cx);
    if (!(twice > 0)) return false;
    const Real b2 = bx * bx + by * by, c2 = cx * cx + cy * cy;
    const Point centre = {a.x + (cy * b2 - by * c2) / twice, a.y + (bx * c2 - cx * b2) / twice};
    const Real radius = std::hypot(centre.x - a.x, centre.y - a.y);
    for (int i = 0; i < 3; ++i) {
      const Point p = At(t[i]), q = At(t[(i + 1) % 3]);
      const Real edge = std::hypot(q.x - p.x, q.y - p.y);
      if (radius <= rho_ * edge) continue;  // good: needs no repair
      if (IsSeenAtRightAngle(centre, edge)) return true;
      // The far apex of the isosceles triangle over pq with circumradius rho |pq|.
      const Real height = rho_ + std::sqrt(rho_ * rho_ - Real{0.25});
      const Point x = {(p.x + q.x) / 2 - height * (q.y - p.y),
                       (p.y + q.y) / 2 + height * (q.x - p.x)};
      if (std::hypot(x.x - p.x, x.y - p.y) < radius && IsSeenAtRightAngle(x, edge)) return true;
    }
    return false;
  }

 private:
  struct Point {
    Real x, y;
  };
  Point At(std::uint32_t v) const { return {mesh_.vertices[v].x, mesh_.vertices[v].y}; }
  bool IsSeenAtRightAngle(const Point& x, Real edge) const {
    return std::ranges::any_of(mesh_.edges, [&](const auto& e) {
      if (e.owner == kNoFeature) return false;
      const Point a = At(e.a), b = At(e.b);
      const Real length2 = (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y);
      if (std::sqrt(length2) > 4 * edge) return false;
      const Real dot = (a.x - x.x) * (b.x - x.x) + (a.y - x.y) * (b.y - x.y);
      return dot <= 1e-6L * length2;
    });
  }

  const io::IndexedMesh& mesh_;
  const Real rho_;
  int asked_ = 0;
};

}  // namespace

double Slack(double shortest, double ulp) {
  if (!(shortest > 0) || std::isinf(shortest)) return 0;
  int exponent = 0;
  std::frexp(shortest, &exponent);
  double below = std::ldexp(1.0, exponent - 1);
  if (std::numbers::sqrt2 * below <= shortest) below *= std::numbers::sqrt2;
  return 2e-9 + 8 * ulp / below;
}

void Record(const Shape& shape, VerifyReport& report) {
  report.worst_radius_edge = std::max(report.worst_radius_edge, shape.ratio);
  report.min_angle_deg = std::min(report.min_angle_deg, shape.min_angle);
  report.max_angle_deg = std::max(report.max_angle_deg, shape.max_angle);
}

VerifyCheck CheckQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report,
                         const std::vector<Feature>* features) {
  Findings findings("quality");
  const double ulp = LargestUlp(mesh);
  const Excuses excuses(mesh, ulp);
  Guarded guarded(mesh, rho);
  const UnsplitCircles unsplit(features);
  report.min_angle_deg = mesh.triangles.empty() ? 0 : 180;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const Shape shape = Measure(mesh, mesh.triangles[t]);
    Record(shape, report);
    if (shape.ratio <= rho * (1 + Slack(shape.shortest, ulp))) continue;
    ++report.over_rho;
    long double shortest = 0;
    const long double squared = RatioSquared(mesh, excuses, mesh.triangles[t], &shortest);
    const double bound = rho * (1 + Slack(static_cast<double>(shortest), ulp));
    if (shape.ratio < HUGE_VAL && shortest > shape.shortest && squared <= bound * bound) {
      ++report.exempt;
      continue;
    }
    if (shape.ratio < HUGE_VAL && unsplit.Excuse(mesh, mesh.triangles[t], rho)) {
      ++report.exempt;
      ++report.exempt_by_unsplit;
      continue;
    }
    if (shape.ratio < HUGE_VAL && guarded.Excuses(mesh.triangles[t])) {
      ++report.exempt;
      ++report.exempt_by_guard;
      continue;
    }
    findings.Add(text::Concat(TriangleName(t), " has circumradius / shortest edge ", shape.ratio));
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
