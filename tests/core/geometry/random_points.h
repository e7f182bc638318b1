// Random 2D points that are hard for predicates, for tests. Each generator names its kind of
// difficulty.
#ifndef DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_
#define DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <utility>

#include "core/geometry/point.h"
#include "tests/support/seed.h"

namespace dynmesh::geometry::testing {

enum class Kind {
  kUniform,       // generic
  kGrid,          // small integers: collinear and cocircular all the time
  kBigGrid,       // integers beyond 2^26: products beyond doubles
  kNative,        // integers below 2^23, the widest in native integers, and some wider ones
  kCocircular,    // exactly on one circle or sphere of integer points, shifted by a power of two
  kUlps,          // a line or a lattice disturbed by a few ulps
  kScales,        // clusters of size 2^-40 beside distances of 1
  kWildExponents  // every exponent of the domain, 2^-250 to 2^250
};

inline constexpr Kind kAllKinds[] = {Kind::kUniform, Kind::kGrid,         Kind::kBigGrid,
                                     Kind::kNative,  Kind::kCocircular,   Kind::kUlps,
                                     Kind::kScales,  Kind::kWildExponents};

template <int D>
class PointSource {
 public:
  PointSource(Kind kind, std::uint64_t seed) : kind_(kind), random_(seed) {}

  Point<D> Next() {
    if (kind_ == Kind::kCocircular) return OnSphere();
    Point<D> p = kind_ == Kind::kUlps ? OnLineOrLattice() : Point<D>{};
    for (double& x : p.c) x = Coordinate(x);
    return p;
  }

 private:
  double Uniform() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int Integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  // `x`: of the point before it is disturbed.
  double Coordinate(double x) {
    const int most = D == 2 ? 3 : 2;
    switch (kind_) {
      case Kind::kUniform:
        return Uniform();
      case Kind::kGrid:
        return Integer(-most, most);
      case Kind::kBigGrid:
        return (0x1p33 + 1) * Integer(-2, 2);
      case Kind::kNative: {
        const int beyond = 1 << 23, how = Integer(0, 99);
        if (how == 0) return beyond;
        return how < 60 ? (how % 2 == 0 ? 1 - beyond : beyond - 1)
                        : Integer(1 - beyond, beyond - 1);
      }
      case Kind::kScales:
        return Integer(0, 2) / 3.0 + (Integer(0, 1) ? 0x1p-40 : 0x1p-20) * Uniform();
      case Kind::kWildExponents: {
        const int how = Integer(0, 9);
        if (how == 0) return 0;
        const double m = 1 + (how < 4 ? 0 : Uniform());
        return (Integer(0, 1) ? 1 : -1) * std::ldexp(m, Integer(-250, 249));
      }
      case Kind::kUlps:
        for (int k = Integer(-2, 2); k != 0; k += k < 0 ? 1 : -1) {
          x = std::nextafter(x, k < 0 ? -1e300 : 1e300);
        }
        return x;
      case Kind::kCocircular:
        break;
    }
    return x;
  }
  Point<D> OnLineOrLattice() {
    const bool on_line = Integer(0, 1) != 0;
    if constexpr (D == 2) {
      const double t = Integer(0, 8) / 8.0;
      return on_line ? Point2{{t + 0.1, 3 * t + 0.3}} : Point2{{0.1 + t, 0.7 + Integer(0, 3)}};
    } else {
      const double t = Integer(0, 4) / 4.0;
      return on_line ? Point3{{t + 0.1, 3 * t + 0.3, 1.6 - t}}
                     : Point3{{0.1 + Integer(0, 2), 0.7 + Integer(0, 2), 0.3 + t}};
    }
  }
  // 2D: x^2 + y^2 = 65^2 * 25. 3D: x^2 + y^2 + z^2 = 15^2, many on common circles, too.
  Point<D> OnSphere() {
    static constexpr double kPairs[][2] = {{325, 0},   {91, 312},  {125, 300}, {165, 280},
                                           {195, 260}, {204, 253}, {36, 323},  {80, 315}};
    static constexpr double kTriples[][3] = {{15, 0, 0},  {9, 12, 0},  {2, 5, 14},
                                             {2, 10, 11}, {5, 10, 10}, {2, 11, 10}};
    Point<D> p;
    if constexpr (D == 2) {
      std::copy_n(kPairs[Integer(0, 7)], D, p.c.begin());
    } else {
      std::copy_n(kTriples[Integer(0, 5)], D, p.c.begin());
    }
    std::shuffle(p.c.begin(), p.c.end(), random_);
    double shift = 0x1p20;
    for (double& x : p.c) {
      x = (Integer(0, 1) ? -x : x) + shift;
      if (D == 2) shift *= 2;
    }
    return p;
  }

  Kind kind_;
  std::mt19937_64 random_;
};

using test::NewSeed;

}  // namespace dynmesh::geometry::testing

#endif  // DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_POINTS_H_
