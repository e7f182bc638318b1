// Random 3D points that are hard for predicates, for tests. Each generator names its kind of
// difficulty; see random_points.h for 2D.
#ifndef DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_SPACE_POINTS_H_
#define DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_SPACE_POINTS_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

#include "core/geometry/point.h"

namespace dynmesh::geometry::testing {

enum class Trouble { kUniform, kGrid, kBigGrid, kCospherical, kUlps, kScales, kWild };
inline constexpr Trouble kAllTroubles[] = {Trouble::kUniform,     Trouble::kGrid, Trouble::kBigGrid,
                                           Trouble::kCospherical, Trouble::kUlps, Trouble::kScales,
                                           Trouble::kWild};

class SpacePointSource {
 public:
  SpacePointSource(Trouble trouble, std::uint64_t seed) : trouble_(trouble), random_(seed) {}

  Point3 Next() {
    Point3 p{};
    switch (trouble_) {
      case Trouble::kUniform:
        for (double& x : p.c) x = Unit();
        break;
      case Trouble::kGrid:
        for (double& x : p.c) x = Int(-2, 2);
        break;
      case Trouble::kBigGrid:
        for (double& x : p.c) x = (0x1p33 + 1) * Int(-2, 2);
        break;
      case Trouble::kCospherical: {
        // x^2 + y^2 + z^2 = 15^2: many on common circles, too.
        static constexpr int kTriples[][3] = {{15, 0, 0},  {9, 12, 0},  {2, 5, 14},
                                              {2, 10, 11}, {5, 10, 10}, {2, 11, 10}};
        const auto& t = kTriples[Int(0, 5)];
        p = {{double(t[0]), double(t[1]), double(t[2])}};
        std::shuffle(p.c.begin(), p.c.end(), random_);
        for (double& x : p.c) x = (Int(0, 1) ? -x : x) + 0x1p20;
        break;
      }
      case Trouble::kUlps: {
        const double t = Int(0, 4) / 4.0;
        p = Int(0, 1) ? Point3{{t + 0.1, 3 * t + 0.3, 1.6 - t}}
                      : Point3{{0.1 + Int(0, 2), 0.7 + Int(0, 2), 0.3 + t}};
        for (double& x : p.c) {
          for (int k = Int(-2, 2); k != 0; k += k < 0 ? 1 : -1) {
            x = std::nextafter(x, k < 0 ? -1e300 : 1e300);
          }
        }
        break;
      }
      case Trouble::kScales:
        for (double& x : p.c) x = Int(0, 2) / 3.0 + (Int(0, 1) ? 0x1p-40 : 0x1p-20) * Unit();
        break;
      case Trouble::kWild:
        for (double& x : p.c) {
          const int how = Int(0, 9);
          const double m = 1 + (how < 4 ? 0 : Unit());
          x = how == 0 ? 0 : (Int(0, 1) ? 1 : -1) * std::ldexp(m, Int(-250, 249));
        }
        break;
    }
    return p;
  }

 private:
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  int Int(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }

  Trouble trouble_;
  std::mt19937_64 random_;
};

}  // namespace dynmesh::geometry::testing

#endif  // DYNMESH_TESTS_CORE_GEOMETRY_RANDOM_SPACE_POINTS_H_
