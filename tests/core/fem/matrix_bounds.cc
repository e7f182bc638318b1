#include "tests/core/fem/matrix_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>
#include <vector>

namespace dynmesh::test {
namespace {

struct Edge {
  std::size_t i, j, k, l;  // kl is opposite to ij
};
constexpr std::array<Edge, 6> kEdges = {
    {{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 0, 2}, {2, 3, 0, 1}}};

double LengthOf(const Corners& p, const Edge& e) {
  return std::sqrt(Dot(p[e.j] - p[e.i], p[e.j] - p[e.i]));
}

// The dihedral angle at ij, in degrees.
double AngleAt(const Corners& p, const Edge& e) {
  const Vector edge = p[e.j] - p[e.i];
  const Vector m = Cross(edge, p[e.k] - p[e.i]), n = Cross(edge, p[e.l] - p[e.i]);
  const Vector across = Cross(m, n);
  return std::atan2(std::sqrt(Dot(across, across)), Dot(m, n)) * 180 / std::numbers::pi;
}

// Takes the tetrahedron in; its longest edge.
double Add(const Corners& p, double bound, Shape* shape) {
  double longest = 0, least = 180;
  for (const Edge& e : kEdges) {
    const double angle = AngleAt(p, e);
    longest = std::max(longest, LengthOf(p, e));
    least = std::min(least, angle);
    shape->greatest_angle = std::max(shape->greatest_angle, angle);
  }
  shape->least_angle = std::min(shape->least_angle, least);
  shape->slivers += least < bound * (1 - 1e-9);
  if (!(VolumeOf(p) > 0)) {
    ++shape->flat;
    return longest;
  }
  const Matrix4 element = StiffnessOf(p);
  double greatest = 0;
  for (std::size_t k = 0; k < 4; ++k) greatest = std::max(greatest, element[k][k]);
  shape->worst_entry = std::max(shape->worst_entry, greatest / (longest / 2));
  for (const Edge& e : kEdges) {
    const double w = -element[e.k][e.l], part = LengthOf(p, e) / 6;
    shape->worst_cotangent = std::max(shape->worst_cotangent, w / part);
    const double difference = std::fabs(w - part * CotangentOf(AngleAt(p, e)));
    shape->worst_difference = std::max(shape->worst_difference, difference / greatest);
  }
  return longest;
}

}  // namespace

double CotangentOf(double degrees) { return 1 / std::tan(degrees * std::numbers::pi / 180); }

std::pair<Vector, Vector> BoxOf(const Domain& domain) {
  Vector lo = domain.points[0], hi = lo;
  for (const Vector& p : domain.points) {
    for (std::size_t i = 0; i < 3; ++i) {
      lo[i] = std::min(lo[i], p[i]);
      hi[i] = std::max(hi[i], p[i]);
    }
  }
  return {lo, hi};
}

Shape ShapeOf(const Domain& domain, double bound) {
  Shape shape;
  std::vector<double> volumes(domain.points.size(), 0), lengths(domain.points.size(), 0);
  for (std::size_t cell = 0; cell < domain.cells.size(); ++cell) {
    const Corners p = domain.CornersOf(cell);
    const double length = Add(p, bound, &shape);
    for (const std::size_t v : domain.cells[cell]) volumes[v] += VolumeOf(p), lengths[v] += length;
  }
  const auto [lo, hi] = BoxOf(domain);
  double mu = 0;
  for (std::size_t i = 0; i < 3; ++i)
    mu += std::numbers::pi * std::numbers::pi / ((hi[i] - lo[i]) * (hi[i] - lo[i]));
  const double cot = CotangentOf(bound);
  double least_volume = INFINITY;
  for (std::size_t v = 0; v < domain.points.size(); ++v) {
    if (domain.is_on_border[v] != 0) continue;
    least_volume = std::min(least_volume, volumes[v]);
    shape.greatest_bound = std::max(shape.greatest_bound, 2 * lengths[v] * cot);
    const double diagonal = lengths[v] * cot / 2;
    shape.scaled_bound = std::max(shape.scaled_bound, 4 * 20 * diagonal / (mu * volumes[v]));
  }
  shape.least_bound = mu * least_volume / 20;
  return shape;
}

}  // namespace dynmesh::test
