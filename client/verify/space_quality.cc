// Radius-edge ratio and dihedral angles of tetrahedra, computed independently of dynmesh/quality.h:
// squared, in long double; in rationals if that is not accurate enough.
#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>
#include <vector>

#include "client/verify/excuses.h"
#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using ExactKernel = CGAL::Simple_cartesian<CGAL::Exact_rational>;

std::array<ExactKernel::Point_3, 4> ExactCorners(const io::IndexedMesh& mesh,
                                                 const io::IndexedMesh::Tetrahedron& t) {
  std::array<ExactKernel::Point_3, 4> p;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& v = mesh.vertices[t[k]];
    p[k] = {v.x, v.y, v.z};
  }
  return p;
}

// The ratio squared; infinity if flat or inverted.
Real ExactRatioSquared(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t) {
  const std::array<ExactKernel::Point_3, 4> p = ExactCorners(mesh, t);
  if (CGAL::orientation(p[0], p[1], p[2], p[3]) != CGAL::POSITIVE) {
    return std::numeric_limits<Real>::infinity();
  }
  CGAL::Exact_rational shortest = CGAL::squared_distance(p[0], p[1]);
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t k = j + 1; k < 4; ++k) {
      shortest = std::min<CGAL::Exact_rational>(shortest, CGAL::squared_distance(p[j], p[k]));
    }
  }
  return CGAL::to_double(
      CGAL::Exact_rational(CGAL::squared_radius(p[0], p[1], p[2], p[3]) / shortest));
}

using ExactVector = ExactKernel::Vector_3;

// sin^2 of the angle between two faces at their common edge is
//   |n x m|^2 / (|n|^2 |m|^2)
// with outward normals n, m, and the angle is acute iff n m < 0. This is rational. The bound's sine
// has 64 bits, so the comparison is practically exact. Angles opposite to excused edges do not
// count.
bool IsBelowExactly(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t,
                    Real degrees, const Excuses& excuses) {
  const std::array<ExactKernel::Point_3, 4> p = ExactCorners(mesh, t);
  if (CGAL::orientation(p[0], p[1], p[2], p[3]) != CGAL::POSITIVE) return degrees > 0;
  const ExactVector a = p[1] - p[0], b = p[2] - p[0], c = p[3] - p[0];
  const std::array<ExactVector, 4> n = {CGAL::cross_product(b - a, c - a),
                                        CGAL::cross_product(c, b), CGAL::cross_product(a, c),
                                        CGAL::cross_product(b, a)};
  const Real sine = std::sin(degrees * std::numbers::pi_v<Real> / 180);
  // A long double is the sum of two doubles.
  const auto high = static_cast<double>(sine);
  const CGAL::Exact_rational s =
      CGAL::Exact_rational(high) + CGAL::Exact_rational(static_cast<double>(sine - high));
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      if (n[i] * n[j] >= 0 || excuses.Excused(t[i], t[j])) continue;
      const CGAL::Exact_rational across = CGAL::cross_product(n[i], n[j]).squared_length();
      if (across < s * s * n[i].squared_length() * n[j].squared_length()) return true;
    }
  }
  return false;
}

Shape Measure(const io::IndexedMesh& mesh, const io::IndexedMesh::Tetrahedron& t) {
  std::array<Vector, 4> p;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto position = mesh.vertices[t[k]].position();
    p[k] = {position[0], position[1], position[2]};
  }
  Real shortest = std::numeric_limits<Real>::infinity(), longest = 0;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t k = j + 1; k < 4; ++k) {
      const Real length = Norm(Minus(p[j], p[k]));
      shortest = std::min(shortest, length), longest = std::max(longest, length);
    }
  }
  Shape shape;
  shape.shortest = static_cast<double>(shortest);
  if (!(shortest > 0)) return shape;
  // In units of the longest edge.
  std::array<Vector, 3> e;
  for (std::size_t i = 0; i < 3; ++i) {
    e[i] = Minus(p[i + 1], p[0]);
    for (Real& c : e[i]) c /= longest;
  }
  const Vector bc = Cross(e[1], e[2]), ca = Cross(e[2], e[0]), ab = Cross(e[0], e[1]);
  const Real volume = Dot(e[0], bc);  // times 6
  Real squared;
  if (std::abs(volume) > 1e-6L) {
    if (volume < 0) return shape;
    const Real sa = Dot(e[0], e[0]), sb = Dot(e[1], e[1]), sc = Dot(e[2], e[2]);
    Vector to_center;
    for (std::size_t k = 0; k < 3; ++k) to_center[k] = sa * bc[k] + sb * ca[k] + sc * ab[k];
    const Real ratio = Norm(to_center) / (2 * volume) / (shortest / longest);
    squared = ratio * ratio;
  } else {
    squared = ExactRatioSquared(mesh, t);
    if (std::isinf(squared)) return shape;
  }
  shape.ratio = static_cast<double>(std::sqrt(squared));
  // Outward normals, twice the areas as length. Opposite to a, b, c, d.
  const Vector from_b = Minus(e[1], e[0]), from_c = Minus(e[2], e[0]);
  std::array<Vector, 4> normal = {Cross(from_b, from_c), bc, ca, ab};
  for (std::size_t i = 1; i < 4; ++i) {
    for (Real& c : normal[i]) c = -c;
  }
  shape.least_area = std::numeric_limits<double>::infinity();
  for (const Vector& n : normal) {
    shape.least_area = std::min(shape.least_area, static_cast<double>(Norm(n)));
  }
  shape.min_angle = 180, shape.max_angle = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const Real sine = Norm(Cross(normal[i], normal[j]));
      const auto angle = static_cast<double>(std::atan2(sine, -Dot(normal[i], normal[j])) * 180 /
                                             std::numbers::pi_v<Real>);
      shape.min_angle = std::min(shape.min_angle, angle);
      shape.max_angle = std::max(shape.max_angle, angle);
    }
  }
  return shape;
}

}  // namespace

VerifyCheck CheckSpaceQuality(const io::IndexedMesh& mesh, double rho, VerifyReport& report) {
  Findings findings("quality");
  const double ulp = LargestUlp(mesh);
  const Excuses excuses(mesh, ulp);
  report.min_angle_deg = mesh.tetrahedra.empty() ? 0 : 180;
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Shape shape = Measure(mesh, mesh.tetrahedra[t]);
    Record(shape, report);
    if (shape.ratio <= rho * (1 + Slack(shape.shortest, ulp))) continue;
    ++report.over_rho;
    const auto shortest = static_cast<double>(excuses.ShortestOf(mesh.tetrahedra[t]));
    const double bound = rho * (1 + Slack(shortest, ulp));
    if (shape.ratio < HUGE_VAL && shortest > shape.shortest &&
        shape.ratio * (shape.shortest / shortest) <= bound) {
      ++report.exempt;
      continue;
    }
    findings.Add(
        text::Concat(TetrahedronName(t), " has circumradius / shortest edge ", shape.ratio));
  }
  return findings.Take();
}

VerifyCheck CheckDihedral(const io::IndexedMesh& mesh, double min_dihedral, VerifyReport& report) {
  // The error of measured angles is smaller, except in needles.
  constexpr double kUnsure = 1e-9;
  constexpr double kNeedle = 1e-7;
  struct Below {
    double angle;
    std::uint32_t tetrahedron;
  };
  const Excuses excuses(mesh, LargestUlp(mesh));
  std::vector<Below> all;
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    const Shape shape = Measure(mesh, mesh.tetrahedra[t]);
    const bool is_unsure =
        std::abs(shape.min_angle - min_dihedral) <= kUnsure || shape.least_area < kNeedle;
    const bool is_below = shape.min_angle < min_dihedral;
    const bool has_excuse = is_below && excuses.AnyOf(mesh.tetrahedra[t]);
    const bool is_trapezoid =
        has_excuse && shape.ratio < HUGE_VAL && excuses.AreOpposite(mesh.tetrahedra[t]);
    if (is_trapezoid) {
      ++report.exempt_dihedral;
    } else if (is_unsure || has_excuse
                   ? IsBelowExactly(mesh, mesh.tetrahedra[t], min_dihedral, excuses)
                   : is_below) {
      all.push_back({shape.min_angle, t});
    } else if (is_below) {
      ++report.exempt_dihedral;
    }
  }
  report.below_dihedral = all.size();
  std::sort(all.begin(), all.end(), [](const Below& s, const Below& t) {
    return std::tie(s.angle, s.tetrahedron) < std::tie(t.angle, t.tetrahedron);
  });
  Findings findings("dihedral");
  for (const Below& below : all) {
    Vector at = {0, 0, 0};
    for (const std::uint32_t v : mesh.tetrahedra[below.tetrahedron]) {
      for (std::size_t k = 0; k < 3; ++k) at[k] += Real{mesh.vertices[v].position()[k]} / 4;
    }
    findings.Add(text::Concat(TetrahedronName(below.tetrahedron), " has a dihedral angle of ",
                              below.angle, " degrees, around ", static_cast<double>(at[0]), " ",
                              static_cast<double>(at[1]), " ", static_cast<double>(at[2])));
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
