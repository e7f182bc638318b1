#include "core/io/meshes/indexed_mesh.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/id_table.h"
#include "core/base/text.h"
#include "core/io/meshes/sort_by_vertex.h"
#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/check_columns.h"

namespace dynmesh::io {

using text::Concat;
using text::Hex;
namespace {

// Of a vertex's order in the header.
int RankOf(int containing_dimension, FeatureId owner) {
  if (owner == kBoxFeature) return 1;
  return containing_dimension == 0 ? 0 : 1 + containing_dimension;
}

// Rows of vertices in the order of the header, those in one place (of an opened part) by id.
class VertexOrder {
 public:
  VertexOrder(const VertexColumns& columns, int dimension)
      : columns_(columns), d_(static_cast<std::size_t>(dimension)) {}

  std::vector<std::uint32_t> Rows() const {
    std::vector<std::vector<std::uint32_t>> by_rank;
    for (std::uint32_t i = 0; i < columns_.size(); ++i) {
      const auto rank =
          static_cast<std::size_t>(RankOf(columns_.containing_dimensions[i], columns_.owners[i]));
      if (rank >= by_rank.size()) by_rank.resize(rank + 1);
      by_rank[rank].push_back(i);
    }
    std::vector<std::uint32_t> order;
    order.reserve(columns_.size());
    for (std::size_t rank = 0; rank < by_rank.size(); ++rank) {
      if (rank == 0) {
        Sort<FeatureId>(by_rank[rank], [this](std::uint32_t row) { return columns_.owners[row]; });
      } else {
        Sort<double>(by_rank[rank], [this](std::uint32_t row) { return At(row)[0]; });
      }
      order.insert(order.end(), by_rank[rank].begin(), by_rank[rank].end());
    }
    return order;
  }

 private:
  const double* At(std::uint32_t row) const { return &columns_.coordinates[d_ * row]; }

  // By the first key, then by position and id. A key is kept beside its row: most comparisons need
  // no more. Keys that are spread evenly are near their place already, after one pass.
  template <class Key, class KeyOf>
  void Sort(std::vector<std::uint32_t>& rows, KeyOf key_of) const {
    struct Item {
      Key key;
      std::uint32_t row;
    };
    if (rows.empty()) return;
    const auto before = [this](const Item& a, const Item& b) {
      if (a.key < b.key) return true;
      if (b.key < a.key) return false;
      const double *const p = At(a.row), *const q = At(b.row);
      for (std::size_t k = 0; k < d_; ++k) {
        if (p[k] < q[k]) return true;
        if (q[k] < p[k]) return false;
      }
      return columns_.ids[a.row] < columns_.ids[b.row];
    };
    std::vector<Item> items;
    items.reserve(rows.size());
    for (const std::uint32_t row : rows) items.push_back({key_of(row), row});
    if (std::ranges::is_sorted(items, before)) return;
    const auto [least, most] = std::ranges::minmax(items, {}, &Item::key);
    const double from = static_cast<double>(least.key);
    const double scale = static_cast<double>(items.size()) / (static_cast<double>(most.key) - from);
    const std::size_t slots = items.size() + 1;
    // Monotone, as each of its operations is.
    const auto slot_of = [&](const Item& item) {
      const double slot = (static_cast<double>(item.key) - from) * scale;
      return slot < static_cast<double>(items.size()) ? static_cast<std::size_t>(slot)
                                                      : items.size();
    };
    if (std::isfinite(scale)) {
      SortByVertex(items, slots, slot_of, before);
    } else {
      std::ranges::sort(items, before);
    }
    for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = items[i].row;
  }

  const VertexColumns& columns_;
  const std::size_t d_;
};

absl::Status UnknownVertex(VertexId id) {
  return absl::InvalidArgumentError(
      Concat("the mesh names vertex ", Hex(id), ", which it does not have"));
}

// The numbers of vertices by id.
absl::StatusOr<IdTable> IndexVertices(const VertexColumns& columns, IndexedMesh& indexed) {
  const std::size_t n = columns.size();
  if (n >= std::numeric_limits<std::uint32_t>::max()) {
    return absl::InvalidArgumentError("the mesh has more vertices than files can number");
  }
  const auto d = static_cast<std::size_t>(indexed.dimension);
  std::vector<std::uint32_t> number_of(n);
  indexed.vertices.reserve(n);
  for (const std::uint32_t row : VertexOrder(columns, indexed.dimension).Rows()) {
    number_of[row] = static_cast<std::uint32_t>(indexed.vertices.size());
    const double* const c = &columns.coordinates[d * row];
    indexed.vertices.push_back(
        {c[0], c[1], columns.containing_dimensions[row], columns.owners[row], d == 3 ? c[2] : 0});
  }
  indexed.has_plain_ids = true;
  for (std::size_t row = 0; row < n && indexed.has_plain_ids; ++row) {
    indexed.has_plain_ids =
        columns.ids[row] == VertexIdAt(&columns.coordinates[d * row], indexed.dimension);
  }
  IdTable table(columns.ids, [&](std::size_t row) { return number_of[row]; });
  if (const auto row = table.repeated()) {
    return absl::InvalidArgumentError(
        Concat("vertex ", Hex(columns.ids[*row]), " stands twice in the mesh"));
  }
  return table;
}

// The numbers of K vertices.
template <std::size_t K>
absl::StatusOr<std::array<std::uint32_t, K>> NumbersOf(const VertexId* ids, const IdTable& table) {
  std::array<std::uint32_t, K> numbers;
  for (std::size_t k = 0; k < K; ++k) {
    numbers[k] = table.Find(ids[k]);
    if (numbers[k] == IdTable::kNone) return UnknownVertex(ids[k]);
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
absl::Status IndexSimplices(const SimplexColumn& simplices, const IdTable& table,
                            IndexedMesh& indexed) {
  constexpr std::size_t kRows = 256;  // looked up together
  auto& rows = SimplicesOf<D>(indexed);
  rows.reserve(simplices.size() / (D + 1));
  std::array<std::uint32_t, kRows*(D + 1)> numbers;
  for (std::span<const VertexId> rest = simplices; !rest.empty();) {
    const auto ids = rest.first(std::min(rest.size(), numbers.size()));
    table.FindAll(ids, std::span(numbers).first(ids.size()));
    for (std::size_t i = 0; i < ids.size(); i += D + 1) {
      IndexedMesh::Simplex<D> corners;
      for (std::size_t k = 0; k <= D; ++k) {
        if (numbers[i + k] == IdTable::kNone) return UnknownVertex(ids[i + k]);
        corners[k] = numbers[i + k];
      }
      rows.push_back(mesh_data::InCanonicalOrder(corners));
    }
    rest = rest.subspan(ids.size());
  }
  SortSimplices(rows, indexed.regions.numbers, indexed.vertices.size());
  return absl::OkStatus();
}

// Rows by their least vertex, in linear time.
template <class Key>
class RowsByVertex {
 public:
  explicit RowsByVertex(std::size_t vertices) : ends_(vertices + 1, 0) {}
  // First all of these, ...
  void Count(std::uint32_t least) { ++ends_[least + std::size_t{1}]; }
  void Reserve() {
    for (std::size_t v = 1; v < ends_.size(); ++v) ends_[v] += ends_[v - 1];
    keys_.resize(ends_.back());
  }
  // ... then the same with their keys.
  void Add(std::uint32_t least, Key key) { keys_[ends_[least]++] = key; }
  // REQUIRES: all are added.
  std::span<const Key> Of(std::size_t least) const {
    const std::size_t begin = least == 0 ? 0 : ends_[least - 1];
    return std::span(keys_).subspan(begin, ends_[least] - begin);
  }

 private:
  std::vector<std::size_t> ends_;  // of the rows; until they are full, where the next key goes
  std::vector<Key> keys_;
};

// Every edge once, with its owner if it is a subsegment.
template <int D>
absl::Status IndexEdges(const SubsegmentColumns& subsegments, const IdTable& table,
                        IndexedMesh& indexed) {
  struct Owned {
    std::array<std::uint32_t, 2> place;
    FeatureId owner;
  };
  std::vector<Owned> owned;
  owned.reserve(subsegments.size());
  for (std::size_t i = 0; i < subsegments.size(); ++i) {
    const auto ends = NumbersOf<2>(&subsegments.ends[2 * i], table);
    if (!ends.ok()) return ends.status();
    const auto [a, b] = std::minmax((*ends)[0], (*ends)[1]);
    owned.push_back({{a, b}, subsegments.owners[i]});
  }
  // Those without an owner last, so that unique() removes the copies without one.
  std::ranges::sort(owned, {}, [](const Owned& e) {
    return std::tuple(e.place, e.owner == kNoFeature, e.owner);
  });
  const auto same = [](const Owned& e, const Owned& f) {
    return e.place == f.place && (f.owner == kNoFeature || e.owner == f.owner);
  };
  owned.erase(std::unique(owned.begin(), owned.end(), same), owned.end());
  const auto& simplices = SimplicesOf<D>(indexed);
  const std::size_t n = indexed.vertices.size();
  // Corner 0 is the least.
  RowsByVertex<std::uint32_t> others(n);
  const auto for_each_other = [&](auto f) {
    for (const auto& s : simplices) {
      for (std::size_t j = 1; j <= D; ++j) {
        for (std::size_t k = j + 1; k <= D; ++k) f(std::min(s[j], s[k]), std::max(s[j], s[k]));
      }
    }
  };
  for_each_other([&](std::uint32_t a, std::uint32_t) { others.Count(a); });
  others.Reserve();
  for_each_other([&](std::uint32_t a, std::uint32_t b) { others.Add(a, b); });
  indexed.edges.reserve((D == 2 ? 3 : 8) * n + owned.size());
  std::vector<std::uint32_t> seen_from(n, ~std::uint32_t{0}), ends;
  auto simplex = simplices.begin();
  auto next = owned.begin();
  for (std::uint32_t a = 0; a < n; ++a) {
    ends.clear();
    const auto see = [&](std::uint32_t b) {
      if (seen_from[b] != a) ends.push_back(b);
      seen_from[b] = a;
    };
    for (; simplex != simplices.end() && (*simplex)[0] == a; ++simplex) {
      for (std::size_t k = 1; k <= D; ++k) see((*simplex)[k]);
    }
    for (const std::uint32_t b : others.Of(a)) see(b);
    for (auto own = next; own != owned.end() && own->place[0] == a; ++own) see(own->place[1]);
    std::ranges::sort(ends);
    for (const std::uint32_t b : ends) {
      const std::array place = {a, b};
      if (next == owned.end() || next->place != place) indexed.edges.push_back({a, b, kNoFeature});
      for (; next != owned.end() && next->place == place; ++next) {
        indexed.edges.push_back({a, b, next->owner});
      }
    }
  }
  return absl::OkStatus();
}

// Adds the triangles with only one tetrahedron, owned by the box.
void AddBorder(IndexedMesh& indexed) {
  // Of a side its two greater corners. Corner 0 is the least, corner 1 that of the others.
  const auto key_of = [](std::uint32_t p, std::uint32_t q) {
    return std::uint64_t{std::min(p, q)} << 32 | std::max(p, q);
  };
  RowsByVertex<std::uint64_t> others(indexed.vertices.size());
  for (const auto& t : indexed.tetrahedra) others.Count(t[1]);
  others.Reserve();
  for (const auto& t : indexed.tetrahedra) others.Add(t[1], key_of(t[2], t[3]));
  std::vector<std::uint64_t> sides;
  auto simplex = indexed.tetrahedra.begin();
  for (std::uint32_t a = 0; a < indexed.vertices.size(); ++a) {
    const auto rest = others.Of(a);
    sides.assign(rest.begin(), rest.end());
    for (; simplex != indexed.tetrahedra.end() && (*simplex)[0] == a; ++simplex) {
      const auto& [least, b, c, d] = *simplex;
      sides.insert(sides.end(), {key_of(b, c), key_of(b, d), key_of(c, d)});
    }
    std::ranges::sort(sides);
    for (std::size_t i = 0; i < sides.size();) {
      const std::size_t first = i;
      while (i < sides.size() && sides[i] == sides[first]) ++i;
      if (i - first != 1) continue;
      const std::uint64_t side = sides[first];
      const std::array corners = {a, static_cast<std::uint32_t>(side >> 32),
                                  static_cast<std::uint32_t>(side)};
      indexed.faces.push_back({corners, kBoxFeature});
    }
  }
}

absl::Status IndexFaces(const SubfacetColumns& subfacets, const IdTable& table,
                        IndexedMesh& indexed) {
  std::vector<IndexedMesh::Face>& faces = indexed.faces;
  if (!indexed.tetrahedra.empty()) AddBorder(indexed);
  for (std::size_t i = 0; i < subfacets.size(); ++i) {
    auto corners = NumbersOf<3>(&subfacets.corners[3 * i], table);
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
  const absl::StatusOr<IdTable> table = IndexVertices(mesh.vertices, indexed);
  if (!table.ok()) return table.status();
  indexed.regions = NumberRegions(mesh);
  const auto index = [&]<int D>() {
    if (auto s = IndexSimplices<D>(mesh.simplices, *table, indexed); !s.ok()) return s;
    return IndexEdges<D>(mesh.subsegments, *table, indexed);
  };
  const absl::Status status =
      mesh.dimension == 2 ? index.template operator()<2>() : index.template operator()<3>();
  if (!status.ok()) return status;
  if (auto s = IndexFaces(mesh.subfacets, *table, indexed); !s.ok()) return s;
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
