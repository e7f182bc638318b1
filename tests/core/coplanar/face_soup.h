// 3D triangles for tests: cut at random, shuffled, and as features; and polygons of features by
// their coordinates only, to be compared independently of ids.
#ifndef DYNMESH_TESTS_CORE_COPLANAR_FACE_SOUP_H_
#define DYNMESH_TESTS_CORE_COPLANAR_FACE_SOUP_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::testing {

using Place = std::array<double, 3>;

struct FaceSoup {
  using Face = std::vector<std::size_t>;
  std::vector<Place> points;
  std::vector<Face> faces;

  void AddQuad(std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    faces.push_back({a, b, c});
    faces.push_back({a, c, d});
  }

  // Puts a point into a triangle or onto an edge, `steps` times. Positions have few enough bits to
  // be exact after any shear: none is made at a depth above 14.
  void Cut(int steps, std::mt19937& rng) {
    depths_.resize(faces.size(), 0);
    for (int i = 0; i < steps; ++i) {
      const std::size_t f = rng() % faces.size();
      if (depths_[f] > 14) continue;
      rng() % 2 == 0 ? CutInside(f, rng) : CutEdge(faces[f][0], faces[f][1]);
      const std::size_t g = rng() % faces.size();
      std::rotate(faces[g].begin(), faces[g].begin() + 1, faces[g].end());
    }
  }

  // Another order of points, faces and corners, and faces seen from either side.
  void Shuffle(std::mt19937& rng) {
    std::vector<std::size_t> to(points.size());
    std::iota(to.begin(), to.end(), std::size_t{0});
    std::shuffle(to.begin(), to.end(), rng);
    std::vector<Place> moved(points.size());
    for (std::size_t i = 0; i < to.size(); ++i) moved[to[i]] = points[i];
    points = std::move(moved);
    for (Face& face : faces) {
      for (std::size_t& corner : face) corner = to[corner];
      std::rotate(face.begin(), face.begin() + static_cast<std::ptrdiff_t>(rng() % face.size()),
                  face.end());
      if (rng() % 2 == 0) std::reverse(face.begin(), face.end());
    }
    std::shuffle(faces.begin(), faces.end(), rng);
  }

  std::vector<Feature> Features() const {
    std::vector<Feature> features;
    FeatureId id = 0;
    for (const Place& p : points) features.push_back(Feature::Point(++id, p[0], p[1], p[2]));
    for (const Face& face : faces) {
      std::vector<FeatureId> ring;
      for (const std::size_t corner : face) ring.push_back(corner + 1);
      features.push_back(Feature::Polygon(++id, {ring}));
    }
    return features;
  }

 private:
  std::size_t Weighted(const Face& face, const std::vector<double>& weights) {
    Place p{};
    for (std::size_t k = 0; k < weights.size(); ++k) {
      for (std::size_t d = 0; d < 3; ++d) p[d] += weights[k] * points[face[k]][d];
    }
    points.push_back(p);
    return points.size() - 1;
  }

  void CutInside(std::size_t f, std::mt19937& rng) {
    const Face face = faces[f];
    std::vector<double> weights = {0.25, 0.25, 0.25};
    weights[rng() % 3] = 0.5;
    const std::size_t p = Weighted(face, weights);
    const int depth = depths_[f] + 2;
    faces[f] = {face[0], face[1], p};
    faces.push_back({face[1], face[2], p});
    faces.push_back({face[2], face[0], p});
    depths_[f] = depth;
    depths_.resize(faces.size(), depth);
  }

  void CutEdge(std::size_t a, std::size_t b) {
    const std::size_t p = Weighted({a, b}, {0.5, 0.5});
    for (std::size_t f = faces.size(); f-- > 0;) {
      Face& face = faces[f];
      const auto at_a = std::find(face.begin(), face.end(), a);
      const auto at_b = std::find(face.begin(), face.end(), b);
      if (at_a == face.end() || at_b == face.end()) continue;
      Face other = face;
      other[static_cast<std::size_t>(at_a - face.begin())] = p;
      *at_b = p;
      ++depths_[f];
      const int depth = depths_[f];
      faces.push_back(other);
      depths_.push_back(depth);
    }
  }

  std::vector<int> depths_;
};

// Rings from their least place towards the lesser neighbour, all sorted.
using Shape = std::vector<std::vector<Place>>;

inline Shape ShapeOf(Shape rings) {
  for (std::vector<Place>& ring : rings) {
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    if (ring.back() < ring[1]) std::reverse(ring.begin() + 1, ring.end());
  }
  std::sort(rings.begin(), rings.end());
  return rings;
}

// Of all polygons.
inline std::multiset<Shape> ShapesOf(const std::vector<Feature>& features) {
  std::map<FeatureId, Place> at;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = f.position;
  }
  std::multiset<Shape> shapes;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPolygon) continue;
    Shape rings;
    for (const std::vector<FeatureId>& ring : f.rings) {
      std::vector<Place>& places = rings.emplace_back();
      for (const FeatureId id : ring) places.push_back(at.at(id));
    }
    shapes.insert(ShapeOf(std::move(rings)));
  }
  return shapes;
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_COPLANAR_FACE_SOUP_H_
