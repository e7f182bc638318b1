#include "core/io/solvers/named_facets.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/strings/ascii.h"
#include "core/base/text.h"
#include "core/io/meshes/msh_groups.h"
#include "core/io/meshes/references.h"
#include "core/io/meshes/tetrahedron_sides.h"

namespace dynmesh::io {
namespace {

using Key = std::array<std::uint32_t, 3>;  // ascending; in 2D the last is the largest number

constexpr std::uint32_t kNone = ~std::uint32_t{0};

Key KeyOf(std::uint32_t a, std::uint32_t b, std::uint32_t c = kNone) {
  Key key = {a, b, c};
  std::sort(key.begin(), key.end());
  return key;
}

// References of the facets that lie on features or the box.
absl::flat_hash_map<Key, int> ReferencesOfFacets(const IndexedMesh& mesh,
                                                 const References& references) {
  absl::flat_hash_map<Key, int> result;
  const auto add = [&](const Key& key, FeatureId owner) {
    if (owner != kNoFeature) result.emplace(key, references.Find(owner));
  };
  if (mesh.dimension == 2) {
    for (const IndexedMesh::Edge& edge : mesh.edges) add(KeyOf(edge.a, edge.b), edge.owner);
  } else {
    for (const IndexedMesh::Face& face : mesh.faces) {
      add(KeyOf(face.corners[0], face.corners[1], face.corners[2]), face.owner);
    }
  }
  return result;
}

struct Side {
  NamedFacet facet;
  int reference = 0;
};

}  // namespace

std::array<std::uint32_t, 3> CornersOf(const IndexedMesh& mesh, const NamedFacet& facet) {
  const auto opposite = static_cast<std::size_t>(facet.opposite);
  if (mesh.dimension == 2) {
    const IndexedMesh::Triangle& t = mesh.triangles[facet.simplex];
    return {t[(opposite + 1) % 3], t[(opposite + 2) % 3], kNone};
  }
  const IndexedMesh::Tetrahedron& t = mesh.tetrahedra[facet.simplex];
  std::array<std::uint32_t, 3> corners;
  for (std::size_t k = 0; k < 3; ++k) corners[k] = t[kTetrahedronSides[opposite][k]];
  return corners;
}

absl::StatusOr<NamedParts> NamePartsOf(const IndexedMesh& mesh) {
  const absl::StatusOr<References> references = References::Of(mesh);
  if (!references.ok()) return references.status();
  const MshGroups groups(mesh, *references);
  const absl::flat_hash_map<Key, int> reference_of = ReferencesOfFacets(mesh, *references);

  // Each facet once, as the side that the header says; and whether there is another.
  absl::flat_hash_map<Key, std::size_t> side_of;
  std::vector<Side> sides;
  const auto corners = static_cast<int>(mesh.dimension) + 1;
  for (std::uint32_t i = 0; i < mesh.simplex_count(); ++i) {
    for (int k = 0; k < corners; ++k) {
      const NamedFacet facet = {i, k, true};
      const auto c = CornersOf(mesh, facet);
      const Key key = KeyOf(c[0], c[1], c[2]);
      const auto [it, is_new] = side_of.try_emplace(key, sides.size());
      if (is_new) {
        const auto reference = reference_of.find(key);
        sides.push_back({facet, reference == reference_of.end() ? 0 : reference->second});
        continue;
      }
      Side& known = sides[it->second];
      if (mesh.regions.Of(i) < mesh.regions.Of(known.facet.simplex)) known.facet = facet;
      known.facet.is_border = false;
    }
  }

  NamedParts parts;
  std::map<int, std::vector<std::uint32_t>> of_region;
  std::set<std::uint32_t> regions;
  for (std::uint32_t i = 0; i < mesh.simplex_count(); ++i) {
    const std::uint32_t region = mesh.regions.Of(i);
    regions.insert(region);
    of_region[groups.OfRegion(region)].push_back(i);
  }
  std::array<std::set<int>, 3> used;
  std::map<int, std::vector<NamedFacet>> of_group;  // 0: none
  for (const Side& side : sides) {
    const int group = groups.Of(side.reference);
    if (group == 0 && !side.facet.is_border) continue;
    if (group != 0) used[static_cast<std::size_t>(mesh.dimension) - 1].insert(side.reference);
    of_group[group].push_back(side.facet);
  }
  std::vector<std::pair<std::string, std::string>> long_names;
  const auto names = groups.Names(used, regions, long_names);
  std::set<std::string> taken;
  for (auto& [group, simplices] : of_region) {
    parts.regions.push_back({names.at({mesh.dimension, group}), std::move(simplices)});
    taken.insert(parts.regions.back().name);
  }
  for (auto& [group, facets] : of_group) {
    if (group == 0) continue;
    parts.facets.push_back({names.at({mesh.dimension - 1, group}), std::move(facets)});
    taken.insert(parts.facets.back().name);
  }
  if (const auto rest = of_group.find(0); rest != of_group.end()) {
    std::string name = "border";
    for (int i = 2; taken.contains(name); ++i) name = text::Concat("border ", i);
    parts.facets.push_back({std::move(name), std::move(rest->second)});
  }
  for (FacetSet& set : parts.facets) {
    std::ranges::sort(set.facets, {},
                      [](const NamedFacet& f) { return std::pair(f.simplex, f.opposite); });
  }
  return parts;
}

std::vector<DirectedEdge> EdgesOf(const IndexedMesh& mesh, const FacetSet& set) {
  std::vector<DirectedEdge> edges;
  for (const NamedFacet& facet : set.facets) {
    const auto corners = CornersOf(mesh, facet);
    edges.emplace_back(corners[0], corners[1]);
  }
  return edges;
}

std::string WordOf(const std::string& name, std::size_t most) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  std::string word;
  if (name.empty() || !is_letter(name[0])) word += 'N';
  for (const char c : name) {
    if (word.size() >= most) break;
    word += is_letter(c) || (c >= '0' && c <= '9') ? c : '_';
  }
  return word;
}

std::vector<std::string> WordsOf(const std::vector<std::string>& names, std::size_t most) {
  std::vector<std::string> words;
  std::set<std::string> taken;
  for (const std::string& name : names) {
    std::string word = WordOf(name, most);
    for (int i = 2; !taken.insert(absl::AsciiStrToLower(word)).second; ++i) {
      const std::string number = text::Concat("_", i);
      word = text::Concat(WordOf(name, most - number.size()), number);
    }
    words.push_back(std::move(word));
  }
  return words;
}

}  // namespace dynmesh::io
