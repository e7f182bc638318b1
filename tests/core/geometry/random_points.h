// Random 2D points that are hard for predicates, for tests. Each generator names its kind of
// difficulty.
#ifndef DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_
#define DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <utility>

#include "core/geometry/point.h"

namespace dynmesh::geometry::testing {

enum class Kind {
  kUniform,       // generic
  kGrid,          // small integers: collinear and cocircular all the time
  kBigGrid,       // integers beyond 2^26: products beyond doubles
  kCocircular,    // exactly on one circle of integer points, shifted by a power of two
  kUlps,          // a line or a lattice disturbed by a few ulps
  kScales,        // clusters of size 2^-40 beside distances of 1
  kWildExponents  // every exponent of the domain, 2^-250 to 2^250
};

inline constexpr Kind kAllKinds[] = {Kind::kUniform,      Kind::kGrid, Kind::kBigGrid,
                                     Kind::kCocircular,   Kind::kUlps, Kind::kScales,
                                     Kind::kWildExponents};

class PointSource {
 public:
  PointSource(Kind kind, std::uint64_t seed) : kind_(kind), random_(seed) {}

  Point2 Next() {
    switch (kind_) {
      case Kind::kUniform:
        return {{Uniform(), Uniform()}};
      case Kind::kGrid:
        return {{double(Integer(-3, 3)), double(Integer(-3, 3))}};
      case Kind::kBigGrid: {
        const double step = 0x1p33 + 1;
        return {{step * double(Integer(-2, 2)), step * double(Integer(-2, 2))}};
      }
      case Kind::kCocircular: {
        // x^2 + y^2 = 65^2 * 25.
        static constexpr int kPairs[][2] = {{325, 0},   {91, 312},  {125, 300}, {165, 280},
                                            {195, 260}, {204, 253}, {36, 323},  {80, 315}};
        const auto& pair = kPairs[Integer(0, 7)];
        double x = pair[0], y = pair[1];
        if (Integer(0, 1)) std::swap(x, y);
        if (Integer(0, 1)) x = -x;
        if (Integer(0, 1)) y = -y;
        return {{x + 0x1p20, y * 1.0 + 0x1p21}};
      }
      case Kind::kUlps: {
        const double t = double(Integer(0, 8)) / 8;
        Point2 p = Integer(0, 1) ? Point2{{t + 0.1, 3 * t + 0.3}}
                                 : Point2{{0.1 + t, 0.7 + double(Integer(0, 3))}};
        for (int i = 0; i < 2; ++i) {
          for (int k = Integer(-2, 2); k != 0; k += k < 0 ? 1 : -1) {
            p[i] = std::nextafter(p[i], k < 0 ? -1e300 : 1e300);
          }
        }
        return p;
      }
      case Kind::kScales: {
        const double cx = double(Integer(0, 2)) / 3, cy = double(Integer(0, 2)) / 3;
        const double s = Integer(0, 1) ? 0x1p-40 : 0x1p-20;
        return {{cx + s * Uniform(), cy + s * Uniform()}};
      }
      case Kind::kWildExponents:
        return {{Wild(), Wild()}};
    }
    return {};
  }

 private:
  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int Integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  double Wild() {
    const int how = Integer(0, 9);
    if (how == 0) return 0;
    const double m = 1 + (how < 4 ? 0 : Uniform());
    return (Integer(0, 1) ? 1 : -1) * std::ldexp(m, Integer(-250, 249));
  }

  Kind kind_;
  std::mt19937_64 random_;
};

// A fresh seed, printed; DYNMESH_TEST_SEED in the environment repeats an old one.
inline std::uint64_t NewSeed() {
  const char* given = std::getenv("DYNMESH_TEST_SEED");
  const std::uint64_t seed =
      given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);
  return seed;
}

}  // namespace dynmesh::geometry::testing

#endif  // DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_
