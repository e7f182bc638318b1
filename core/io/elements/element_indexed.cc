// Elements as a mesh to be measured and judged.
#include <algorithm>
#include <map>
#include <set>

#include "core/coplanar/facet_rings.h"
#include "core/geometry/predicates.h"
#include "core/geometry/space_predicates.h"
#include "core/io/elements/element_mesh.h"

namespace dynmesh::io {
namespace {

FeatureId OwnerOf(std::int64_t marker) {
  return marker > 0 && static_cast<FeatureId>(marker) <= kLastPolygonId
             ? static_cast<FeatureId>(marker)
             : FeatureId{1};
}

template <int D>
int SignOf(const ElementMesh& mesh, const Element<D + 1>& element) {
  std::array<geometry::Point<D>, D + 1> c;
  for (std::size_t j = 0; j <= D; ++j) {
    const std::array<double, 3>& p = mesh.positions[element.corners[j]];
    if (!coplanar::IsInDomain(p)) return 0;
    for (std::size_t k = 0; k < D; ++k) c[j].c[k] = p[k];
  }
  if constexpr (D == 2) {
    return geometry::Orientation(c[0], c[1], c[2]);
  } else {
    return geometry::Orientation(c[0], c[1], c[2], c[3]);
  }
}

template <int D>
void AddSimplices(const ElementMesh& mesh, const std::vector<Element<D + 1>>& elements,
                  IndexedMesh& indexed) {
  std::int64_t positive = 0;
  for (const auto& element : elements) positive += SignOf<D>(mesh, element);
  auto& simplices = SimplicesOf<D>(indexed);
  for (const auto& element : elements) {
    auto corners = element.corners;
    if (positive < 0) std::swap(corners[0], corners[1]);
    simplices.push_back(corners);
  }
}

}  // namespace

IndexedMesh ToIndexed(const ElementMesh& mesh) {
  IndexedMesh indexed;
  indexed.dimension = mesh.dimension;
  for (const auto& [x, y, z] : mesh.positions) {
    indexed.vertices.push_back({x, y, mesh.dimension, kNoFeature, mesh.dimension == 3 ? z : 0});
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::map<std::pair<std::uint32_t, std::uint32_t>, FeatureId> owners;
  std::map<std::array<std::uint32_t, 3>, FeatureId> faces;
  const auto add_face = [&](std::array<std::uint32_t, 3> corners, FeatureId owner) {
    std::sort(corners.begin(), corners.end());
    faces[corners] = owner;
  };
  if (mesh.dimension == 2) {
    AddSimplices<2>(mesh, mesh.triangles, indexed);
  } else {
    AddSimplices<3>(mesh, mesh.tetrahedra, indexed);
    std::map<std::array<std::uint32_t, 3>, int> uses;
    for (const auto& t : indexed.tetrahedra) {
      for (std::size_t k = 0; k < 4; ++k) {
        std::array<std::uint32_t, 3> side = {t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
        std::sort(side.begin(), side.end());
        ++uses[side];
      }
    }
    for (const auto& [side, count] : uses) {
      if (count == 1) faces[side] = FeatureId{1};
    }
    for (const auto& triangle : mesh.triangles) {
      add_face(triangle.corners, OwnerOf(triangle.marker));
    }
  }
  ForEachSimplex(indexed, [&](const auto& corners) {
    for (std::size_t j = 0; j < corners.size(); ++j) {
      for (std::size_t k = j + 1; k < corners.size(); ++k) {
        edges.insert(std::minmax(corners[j], corners[k]));
      }
    }
  });
  std::map<std::uint32_t, std::set<FeatureId>> at;  // owners of the segments at a vertex
  for (const auto& line : mesh.segments) {
    const auto ends = std::minmax(line.corners[0], line.corners[1]);
    edges.insert(ends);
    owners[ends] = OwnerOf(line.marker);
    for (const std::uint32_t end : line.corners) at[end].insert(OwnerOf(line.marker));
  }
  for (const auto& [a, b] : edges) {
    const auto owner = owners.find({a, b});
    indexed.edges.push_back({a, b, owner == owners.end() ? kNoFeature : owner->second});
  }
  for (const auto& [corners, owner] : faces) {
    indexed.faces.push_back({corners, owner});
    for (const std::uint32_t v : corners) {
      indexed.vertices[v].containing_dimension = 2;
      indexed.vertices[v].owner = owner;
    }
  }
  for (const auto& [v, names] : at) {
    indexed.vertices[v].containing_dimension = names.size() == 1 ? 1 : 0;
    indexed.vertices[v].owner = *names.begin();
  }
  return indexed;
}

}  // namespace dynmesh::io
