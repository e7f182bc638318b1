#include "client/cli/size_conformity.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "absl/strings/str_format.h"
#include "client/cli/percentile.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {

// The nearest neighbour of a vertex is joined with it by an edge, as the mesh is Delaunay.
SizeConformity MeasureConformity(const io::IndexedMesh& mesh,
                                 const std::vector<Feature>& features) {
  std::vector<double> nearest(mesh.vertices.size(), std::numeric_limits<double>::infinity());
  for (const io::IndexedMesh::Edge& e : mesh.edges) {
    const auto &a = mesh.vertices[e.a], &b = mesh.vertices[e.b];
    const double length = std::hypot(a.x - b.x, a.y - b.y, a.z - b.z);
    for (const std::uint32_t v : {e.a, e.b}) nearest[v] = std::min(nearest[v], length);
  }
  std::vector<double> coordinates;
  for (const io::IndexedMesh::Vertex& v : mesh.vertices) {
    coordinates.insert(coordinates.end(), {v.x, v.y});
    if (mesh.dimension == 3) coordinates.push_back(v.z);
  }
  const std::vector<double> sizes = LocalFeatureSizes(features, mesh.dimension, coordinates);
  std::vector<double> ratios;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double ratio = sizes[i] / nearest[i];
    if (std::isfinite(ratio)) ratios.push_back(ratio);
  }
  return {Percentile(ratios, 0), Percentile(ratios, 0.5), Percentile(ratios, 0.9),
          Percentile(ratios, 0.99), Percentile(ratios, 1)};
}

std::string ConformityText(const SizeConformity& c) {
  if (std::isnan(c.median)) return "local feature size: no two features are disjoint\n";
  return absl::StrFormat(
      "local feature size / distance to the nearest vertex: %.3g to %.3g, median %.3g, 90 %% up to "
      "%.3g, 99 %% up to %.3g\n",
      c.least, c.greatest, c.median, c.p90, c.p99);
}

JsonObject ConformityJson(const SizeConformity& c) {
  JsonObject object;
  object.Add("min", c.least)
      .Add("p50", c.median)
      .Add("p90", c.p90)
      .Add("p99", c.p99)
      .Add("max", c.greatest);
  return object;
}

}  // namespace dynmesh::cli
