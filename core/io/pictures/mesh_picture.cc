#include "core/io/pictures/mesh_picture.h"

#include <algorithm>
#include <span>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"

namespace dynmesh::io {
namespace {

class Cut {
 public:
  Cut(const IndexedMesh& mesh, int axis, double position)
      : mesh_(mesh),
        axis_(static_cast<std::size_t>(axis)),
        across_(AxesAcross(axis)),
        position_(position) {}

  MeshPicture Run() {
    for (std::uint32_t i = 0; i < mesh_.tetrahedra.size(); ++i) AddTetrahedron(i);
    for (const IndexedMesh::Face& f : mesh_.faces) {
      if (f.owner == kNoFeature) continue;
      const Polygon line = Section(f.corners);
      if (line.size == 2) AddLine(line.corners[0], line.corners[1], f.owner);
    }
    // Owned lines first, so that unique() keeps them.
    std::vector<MeshPicture::Line>& lines = picture_.lines;
    std::sort(lines.begin(), lines.end(), [](const auto& e, const auto& f) {
      return std::tuple(e.a, e.b, e.owner == kNoFeature, e.owner) <
             std::tuple(f.a, f.b, f.owner == kNoFeature, f.owner);
    });
    const auto same = [](const auto& e, const auto& f) { return e.a == f.a && e.b == f.b; };
    lines.erase(std::unique(lines.begin(), lines.end(), same), lines.end());
    return std::move(picture_);
  }

 private:
  struct Polygon {
    std::array<std::uint32_t, 4> corners = {0, 0, 0, 0};
    std::uint32_t size = 0;
    // Ignores a corner equal to the one before.
    void Add(std::uint32_t corner) {
      if (size == 0 || (corners[size - 1] != corner && corners[0] != corner)) {
        corners[size++] = corner;
      }
    }
  };

  // The section of a triangle or tetrahedron, in order around.
  Polygon Section(std::span<const std::uint32_t> corners) {
    std::array<std::uint32_t, 4> below, above;
    std::size_t lows = 0, highs = 0;
    for (const std::uint32_t v : corners) {
      if (Height(v) <= position_) {
        below[lows++] = v;
      } else {
        above[highs++] = v;
      }
    }
    Polygon polygon;
    for (std::size_t i = 0; i < lows; ++i) {
      // Back and forth, so that neighbours in the list share a triangle.
      for (std::size_t k = 0; k < highs; ++k) {
        polygon.Add(PointOn(below[i], above[i % 2 == 0 ? k : highs - 1 - k]));
      }
    }
    return polygon;
  }

  void AddTetrahedron(std::uint32_t i) {
    const Polygon polygon = Section(mesh_.tetrahedra[i]);
    if (polygon.size < 3) return;
    picture_.cells.push_back({polygon.corners, polygon.size, i});
    for (std::uint32_t k = 0; k < polygon.size; ++k) {
      AddLine(polygon.corners[k], polygon.corners[(k + 1) % polygon.size], kNoFeature);
    }
  }

  void AddLine(std::uint32_t p, std::uint32_t q, FeatureId owner) {
    const auto [a, b] = std::minmax(p, q);
    picture_.lines.push_back({a, b, owner});
  }

  double Height(std::uint32_t v) const { return mesh_.vertices[v].position()[axis_]; }

  // The section's corner on the edge from `below` to `above`; a vertex in the plane is one corner.
  std::uint32_t PointOn(std::uint32_t below, std::uint32_t above) {
    const double low = Height(below), high = Height(above);
    if (low == position_) above = below;
    const auto number = static_cast<std::uint32_t>(picture_.positions.size());
    const auto [it, is_new] = point_on_.try_emplace(std::pair(below, above), number);
    if (is_new) {
      const std::array<double, 3> p = mesh_.vertices[below].position();
      const std::array<double, 3> q = mesh_.vertices[above].position();
      const double t = above == below ? 0 : (position_ - low) / (high - low);
      MeshPicture::Position& position = picture_.positions.emplace_back();
      for (std::size_t k = 0; k < 2; ++k) {
        position[k] = (1 - t) * p[across_[k]] + t * q[across_[k]];
      }
    }
    return it->second;
  }

  const IndexedMesh& mesh_;
  const std::size_t axis_;
  const std::array<std::size_t, 2> across_;
  const double position_;
  absl::flat_hash_map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> point_on_;
  MeshPicture picture_;
};

}  // namespace

std::array<std::size_t, 2> AxesAcross(int axis) {
  return axis == 0   ? std::array<std::size_t, 2>{1, 2}
         : axis == 1 ? std::array<std::size_t, 2>{0, 2}
                     : std::array<std::size_t, 2>{0, 1};
}

MeshPicture PictureOf(const IndexedMesh& planar) {
  MeshPicture picture;
  picture.positions.reserve(planar.vertices.size());
  for (std::uint32_t i = 0; i < planar.vertices.size(); ++i) {
    const IndexedMesh::Vertex& v = planar.vertices[i];
    picture.positions.push_back({v.x, v.y});
    const bool is_input = v.owner != kBoxFeature && v.owner != kNoFeature;
    if (v.containing_dimension == 0 && is_input) picture.dots.push_back(i);
  }
  picture.cells.reserve(planar.triangles.size());
  for (std::uint32_t i = 0; i < planar.triangles.size(); ++i) {
    const IndexedMesh::Triangle& t = planar.triangles[i];
    picture.cells.push_back({{t[0], t[1], t[2], 0}, 3, i});
  }
  picture.lines = planar.edges;
  return picture;
}

MeshPicture CutThrough(const IndexedMesh& spatial, int axis, double position) {
  return Cut(spatial, axis, position).Run();
}

}  // namespace dynmesh::io
