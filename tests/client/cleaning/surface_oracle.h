// What is wrong with a cleaned surface: all pairs of faces, by CGAL's exact intersections.
#ifndef DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_ORACLE_H_
#define DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_ORACLE_H_

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::cleaning {

using Place3 = std::array<double, 3>;

// Do the triangles from the first corner have area, all on one side?
inline bool FanIsValid(const std::vector<Place3>& ring) {
  const auto normal = [&](std::size_t i) {
    Place3 u, w;
    for (std::size_t k = 0; k < 3; ++k) {
      u[k] = ring[i][k] - ring[0][k];
      w[k] = ring[i + 1][k] - ring[0][k];
    }
    return Place3{u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
  };
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const Place3 a = normal(1), b = normal(i);
    if (!(a[0] * b[0] + a[1] * b[1] + a[2] * b[2] > 0)) return false;
  }
  return true;
}

// Polygons as triangles, a fan from a corner that sees them all: of quadrangles there always is
// one.
struct PlainSurface {
  std::vector<std::array<Place3, 3>> triangles;
  std::vector<std::array<Place3, 2>> segments;
  std::vector<Place3> points;  // all
};

inline PlainSurface PlainOf(const std::vector<Feature>& features) {
  PlainSurface plain;
  std::map<FeatureId, Place3> at;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) {
      at[f.id] = f.position;
      plain.points.push_back(f.position);
    }
  }
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kSegment) {
      plain.segments.push_back({at.at(f.ends[0]), at.at(f.ends[1])});
    }
    if (f.kind != FeatureKind::kPolygon) continue;
    std::vector<Place3> ring;
    for (const FeatureId corner : f.rings.front()) ring.push_back(at.at(corner));
    for (std::size_t turns = 0; turns < ring.size() && !FanIsValid(ring); ++turns) {
      std::rotate(ring.begin(), ring.begin() + 1, ring.end());
    }
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
      plain.triangles.push_back({ring[0], ring[i], ring[i + 1]});
    }
  }
  return plain;
}

// The first fault, empty if there is none. O(n^2).
std::string FaultOf(const PlainSurface& surface);

// The faces of any orientation and order, by coordinates.
inline std::set<std::set<Place3>> FacesOf(const std::vector<Feature>& features) {
  std::map<FeatureId, Place3> at;
  std::set<std::set<Place3>> faces;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) at[f.id] = f.position;
  }
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPolygon) continue;
    std::set<Place3> face;
    for (const auto& ring : f.rings) {
      for (const FeatureId corner : ring) face.insert(at.at(corner));
    }
    faces.insert(std::move(face));
  }
  return faces;
}

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_TESTS_CLIENT_CLEANING_SURFACE_ORACLE_H_
