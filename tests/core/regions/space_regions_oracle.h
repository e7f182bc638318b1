// Boxes as input, and the closed surfaces around each tetrahedron by counting crossings in exact
// numbers.
#ifndef DYNMESH_TESTS_CORE_REGIONS_SPACE_REGIONS_ORACLE_H_
#define DYNMESH_TESTS_CORE_REGIONS_SPACE_REGIONS_ORACLE_H_

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::testing {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Exact = Kernel::Point_3;
using Place = std::array<double, 3>;

inline MeshOptions Space() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = kDefaultQuality3D;
  return options;
}

inline Exact ToExact(const double* c) { return {c[0], c[1], c[2]}; }

// --- Input ------------------------------------------------------------------------------

// A box, or a part of one, turned: corners, ids from `first` on, and faces, ids from `polygon` on.
struct Solid {
  FeatureId first, polygon;
  std::vector<Place> corners;
  std::vector<std::vector<int>> faces;

  std::vector<Feature> Points() const {
    std::vector<Feature> features;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      features.push_back(Feature::Point(first + i, corners[i][0], corners[i][1], corners[i][2]));
    }
    return features;
  }
  Feature Face(std::size_t i) const {
    std::vector<FeatureId> ring;
    for (const int corner : faces[i]) ring.push_back(first + static_cast<FeatureId>(corner));
    return Feature::Polygon(polygon + i, {ring});
  }
  std::vector<Feature> All() const {
    std::vector<Feature> features = Points();
    for (std::size_t i = 0; i < faces.size(); ++i) features.push_back(Face(i));
    return features;
  }
};

// Turned about two axes unless `turn` is 0.
inline Place Turned(const Place& p, double turn) {
  const double c = std::cos(turn), s = std::sin(turn);
  const Place q = {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
  return {q[0], c * q[1] - s * q[2], s * q[1] + c * q[2]};
}

// Half as wide, around `at`. Of two boxes side by side if `parts` is 2: their outside alone, with
// two faces in one plane on four sides.
inline Solid Box(FeatureId first, FeatureId polygon, const Place& at, double half, double turn,
                 int parts = 1) {
  Solid solid{first, polygon, {}, {}};
  for (int i = 0; i <= parts; ++i) {
    for (int j = 0; j < 4; ++j) {
      const Place p = Turned({(2.0 * i / parts - 1) * half, (j == 1 || j == 2 ? half : -half),
                              (j >= 2 ? half : -half)},
                             turn);
      solid.corners.push_back({at[0] + p[0], at[1] + p[1], at[2] + p[2]});
    }
  }
  solid.faces = {{0, 1, 2, 3}, {4 * parts, 4 * parts + 1, 4 * parts + 2, 4 * parts + 3}};
  for (int i = 0; i < parts; ++i) {
    for (int j = 0; j < 4; ++j) {
      const int k = (j + 1) % 4;
      solid.faces.push_back({4 * i + j, 4 * i + k, 4 * i + 4 + k, 4 * i + 4 + j});
    }
  }
  return solid;
}

inline std::vector<Feature> operator+(std::vector<Feature> a, const std::vector<Feature>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// --- The oracle ---------------------------------------------------------------------------

using Fan = std::vector<std::array<Exact, 3>>;

// Fans from a corner of the polygon to its edges: modulo 2 they cover the polygon.
inline Fan FanOf(const Rings& rings, const std::map<FeatureId, Exact>& points) {
  Fan fan;
  const FeatureId apex = rings[0][0];
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const FeatureId a = ring[i], b = ring[(i + 1) % ring.size()];
      if (a != apex && b != apex) fan.push_back({points.at(apex), points.at(a), points.at(b)});
    }
  }
  return fan;
}

inline bool Crosses(const Exact& p, const Exact& q, const std::array<Exact, 3>& t) {
  const auto side = CGAL::orientation(t[0], t[1], t[2], p);
  if (side == CGAL::orientation(t[0], t[1], t[2], q)) return false;
  CGAL::Orientation turns[3];
  for (std::size_t i = 0; i < 3; ++i) turns[i] = CGAL::orientation(p, q, t[i], t[(i + 1) % 3]);
  const auto none = [&](CGAL::Orientation way) {
    return turns[0] != way && turns[1] != way && turns[2] != way;
  };
  if (!none(CGAL::POSITIVE) && !none(CGAL::NEGATIVE)) return false;
  // The segment meets the triangle: not at an edge, nor begins there.
  EXPECT_TRUE(side != CGAL::COPLANAR && none(CGAL::ZERO));
  return true;
}

// `surfaces`: the polygons of each, by its id. Skips flat tetrahedra beside a facet: the mesh knows
// the exact position of the facet better.
inline std::string FindWrongRegion(const Mesh& mesh, const std::vector<Feature>& features,
                                   const std::map<FeatureId, std::set<FeatureId>>& surfaces,
                                   std::size_t* counted = nullptr) {
  std::map<FeatureId, Exact> points;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) points.emplace(f.id, ToExact(f.position.data()));
  }
  std::map<FeatureId, Fan> fans;
  for (const auto& [id, polygons] : surfaces) {
    for (const Feature& f : features) {
      if (f.kind != FeatureKind::kPolygon || !polygons.contains(f.id)) continue;
      for (const auto& t : FanOf(f.rings, points)) fans[id].push_back(t);
    }
  }
  std::map<VertexId, const double*> vertices;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    vertices[mesh.vertices.ids[i]] = &mesh.vertices.coordinates[3 * i];
  }
  const Exact far(17.1234567, 31.7654321, 23.3141592);
  std::size_t flat = 0;
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) {
    Exact v[4];
    for (std::size_t k = 0; k < 4; ++k) v[k] = ToExact(vertices.at(mesh.simplices[4 * t + k]));
    const double volume = CGAL::to_double(CGAL::volume(v[0], v[1], v[2], v[3]));
    const double edge = std::sqrt(CGAL::to_double(CGAL::squared_distance(v[0], v[1])));
    if (volume < 1e-9 * edge * edge * edge) {
      ++flat;
      continue;
    }
    const Exact middle = CGAL::centroid(v[0], v[1], v[2], v[3]);
    std::vector<FeatureId> inside;
    for (const auto& [id, fan] : fans) {
      bool odd = false;
      for (const auto& triangle : fan) odd ^= Crosses(middle, far, triangle);
      if (odd) inside.push_back(id);
    }
    if (PolygonsOf(mesh.region(t), mesh.region_sets) != inside) {
      return "tetrahedron " + std::to_string(t) + " is in " + std::to_string(inside.size()) +
             " surfaces; the mesh says region " + std::to_string(mesh.region(t));
    }
  }
  if (flat > mesh.simplex_count() / 20) return "many flat tetrahedra";
  if (counted != nullptr) *counted += mesh.simplex_count() - flat;
  return "";
}

inline std::set<FeatureId> FacesOf(const Solid& solid) {
  std::set<FeatureId> ids;
  for (std::size_t i = 0; i < solid.faces.size(); ++i) ids.insert(solid.polygon + i);
  return ids;
}

inline std::set<RegionId> RegionsOf(const Mesh& mesh) {
  std::set<RegionId> ids;
  for (std::size_t t = 0; t < mesh.simplex_count(); ++t) ids.insert(mesh.region(t));
  return ids;
}

inline std::string Difference(Mesh a, Mesh b) {
  Canonicalize(a);
  Canonicalize(b);
  if (!(a.vertices == b.vertices)) return "vertices";
  if (a.simplices != b.simplices) return "simplices";
  if (a.regions != b.regions) return "regions";
  if (a.region_sets != b.region_sets) return "region sets";
  if (!(a.subfacets == b.subfacets)) return "subfacets";
  if (!(a.hash == b.hash)) return "hash";
  return "";
}

}  // namespace dynmesh::testing

#endif  // DYNMESH_TESTS_CORE_REGIONS_SPACE_REGIONS_ORACLE_H_
