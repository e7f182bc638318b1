#include "core/io/meshes/indexed_mesh.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/io/meshes/sort_by_vertex.h"
#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/check_columns.h"

namespace dynmesh::io {

using text::Concat;
using text::Hex;
namespace {

using NumberOf = absl::flat_hash_map<VertexId, std::uint32_t>;

// The order described in the header: by rank, then by a key.
int RankOf(const IndexedMesh::Vertex& v) {
  const bool on_box = v.owner == kBoxFeature;
  if (on_box) return 1;
  return v.containing_dimension == 0 ? 0 : 1 + v.containing_dimension;
}
auto VertexKey(const IndexedMesh::Vertex& v) {
  return std::tuple(RankOf(v) == 0 ? v.owner : kNoFeature, v.x, v.y, v.z);
}

// The rows in that order, those in one place (of an opened part) by id. Most inputs have it
// already.
std::vector<std::uint32_t> OrderOf(const std::vector<IndexedMesh::Vertex>& rows,
                                   const std::vector<VertexId>& ids) {
  std::vector<std::vector<std::uint32_t>> by_rank;
  for (std::uint32_t i = 0; i < rows.size(); ++i) {
    const auto rank = static_cast<std::size_t>(RankOf(rows[i]));
    if (rank >= by_rank.size()) by_rank.resize(rank + 1);
    by_rank[rank].push_back(i);
  }
  std::vector<std::uint32_t> order;
  order.reserve(rows.size());
  const auto before = [&](std::uint32_t i, std::uint32_t j) {
    const auto a = VertexKey(rows[i]), b = VertexKey(rows[j]);
    return a < b || (a == b && ids[i] < ids[j]);
  };
  for (std::vector<std::uint32_t>& rank : by_rank) {
    if (!std::is_sorted(rank.begin(), rank.end(), before)) {
      std::sort(rank.begin(), rank.end(), before);
    }
    order.insert(order.end(), rank.begin(), rank.end());
  }
  return order;
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
  const auto d = static_cast<std::size_t>(indexed.dimension);
  std::vector<IndexedMesh::Vertex> rows(n);
  for (std::size_t i = 0; i < n; ++i) {
    const double* const c = &columns.coordinates[d * i];
    rows[i] = {c[0], c[1], columns.containing_dimensions[i], columns.owners[i], d == 3 ? c[2] : 0};
  }
  NumberOf number_of;
  number_of.reserve(n);
  indexed.vertices.reserve(n);
  for (const std::uint32_t row : OrderOf(rows, columns.ids)) {
    const auto number = static_cast<std::uint32_t>(indexed.vertices.size());
    if (!number_of.emplace(columns.ids[row], number).second) {
      return absl::InvalidArgumentError(
          Concat("vertex ", Hex(columns.ids[row]), " stands twice in the mesh"));
    }
    indexed.vertices.push_back(rows[row]);
  }
  return number_of;
}

// The numbers of K vertices.
template <std::size_t K>
absl::StatusOr<std::array<std::uint32_t, K>> NumbersOf(const VertexId* ids,
                                                       const NumberOf& number_of) {
  std::array<std::uint32_t, K> numbers;
  for (std::size_t k = 0; k < K; ++k) {
    const auto it = number_of.find(ids[k]);
    if (it == number_of.end()) return UnknownVertex(ids[k]);
    numbers[k] = it->second;
  }
  return numbers;
}

// Sorts the simplices, and the regions' numbers with them.
template <class Simplex>
void SortSimplices(std::vector<Simplex>& simplices, std::vector<std::uint32_t>& numbers,
                   std::size_t vertices) {
  if (numbers.empty()) {
    return SortByVertex(
        simplices, vertices, [](const Simplex& s) { return s[0]; }, std::less<>());
  }
  using Row = std::pair<Simplex, std::uint32_t>;
  std::vector<Row> rows(simplices.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = {simplices[i], numbers[i]};
  SortByVertex(
      rows, vertices, [](const Row& row) { return row.first[0]; }, std::less<>());
  for (std::size_t i = 0; i < rows.size(); ++i) std::tie(simplices[i], numbers[i]) = rows[i];
}

template <int D>
absl::Status IndexSimplices(const SimplexColumn& simplices, const NumberOf& number_of,
                            IndexedMesh& indexed) {
  auto& rows = SimplicesOf<D>(indexed);
  rows.reserve(simplices.size() / (D + 1));
  for (std::size_t i = 0; i < simplices.size(); i += D + 1) {
    const auto t = NumbersOf<D + 1>(&simplices[i], number_of);
    if (!t.ok()) return t.status();
    rows.push_back(mesh_data::InCanonicalOrder(*t));
  }
  SortSimplices(rows, indexed.regions.numbers, indexed.vertices.size());
  return absl::OkStatus();
}

// Merges subsegments and the simplices' edges. If both have an edge, its owner stays.
absl::Status IndexEdges(const SubsegmentColumns& subsegments, const NumberOf& number_of,
                        IndexedMesh& indexed) {
  std::vector<IndexedMesh::Edge>& edges = indexed.edges;
  const std::size_t each = indexed.dimension == 2 ? 3 : 6;
  edges.reserve(each * indexed.simplex_count() + subsegments.size());
  ForEachSimplex(indexed, [&](const auto& corners) {
    for (std::size_t j = 0; j < corners.size(); ++j) {
      for (std::size_t k = j + 1; k < corners.size(); ++k) {
        const auto [a, b] = std::minmax(corners[j], corners[k]);
        edges.push_back({a, b, kNoFeature});
      }
    }
  });
  for (std::size_t i = 0; i < subsegments.size(); ++i) {
    const auto ends = NumbersOf<2>(&subsegments.ends[2 * i], number_of);
    if (!ends.ok()) return ends.status();
    const auto [a, b] = std::minmax((*ends)[0], (*ends)[1]);
    edges.push_back({a, b, subsegments.owners[i]});
  }
  // Owned rows first, so that unique() removes the copies without an owner.
  SortByVertex(
      edges, indexed.vertices.size(), [](const auto& e) { return e.a; },
      [](const auto& e, const auto& f) {
        return std::tuple(e.a, e.b, e.owner == kNoFeature, e.owner) <
               std::tuple(f.a, f.b, f.owner == kNoFeature, f.owner);
      });
  const auto same = [](const auto& e, const auto& f) {
    return e.a == f.a && e.b == f.b && (f.owner == kNoFeature || e.owner == f.owner);
  };
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  return absl::OkStatus();
}

// Adds the triangles with only one tetrahedron, owned by the box.
void AddBorder(IndexedMesh& indexed) {
  std::vector<std::array<std::uint32_t, 3>> sides;
  sides.reserve(4 * indexed.tetrahedra.size());
  for (const auto& t : indexed.tetrahedra) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<std::uint32_t, 3> side = {t[(k + 1) % 4], t[(k + 2) % 4], t[(k + 3) % 4]};
      std::sort(side.begin(), side.end());
      sides.push_back(side);
    }
  }
  SortByVertex(
      sides, indexed.vertices.size(), [](const auto& side) { return side[0]; }, std::less<>());
  for (std::size_t i = 0; i < sides.size();) {
    const std::size_t first = i;
    while (i < sides.size() && sides[i] == sides[first]) ++i;
    if (i - first == 1) indexed.faces.push_back({sides[first], kBoxFeature});
  }
}

absl::Status IndexFaces(const SubfacetColumns& subfacets, const NumberOf& number_of,
                        IndexedMesh& indexed) {
  std::vector<IndexedMesh::Face>& faces = indexed.faces;
  AddBorder(indexed);
  for (std::size_t i = 0; i < subfacets.size(); ++i) {
    auto corners = NumbersOf<3>(&subfacets.corners[3 * i], number_of);
    if (!corners.ok()) return corners.status();
    std::sort(corners->begin(), corners->end());
    faces.push_back({*corners, subfacets.owners[i]});
  }
  // The box's id is the greatest: a feature's row comes before the border's.
  SortByVertex(
      faces, indexed.vertices.size(), [](const auto& e) { return e.corners[0]; },
      [](const auto& e, const auto& f) {
        return std::tie(e.corners, e.owner) < std::tie(f.corners, f.owner);
      });
  const auto same = [](const auto& e, const auto& f) {
    return e.corners == f.corners && (f.owner == kBoxFeature || e.owner == f.owner);
  };
  faces.erase(std::unique(faces.begin(), faces.end(), same), faces.end());
  return absl::OkStatus();
}

template <int D>
void AppendSimplices(const IndexedMesh& indexed, Mesh& mesh) {
  const std::vector<VertexId>& ids = mesh.vertices.ids;
  mesh.simplices.reserve((D + 1) * indexed.simplex_count());
  for (const auto& t : SimplicesOf<D>(indexed)) {
    std::array<VertexId, D + 1> s;
    for (std::size_t k = 0; k <= D; ++k) s[k] = ids[t[k]];
    s = mesh_data::InCanonicalOrder(s);
    mesh.simplices.insert(mesh.simplices.end(), s.begin(), s.end());
  }
}

template <int D>
std::vector<std::uint32_t> Find(const IndexedMesh& mesh, const SimplexColumn& simplices) {
  using Row = std::array<VertexId, D + 1>;
  std::set<Row> wanted;
  for (std::size_t i = 0; i + D < simplices.size(); i += D + 1) {
    Row row;
    std::copy_n(&simplices[i], D + 1, row.begin());
    std::sort(row.begin(), row.end());
    wanted.insert(row);
  }
  std::vector<VertexId> ids;
  ids.reserve(mesh.vertices.size());
  for (const auto& v : mesh.vertices) ids.push_back(VertexIdAt(v.position().data(), D));
  std::vector<std::uint32_t> found;
  const auto& rows = SimplicesOf<D>(mesh);
  for (std::uint32_t i = 0; i < rows.size(); ++i) {
    Row row;
    for (std::size_t k = 0; k <= D; ++k) row[k] = ids[rows[i][k]];
    std::sort(row.begin(), row.end());
    if (wanted.contains(row)) found.push_back(i);
  }
  return found;
}

template <class Rows, class Wanted>
std::size_t CountOwned(const Rows& rows, Wanted wanted) {
  return static_cast<std::size_t>(
      std::count_if(rows.begin(), rows.end(), [&](const auto& row) { return wanted(row.owner); }));
}

bool IsSubfacetOwner(FeatureId owner) { return owner != kNoFeature && owner != kBoxFeature; }

}  // namespace

std::size_t IndexedMesh::subsegment_count() const {
  return CountOwned(edges, [](FeatureId owner) { return owner != kNoFeature; });
}

std::size_t IndexedMesh::subfacet_count() const { return CountOwned(faces, IsSubfacetOwner); }

absl::StatusOr<IndexedMesh> IndexMesh(const Mesh& mesh) {
  if (auto status = mesh_data::CheckColumns(mesh); !status.ok()) return status;
  IndexedMesh indexed;
  indexed.dimension = mesh.dimension;
  absl::StatusOr<NumberOf> number_of = IndexVertices(mesh.vertices, indexed);
  if (!number_of.ok()) return number_of.status();
  indexed.regions = NumberRegions(mesh);
  const absl::Status status = mesh.dimension == 2
                                  ? IndexSimplices<2>(mesh.simplices, *number_of, indexed)
                                  : IndexSimplices<3>(mesh.simplices, *number_of, indexed);
  if (!status.ok()) return status;
  if (auto s = IndexEdges(mesh.subsegments, *number_of, indexed); !s.ok()) return s;
  if (auto s = IndexFaces(mesh.subfacets, *number_of, indexed); !s.ok()) return s;
  return indexed;
}

Mesh ToMesh(const IndexedMesh& indexed) {
  Mesh mesh;
  mesh.dimension = indexed.dimension;
  const auto d = static_cast<std::ptrdiff_t>(indexed.dimension);
  // The next salt per id: linear however often a damaged file repeats a vertex. (Of two positions
  // that truly collide the first takes salt 0; at 10^7 vertices the chance of one such pair is
  // 3e-6.)
  absl::flat_hash_map<VertexId, std::uint64_t> next_salt;
  next_salt.reserve(indexed.vertices.size());
  for (const auto& v : indexed.vertices) {
    const std::array<double, 3> position = v.position();
    const VertexId unsalted = VertexIdAt(position.data(), indexed.dimension);
    VertexId id = unsalted;
    while (!next_salt.emplace(id, 1).second) {
      id = VertexIdAt(position.data(), indexed.dimension, next_salt.find(unsalted)->second++);
    }
    mesh.vertices.ids.push_back(id);
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), position.begin(),
                                     position.begin() + d);
    mesh.vertices.containing_dimensions.push_back(
        static_cast<std::uint8_t>(v.containing_dimension));
    mesh.vertices.owners.push_back(v.owner);
  }
  const std::vector<VertexId>& ids = mesh.vertices.ids;
  if (indexed.dimension == 2) {
    AppendSimplices<2>(indexed, mesh);
  } else {
    AppendSimplices<3>(indexed, mesh);
  }
  SetRegions(indexed.regions, mesh);
  for (const auto& e : indexed.edges) {
    if (e.owner == kNoFeature) continue;
    const auto [a, b] = std::minmax(ids[e.a], ids[e.b]);
    mesh.subsegments.ends.insert(mesh.subsegments.ends.end(), {a, b});
    mesh.subsegments.owners.push_back(e.owner);
  }
  for (const auto& f : indexed.faces) {
    if (!IsSubfacetOwner(f.owner)) continue;
    std::array<VertexId, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = ids[f.corners[k]];
    std::sort(corners.begin(), corners.end());
    mesh.subfacets.corners.insert(mesh.subfacets.corners.end(), corners.begin(), corners.end());
    mesh.subfacets.owners.push_back(f.owner);
  }
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

std::vector<std::uint32_t> FindSimplices(const IndexedMesh& mesh, const SimplexColumn& simplices) {
  return mesh.dimension == 2 ? Find<2>(mesh, simplices) : Find<3>(mesh, simplices);
}

TriangleQuality MeasureTriangle(const IndexedMesh& mesh, std::size_t i) {
  std::array<double, 3> corner[3];
  for (std::size_t k = 0; k < 3; ++k) corner[k] = mesh.vertices[mesh.triangles[i][k]].position();
  return dynmesh::MeasureTriangle(corner[0].data(), corner[1].data(), corner[2].data());
}

TetrahedronQuality MeasureTetrahedron(const IndexedMesh& mesh, std::size_t i) {
  std::array<double, 3> corner[4];
  for (std::size_t k = 0; k < 4; ++k) corner[k] = mesh.vertices[mesh.tetrahedra[i][k]].position();
  return dynmesh::MeasureTetrahedron(corner[0].data(), corner[1].data(), corner[2].data(),
                                     corner[3].data());
}

SimplexMeasures MeasureSimplex(const IndexedMesh& mesh, std::size_t i) {
  const auto brief = [](const auto& q) {
    return SimplexMeasures{q.radius_edge, q.shortest_edge, q.min_angle_deg};
  };
  return mesh.dimension == 2 ? brief(MeasureTriangle(mesh, i)) : brief(MeasureTetrahedron(mesh, i));
}

std::vector<SimplexVerdict> JudgeSimplices(const IndexedMesh& mesh, double rho,
                                           double min_dihedral) {
  MeshOptions options;
  options.dimension = mesh.dimension;
  options.quality = rho;
  options.min_dihedral = min_dihedral;
  return dynmesh::JudgeSimplices(ToMesh(mesh), options);
}

}  // namespace dynmesh::io
