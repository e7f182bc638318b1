// Surfaces of many triangles that are easily described.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_TEST_SURFACES_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_TEST_SURFACES_H_

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numbers>
#include <random>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

// Triangles with common corners. Points have ids from 1, faces follow.
class SurfaceMaker {
 public:
  using Place = std::array<double, 3>;

  void AddTriangle(const Place& a, const Place& b, const Place& c) {
    faces_.push_back({Id(a), Id(b), Id(c)});
  }
  void AddQuadrangle(const Place& a, const Place& b, const Place& c, const Place& d) {
    AddTriangle(a, b, c);
    AddTriangle(a, c, d);
  }
  // n x n squares a side, as triangles; the box from `lo` to `lo + n`.
  void AddCube(int n, int lo = 0) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (const int at : {lo, lo + n}) {
        for (int i = lo; i < lo + n; ++i) {
          for (int j = lo; j < lo + n; ++j) {
            const auto place = [&](int a, int b) {
              Place p;
              p[axis] = at;
              p[(axis + 1) % 3] = a;
              p[(axis + 2) % 3] = b;
              return p;
            };
            AddQuadrangle(place(i, j), place(i + 1, j), place(i + 1, j + 1), place(i, j + 1));
          }
        }
      }
    }
  }
  // Of radius 1: an octahedron, each triangle split into n * n.
  void AddSphere(int n) {
    const auto place = [&](int sx, int sy, int sz, int i, int j) {
      const Place p = {double(sx) * i, double(sy) * j, double(sz) * (n - i - j)};
      const double length = std::hypot(p[0], p[1], p[2]);
      return Place{p[0] / length, p[1] / length, p[2] / length};
    };
    for (const int sx : {-1, 1}) {
      for (const int sy : {-1, 1}) {
        for (const int sz : {-1, 1}) {
          for (int i = 0; i < n; ++i) {
            for (int j = 0; i + j < n; ++j) {
              const auto at = [&](int a, int b) { return place(sx, sy, sz, a, b); };
              AddTriangle(at(i, j), at(i + 1, j), at(i, j + 1));
              if (i + j + 1 < n) AddTriangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            }
          }
        }
      }
    }
  }
  // Of radius and height 1, with n sides and n / 4 layers; with flat ends, or open.
  void AddCylinder(int n, bool is_closed) {
    const int layers = n / 4;
    const auto place = [&](int i, int k, double radius) {
      const double angle = 2 * std::numbers::pi * (i % n) / n;
      return Place{radius * std::cos(angle), radius * std::sin(angle), double(k) / layers};
    };
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < layers; ++k) {
        AddQuadrangle(place(i, k, 1), place(i + 1, k, 1), place(i + 1, k + 1, 1),
                      place(i, k + 1, 1));
      }
      for (const int k : {0, layers}) {
        if (!is_closed) continue;
        AddQuadrangle(place(i, k, 1), place(i + 1, k, 1), place(i + 1, k, 0.5), place(i, k, 0.5));
        AddTriangle(place(i, k, 0.5), place(i + 1, k, 0.5), {0, 0, double(k) / layers});
      }
    }
  }
  // Over the unit square, 2 n n triangles: waves and noise.
  void AddTerrain(int n, double noise, std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<Place> places;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) {
        const double x = double(i) / n, y = double(j) / n;
        const double dx = 0.2 * uniform(random) / n, dy = 0.2 * uniform(random) / n;
        places.push_back(
            {x + dx, y + dy, 0.1 * std::sin(7 * x) * std::cos(5 * y) + noise * uniform(random)});
      }
    }
    const auto at = [&](int i, int j) { return places[static_cast<std::size_t>(i * (n + 1) + j)]; };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        AddQuadrangle(at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
    }
  }

  std::vector<Feature> Features() const {
    std::vector<Feature> features(ids_.size());
    for (const auto& [p, id] : ids_) features[id - 1] = Feature::Point(id, p[0], p[1], p[2]);
    FeatureId id = ids_.size();
    for (const auto& face : faces_) features.push_back(Feature::Polygon(++id, {face}));
    return features;
  }
  std::size_t face_count() const { return faces_.size(); }

 private:
  FeatureId Id(const Place& p) { return ids_.try_emplace(p, ids_.size() + 1).first->second; }

  std::map<Place, FeatureId> ids_;
  std::vector<std::vector<FeatureId>> faces_;
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_TEST_SURFACES_H_
