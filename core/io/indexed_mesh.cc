#include "core/io/indexed_mesh.h"

#include <algorithm>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/data/canonical_order.h"
#include "core/data/mesh_store.h"
#include "core/data/text.h"

namespace dynmesh::io {

using data::Concat;
using data::Hex;
namespace {

using NumberOf = absl::flat_hash_map<VertexId, std::uint32_t>;

// The order described in the header, as a key.
auto VertexKey(const IndexedMesh::Vertex& v) {
  const bool on_box = v.owner == kBoxFeature;
  const bool input = v.containing_dimension == 0 && !on_box;
  const int rank = input ? 0 : on_box ? 1 : 1 + v.containing_dimension;
  return std::tuple(rank, input ? v.owner : kNoFeature, v.x, v.y);
}

absl::Status UnknownVertex(VertexId id) {
  return absl::InvalidArgumentError(
      Concat("the mesh names vertex ", Hex(id), ", which it does not have"));
}

absl::StatusOr<NumberOf> IndexVertices(const VertexColumns& columns, IndexedMesh& indexed) {
  const std::size_t n = columns.size();
  if (n >= std::numeric_limits<std::uint32_t>::max()) {
    return absl::InvalidArgumentError("the mesh has more vertices than files can number");
  }
  std::vector<IndexedMesh::Vertex> rows(n);
  for (std::size_t i = 0; i < n; ++i) {
    rows[i] = {columns.coordinates[2 * i], columns.coordinates[2 * i + 1],
               columns.containing_dimensions[i], columns.owners[i]};
  }
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::uint32_t i, std::uint32_t j) {
    return VertexKey(rows[i]) < VertexKey(rows[j]);
  });
  NumberOf number_of;
  number_of.reserve(n);
  indexed.vertices.reserve(n);
  for (const std::uint32_t row : order) {
    const auto number = static_cast<std::uint32_t>(indexed.vertices.size());
    if (!number_of.emplace(columns.ids[row], number).second) {
      return absl::InvalidArgumentError(
          Concat("vertex ", Hex(columns.ids[row]), " stands twice in the mesh"));
    }
    indexed.vertices.push_back(rows[row]);
  }
  return number_of;
}

// Sorts the triangles, and the regions' numbers with them.
void SortTriangles(IndexedMesh& indexed) {
  std::vector<IndexedMesh::Triangle>& triangles = indexed.triangles;
  std::vector<std::uint32_t>& numbers = indexed.regions.numbers;
  if (numbers.empty()) {
    std::sort(triangles.begin(), triangles.end());
    return;
  }
  std::vector<std::pair<IndexedMesh::Triangle, std::uint32_t>> rows(triangles.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = {triangles[i], numbers[i]};
  std::sort(rows.begin(), rows.end());
  for (std::size_t i = 0; i < rows.size(); ++i) std::tie(triangles[i], numbers[i]) = rows[i];
}

absl::Status IndexTriangles(const SimplexColumn& simplices, const NumberOf& number_of,
                            IndexedMesh& indexed) {
  indexed.triangles.reserve(simplices.size() / 3);
  for (std::size_t i = 0; i < simplices.size(); i += 3) {
    IndexedMesh::Triangle t;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto it = number_of.find(simplices[i + k]);
      if (it == number_of.end()) return UnknownVertex(simplices[i + k]);
      t[k] = it->second;
    }
    indexed.triangles.push_back(data::InCanonicalOrder(t));
  }
  SortTriangles(indexed);
  return absl::OkStatus();
}

// Subsegments and the triangles' edges, merged: where both name an edge the owner stays.
absl::Status IndexEdges(const SubsegmentColumns& subsegments, const NumberOf& number_of,
                        IndexedMesh& indexed) {
  std::vector<IndexedMesh::Edge>& edges = indexed.edges;
  edges.reserve(3 * indexed.triangles.size() + subsegments.size());
  for (const auto& t : indexed.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      edges.push_back({a, b, kNoFeature});
    }
  }
  for (std::size_t i = 0; i < subsegments.size(); ++i) {
    std::uint32_t ends[2];
    for (std::size_t k = 0; k < 2; ++k) {
      const auto it = number_of.find(subsegments.ends[2 * i + k]);
      if (it == number_of.end()) return UnknownVertex(subsegments.ends[2 * i + k]);
      ends[k] = it->second;
    }
    const auto [a, b] = std::minmax(ends[0], ends[1]);
    edges.push_back({a, b, subsegments.owners[i]});
  }
  // Owned rows first, so that the copies without an owner fall to unique().
  std::sort(edges.begin(), edges.end(), [](const auto& e, const auto& f) {
    return std::tuple(e.a, e.b, e.owner == kNoFeature, e.owner) <
           std::tuple(f.a, f.b, f.owner == kNoFeature, f.owner);
  });
  const auto same = [](const auto& e, const auto& f) {
    return e.a == f.a && e.b == f.b && (f.owner == kNoFeature || e.owner == f.owner);
  };
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<IndexedMesh> IndexMesh(const Mesh& mesh) {
  if (mesh.dimension != 2) {
    return absl::UnimplementedError("meshes of 3 dimensions are not supported yet in this version");
  }
  if (auto status = data::CheckColumns(mesh); !status.ok()) return status;
  IndexedMesh indexed;
  absl::StatusOr<NumberOf> number_of = IndexVertices(mesh.vertices, indexed);
  if (!number_of.ok()) return number_of.status();
  indexed.regions = NumberRegions(mesh);
  if (auto s = IndexTriangles(mesh.simplices, *number_of, indexed); !s.ok()) return s;
  if (auto s = IndexEdges(mesh.subsegments, *number_of, indexed); !s.ok()) return s;
  return indexed;
}

Mesh ToMesh(const IndexedMesh& indexed) {
  Mesh mesh;
  // Id to the next salt for its place: linear however often a damaged file repeats one.
  // (Of two places that truly collide the first takes salt 0; at 10^7 vertices the
  // chance of one such pair is 3e-6.)
  absl::flat_hash_map<VertexId, std::uint64_t> next_salt;
  next_salt.reserve(indexed.vertices.size());
  for (const auto& v : indexed.vertices) {
    const double coordinates[2] = {v.x, v.y};
    const VertexId unsalted = VertexIdAt(coordinates, 2);
    VertexId id = unsalted;
    while (!next_salt.emplace(id, 1).second) {
      id = VertexIdAt(coordinates, 2, next_salt.find(unsalted)->second++);
    }
    mesh.vertices.ids.push_back(id);
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), {v.x, v.y});
    mesh.vertices.containing_dimensions.push_back(
        static_cast<std::uint8_t>(v.containing_dimension));
    mesh.vertices.owners.push_back(v.owner);
  }
  const std::vector<VertexId>& ids = mesh.vertices.ids;
  mesh.simplices.reserve(3 * indexed.triangles.size());
  for (const auto& t : indexed.triangles) {
    const auto s = data::InCanonicalOrder(std::array<VertexId, 3>{ids[t[0]], ids[t[1]], ids[t[2]]});
    mesh.simplices.insert(mesh.simplices.end(), s.begin(), s.end());
  }
  SetRegions(indexed.regions, mesh);
  for (const auto& e : indexed.edges) {
    if (e.owner == kNoFeature) continue;
    const auto [a, b] = std::minmax(ids[e.a], ids[e.b]);
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), {a, b});
    mesh.subsegments.owners.push_back(e.owner);
  }
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

TriangleQuality MeasureTriangle(const IndexedMesh& mesh, std::size_t i) {
  double corner[3][2];
  for (std::size_t k = 0; k < 3; ++k) {
    const IndexedMesh::Vertex& v = mesh.vertices[mesh.triangles[i][k]];
    corner[k][0] = v.x;
    corner[k][1] = v.y;
  }
  return dynmesh::MeasureTriangle(corner[0], corner[1], corner[2]);
}

std::vector<SimplexVerdict> JudgeTriangles(const IndexedMesh& mesh, double rho) {
  MeshOptions options;
  options.quality = rho;
  return JudgeSimplices(ToMesh(mesh), options);
}

}  // namespace dynmesh::io
