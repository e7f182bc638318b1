#include "core/io/msh_writer.h"

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/io/file_writer.h"
#include "core/io/references.h"

namespace dynmesh::io {
namespace {

constexpr int kLineElement = 1;
constexpr int kTriangleElement = 2;
constexpr int kPointElement = 15;

struct PointEntity {
  int tag = 0;
  std::uint32_t vertex = 0;
  int physical = 0;
};

// One feature's chain of edges, or the box's border.
struct CurveEntity {
  std::vector<std::uint32_t> edges;
  std::vector<std::uint32_t> inner;  // vertices that are no points
};

// One region, or what lies in no polygon.
struct SurfaceEntity {
  std::vector<std::uint32_t> triangles;
  std::vector<std::uint32_t> inner;  // free vertices
  std::set<int> border;              // curves
};

class BoundingRange {
 public:
  void Add(const IndexedMesh::Vertex& v) {
    lo_[0] = std::min(lo_[0], v.x), lo_[1] = std::min(lo_[1], v.y);
    hi_[0] = std::max(hi_[0], v.x), hi_[1] = std::max(hi_[1], v.y);
  }
  void Write(FileWriter& out) const {
    out << lo_[0] << ' ' << lo_[1] << " 0 " << hi_[0] << ' ' << hi_[1] << " 0 ";
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();
  double lo_[2] = {kInfinity, kInfinity};
  double hi_[2] = {-kInfinity, -kInfinity};
};

class MshFile {
 public:
  MshFile(const IndexedMesh& mesh, const References& references, FileWriter& out)
      : mesh_(mesh), references_(references), out_(out), point_of_(mesh.vertices.size(), 0) {
    Classify();
  }

  void Write() {
    out_ << "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    WritePhysicalNames();
    WriteEntities();
    WriteNodes();
    WriteElements();
  }

 private:
  // Puts every vertex and subsegment on the entity of the least dimension that it is part of.
  // The box's border has no points: it is a grid's, and its corners are nobody's input.
  void Classify() {
    int next = references_.box() + 1;
    std::set<int> used;
    const std::vector<std::uint32_t> region_of = RegionsOfVertices();
    for (std::uint32_t i = 0; i < mesh_.vertices.size(); ++i) {
      const IndexedMesh::Vertex& v = mesh_.vertices[i];
      const int reference = references_.Find(v.owner);
      if (reference == 0 || v.containing_dimension > 1) {
        surfaces_[SurfaceTag(region_of[i])].inner.push_back(i);
      } else if (v.containing_dimension == 1 || reference == references_.box()) {
        curves_[reference].inner.push_back(i);
      } else {
        // Only a damaged mesh has a second vertex for the same point.
        const int tag = used.insert(reference).second ? reference : next++;
        points_.push_back({tag, i, reference});
        point_of_[i] = tag;
      }
    }
    std::sort(points_.begin(), points_.end(),
              [](const PointEntity& a, const PointEntity& b) { return a.tag < b.tag; });
    for (std::uint32_t i = 0; i < mesh_.edges.size(); ++i) {
      const int reference = references_.Find(mesh_.edges[i].owner);
      if (reference != 0) curves_[reference].edges.push_back(i);
    }
    for (std::uint32_t i = 0; i < mesh_.triangles.size(); ++i) {
      surfaces_[SurfaceTag(mesh_.regions.Of(i))].triangles.push_back(i);
    }
    FindBorders();
  }

  static int SurfaceTag(std::uint32_t region) { return static_cast<int>(region) + 1; }

  // That of a triangle around it. Where these differ, the vertex is on a curve.
  std::vector<std::uint32_t> RegionsOfVertices() const {
    std::vector<std::uint32_t> region_of(mesh_.vertices.size(), 0);
    for (std::size_t i = 0; i < mesh_.triangles.size(); ++i) {
      for (const std::uint32_t v : mesh_.triangles[i]) region_of[v] = mesh_.regions.Of(i);
    }
    return region_of;
  }

  // A curve borders a surface that has one of its edges on one side only.
  void FindBorders() {
    absl::flat_hash_map<std::pair<std::uint32_t, std::uint32_t>, int> curve_of;
    for (const auto& [tag, curve] : curves_) {
      for (const std::uint32_t i : curve.edges) {
        curve_of.emplace(std::minmax(mesh_.edges[i].a, mesh_.edges[i].b), tag);
      }
    }
    for (auto& [tag, surface] : surfaces_) {
      std::map<std::pair<std::uint32_t, std::uint32_t>, int> one_sided;
      for (const std::uint32_t i : surface.triangles) {
        const IndexedMesh::Triangle& t = mesh_.triangles[i];
        for (std::size_t k = 0; k < 3; ++k) {
          const auto curve = curve_of.find(std::minmax(t[k], t[(k + 1) % 3]));
          if (curve == curve_of.end()) continue;
          if (!one_sided.insert(*curve).second) one_sided.erase(curve->first);
        }
      }
      for (const auto& [edge, curve] : one_sided) surface.border.insert(curve);
    }
  }

  void WritePhysicalNames() {
    std::set<std::pair<int, int>> groups;  // dimension, tag
    for (const PointEntity& p : points_) groups.emplace(0, p.physical);
    for (const auto& [tag, curve] : curves_) groups.emplace(1, tag);
    out_ << "$PhysicalNames\n" << groups.size() + surfaces_.size() << '\n';
    for (const auto& [dimension, tag] : groups) {
      out_ << dimension << ' ' << tag << " \"" << references_.Name(tag) << "\"\n";
    }
    for (const auto& [tag, surface] : surfaces_) {
      const std::string name = mesh_.regions.Name(static_cast<std::uint32_t>(tag - 1));
      out_ << "2 " << tag << " \"" << name << "\"\n";
    }
    out_ << "$EndPhysicalNames\n";
  }

  void WriteEntities() {
    out_ << "$Entities\n"
         << points_.size() << ' ' << curves_.size() << ' ' << surfaces_.size() << " 0\n";
    for (const PointEntity& p : points_) {
      const IndexedMesh::Vertex& v = mesh_.vertices[p.vertex];
      out_ << p.tag << ' ' << v.x << ' ' << v.y << " 0 1 " << p.physical << '\n';
    }
    for (const auto& [tag, curve] : curves_) WriteCurve(tag, curve);
    for (const auto& [tag, surface] : surfaces_) WriteSurface(tag, surface);
    out_ << "$EndEntities\n";
  }

  void WriteCurve(int tag, const CurveEntity& curve) {
    BoundingRange range;
    std::map<int, int> uses;  // of the points at its edges' ends
    for (const std::uint32_t i : curve.inner) range.Add(mesh_.vertices[i]);
    for (const std::uint32_t i : curve.edges) {
      for (const std::uint32_t end : {mesh_.edges[i].a, mesh_.edges[i].b}) {
        range.Add(mesh_.vertices[end]);
        if (point_of_[end] != 0) ++uses[point_of_[end]];
      }
    }
    out_ << tag << ' ';
    range.Write(out_);
    out_ << "1 " << tag << ' ';
    std::erase_if(uses, [](const auto& use) { return use.second % 2 == 0; });
    // A chain has a first and a last point; a border, run round, has none.
    if (uses.size() == 2) {
      out_ << "2 " << uses.begin()->first << ' ' << -uses.rbegin()->first << '\n';
    } else {
      out_ << "0\n";
    }
  }

  void WriteSurface(int tag, const SurfaceEntity& surface) {
    BoundingRange range;
    for (const std::uint32_t i : surface.triangles) {
      for (const std::uint32_t v : mesh_.triangles[i]) range.Add(mesh_.vertices[v]);
    }
    for (const std::uint32_t i : surface.inner) range.Add(mesh_.vertices[i]);
    out_ << tag << ' ';
    range.Write(out_);
    out_ << "1 " << tag << ' ' << surface.border.size();
    for (const int curve : surface.border) out_ << ' ' << curve;
    out_ << '\n';
  }

  void WriteNodes() {
    std::size_t blocks = points_.size();
    for (const auto& [tag, curve] : curves_) blocks += curve.inner.empty() ? 0 : 1;
    for (const auto& [tag, surface] : surfaces_) blocks += surface.inner.empty() ? 0 : 1;
    const std::size_t n = mesh_.vertices.size();
    out_ << "$Nodes\n" << blocks << ' ' << n << ' ' << (n == 0 ? 0 : 1) << ' ' << n << '\n';
    for (const PointEntity& p : points_) WriteNodeBlock(0, p.tag, {p.vertex});
    for (const auto& [tag, curve] : curves_) WriteNodeBlock(1, tag, curve.inner);
    for (const auto& [tag, surface] : surfaces_) WriteNodeBlock(2, tag, surface.inner);
    out_ << "$EndNodes\n";
  }

  void WriteNodeBlock(int dimension, int tag, const std::vector<std::uint32_t>& vertices) {
    if (vertices.empty()) return;
    out_ << dimension << ' ' << tag << " 0 " << vertices.size() << '\n';
    for (const std::uint32_t i : vertices) out_ << std::uint64_t{i} + 1 << '\n';
    for (const std::uint32_t i : vertices) {
      out_ << mesh_.vertices[i].x << ' ' << mesh_.vertices[i].y << " 0\n";
    }
  }

  void WriteElements() {
    std::size_t blocks = points_.size();
    std::size_t elements = points_.size() + mesh_.triangles.size();
    for (const auto& [tag, curve] : curves_) {
      blocks += curve.edges.empty() ? 0 : 1;
      elements += curve.edges.size();
    }
    for (const auto& [tag, surface] : surfaces_) blocks += surface.triangles.empty() ? 0 : 1;
    out_ << "$Elements\n"
         << blocks << ' ' << elements << ' ' << (elements == 0 ? 0 : 1) << ' ' << elements << '\n';
    for (const PointEntity& p : points_) {
      out_ << "0 " << p.tag << ' ' << kPointElement << " 1\n";
      WriteElement({p.vertex});
    }
    for (const auto& [tag, curve] : curves_) {
      if (curve.edges.empty()) continue;
      out_ << "1 " << tag << ' ' << kLineElement << ' ' << curve.edges.size() << '\n';
      for (const std::uint32_t i : curve.edges) WriteElement({mesh_.edges[i].a, mesh_.edges[i].b});
    }
    for (const auto& [tag, surface] : surfaces_) {
      if (surface.triangles.empty()) continue;
      out_ << "2 " << tag << ' ' << kTriangleElement << ' ' << surface.triangles.size() << '\n';
      for (const std::uint32_t i : surface.triangles) {
        const IndexedMesh::Triangle& t = mesh_.triangles[i];
        WriteElement({t[0], t[1], t[2]});
      }
    }
    out_ << "$EndElements\n";
  }

  void WriteElement(std::initializer_list<std::uint32_t> corners) {
    out_ << ++element_;
    for (const std::uint32_t corner : corners) out_ << ' ' << std::uint64_t{corner} + 1;
    out_ << '\n';
  }

  const IndexedMesh& mesh_;
  const References& references_;
  FileWriter& out_;
  std::vector<PointEntity> points_;        // by tag
  std::vector<int> point_of_;              // the point that a vertex is, 0 if none
  std::map<int, CurveEntity> curves_;      // by tag, which is the owner's reference
  std::map<int, SurfaceEntity> surfaces_;  // by tag: 1 + the region's number
  std::uint64_t element_ = 0;              // the last one's tag
};

}  // namespace

absl::Status WriteMsh(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  FileWriter out(path);
  MshFile(mesh, *references, out).Write();
  return out.Close();
}

}  // namespace dynmesh::io
