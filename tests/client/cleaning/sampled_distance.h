// How far surfaces are from each other, by samples and all triangles: slow and obvious.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_SAMPLED_DISTANCE_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_SAMPLED_DISTANCE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "tests/client/cleaning/surface_oracle.h"
#include "tests/client/cleaning/surface_soups.h"

namespace dynmesh::cleaning {

inline Corner3 Difference(const Corner3& a, const Corner3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline double Dot(const Corner3& a, const Corner3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

inline double DistanceToSegment(const Corner3& p, const Corner3& a, const Corner3& b) {
  const Corner3 d = Difference(b, a), w = Difference(p, a);
  const double length2 = Dot(d, d);
  const double t = length2 > 0 ? std::clamp(Dot(d, w) / length2, 0.0, 1.0) : 0;
  const Corner3 r = {w[0] - t * d[0], w[1] - t * d[1], w[2] - t * d[2]};
  return std::sqrt(Dot(r, r));
}

inline double DistanceTo(const Corner3& p, const std::array<Corner3, 3>& t) {
  double least = std::min({DistanceToSegment(p, t[0], t[1]), DistanceToSegment(p, t[1], t[2]),
                           DistanceToSegment(p, t[2], t[0])});
  const Corner3 u = Difference(t[1], t[0]), w = Difference(t[2], t[0]), r = Difference(p, t[0]);
  const double uu = Dot(u, u), uw = Dot(u, w), ww = Dot(w, w), det = uu * ww - uw * uw;
  if (!(det > 0)) return least;
  const double a = (Dot(r, u) * ww - Dot(r, w) * uw) / det;
  const double b = (Dot(r, w) * uu - Dot(r, u) * uw) / det;
  if (a < 0 || b < 0 || a + b > 1) return least;
  const Corner3 rest = {r[0] - a * u[0] - b * w[0], r[1] - a * u[1] - b * w[1],
                        r[2] - a * u[2] - b * w[2]};
  return std::min(least, std::sqrt(Dot(rest, rest)));
}

// Over the longest edge.
inline double HeightOf(const std::array<Corner3, 3>& t) {
  double least = 1e300;
  for (std::size_t k = 0; k < 3; ++k) {
    least = std::min(least, DistanceToSegment(t[k], t[(k + 1) % 3], t[(k + 2) % 3]));
  }
  return least;
}

inline double DistanceTo(const Corner3& p, const PlainSurface& surface) {
  double least = 1e300;
  for (const auto& t : surface.triangles) least = std::min(least, DistanceTo(p, t));
  return least;
}

// Corners, and some places inside of triangles.
inline std::vector<Corner3> SamplesOf(const PlainSurface& surface, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Corner3> samples;
  for (const auto& t : surface.triangles) {
    samples.insert(samples.end(), t.begin(), t.end());
    for (int i = 0; i < 5; ++i) {
      double a = uniform(random), b = uniform(random);
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const Corner3 u = Difference(t[1], t[0]), w = Difference(t[2], t[0]);
      samples.push_back({t[0][0] + a * u[0] + b * w[0], t[0][1] + a * u[1] + b * w[1],
                         t[0][2] + a * u[2] + b * w[2]});
    }
  }
  return samples;
}

inline double FarthestFrom(const PlainSurface& from, const PlainSurface& to) {
  double most = 0;
  for (const Corner3& p : SamplesOf(from, 5)) most = std::max(most, DistanceTo(p, to));
  return most;
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_SAMPLED_DISTANCE_H_
