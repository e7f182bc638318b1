// Surface files for tests.
#ifndef DYNMESH_TESTS_CLIENT_PREPARATION_SOLIDS_H_
#define DYNMESH_TESTS_CLIENT_PREPARATION_SOLIDS_H_

#include <array>
#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::test {

// Points and triangles, oriented with their normals outwards. A box has 8 and 12.
struct Solid {
  std::vector<std::array<double, 3>> points;
  std::vector<std::array<std::size_t, 3>> faces;

  void Add(const Solid& other) {
    const std::size_t first = points.size();
    points.insert(points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.faces) faces.push_back({first + a, first + b, first + c});
  }
  void TurnInsideOut() {
    for (auto& face : faces) std::swap(face[1], face[2]);
  }
  // Points 1, 2, ..., then triangles.
  std::vector<Feature> Features() const {
    std::vector<Feature> features;
    for (const auto& [x, y, z] : points) {
      features.push_back(Feature::Point(features.size() + 1, x, y, z));
    }
    for (const auto& [a, b, c] : faces) {
      features.push_back(Feature::Polygon(features.size() + 1, {{a + 1, b + 1, c + 1}}));
    }
    return features;
  }
  std::string Off() const {
    std::string text =
        "OFF\n" + std::to_string(points.size()) + " " + std::to_string(faces.size()) + " 0\n";
    for (const auto& [x, y, z] : points) {
      char line[100];
      std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", x, y, z);
      text += line;
    }
    for (const auto& [a, b, c] : faces) {
      text += "3 " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    }
    return text;
  }
};

inline Solid BoxSolid(const std::array<double, 3>& lo, const std::array<double, 3>& hi) {
  Solid box;
  for (std::size_t i = 0; i < 8; ++i) {
    box.points.push_back({i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1], i & 4 ? hi[2] : lo[2]});
  }
  box.faces = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
               {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return box;
}

// Two fans of triangles over a ring in the plane z = 0: to tips at z = 1 and -1.
inline Solid DoublePyramid(const std::vector<std::array<double, 2>>& ring) {
  Solid solid;
  for (const auto& [x, y] : ring) solid.points.push_back({x, y, 0});
  const std::size_t n = ring.size();
  solid.points.push_back({0.1, 0.2, 1});
  solid.points.push_back({-0.1, 0.1, -1});
  for (std::size_t i = 0; i < n; ++i) {
    solid.faces.push_back({i, (i + 1) % n, n});
    solid.faces.push_back({(i + 1) % n, i, n + 1});
  }
  return solid;
}

// A box whose two faces at the highest z have points of their own, `gap` above the others.
inline Solid CrackedBox(double gap) {
  Solid box = BoxSolid({0, 0, 0}, {1, 1, 1});
  for (std::size_t i = 4; i < 8; ++i) {
    box.points.push_back({box.points[i][0], box.points[i][1], 1 + gap});
  }
  box.faces[2] = {8, 9, 11};
  box.faces[3] = {8, 11, 10};
  return box;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CLIENT_PREPARATION_SOLIDS_H_
