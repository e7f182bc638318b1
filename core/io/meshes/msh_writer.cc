#include "core/io/meshes/msh_writer.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/meshes/msh_groups.h"
#include "core/io/meshes/msh_numbers.h"
#include "core/io/meshes/references.h"

namespace dynmesh::io {

using text::Concat;

namespace {

constexpr int kPointElement = 15;
// By order and dimension: line, triangle, tetrahedron.
constexpr int kElementOf[2][4] = {{kPointElement, 1, 2, 4}, {kPointElement, 8, 9, 11}};
// The format's order of midpoints, by the number of corners.
const std::vector<std::pair<std::size_t, std::size_t>> kMidpointsOf[] = {
    {}, {}, {{0, 1}}, {{0, 1}, {1, 2}, {2, 0}}, {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {2, 3}, {1, 3}}};

struct PointEntity {
  int tag = 0;
  std::uint32_t vertex = 0;
  int physical = 0;
};

// An entity of dimension k: of one feature, of the box's border or, if k is the mesh's dimension,
// of one region or of the domain outside all polygons.
struct Entity {
  std::vector<std::uint32_t> elements;
  std::vector<std::uint32_t> inner;  // vertices of this dimension
  std::set<int> border;              // entities of dimension k - 1
};
using Entities = std::map<int, Entity>;  // by tag

// The vertices of an element.
class Corners {
 public:
  template <std::size_t N>
  explicit Corners(const std::array<std::uint32_t, N>& corners) : size_(N) {
    std::copy(corners.begin(), corners.end(), v_.begin());
  }
  const std::uint32_t* begin() const { return v_.data(); }
  const std::uint32_t* end() const { return v_.data() + size_; }
  std::size_t size() const { return size_; }
  // A key: its vertices ascending, except corner `without`.
  std::array<std::uint32_t, 4> Key(std::size_t without = 4) const {
    std::array<std::uint32_t, 4> key;
    key.fill(~std::uint32_t{0});
    for (std::size_t k = 0; k < size_; ++k) {
      if (k != without) key[k] = v_[k];
    }
    std::sort(key.begin(), key.end());
    return key;
  }

 private:
  std::array<std::uint32_t, 4> v_;
  std::size_t size_;
};

class BoundingRange {
 public:
  void Add(const IndexedMesh::Vertex& v) {
    const std::array<double, 3> position = v.position();
    for (std::size_t k = 0; k < 3; ++k) {
      lo_[k] = std::min(lo_[k], position[k]), hi_[k] = std::max(hi_[k], position[k]);
    }
  }
  void Write(MshNumbers& numbers) const {
    for (const double c : lo_) numbers.Real(c);
    for (const double c : hi_) numbers.Real(c);
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double lo_[3] = {kInfinity, kInfinity, kInfinity};
  double hi_[3] = {-kInfinity, -kInfinity, -kInfinity};
};

class MshFile {
 public:
  MshFile(const IndexedMesh& mesh, const References& references, bool binary, FileWriter& out)
      : mesh_(mesh),
        references_(references),
        out_(out),
        numbers_(out, binary),
        groups_(mesh, references),
        point_of_(mesh.vertices.size(), 0) {
    Classify();
  }

  void Write(MshVersion version) {
    const bool is_old = version == MshVersion::k22;
    out_ << "$MeshFormat\n"
         << (is_old ? "2.2" : "4.1") << (numbers_.binary() ? " 1 8\n" : " 0 8\n");
    if (numbers_.binary()) numbers_.Int(1).EndSection();  // tells the order of bytes
    out_ << "$EndMeshFormat\n";
    WritePhysicalNames();
    if (is_old) {
      WriteOldNodes();
      WriteOldElements();
      return;
    }
    WriteEntities();
    WriteNodes();
    WriteElements();
  }

 private:
  // Assigns every vertex, subsegment and face to the entity of least dimension that contains it.
  // The box's border has no points: its vertices are a grid's, and its corners are not input.
  void Classify() {
    int next = references_.box() + 1;
    std::set<int> used;
    const std::vector<std::uint32_t> region_of = RegionsOfVertices();
    for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
      const IndexedMesh::Vertex& v = mesh_.vertices[i];
      const int reference = references_.Find(v.owner);
      const bool on_box = reference == references_.box();
      if (reference == 0 || v.containing_dimension >= top_) {
        entities_[top_][RegionTag(region_of[i])].inner.push_back(i);
      } else if (v.containing_dimension != 0 || on_box) {
        const int dimension = v.containing_dimension == 0 ? top_ - 1 : v.containing_dimension;
        entities_[dimension][reference].inner.push_back(i);
      } else {
        // Only a damaged mesh has two vertices for the same point.
        const int tag = used.insert(reference).second ? reference : next++;
        points_.push_back({tag, i, reference});
        point_of_[i] = tag;
      }
    }
    std::sort(points_.begin(), points_.end(),
              [](const PointEntity& a, const PointEntity& b) { return a.tag < b.tag; });
    ClassifyOwned(mesh_.edges, entities_[1]);
    ClassifyOwned(mesh_.faces, entities_[2]);
    for (std::uint32_t i = 0; i < mesh_.simplex_count(); ++i) {
      entities_[top_][RegionTag(mesh_.regions.Of(i))].elements.push_back(i);
    }
    for (int dimension = 2; dimension <= top_; ++dimension) FindBorders(dimension);
  }

  template <class Rows>
  void ClassifyOwned(const Rows& rows, Entities& entities) {
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
      const int reference = references_.Find(rows[i].owner);
      if (reference != 0) entities[reference].elements.push_back(i);
    }
  }

  static int RegionTag(std::uint32_t region) { return static_cast<int>(region) + 1; }

  Corners CornersOf(int dimension, std::uint32_t i) const {
    if (dimension == 1) return Corners(std::array{mesh_.edges[i].a, mesh_.edges[i].b});
    if (dimension == 3) return Corners(mesh_.tetrahedra[i]);
    return Corners(top_ == 2 ? mesh_.triangles[i] : mesh_.faces[i].corners);
  }

  // The region of a simplex around each vertex. Where these differ, the vertex is on the border of
  // regions.
  std::vector<std::uint32_t> RegionsOfVertices() const {
    std::vector<std::uint32_t> region_of(mesh_.vertices.size(), 0);
    std::size_t i = 0;
    ForEachSimplex(mesh_, [&](const auto& corners) {
      for (const std::uint32_t v : corners) region_of[v] = mesh_.regions.Of(i);
      if (mesh_.order() == 2) {
        for (const auto& [j, k] : kMidpointsOf[corners.size()]) {
          region_of[mesh_.MidpointOf(corners[j], corners[k])] = mesh_.regions.Of(i);
        }
      }
      ++i;
    });
    return region_of;
  }

  // A curve borders a surface that has one of its edges on one side only; likewise surfaces and
  // volumes.
  void FindBorders(int dimension) {
    using Key = std::array<std::uint32_t, 4>;
    absl::flat_hash_map<Key, int> tag_of;
    for (const auto& [tag, entity] : entities_[dimension - 1]) {
      for (const std::uint32_t i : entity.elements) {
        tag_of.emplace(CornersOf(dimension - 1, i).Key(), tag);
      }
    }
    for (auto& [tag, entity] : entities_[dimension]) {
      std::map<Key, int> one_sided;
      for (const std::uint32_t i : entity.elements) {
        const Corners corners = CornersOf(dimension, i);
        for (std::size_t k = 0; k < corners.size(); ++k) {
          const auto below = tag_of.find(corners.Key(k));
          if (below == tag_of.end()) continue;
          if (!one_sided.insert(*below).second) one_sided.erase(below->first);
        }
      }
      for (const auto& [key, below] : one_sided) entity.border.insert(below);
    }
  }

  void WritePhysicalNames() {
    std::array<std::set<int>, 3> features;
    for (const PointEntity& p : points_) features[0].insert(p.physical);
    for (int dimension = 1; dimension < top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) features[dimension].insert(tag);
    }
    std::set<std::uint32_t> regions;
    for (const auto& [tag, entity] : entities_[top_]) {
      regions.insert(static_cast<std::uint32_t>(tag - 1));
    }
    std::vector<std::pair<std::string, std::string>> long_names;
    const auto names = groups_.Names(features, regions, long_names);
    out_ << "$PhysicalNames\n" << names.size() << '\n';
    for (const auto& [key, name] : names) {
      out_ << key.first << ' ' << key.second << " \"" << name << "\"\n";
    }
    out_ << "$EndPhysicalNames\n";
    if (long_names.empty()) return;
    out_ << "$Comments\n";
    for (const auto& [short_name, name] : long_names) out_ << short_name << ": " << name << '\n';
    out_ << "$EndComments\n";
  }

  // "1 GROUP", or "0" for none.
  void WriteGroup(int group) {
    numbers_.Size(group == 0 ? 0 : 1);
    if (group != 0) numbers_.Int(group);
  }

  void WriteEntities() {
    out_ << "$Entities\n";
    numbers_.Size(points_.size());
    for (int dimension = 1; dimension <= 3; ++dimension) {
      numbers_.Size(entities_[dimension].size());
    }
    numbers_.EndLine();
    for (const PointEntity& p : points_) {
      const IndexedMesh::Vertex& v = mesh_.vertices[p.vertex];
      numbers_.Int(p.tag).Real(v.x).Real(v.y).Real(v.z);
      WriteGroup(groups_.Of(p.physical));
      numbers_.EndLine();
    }
    for (int dimension = 1; dimension <= top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) WriteEntity(dimension, tag, entity);
    }
    numbers_.EndSection();
    out_ << "$EndEntities\n";
  }

  void WriteEntity(int dimension, int tag, const Entity& entity) {
    BoundingRange range;
    // Which of 0 and -0 is the least depends on the first value; for curves that is an inner
    // vertex.
    const auto add_inner = [&] {
      for (const std::uint32_t i : entity.inner) range.Add(mesh_.vertices[i]);
    };
    if (dimension == 1) add_inner();
    for (const std::uint32_t i : entity.elements) {
      for (const std::uint32_t v : CornersOf(dimension, i)) range.Add(mesh_.vertices[v]);
    }
    if (dimension != 1) add_inner();
    numbers_.Int(tag);
    range.Write(numbers_);
    WriteGroup(GroupOf(dimension, tag));
    if (dimension == 1) {
      WriteEnds(entity);
    } else {
      numbers_.Size(entity.border.size());
      for (const int below : entity.border) numbers_.Int(below);
    }
    numbers_.EndLine();
  }

  // A chain has a first and a last point; a closed border has none.
  void WriteEnds(const Entity& curve) {
    std::map<int, int> uses;  // of the points at its edges' ends
    for (const std::uint32_t i : curve.elements) {
      for (const std::uint32_t end : {mesh_.edges[i].a, mesh_.edges[i].b}) {
        if (point_of_[end] != 0) ++uses[point_of_[end]];
      }
    }
    std::erase_if(uses, [](const auto& use) { return use.second % 2 == 0; });
    if (uses.size() == 2) {
      numbers_.Size(2).Int(uses.begin()->first).Int(-uses.rbegin()->first);
    } else {
      numbers_.Size(0);
    }
  }

  void WriteNodes() {
    std::size_t blocks = points_.size();
    for (const Entities& entities : entities_) {
      for (const auto& [tag, entity] : entities) blocks += entity.inner.empty() ? 0 : 1;
    }
    const std::size_t n = mesh_.vertices.size();
    out_ << "$Nodes\n";
    numbers_.Size(blocks).Size(n).Size(n == 0 ? 0 : 1).Size(n).EndLine();
    for (const PointEntity& p : points_) WriteNodeBlock(0, p.tag, {p.vertex});
    for (int dimension = 1; dimension <= top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) {
        WriteNodeBlock(dimension, tag, entity.inner);
      }
    }
    numbers_.EndSection();
    out_ << "$EndNodes\n";
  }

  void WriteNodeBlock(int dimension, int tag, const std::vector<std::uint32_t>& vertices) {
    if (vertices.empty()) return;
    numbers_.Int(dimension).Int(tag).Int(0).Size(vertices.size()).EndLine();
    for (const std::uint32_t i : vertices) numbers_.Size(std::uint64_t{i} + 1).EndLine();
    for (const std::uint32_t i : vertices) {
      const IndexedMesh::Vertex& v = mesh_.vertices[i];
      numbers_.Real(v.x).Real(v.y).Real(v.z).EndLine();
    }
  }

  // As Gmsh saves a mesh that has groups: elements without a group are left out.
  bool IsSaved(int dimension, int reference) const {
    return dimension == top_ || groups_.Of(reference) != 0;
  }

  int GroupOf(int dimension, int tag) const {
    return dimension == top_ ? groups_.OfRegion(static_cast<std::uint32_t>(tag - 1))
                             : groups_.Of(tag);
  }

  // Those that are saved: blocks of one entity, and elements.
  std::pair<std::size_t, std::size_t> CountElements() const {
    std::size_t blocks = static_cast<std::size_t>(
        std::count_if(points_.begin(), points_.end(),
                      [this](const PointEntity& p) { return IsSaved(0, p.physical); }));
    std::size_t count = blocks;
    for (int dimension = 1; dimension <= top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) {
        if (entity.elements.empty() || !IsSaved(dimension, tag)) continue;
        ++blocks;
        count += entity.elements.size();
      }
    }
    return {blocks, count};
  }

  void WriteElements() {
    const auto [blocks, count] = CountElements();
    out_ << "$Elements\n";
    numbers_.Size(blocks).Size(count).Size(count == 0 ? 0 : 1).Size(count).EndLine();
    for (const PointEntity& p : points_) {
      if (!IsSaved(0, p.physical)) continue;
      numbers_.Int(0).Int(p.tag).Int(kPointElement).Size(1).EndLine();
      WriteElement(Corners(std::array{p.vertex}));
    }
    for (int dimension = 1; dimension <= top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) {
        if (entity.elements.empty() || !IsSaved(dimension, tag)) continue;
        numbers_.Int(dimension).Int(tag).Int(kElementOf[mesh_.order() - 1][dimension]);
        numbers_.Size(entity.elements.size()).EndLine();
        for (const std::uint32_t i : entity.elements) WriteElement(CornersOf(dimension, i));
      }
    }
    numbers_.EndSection();
    out_ << "$EndElements\n";
  }

  // ---- version 2.2

  void WriteOldNodes() {
    out_ << "$Nodes\n" << mesh_.vertices.size() << '\n';
    for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
      const IndexedMesh::Vertex& v = mesh_.vertices[i];
      numbers_.Int(OldTag(std::uint64_t{i} + 1)).Real(v.x).Real(v.y).Real(v.z).EndLine();
    }
    numbers_.EndSection();
    out_ << "$EndNodes\n";
  }

  void WriteOldElements() {
    const auto [blocks, count] = CountElements();
    out_ << "$Elements\n" << count << '\n';
    // As bytes, elements of one type and their number of tags stand behind each other.
    const auto begin = [&](int type, std::size_t of_type) {
      if (numbers_.binary()) numbers_.Int(type).Int(OldTag(of_type)).Int(2);
    };
    const auto write = [&](int type, int group, int entity, const Corners& corners) {
      numbers_.Int(OldTag(++element_));
      if (!numbers_.binary()) numbers_.Int(type).Int(2);
      numbers_.Int(group).Int(entity);
      WriteNodesOf(corners, [&](std::uint64_t node) { numbers_.Int(OldTag(node)); });
    };
    for (const PointEntity& p : points_) {
      if (!IsSaved(0, p.physical)) continue;
      begin(kPointElement, 1);
      write(kPointElement, groups_.Of(p.physical), p.tag, Corners(std::array{p.vertex}));
    }
    for (int dimension = 1; dimension <= top_; ++dimension) {
      for (const auto& [tag, entity] : entities_[dimension]) {
        if (entity.elements.empty() || !IsSaved(dimension, tag)) continue;
        const int type = kElementOf[mesh_.order() - 1][dimension];
        begin(type, entity.elements.size());
        for (const std::uint32_t i : entity.elements) {
          write(type, GroupOf(dimension, tag), tag, CornersOf(dimension, i));
        }
      }
    }
    numbers_.EndSection();
    out_ << "$EndElements\n";
  }

  // ----

  void WriteElement(const Corners& corners) {
    numbers_.Size(++element_);
    WriteNodesOf(corners, [&](std::uint64_t node) { numbers_.Size(node); });
  }

  // Corners, then the nodes in the middles; and ends the line.
  template <class Write>
  void WriteNodesOf(const Corners& corners, const Write& write) {
    for (const std::uint32_t corner : corners) write(std::uint64_t{corner} + 1);
    if (mesh_.order() == 2) {
      for (const auto& [j, k] : kMidpointsOf[corners.size()]) {
        write(std::uint64_t{mesh_.MidpointOf(corners.begin()[j], corners.begin()[k])} + 1);
      }
    }
    numbers_.EndLine();
  }

  // Tags of version 2.2 are ints: WriteMsh has checked that these do.
  static std::int32_t OldTag(std::uint64_t tag) { return static_cast<std::int32_t>(tag); }

  const IndexedMesh& mesh_;
  const References& references_;
  FileWriter& out_;
  MshNumbers numbers_;
  const MshGroups groups_;
  const int top_ = mesh_.dimension;
  std::vector<PointEntity> points_;  // by tag
  std::vector<int> point_of_;        // the point of each vertex, 0 if none
  // By dimension from 1. Tags are the owner's reference; of the mesh's dimension 1 + the region's
  // number.
  std::array<Entities, 4> entities_;
  std::uint64_t element_ = 0;  // the last one's tag
};

}  // namespace

absl::Status WriteMsh(const IndexedMesh& mesh, const std::string& path, MshVersion version,
                      bool binary) {
  constexpr std::size_t kMostOldRows = std::numeric_limits<std::int32_t>::max();
  if (version == MshVersion::k22 &&
      mesh.vertices.size() + mesh.edges.size() + mesh.faces.size() + mesh.simplex_count() >
          kMostOldRows) {
    return absl::InvalidArgumentError(
        Concat(path, ": version 2.2 of a .msh has at most ", kMostOldRows, " elements; take 4.1"));
  }
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  FileWriter out(path);
  MshFile(mesh, *references, binary, out).Write(version);
  return out.Close();
}

absl::StatusOr<MshVersion> MshVersionOf(double version, std::string_view name) {
  if (version == 4.1) return MshVersion::k41;
  if (version == 2.2) return MshVersion::k22;
  return absl::InvalidArgumentError(Concat(name, " is 4.1 or 2.2, found ", version));
}

}  // namespace dynmesh::io
