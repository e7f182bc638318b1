// Checks the topology of the tetrahedra, and that they fill their box.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <tuple>

#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Triple = std::array<std::uint32_t, 3>;

struct Bounds {
  std::array<double, 3> lo, hi;
};

Bounds BoundsOf(const io::IndexedMesh& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Bounds b{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (const auto& v : mesh.vertices) {
    const std::array<double, 3> p = v.position();
    for (std::size_t k = 0; k < 3; ++k) {
      b.lo[k] = std::min(b.lo[k], p[k]), b.hi[k] = std::max(b.hi[k], p[k]);
    }
  }
  return b;
}

bool IsOnASide(const Bounds& b, const io::IndexedMesh& mesh, const Triple& v) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto all_at = [&](double c) {
      return std::all_of(v.begin(), v.end(),
                         [&](std::uint32_t i) { return mesh.vertices[i].position()[k] == c; });
    };
    if (all_at(b.lo[k]) || all_at(b.hi[k])) return true;
  }
  return false;
}

// The sum of the signed volumes, divided by the box's volume.
long double VolumeShare(const io::IndexedMesh& mesh, const Bounds& b) {
  // In units of the box, to avoid overflow.
  const auto scaled = [&](std::uint32_t v) {
    const std::array<double, 3> p = mesh.vertices[v].position();
    std::array<Real, 3> q;
    for (std::size_t k = 0; k < 3; ++k) q[k] = (Real{p[k]} - b.lo[k]) / (Real{b.hi[k]} - b.lo[k]);
    return q;
  };
  Real sum = 0;
  for (const auto& t : mesh.tetrahedra) {
    const auto a = scaled(t[0]);
    std::array<Real, 3> e[3];
    for (std::size_t i = 0; i < 3; ++i) {
      const auto p = scaled(t[i + 1]);
      for (std::size_t k = 0; k < 3; ++k) e[i][k] = p[k] - a[k];
    }
    sum += e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
           e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
           e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
  }
  return sum / 6;
}

}  // namespace

std::vector<Face> CollectFaces(const io::IndexedMesh& mesh) {
  // The corners opposite to each, as seen from outside of a positive tetrahedron.
  constexpr std::uint8_t kOpposite[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  std::vector<Face> faces;
  faces.reserve(4 * mesh.tetrahedra.size());
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    for (std::uint8_t k = 0; k < 4; ++k) {
      Face face{{}, t, k, true};
      for (std::size_t i = 0; i < 3; ++i) face.v[i] = mesh.tetrahedra[t][kOpposite[k][i]];
      for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 2), std::pair(0, 1)}) {
        if (face.v[i] <= face.v[j]) continue;
        std::swap(face.v[i], face.v[j]);
        face.even = !face.even;
      }
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& f, const Face& g) {
    return std::tie(f.v, f.tetrahedron, f.k) < std::tie(g.v, g.tetrahedron, g.k);
  });
  return faces;
}

std::vector<MeshEdge> EdgesOf(const io::IndexedMesh& mesh, const std::vector<Face>& faces) {
  std::vector<MeshEdge> edges;
  edges.reserve(3 * faces.size());
  const auto add = [&](const auto& v, bool on_border) {
    for (std::size_t j = 0; j < v.size(); ++j) {
      for (std::size_t k = j + 1; k < v.size(); ++k) {
        edges.push_back({std::min(v[j], v[k]), std::max(v[j], v[k]), on_border});
      }
    }
  };
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    if (count == 1) add(face->v, true);
  });
  for (const auto& t : mesh.tetrahedra) add(t, false);
  std::sort(edges.begin(), edges.end(), [](const MeshEdge& e, const MeshEdge& f) {
    return std::tuple(e.a, e.b, !e.on_border) < std::tuple(f.a, f.b, !f.on_border);
  });
  const auto same = [](const MeshEdge& e, const MeshEdge& f) { return e.a == f.a && e.b == f.b; };
  edges.erase(std::unique(edges.begin(), edges.end(), same), edges.end());
  return edges;
}

VerifyCheck CheckManifold(const io::IndexedMesh& mesh, const std::vector<Face>& faces) {
  Findings findings("manifold");
  for (std::uint32_t t = 0; t < mesh.tetrahedra.size(); ++t) {
    io::IndexedMesh::Tetrahedron v = mesh.tetrahedra[t];
    std::sort(v.begin(), v.end());
    if (std::adjacent_find(v.begin(), v.end()) != v.end()) {
      findings.Add(TetrahedronName(t) + " has a vertex twice");
    }
  }
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    if (count > 2) {
      findings.Add(Concat(FaceName(face->v), " has ", count, " tetrahedra"));
    } else if (count == 2 && face[0].even == face[1].even) {
      findings.Add(Concat(FaceName(face->v), " has ", TetrahedronName(face[0].tetrahedron), " and ",
                          TetrahedronName(face[1].tetrahedron), " on the same side"));
    }
  });
  return findings.Take();
}

VerifyCheck CheckBox(const io::IndexedMesh& mesh, const std::vector<Face>& faces) {
  Findings findings("box");
  const Bounds bounds = BoundsOf(mesh);
  std::uint64_t border = 0;
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    if (count != 1) return;
    ++border;
    if (!IsOnASide(bounds, mesh, face->v)) {
      findings.Add("border " + FaceName(face->v) + " is not on a side of the bounding box");
    }
  });
  if (border == 0) {
    findings.Add("there is no border");
    return findings.Take();
  }
  // If the faces are correct, this is an integer, so rounding does not matter.
  const long double share = VolumeShare(mesh, bounds);
  if (!(std::abs(share - 1) < 1e-9L)) {
    findings.Add(Concat("the volumes sum up to ", static_cast<double>(share),
                        " of that of the bounding box"));
  }
  return findings.Take();
}

VerifyCheck CheckFaces(const io::MeshFiles& files, const std::vector<Face>& faces) {
  Findings findings("faces");
  if (!files.has_faces) {
    findings.Add("there is no .face file");
    return findings.Take();
  }
  std::vector<io::IndexedMesh::Face> listed = files.mesh.faces;
  std::sort(listed.begin(), listed.end(),
            [](const auto& f, const auto& g) { return f.corners < g.corners; });
  std::size_t row = 0;
  const auto check_until = [&](const Triple* end) {
    for (; row < listed.size() && (end == nullptr || listed[row].corners < *end); ++row) {
      const Triple& v = listed[row].corners;
      const bool again = row > 0 && listed[row - 1].corners == v;
      findings.Add(FaceName(v) +
                   (again ? " is listed twice" : " is listed, but no tetrahedron has it"));
    }
  };
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    check_until(&face->v);
    const bool border = count == 1;
    if (row == listed.size() || listed[row].corners != face->v) {
      if (border) findings.Add(FaceName(face->v) + " is on the border and not listed");
      return;
    }
    const FeatureId owner = listed[row++].owner;
    if (owner == kNoFeature && !files.has_input_markers) {
      findings.Add(FaceName(face->v) + " is listed without a marker");
    } else if (owner == kBoxFeature && !border) {
      findings.Add(FaceName(face->v) + " is inside and has the marker -1");
    }
  });
  check_until(nullptr);
  return findings.Take();
}

}  // namespace dynmesh::cli
