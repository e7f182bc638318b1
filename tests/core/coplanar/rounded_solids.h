// Solids with flat faces, at any angle, whose faces are cut at random into triangles and whose
// coordinates are rounded as files round them.
#ifndef DYNMESH_TESTS_CORE_COPLANAR_ROUNDED_SOLIDS_H_
#define DYNMESH_TESTS_CORE_COPLANAR_ROUNDED_SOLIDS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/io/common/written_digits.h"
#include "dynmesh/feature.h"

namespace dynmesh::coplanar::rounded {

// More exact than the numbers of files, so that what is rounded is the only error.
using Real = long double;
using Place = std::array<Real, 3>;
using Loop = std::vector<int>;
using Random = std::mt19937;

struct Solid {
  std::vector<Place> points;
  std::vector<std::vector<Loop>> faces;  // the outer ring first
  std::vector<Loop> triangles;           // of the faces
};

inline double Uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
inline std::size_t Below(Random& random, std::size_t n) {
  return std::uniform_int_distribution<std::size_t>(0, n - 1)(random);
}

inline Real Dot(const Place& a, const Place& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline Place Cross(const Place& a, const Place& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Place Minus(const Place& a, const Place& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Place Unit(const Place& a) {
  const Real length = std::sqrt(Dot(a, a));
  return {a[0] / length, a[1] / length, a[2] / length};
}
inline Place RandomDirection(Random& random) {
  std::normal_distribution<double> normal;
  return Unit({normal(random), normal(random), normal(random)});
}

// Twice the area of a triangle along `normal`.
inline Real Turn(const Solid& solid, const Place& normal, int a, int b, int c) {
  const auto at = [&](int i) { return solid.points[static_cast<std::size_t>(i)]; };
  return Dot(normal, Cross(Minus(at(b), at(a)), Minus(at(c), at(a))));
}

// Cuts ears at random. A ring may touch itself.
inline void CutEars(Random& random, const Place& normal, Loop ring, Solid& solid) {
  while (ring.size() > 3) {
    std::vector<std::size_t> ears;
    const std::size_t n = ring.size();
    for (std::size_t i = 0; i < n; ++i) {
      const int a = ring[(i + n - 1) % n], b = ring[i], c = ring[(i + 1) % n];
      if (!(Turn(solid, normal, a, b, c) > 1e-6) || a == c) continue;
      const bool is_ear = std::none_of(ring.begin(), ring.end(), [&](int other) {
        return other != a && other != b && other != c && Turn(solid, normal, a, b, other) > -1e-9 &&
               Turn(solid, normal, b, c, other) > -1e-9 && Turn(solid, normal, c, a, other) > -1e-9;
      });
      if (is_ear) ears.push_back(i);
    }
    if (ears.empty()) std::abort();
    const std::size_t i = ears[Below(random, ears.size())];
    solid.triangles.push_back({ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]});
    ring.erase(ring.begin() + static_cast<std::ptrdiff_t>(i));
  }
  solid.triangles.push_back(ring);
}

// `corners` counter-clockwise about `normal`; `hole` clockwise, or empty: joined by a bridge from
// the first corner to the first of the hole.
inline void AddFace(Random& random, const Place& normal, const Loop& corners, const Loop& hole,
                    Solid& solid) {
  solid.faces.push_back({corners});
  Loop ring = corners;
  if (!hole.empty()) {
    solid.faces.back().push_back(hole);
    ring.push_back(corners.front());
    ring.insert(ring.end(), hole.begin(), hole.end());
    ring.push_back(hole.front());
  }
  // Sometimes with a point inside.
  if (hole.empty() && corners.size() < 5 && Below(random, 4) == 0) {
    Place middle{};
    for (const int c : corners) {
      for (std::size_t k = 0; k < 3; ++k) {
        middle[k] +=
            solid.points[static_cast<std::size_t>(c)][k] / static_cast<Real>(corners.size());
      }
    }
    const int at = static_cast<int>(solid.points.size());
    solid.points.push_back(middle);
    for (std::size_t i = 0; i < corners.size(); ++i) {
      solid.triangles.push_back({corners[i], corners[(i + 1) % corners.size()], at});
    }
    return;
  }
  CutEars(random, normal, std::move(ring), solid);
}

// The intersection of half-spaces about the origin; empty if it has small edges or angles.
inline Solid Polyhedron(Random& random, std::size_t planes) {
  std::vector<Place> normals;
  for (std::size_t i = 0; i < planes; ++i) normals.push_back(RandomDirection(random));
  Solid solid;
  std::vector<Loop> at(planes);  // corners
  for (std::size_t i = 0; i < planes; ++i) {
    for (std::size_t j = i + 1; j < planes; ++j) {
      for (std::size_t k = j + 1; k < planes; ++k) {
        const Place jk = Cross(normals[j], normals[k]), ki = Cross(normals[k], normals[i]),
                    ij = Cross(normals[i], normals[j]);
        const Real det = Dot(normals[i], jk);
        if (std::abs(det) < 0.02) continue;
        Place p{};
        for (std::size_t x = 0; x < 3; ++x) p[x] = (jk[x] + ki[x] + ij[x]) / det;
        const bool inside = std::all_of(normals.begin(), normals.end(),
                                        [&](const Place& n) { return Dot(n, p) < 1 + 1e-9; });
        if (!inside || Dot(p, p) > 100) continue;
        for (const std::size_t f : {i, j, k})
          at[f].push_back(static_cast<int>(solid.points.size()));
        solid.points.push_back(p);
      }
    }
  }
  for (std::size_t i = 0; i < solid.points.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Place d = Minus(solid.points[i], solid.points[j]);
      if (Dot(d, d) < 0.01) return {};
    }
  }
  for (std::size_t f = 0; f < planes; ++f) {
    for (std::size_t g = 0; g < f; ++g) {
      if (std::abs(Dot(normals[f], normals[g])) > 0.98) return {};
    }
    if (at[f].size() < 3) return {};
    const Place& n = normals[f];
    const Place u = Unit(Cross(n, std::abs(n[0]) < 0.5 ? Place{1, 0, 0} : Place{0, 1, 0}));
    const Place w = Cross(n, u);
    const auto angle = [&](int c) {
      const Place d = Minus(solid.points[static_cast<std::size_t>(c)], n);
      return std::atan2(Dot(d, w), Dot(d, u));
    };
    std::sort(at[f].begin(), at[f].end(), [&](int a, int b) { return angle(a) < angle(b); });
  }
  // Closed?
  std::size_t corners = 0;
  for (const Loop& face : at) corners += face.size();
  if (corners != 3 * solid.points.size() || solid.points.size() != 2 * planes - 4) return {};
  for (std::size_t f = 0; f < planes; ++f) AddFace(random, normals[f], at[f], {}, solid);
  return solid;
}

// Over a polygon, with a hole through it or without.
inline Solid Prism(Random& random, const std::vector<std::array<double, 2>>& outline,
                   const std::vector<std::array<double, 2>>& hole, double height) {
  Solid solid;
  const int n = static_cast<int>(outline.size()), m = static_cast<int>(hole.size());
  for (const double z : {0.0, height}) {
    for (const auto& [x, y] : outline) solid.points.push_back({x, y, z});
    for (const auto& [x, y] : hole) solid.points.push_back({x, y, z});
  }
  Loop top, bottom, in_top, in_bottom;
  for (int i = 0; i < n; ++i) top.push_back(n + m + i), bottom.push_back((n - i) % n);
  for (int i = 0; i < m; ++i) in_top.push_back(n + m + n + (m - i) % m), in_bottom.push_back(n + i);
  AddFace(random, {0, 0, 1}, top, in_top, solid);
  AddFace(random, {0, 0, -1}, bottom, in_bottom, solid);
  const auto side = [&](int a, int b) {
    const Place &p = solid.points[static_cast<std::size_t>(a)],
                &q = solid.points[static_cast<std::size_t>(b)];
    const Place normal = Unit(Cross(Minus(q, p), {0, 0, 1}));
    AddFace(random, normal, {a, b, b + n + m, a + n + m}, {}, solid);
  };
  for (int i = 0; i < n; ++i) side(i, (i + 1) % n);
  for (int i = 0; i < m; ++i) side(n + (i + 1) % m, n + i);
  return solid;
}

inline Solid AnySolid(Random& random) {
  switch (Below(random, 5)) {
    case 0:  // a box with a hole through it
      return Prism(random, {{0, 0}, {4, 0}, {4, 3}, {0, 3}}, {{1, 1}, {3, 1}, {3, 2}, {1, 2}},
                   Uniform(random, 0.2, 6));
    case 1:  // steps
      return Prism(random, {{0, 0}, {6, 0}, {6, 1}, {4, 1}, {4, 2}, {2, 2}, {2, 3}, {0, 3}}, {},
                   Uniform(random, 0.2, 6));
    case 2: {  // a nut
      std::vector<std::array<double, 2>> outline, hole;
      for (int i = 0; i < 6; ++i) {
        const double angle = i * std::acos(-1) / 3;
        outline.push_back({2 * std::cos(angle), 2 * std::sin(angle)});
        hole.push_back({std::cos(angle), std::sin(angle)});
      }
      return Prism(random, outline, hole, Uniform(random, 0.3, 3));
    }
    default:
      for (;;) {
        Solid solid = Polyhedron(random, 6 + Below(random, 7));
        if (!solid.faces.empty()) return solid;
      }
  }
}

// Turned, scaled and moved; sometimes only scaled.
inline void Put(Random& random, Solid& solid) {
  const bool is_turned = Below(random, 4) != 0;
  const Place u = is_turned ? RandomDirection(random) : Place{1, 0, 0};
  const Place v = is_turned ? Unit(Cross(u, RandomDirection(random))) : Place{0, 1, 0};
  const Place w = Cross(u, v);
  const double scale = std::pow(10, Uniform(random, -3, 3));
  Place offset{};
  for (Real& x : offset) x = scale * Uniform(random, -3, 3);
  for (Place& p : solid.points) {
    const Place q = p;
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = offset[k] + scale * (q[0] * u[k] + q[1] * v[k] + q[2] * w[k]);
    }
  }
}

enum class Numbers { kFloats, kSixDigits, kSixDecimals, kDoubles };

// Rounds the points as a file does. Returns what is known of such a file.
inline io::NumberRounding Round(Numbers numbers, Solid& solid) {
  io::WrittenDigits digits;
  for (Place& p : solid.points) {
    for (Real& x : p) {
      if (numbers == Numbers::kFloats) {
        x = double{static_cast<float>(x)};
        digits.AddFloat(static_cast<float>(x));
        continue;
      }
      char text[64];
      const char* const form = numbers == Numbers::kSixDigits     ? "%.6g"
                               : numbers == Numbers::kSixDecimals ? "%.6f"
                                                                  : "%.17g";
      std::snprintf(text, sizeof(text), form, static_cast<double>(x));
      x = std::strtod(text, nullptr) + 0.0;
      digits.Add(text, static_cast<double>(x));
    }
  }
  return digits.Rounding();
}

// The triangles as features, in any order, with any first corner and orientation.
struct Soup {
  std::vector<Feature> features;
  std::vector<FeatureId> id_of;  // of points
};
inline Soup Shuffled(Random& random, const Solid& solid) {
  Soup soup;
  std::vector<std::size_t> order(solid.points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::shuffle(order.begin(), order.end(), random);
  soup.id_of.resize(order.size());
  for (const std::size_t i : order) {
    const Place& p = solid.points[i];
    soup.id_of[i] = soup.features.size() + 1;
    soup.features.push_back(Feature::Point(soup.id_of[i], static_cast<double>(p[0]),
                                           static_cast<double>(p[1]), static_cast<double>(p[2])));
  }
  std::vector<Loop> triangles = solid.triangles;
  std::shuffle(triangles.begin(), triangles.end(), random);
  for (Loop& triangle : triangles) {
    std::rotate(triangle.begin(),
                triangle.begin() + static_cast<std::ptrdiff_t>(Below(random, triangle.size())),
                triangle.end());
    if (Below(random, 2) == 0) std::reverse(triangle.begin(), triangle.end());
    std::vector<FeatureId> ring;
    for (const int c : triangle) ring.push_back(soup.id_of[static_cast<std::size_t>(c)]);
    soup.features.push_back(Feature::Polygon(soup.features.size() + 1, {ring}));
  }
  return soup;
}

}  // namespace dynmesh::coplanar::rounded

#endif  // DYNMESH_TESTS_CORE_COPLANAR_ROUNDED_SOLIDS_H_
