#include "core/io/meshes/mesh_companions.h"

#include <algorithm>
#include <array>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/circumball.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::io {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Sides of simplices in the order of their first simplices.
template <int D>
struct Sides {
  struct Side {
    std::array<std::uint32_t, D> corners;
    std::uint32_t opposite;  // the corner of the first simplex that is not on it
    std::array<std::uint32_t, 2> simplices = {kNone, kNone};
  };
  std::vector<Side> sides;
  std::vector<std::array<std::uint32_t, D + 1>> of;  // of each simplex, opposite to its corners

  explicit Sides(const IndexedMesh& mesh) {
    absl::flat_hash_map<std::array<std::uint32_t, D>, std::uint32_t> index;
    const auto& simplices = SimplicesOf<D>(mesh);
    for (std::uint32_t i = 0; i < simplices.size(); ++i) {
      auto& row = of.emplace_back();
      for (std::size_t k = 0; k <= D; ++k) {
        std::array<std::uint32_t, D> corners;
        std::size_t count = 0;
        for (std::size_t j = 0; j <= D; ++j) {
          if (j != k) corners[count++] = simplices[i][j];
        }
        std::sort(corners.begin(), corners.end());
        const auto [it, is_new] = index.emplace(corners, static_cast<std::uint32_t>(sides.size()));
        if (is_new) sides.push_back({corners, simplices[i][k]});
        auto& both = sides[it->second].simplices;
        (both[0] == kNone ? both[0] : both[1]) = i;
        row[k] = it->second;
      }
    }
  }
};

template <int D>
void WriteNeighboursOf(const IndexedMesh& mesh, std::uint64_t base, FileWriter& out) {
  const Sides<D> sides(mesh);
  out << sides.of.size() << ' ' << D + 1 << '\n';
  for (std::uint32_t i = 0; i < sides.of.size(); ++i) {
    out << i + base;
    for (const std::uint32_t side : sides.of[i]) {
      const auto& both = sides.sides[side].simplices;
      const std::uint32_t other = both[0] == i ? both[1] : both[0];
      if (other == kNone) {
        out << " -1";
      } else {
        out << ' ' << other + base;
      }
    }
    out << '\n';
  }
}

using geometry::Point3;
using Vec = geometry::Vector3;

Vec Circumcentre(const std::array<Vec, 3>& c) {
  const Vec u = geometry::Difference(c[1], c[0]), v = geometry::Difference(c[2], c[0]);
  const double twice = 2 * (u[0] * v[1] - u[1] * v[0]);
  const double uu = geometry::Dot(u, u), vv = geometry::Dot(v, v);
  return {c[0][0] + (v[1] * uu - u[1] * vv) / twice, c[0][1] + (u[0] * vv - v[0] * uu) / twice, 0};
}

// Right even for slivers. A flat tetrahedron has no centre: its first corner stands for it.
Vec Circumcentre(const std::array<Vec, 4>& c) {
  const std::array<Point3, 4> p = {Point3{c[0]}, Point3{c[1]}, Point3{c[2]}, Point3{c[3]}};
  if (geometry::Orientation(p[0], p[1], p[2], p[3]) <= 0) return c[0];
  const Vec w = geometry::CircumballOf(p[0], p[1], p[2], p[3]).w;
  return {c[0][0] + w[0], c[0][1] + w[1], c[0][2] + w[2]};
}

// The normal of a side, away from `inside`.
Vec Outwards(const std::array<Vec, 2>& side, const Vec& inside) {
  const Vec e = geometry::Difference(side[1], side[0]);
  const Vec n = {e[1], -e[0], 0};
  return geometry::Dot(n, geometry::Difference(inside, side[0])) < 0 ? n : Vec{-n[0], -n[1], 0};
}
Vec Outwards(const std::array<Vec, 3>& side, const Vec& inside) {
  const Vec n = geometry::Cross(geometry::Difference(side[1], side[0]),
                                geometry::Difference(side[2], side[0]));
  return geometry::Dot(n, geometry::Difference(inside, side[0])) < 0 ? n : Vec{-n[0], -n[1], -n[2]};
}

template <int D>
void WriteVoronoiOf(const IndexedMesh& mesh, std::uint64_t base, FileWriter& nodes,
                    FileWriter& edges) {
  const auto write = [](const Vec& v, FileWriter& out) {
    for (std::size_t k = 0; k < D; ++k) out << ' ' << v[k];
    out << '\n';
  };
  const auto& simplices = SimplicesOf<D>(mesh);
  nodes << simplices.size() << ' ' << D << " 0 0\n";
  for (std::size_t i = 0; i < simplices.size(); ++i) {
    std::array<Vec, D + 1> corners;
    for (std::size_t k = 0; k <= D; ++k) corners[k] = mesh.vertices[simplices[i][k]].position();
    nodes << i + base;
    write(Circumcentre(corners), nodes);
  }
  const Sides<D> all(mesh);
  edges << all.sides.size() << " 0\n";
  for (std::size_t i = 0; i < all.sides.size(); ++i) {
    const auto& side = all.sides[i];
    edges << i + base << ' ' << side.simplices[0] + base << ' ';
    if (side.simplices[1] != kNone) {
      edges << side.simplices[1] + base << '\n';
      continue;
    }
    std::array<Vec, D> corners;
    for (std::size_t k = 0; k < D; ++k) corners[k] = mesh.vertices[side.corners[k]].position();
    edges << -1;
    write(Outwards(corners, mesh.vertices[side.opposite].position()), edges);
  }
}

void WriteHoles(const MeshFileOptions& options, int dimension, FileWriter& out) {
  out << options.holes.size() << '\n';
  for (std::size_t i = 0; i < options.holes.size(); ++i) {
    out << i + options.base();
    for (int k = 0; k < dimension; ++k) {
      out << ' ' << options.holes[i].position[static_cast<std::size_t>(k)];
    }
    out << '\n';
  }
}

// Is the row a segment or facet: of a feature, or with a marker of the input?
bool IsConstraint(const IndexedMesh& mesh, FeatureId owner, const std::vector<std::int64_t>& labels,
                  std::size_t i) {
  return owner != kNoFeature || (mesh.labels.replace_ids && labels[i] != 0);
}

}  // namespace

void WriteNeighbours(const IndexedMesh& mesh, std::uint64_t base, FileWriter& out) {
  mesh.dimension == 2 ? WriteNeighboursOf<2>(mesh, base, out)
                      : WriteNeighboursOf<3>(mesh, base, out);
}

void WriteVoronoi(const IndexedMesh& mesh, std::uint64_t base, FileWriter& nodes,
                  FileWriter& edges) {
  mesh.dimension == 2 ? WriteVoronoiOf<2>(mesh, base, nodes, edges)
                      : WriteVoronoiOf<3>(mesh, base, nodes, edges);
}

void WriteConstraints(const IndexedMesh& mesh, const MeshFileOptions& options,
                      const std::string& extension, FileWriter& out) {
  const std::uint64_t base = options.base();
  out << "0 " << mesh.dimension << " 0 1\n";
  std::vector<std::size_t> rows;
  if (mesh.dimension == 2) {
    for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
      if (IsConstraint(mesh, mesh.edges[i].owner, mesh.labels.edge_markers, i)) rows.push_back(i);
    }
    out << rows.size() << " 1\n";
    for (std::size_t n = 0; n < rows.size(); ++n) {
      const IndexedMesh::Edge& e = mesh.edges[rows[n]];
      out << n + base << ' ' << e.a + base << ' ' << e.b + base << ' ';
      WriteRowMarker(mesh, mesh.labels.edge_markers, rows[n], e.owner, out);
      out << '\n';
    }
  } else {
    for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
      if (IsConstraint(mesh, mesh.faces[i].owner, mesh.labels.face_markers, i)) rows.push_back(i);
    }
    const bool is_poly = extension == ".poly";
    out << rows.size() << " 1\n";
    for (const std::size_t i : rows) {
      if (is_poly) {
        out << "1 0 ";
        WriteRowMarker(mesh, mesh.labels.face_markers, i, mesh.faces[i].owner, out);
        out << '\n';
      }
      out << 3;
      for (const std::uint32_t v : mesh.faces[i].corners) out << ' ' << v + base;
      if (!is_poly) {
        out << ' ';
        WriteRowMarker(mesh, mesh.labels.face_markers, i, mesh.faces[i].owner, out);
      }
      out << '\n';
    }
  }
  WriteHoles(options, mesh.dimension, out);
  if (mesh.dimension == 3) out << "0\n";  // regions
}

}  // namespace dynmesh::io
