// Checks how triangles are connected. The only geometry is comparisons of coordinates.
#include <algorithm>
#include <limits>

#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// The corner of the side's triangle at vertex v.
std::size_t CornerAt(const io::IndexedMesh& mesh, const Side& side, std::uint32_t v) {
  const auto& t = mesh.triangles[side.triangle];
  return 3 * std::size_t{side.triangle} + (t[side.k] == v ? side.k : (side.k + 1U) % 3);
}

// The corners reachable from each other across sides at a common vertex must be all corners at that
// vertex.
void CheckFans(const io::IndexedMesh& mesh, const std::vector<Side>& sides, Findings& findings) {
  UnionFind corners(3 * mesh.triangles.size());
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    for (std::size_t i = 1; i < count; ++i) {
      for (const std::uint32_t v : {side->a, side->b}) {
        corners.Unite(CornerAt(mesh, side[0], v), CornerAt(mesh, side[i], v));
      }
    }
  });
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  std::vector<std::size_t> fan_of(mesh.vertices.size(), kNone);
  for (std::size_t c = 0; c < 3 * mesh.triangles.size(); ++c) {
    const std::uint32_t v = mesh.triangles[c / 3][c % 3];
    const std::size_t fan = corners.Find(c);
    if (fan_of[v] == kNone) fan_of[v] = fan;
    if (fan_of[v] != fan) {
      findings.Add(VertexName(v) + " has triangles that do not form one fan");
      fan_of[v] = fan;
    }
  }
}

void CheckConnected(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                    Findings& findings) {
  UnionFind components(mesh.triangles.size());
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    for (std::size_t i = 1; i < count; ++i) components.Unite(side[0].triangle, side[i].triangle);
  });
  std::uint64_t count = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) count += components.Find(t) == t ? 1 : 0;
  if (count != 1) findings.Add(Concat("the triangles form ", count, " pieces, not one"));
}

struct BorderEdge {
  std::uint32_t from;
  std::uint32_t to;
};

// Border edges with the mesh on the left.
std::vector<BorderEdge> CollectBorder(const std::vector<Side>& sides) {
  std::vector<BorderEdge> border;
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    if (count != 1) return;
    border.push_back(side->forward ? BorderEdge{side->a, side->b} : BorderEdge{side->b, side->a});
  });
  return border;
}

struct Rectangle {
  double x0, y0, x1, y1;
};

Rectangle RectangleOf(const io::IndexedMesh& mesh) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Rectangle r{kInfinity, kInfinity, -kInfinity, -kInfinity};
  for (const auto& v : mesh.vertices) {
    r = {std::min(r.x0, v.x), std::min(r.y0, v.y), std::max(r.x1, v.x), std::max(r.y1, v.y)};
  }
  return r;
}

// True if the edge runs counter-clockwise along a side of the rectangle.
bool RunsAlong(const Rectangle& r, const io::IndexedMesh::Vertex& p,
               const io::IndexedMesh::Vertex& q) {
  return (p.y == r.y0 && q.y == r.y0 && p.x < q.x) || (p.x == r.x1 && q.x == r.x1 && p.y < q.y) ||
         (p.y == r.y1 && q.y == r.y1 && p.x > q.x) || (p.x == r.x0 && q.x == r.x0 && p.y > q.y);
}

}  // namespace

VerifyCheck CheckManifold(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                          bool is_whole) {
  Findings findings("manifold");
  std::uint64_t edges = 0;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& v = mesh.triangles[t];
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
      findings.Add(TriangleName(t) + " has a corner twice");
    }
  }
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    ++edges;
    if (count > 2) {
      findings.Add(Concat(EdgeName(side->a, side->b), " has ", count, " triangles"));
    } else if (count == 2 && side[0].forward == side[1].forward) {
      findings.Add(EdgeName(side->a, side->b) + " has two triangles on one side");
    }
  });
  if (!is_whole) return findings.Take();
  CheckFans(mesh, sides, findings);
  CheckConnected(mesh, sides, findings);
  const std::uint64_t v = mesh.vertices.size();
  const std::uint64_t t = mesh.triangles.size();
  if (v + t != edges + 1) {
    findings.Add(Concat("V - E + T is not 1: V = ", v, ", E = ", edges, ", T = ", t));
  }
  return findings.Take();
}

VerifyCheck CheckBox(const io::IndexedMesh& mesh, const std::vector<Side>& sides) {
  Findings findings("box");
  const Rectangle box = RectangleOf(mesh);
  const std::vector<BorderEdge> border = CollectBorder(sides);
  constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
  std::vector<std::uint32_t> next(mesh.vertices.size(), kNone);
  for (const BorderEdge& e : border) {
    if (!RunsAlong(box, mesh.vertices[e.from], mesh.vertices[e.to])) {
      findings.Add("border " + EdgeName(e.from, e.to) + " does not run along the bounding box");
    }
    if (next[e.from] != kNone) {
      findings.Add("the border branches at " + VertexName(e.from));
    }
    next[e.from] = e.to;
  }
  if (border.empty()) {
    findings.Add("there is no border");
    return findings.Take();
  }
  // One loop contains all border edges. Each runs along its side, so the loop goes round once.
  std::size_t steps = 0;
  std::uint32_t at = border.front().from;
  do {
    at = next[at];
    ++steps;
  } while (at != kNone && at != border.front().from && steps <= border.size());
  if (at == kNone || steps != border.size()) findings.Add("the border is not one closed loop");
  return findings.Take();
}

std::vector<MeshEdge> EdgesOf(const std::vector<Side>& sides) {
  std::vector<MeshEdge> edges;
  ForEachEdge(sides, [&](const Side* side, std::size_t count) {
    edges.push_back({side->a, side->b, count == 1});
  });
  return edges;
}

VerifyCheck CheckEdges(const io::MeshFiles& files, const std::vector<MeshEdge>& edges,
                       bool is_whole) {
  Findings findings("edges");
  const io::IndexedMesh& mesh = files.mesh;
  if (!files.has_edges) {
    findings.Add("there is no .edge file");
    return findings.Take();
  }
  std::vector<io::IndexedMesh::Edge> listed = mesh.edges;
  const auto key = [](const io::IndexedMesh::Edge& e) { return std::pair(e.a, e.b); };
  std::sort(listed.begin(), listed.end(),
            [&](const auto& e, const auto& f) { return key(e) < key(f); });
  for (std::size_t i = 1; i < listed.size(); ++i) {
    if (key(listed[i - 1]) == key(listed[i])) {
      findings.Add(EdgeName(listed[i].a, listed[i].b) + " is listed twice");
    }
  }
  listed.erase(std::unique(listed.begin(), listed.end(),
                           [&](const auto& e, const auto& f) { return key(e) == key(f); }),
               listed.end());
  std::vector<bool> on_border(mesh.vertices.size(), false);
  std::size_t row = 0;
  const bool in_space = mesh.dimension == 3;
  const char* const none =
      in_space ? " is listed, but no tetrahedron has it" : " is listed, but no triangle has it";
  for (const auto& [a, b, border] : edges) {
    const std::pair here(a, b);
    for (; row < listed.size() && key(listed[row]) < here; ++row) {
      findings.Add(EdgeName(listed[row].a, listed[row].b) + none);
    }
    if (border) on_border[a] = on_border[b] = true;
    if (row == listed.size() || key(listed[row]) != here) {
      findings.Add(EdgeName(a, b) + " is not listed");
      continue;
    }
    const bool marked = listed[row++].owner == kBoxFeature;
    // In 3D the border is marked on its faces.
    if (border && !marked && !in_space && is_whole) {
      findings.Add(EdgeName(a, b) + " is on the border without the marker -1");
    } else if (marked && !border) {
      findings.Add(EdgeName(a, b) + " is inside and has the marker -1");
    }
  }
  for (; row < listed.size(); ++row) {
    findings.Add(EdgeName(listed[row].a, listed[row].b) + none);
  }
  for (std::uint32_t v = 0; v < mesh.vertices.size() && is_whole; ++v) {
    const bool marked = mesh.vertices[v].owner == kBoxFeature;
    if (on_border[v] != marked) {
      findings.Add(VertexName(v) + (marked ? " is inside and has the marker -1"
                                           : " is on the border without the marker -1"));
    }
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
