#include "core/io/solvers/adcirc_writer.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "absl/strings/match.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/solvers/edge_chains.h"
#include "core/io/solvers/named_facets.h"

namespace dynmesh::io {
namespace {

constexpr int kMainland = 0, kIsland = 1;

struct Boundary {
  int type = kMainland;
  Chain vertices;
};
struct Boundaries {
  std::vector<Boundary> open, land;
};

bool IsOpen(const std::string& name) {
  return absl::StartsWithIgnoreCase(name, "open") || absl::StartsWithIgnoreCase(name, "ocean");
}

// Twice the signed area inside a closed chain.
double AreaOf(const IndexedMesh& mesh, const Chain& chain) {
  double area = 0;
  const IndexedMesh::Vertex& origin = mesh.vertices[chain[0]];
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const IndexedMesh::Vertex& a = mesh.vertices[chain[i]];
    const IndexedMesh::Vertex& b = mesh.vertices[chain[i + 1]];
    area += (a.x - origin.x) * (b.y - origin.y) - (b.x - origin.x) * (a.y - origin.y);
  }
  return area;
}

using OpenEdges = absl::flat_hash_map<DirectedEdge, std::size_t>;  // with the number of their set

// A closed chain as its open parts, a part a set, and the rest.
void Split(Chain loop, bool is_outer, const OpenEdges& open, Boundaries& boundaries) {
  constexpr std::size_t kLand = ~std::size_t{0};
  const auto set_of = [&](std::size_t i) {
    const auto it = open.find({loop[i], loop[i + 1]});
    return it == open.end() ? kLand : it->second;
  };
  const std::size_t edges = loop.size() - 1;
  std::size_t change = 0;
  while (change < edges && set_of(change) == set_of((change + edges - 1) % edges)) ++change;
  if (change == edges) {
    const bool is_land = set_of(0) == kLand;
    const int type = is_land && !is_outer ? kIsland : kMainland;
    // Only along a mainland the way back to the first vertex has to be listed.
    if (!is_land || !is_outer) loop.pop_back();
    (is_land ? boundaries.land : boundaries.open).push_back({type, std::move(loop)});
    return;
  }
  loop.pop_back();
  std::rotate(loop.begin(), loop.begin() + static_cast<std::ptrdiff_t>(change), loop.end());
  loop.push_back(loop[0]);
  for (std::size_t i = 0; i < edges;) {
    Chain part = {loop[i]};
    const std::size_t set = set_of(i);
    for (; i < edges && set_of(i) == set; ++i) part.push_back(loop[i + 1]);
    (set == kLand ? boundaries.land : boundaries.open).push_back({kMainland, std::move(part)});
  }
}

// What is to be open must be on the border.
absl::Status CheckOpen(const IndexedMesh& mesh, const Boundaries& boundaries) {
  if (!boundaries.open.empty() || mesh.labels.features == nullptr) return absl::OkStatus();
  for (const auto& [id, name] : mesh.labels.features->names) {
    if (!IsOpen(name)) continue;
    return absl::InvalidArgumentError(
        text::Concat("no edge of the border lies on feature ", id, ", ", name,
                     ", which its name makes an open boundary: write the inside alone"));
  }
  return absl::OkStatus();
}

absl::StatusOr<Boundaries> BoundariesOf(const IndexedMesh& mesh, const NamedParts& parts) {
  std::vector<DirectedEdge> border;
  OpenEdges open;
  for (std::size_t k = 0; k < parts.facets.size(); ++k) {
    FacetSet set = parts.facets[k];
    std::erase_if(set.facets, [](const NamedFacet& facet) { return !facet.is_border; });
    for (const DirectedEdge& edge : EdgesOf(mesh, set)) {
      border.push_back(edge);
      if (IsOpen(set.name)) open.emplace(edge, k);
    }
  }
  std::ranges::sort(border);
  Boundaries boundaries;
  absl::flat_hash_set<std::uint32_t> seen;
  for (Chain& chain : ChainsOf(border)) {
    // Chains end where the border touches itself.
    for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
      if (seen.insert(chain[i]).second) continue;
      const IndexedMesh::Vertex& v = mesh.vertices[chain[i]];
      return absl::InvalidArgumentError(
          text::Concat("the border touches itself at (", v.x, ", ", v.y,
                       "), which ADCIRC does not take: write a part without that vertex"));
    }
    const bool is_outer = AreaOf(mesh, chain) > 0;
    Split(std::move(chain), is_outer, open, boundaries);
  }
  if (absl::Status status = CheckOpen(mesh, boundaries); !status.ok()) return status;
  return boundaries;
}

void WriteBoundaries(const char* what, const std::vector<Boundary>& boundaries, bool has_types,
                     FileWriter& out) {
  std::size_t vertices = 0;
  for (const Boundary& b : boundaries) vertices += b.vertices.size();
  out << boundaries.size() << " = number of " << what << " boundaries\n"
      << vertices << " = their vertices\n";
  for (const Boundary& b : boundaries) {
    out << b.vertices.size();
    if (has_types) out << ' ' << b.type;
    out << '\n';
    for (const std::uint32_t v : b.vertices) out << std::uint64_t{v} + 1 << '\n';
  }
}

}  // namespace

absl::Status WriteAdcirc(const IndexedMesh& mesh, const std::string& path) {
  const absl::StatusOr<NamedParts> parts = NamePartsOf(mesh);
  if (!parts.ok()) return parts.status();
  const absl::StatusOr<Boundaries> boundaries = BoundariesOf(mesh, *parts);
  if (!boundaries.ok()) {
    return absl::InvalidArgumentError(
        text::Concat(path, ": ", text::View(boundaries.status().message())));
  }
  FileWriter out(path);
  out << "by dynmesh\n" << mesh.triangles.size() << ' ' << mesh.vertices.size() << '\n';
  const std::size_t width = mesh.labels.attributes;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    out << i + 1 << ' ' << mesh.vertices[i].x << ' ' << mesh.vertices[i].y << ' '
        << (width == 0 ? 0.0 : mesh.labels.vertex_values[width * i]) << '\n';
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out << i + 1 << " 3";
    for (const std::uint32_t corner : mesh.triangles[i]) out << ' ' << std::uint64_t{corner} + 1;
    out << '\n';
  }
  WriteBoundaries("open", boundaries->open, false, out);
  WriteBoundaries("land", boundaries->land, true, out);
  return out.Close();
}

}  // namespace dynmesh::io
