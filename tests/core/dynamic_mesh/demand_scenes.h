// Random scenes that need many vertices: thin and fine regions, near lines, near facets.
#ifndef DYNMESH_TESTS_CORE_DYNAMIC_MESH_DEMAND_SCENES_H_
#define DYNMESH_TESTS_CORE_DYNAMIC_MESH_DEMAND_SCENES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::test {

// One scene: a call of a member adds to `features`. Ids ascend from 1.
class Scenes {
 public:
  explicit Scenes(std::uint64_t seed) : random_(seed) {}

  double Uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random_);
  }
  int Count(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(random_); }
  double Log(double lo, double hi) { return std::exp(Uniform(std::log(lo), std::log(hi))); }

  FeatureId Point(double x, double y, double z = 0) {
    features.push_back(Feature::Point(next_, x, y, z));
    return next_++;
  }
  void Segment(FeatureId p, FeatureId q) { features.push_back(Feature::Segment(next_++, p, q)); }
  void Polygon(Rings rings) { features.push_back(Feature::Polygon(next_++, std::move(rings))); }
  void Size(const std::array<double, 3>& at, const Sizing& sizing, Rings rings = {}) {
    features.push_back(Feature::Size(next_++, at, sizing));
    features.back().rings = std::move(rings);
  }

  // Regions, over each other or not, some out of the box.
  void Regions(int dimension, bool with_capsules = false) {
    const int n = Count(1, 5);
    for (int i = 0; i < n; ++i) {
      const double h = dimension == 2 ? Log(0.008, 0.05) : Log(0.05, 0.2);
      const std::array<double, 3> at = {Uniform(0, 1), Uniform(0, 1), Uniform(0, 1)};
      if (with_capsules) {
        Path path;
        for (int c = Count(2, 6); c > 0; --c) {
          path.push_back({Uniform(0, 1), Uniform(0, 1), dimension == 3 ? Uniform(0, 1) : 0});
        }
        Size({}, {SizeShape::kCapsule, h, Log(0.01, 0.5), {}, std::move(path)});
        continue;
      }
      const int kind = Count(0, dimension == 2 ? 3 : 2);
      if (kind == 0) Size(at, {SizeShape::kPoint, h, 0, {}});
      if (kind == 1) Size(at, {SizeShape::kDisc, h, Log(0.01, 0.5), {}});
      if (kind == 2) {
        Size(at, {SizeShape::kBox,
                  h,
                  0,
                  {at[0] + Log(0.02, 1.5), at[1] + Log(0.02, 1.5), at[2] + Log(0.02, 1.5)}});
      }
      // Rings that may cross, themselves or each other.
      if (kind == 3) {
        Rings rings(Count(1, 2));
        for (auto& ring : rings) {
          const int corners = Count(3, 6);
          for (int c = 0; c < corners; ++c) ring.push_back(Point(Uniform(0, 1), Uniform(0, 1)));
        }
        Size({}, {SizeShape::kPolygon, h, 0, {}}, std::move(rings));
      }
    }
  }

  // Regions thinner than their targets, some of no width.
  void ThinRegions(int dimension) {
    const auto any = [&] {
      return std::array<double, 3>{Uniform(0, 1), Uniform(0, 1),
                                   dimension == 3 ? Uniform(0, 1) : 0};
    };
    const int n = Count(1, 3);
    for (int i = 0; i < n; ++i) {
      const double h = dimension == 2 ? Log(0.001, 0.01) : Log(0.01, 0.05);
      const double width = Count(0, 1) * Log(1e-9, 1e-3);
      const int kind = Count(0, dimension == 2 ? 2 : 1);
      if (kind == 0) {
        Path path;
        for (int c = Count(2, 6); c > 0; --c) path.push_back(any());
        Size({}, {SizeShape::kCapsule, h, width, {}, std::move(path)});
      }
      if (kind == 1) {
        const std::array<double, 3> at = any();
        std::array<double, 3> hi = at;
        const int along = Count(0, dimension - 1);
        for (int k = 0; k < dimension; ++k) hi[k] += k == along ? Log(0.1, 1.5) : width;
        Size(at, {SizeShape::kBox, h, 0, hi});
      }
      if (kind == 2) {
        const std::array<double, 3> p = any(), q = any();
        Rings ring = {{Point(p[0], p[1]), Point(q[0], q[1]), Point(q[0] + width, q[1] + width)}};
        Size({}, {SizeShape::kPolygon, h, 0, {}}, std::move(ring));
      }
    }
  }

  // Lines that are nearly parallel, each shifted and turned a little.
  void Lines(int dimension) {
    const int n = Count(2, 6);
    const double gap = dimension == 2 ? Log(0.0003, 0.02) : Log(1e-4, 1.5e-3),
                 angle = Uniform(0, std::numbers::pi);
    double across = -0.1, beside = 0;
    for (int i = 0; i < n; ++i) {
      across += gap * Log(0.3, 4);
      beside += dimension == 3 ? gap * Uniform(-1, 1) : 0;
      const double from = Uniform(-0.3, 0.1), to = from + Uniform(0.02, 0.3);
      const double turn = Count(0, 1) * gap * Uniform(-0.5, 0.5);
      const auto place = [&](double along, double y) {
        return Point(0.5 + along * std::cos(angle) - y * std::sin(angle),
                     0.5 + along * std::sin(angle) + y * std::cos(angle), 0.5 + beside);
      };
      const FeatureId p = place(from, across), q = place(to, across + turn);
      Segment(p, q);
    }
  }

  // Parallel lines joined by diagonals, at one end or both: at sharp angles the quality is not
  // guaranteed, and meshes have few vertices.
  void Zigzags() {
    const double gap = Log(1e-4, 0.02), from = 0.2, to = from + Uniform(0.2, 0.6);
    const int n = Count(2, 5);
    std::vector<FeatureId> left, right;
    for (int i = 0; i < n; ++i) {
      left.push_back(Point(from + Count(0, 1) * Uniform(-0.1, 0.1), 0.5 + i * gap));
      right.push_back(Point(to + Count(0, 1) * Uniform(-0.1, 0.1), 0.5 + i * gap));
      Segment(left.back(), right.back());
    }
    for (int i = 0; i + 1 < n; ++i) {
      switch (Count(0, 4)) {
        case 0:
          Segment(left[i], right[i + 1]);
          break;
        case 1:
          Segment(right[i], left[i + 1]);
          break;
        case 2: {  // a fold between the two
          const FeatureId fold = Point(from + Uniform(0.02, 0.15), 0.5 + (i + 0.5) * gap);
          Segment(left[i], fold);
          Segment(fold, left[i + 1]);
          break;
        }
        case 3: {
          const FeatureId fold = Point(to - Uniform(0.02, 0.15), 0.5 + (i + 0.5) * gap);
          Segment(right[i], fold);
          Segment(fold, right[i + 1]);
          break;
        }
        default:
          break;
      }
    }
  }

  // A fan of spokes, some of which go on, and lines beside it.
  void Fan() {
    const FeatureId hub = Point(0.3, 0.3);
    const int n = Count(2, 12);
    double angle = 0;
    for (int i = 0; i < n; ++i) {
      angle += Log(0.0005, 0.2);
      const double r = Uniform(0.3, 0.6);
      const FeatureId end = Point(0.3 + r * std::cos(angle), 0.3 + r * std::sin(angle));
      Segment(hub, end);
      if (Count(0, 3) > 0) continue;
      const double far = r + 0.05;
      Segment(end, Point(0.3 + far * std::cos(angle + 0.0001), 0.3 + far * std::sin(angle)));
    }
  }

  // Squares in each other.
  void NestedSquares() {
    double half = Uniform(0.1, 0.4);
    const int n = Count(2, 4);
    for (int i = 0; i < n; ++i) {
      const FeatureId a = Point(0.5 - half, 0.5 - half), b = Point(0.5 + half, 0.5 - half),
                      c = Point(0.5 + half, 0.5 + half), d = Point(0.5 - half, 0.5 + half);
      Polygon({{a, b, c, d}});
      half -= Log(0.0005, 0.02);
    }
  }

  // Two rows of points that are joined, nearly side by side; they part or meet, their points are
  // opposite to each other or not.
  void Seams() {
    const double gap = Log(2e-5, 0.01), angle = Uniform(0, std::numbers::pi);
    const double opening = Count(0, 1) * Log(1e-4, 0.05);
    const bool shared_end = Count(0, 2) == 0;
    const auto place = [&](double along, double across) {
      return Point(0.5 + along * std::cos(angle) - across * std::sin(angle),
                   0.5 + along * std::sin(angle) + across * std::cos(angle));
    };
    const auto row = [&](double from, double to, double across, FeatureId last) {
      const int n = Count(1, 12);
      for (int i = 0; i <= n; ++i) {
        const double along = from + (to - from) * (i + (i % n == 0 ? 0 : Uniform(-0.3, 0.3))) / n;
        const FeatureId next = place(along, across == 0 ? 0 : across + opening * (along + 0.3));
        if (last != kNoFeature) Segment(last, next);
        last = next;
      }
    };
    const FeatureId start = shared_end ? place(-0.31, 0) : kNoFeature;
    row(-0.3, Uniform(0, 0.3), 0, start);
    row(-0.3 + Count(0, 1) * Uniform(0, 0.1), Uniform(0, 0.3), gap, start);
  }

  // A polygon with points next to each other on a line, beside a long edge.
  void NearDoubles() {
    const double gap = Log(1e-4, 0.01);
    std::vector<FeatureId> ring = {Point(0.8, 0.5 - gap), Point(0.8, 0.5)};
    for (int i = Count(0, 4); i > 0; --i) {
      ring.push_back(Point(0.8 - gap * i * Uniform(0.2, 0.9), 0.5 + Count(0, 1) * gap * 0.1));
    }
    std::sort(ring.begin() + 1, ring.end(), [&](FeatureId a, FeatureId b) {
      return features[a - 1].position[0] > features[b - 1].position[0];
    });
    ring.push_back(Point(Uniform(0.15, 0.5), 0.5));
    ring.push_back(Point(0.14, Uniform(0.55, 0.7)));
    ring.push_back(Point(Uniform(0.05, 0.13), 0.5 - gap));
    Polygon({ring});
  }

  // Plates above each other, as large or smaller, shifted or not.
  void Plates() {
    const int n = Count(2, 4);
    const double gap = Log(0.004, 0.02);
    const bool same = Count(0, 1) == 0;
    double z = 0.3, side = Uniform(0.3, 0.6), x = 0.2, y = 0.2;
    for (int i = 0; i < n; ++i) {
      if (!same) x += Uniform(0, 0.05), y += Uniform(0, 0.05), side *= Uniform(0.6, 1.1);
      const double tilt = Count(0, 1) * gap * Uniform(-0.4, 0.4);
      const FeatureId a = Point(x, y, z), b = Point(x + side, y, z + tilt),
                      c = Point(x + side, y + side, z + tilt), d = Point(x, y + side, z);
      Polygon({{a, b, c, d}});
      z += gap * Uniform(0.6, 2);
    }
  }

  // Narrow triangles above each other.
  void Blades() {
    const double gap = Log(0.004, 0.02), length = Uniform(0.3, 0.6), turn = Log(0.001, 0.9);
    const int n = Count(2, 4);
    double z = 0.3;
    for (int i = 0; i < n; ++i, z += gap * Uniform(0.6, 2)) {
      const FeatureId a = Point(0.2, 0.2, z), b = Point(0.2 + length, 0.2, z),
                      c = Point(0.2 + length * std::cos(turn), 0.2 + length * std::sin(turn), z);
      Polygon({{a, b, c}});
    }
  }

  std::vector<Feature> features;

 private:
  std::mt19937_64 random_;
  FeatureId next_ = 1;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CORE_DYNAMIC_MESH_DEMAND_SCENES_H_
