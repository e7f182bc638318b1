// Random surfaces that no mesh accepts.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_SOUPS_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_SOUPS_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

using Corner3 = std::array<double, 3>;

// Points come first, each face has corners of its own.
class SoupMaker {
 public:
  explicit SoupMaker(std::uint64_t seed) : random_(seed) {}

  void AddFace(const std::vector<Corner3>& corners) { faces_.push_back(corners); }

  std::vector<Feature> Features() const {
    std::vector<Feature> features;
    FeatureId id = 0;
    std::vector<std::vector<FeatureId>> rings;
    for (const auto& face : faces_) {
      std::vector<FeatureId>& ring = rings.emplace_back();
      for (const Corner3& p : face) {
        features.push_back(Feature::Point(++id, p[0], p[1], p[2]));
        ring.push_back(id);
      }
    }
    for (auto& ring : rings) features.push_back(Feature::Polygon(++id, {std::move(ring)}));
    return features;
  }

  double Uniform(double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random_);
  }
  int Integer(int lo, int hi) { return std::uniform_int_distribution<int>(lo, hi)(random_); }
  Corner3 Place(double lo, double hi) {
    const double x = Uniform(lo, hi), y = Uniform(lo, hi), z = Uniform(lo, hi);
    return {x, y, z};
  }
  Corner3 LatticePlace(int n) {
    const int x = Integer(0, n), y = Integer(0, n), z = Integer(0, n);
    return {double(x), double(y), double(z)};
  }
  Corner3 Beside(const Corner3& p, double size) {
    const Corner3 d = Place(-size, size);
    return {p[0] + d[0], p[1] + d[1], p[2] + d[2]};
  }

  void Triangles(int n, double size) {
    for (int i = 0; i < n; ++i) {
      const Corner3 p = Place(0, 1);
      const Corner3 q = Beside(p, size), r = Beside(p, size);
      AddFace({p, q, r});
    }
  }
  // Corners are few: many are shared, and triangles come twice.
  void LatticeTriangles(int n, int extent) {
    for (int i = 0; i < n; ++i) {
      const Corner3 p = LatticePlace(extent), q = LatticePlace(extent), r = LatticePlace(extent);
      AddFace({p, q, r});
    }
  }
  // Squares and right triangles in the planes of a lattice, which overlap.
  void AxisParallel(int n, int extent) {
    for (int i = 0; i < n; ++i) {
      const Corner3 p = LatticePlace(extent);
      const std::size_t axis = static_cast<std::size_t>(Integer(0, 2));
      const double width = Integer(1, extent), height = Integer(1, extent);
      Corner3 q = p, r = p, s = p;
      q[(axis + 1) % 3] += width;
      r[(axis + 1) % 3] += width;
      r[(axis + 2) % 3] += height;
      s[(axis + 2) % 3] += height;
      if (Integer(0, 2) == 0) {
        AddFace({p, q, r});
      } else {
        AddFace({p, q, r, s});
      }
    }
  }
  // Almost in one plane, that is oblique.
  void NearCoplanar(int n, double height) {
    for (int i = 0; i < n; ++i) {
      std::vector<Corner3> corners;
      const double x = Uniform(0, 1), y = Uniform(0, 1);
      for (int k = 0; k < 3; ++k) {
        const double u = x + Uniform(-0.3, 0.3), v = y + Uniform(-0.3, 0.3);
        corners.push_back({u, v, 0.3 * u - 0.7 * v + Uniform(-height, height)});
      }
      AddFace(corners);
    }
  }
  void Needles(int n, double width) {
    for (int i = 0; i < n; ++i) {
      const Corner3 p = Place(0, 1), q = Place(0, 1);
      const double t = Integer(0, 1) == 0 ? 0 : Uniform(0, 1);
      const Corner3 r = Beside(
          {p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1]), p[2] + t * (q[2] - p[2])}, width);
      AddFace({p, q, r});
    }
  }
  // Surfaces of boxes, with corners that are nearly those of others.
  void Boxes(int n, double crack) {
    for (int i = 0; i < n; ++i) {
      Corner3 lo = LatticePlace(6), hi = lo;
      for (double& x : hi) x += Integer(1, 4);
      const auto corner = [&](int bits) {
        Corner3 p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = (bits >> k & 1) != 0 ? hi[k] : lo[k];
        return Beside(p, crack);
      };
      for (const std::array<int, 4>& f :
           {std::array{0, 2, 3, 1}, std::array{4, 5, 7, 6}, std::array{0, 1, 5, 4},
            std::array{2, 6, 7, 3}, std::array{0, 4, 6, 2}, std::array{1, 3, 7, 5}}) {
        AddFace({corner(f[0]), corner(f[1]), corner(f[2]), corner(f[3])});
      }
    }
  }
  void Repeat(int n) {
    for (int i = 0; i < n && !faces_.empty(); ++i) {
      std::vector<Corner3> face =
          faces_[static_cast<std::size_t>(Integer(0, static_cast<int>(faces_.size()) - 1))];
      std::rotate(face.begin(), face.begin() + 1, face.end());
      if (Integer(0, 1) == 1) std::reverse(face.begin(), face.end());
      faces_.push_back(std::move(face));
    }
  }

 private:
  std::mt19937_64 random_;
  std::vector<std::vector<Corner3>> faces_;
};

// The same surface: faces in another order, with other ids and orientations.
inline std::vector<Feature> Shuffled(const std::vector<Feature>& features, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::vector<FeatureId> ids(features.size());
  for (std::size_t i = 0; i < ids.size(); ++i) ids[i] = i + 1;
  std::shuffle(ids.begin(), ids.end(), random);
  std::vector<Feature> result = features;
  for (Feature& f : result) {
    f.id = ids[f.id - 1];
    for (FeatureId& end : f.ends) end = end == kNoFeature ? end : ids[end - 1];
    for (auto& ring : f.rings) {
      for (FeatureId& corner : ring) corner = ids[corner - 1];
      std::rotate(ring.begin(), ring.begin() + static_cast<std::ptrdiff_t>(random() % ring.size()),
                  ring.end());
      if (random() % 2 == 0) std::reverse(ring.begin(), ring.end());
    }
  }
  std::shuffle(result.begin(), result.end(), random);
  return result;
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_SOUPS_H_
