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

// Polygons as triangles, a fan from the first corner: of convex ones, the same area.
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
    const auto& ring = f.rings.front();
    for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
      plain.triangles.push_back({at.at(ring[0]), at.at(ring[i]), at.at(ring[i + 1])});
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
