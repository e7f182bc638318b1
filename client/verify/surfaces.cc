// Checks every tetrahedron's set of closed surfaces around it. Polygons cut the mesh into cells,
// found by flood fill. The chambers of one component (connected polygons) are the cells joined
// across all other components. CheckFacets checks that subfacets cover the polygons exactly once,
// and other checks that tetrahedra fill the box.
#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <queue>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Joint = std::pair<FeatureId, FeatureId>;
using Corners = std::array<std::uint32_t, 3>;

// Polygons with subfacets that are not connected by edges.
std::set<FeatureId> FindApart(const io::IndexedMesh& mesh) {
  UnionFind joined(mesh.faces.size());
  std::map<std::pair<FeatureId, std::array<std::uint32_t, 2>>, std::size_t> at;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const auto& face = mesh.faces[i];
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax({face.corners[k], face.corners[(k + 1) % 3]});
      joined.Unite(i, at.try_emplace({face.owner, {a, b}}, i).first->second);
    }
  }
  std::map<FeatureId, std::size_t> part_of;
  std::set<FeatureId> apart;
  for (std::size_t i = 0; i < mesh.faces.size(); ++i) {
    const std::size_t part = joined.Find(i);
    if (part_of.emplace(mesh.faces[i].owner, part).first->second != part) {
      apart.insert(mesh.faces[i].owner);
    }
  }
  return apart;
}

// The connected components of polygons that may be part of a closed surface, as dynmesh/mesh.h
// defines. `apart`: polygons with a disconnected inside.
class Components {
 public:
  Components(const std::vector<Feature>& features, const std::set<FeatureId>& apart) {
    for (const Feature& f : features) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>) || apart.contains(f.id)) continue;
      for (const auto& ring : f.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          const Joint joint = std::minmax(ring[i], ring[(i + 1) % ring.size()]);
          joints_[f.id].push_back(joint);
          polygons_[joint].insert(f.id);
        }
      }
    }
    DropWhatDangles();
    for (const auto& [polygon, joints] : joints_) {
      if (!component_of_.contains(polygon)) TakeComponent(polygon);
    }
  }

  std::size_t size() const { return count_; }
  bool Has(FeatureId polygon) const { return component_of_.contains(polygon); }
  std::size_t Of(FeatureId polygon) const { return component_of_.at(polygon); }

 private:
  void DropWhatDangles() {
    std::vector<Joint> lone;
    for (const auto& [joint, polygons] : polygons_) {
      if (polygons.size() == 1) lone.push_back(joint);
    }
    while (!lone.empty()) {
      const Joint joint = lone.back();
      lone.pop_back();
      if (polygons_[joint].size() != 1) continue;
      const FeatureId polygon = *polygons_[joint].begin();
      for (const Joint& other : joints_[polygon]) {
        polygons_[other].erase(polygon);
        if (polygons_[other].size() == 1) lone.push_back(other);
      }
      joints_.erase(polygon);
    }
  }

  // Collects the polygons connected to this one.
  void TakeComponent(FeatureId polygon) {
    std::vector<FeatureId> ahead = {polygon};
    component_of_[polygon] = count_;
    while (!ahead.empty()) {
      const FeatureId next = ahead.back();
      ahead.pop_back();
      for (const Joint& joint : joints_.at(next)) {
        for (const FeatureId other : polygons_.at(joint)) {
          if (component_of_.emplace(other, count_).second) ahead.push_back(other);
        }
      }
    }
    ++count_;
  }

  std::map<FeatureId, std::vector<Joint>> joints_;
  std::map<Joint, std::set<FeatureId>> polygons_;
  std::map<FeatureId, std::size_t> component_of_;
  std::size_t count_ = 0;
};

// The two cells on both sides of a polygon.
struct Wall {
  FeatureId polygon;
  std::array<std::size_t, 2> cells;  // the lesser first
  friend auto operator<=>(const Wall&, const Wall&) = default;
};

// The id of each chamber's surface; kNoFeature for the outside. `walls`: those of the component, by
// ascending id; `chamber_of(cell)`. Starts at the outside. Repeatedly, the polygon of least id that
// leads from a named chamber to an unnamed one gives it its id.
template <class ChamberOf>
std::map<std::size_t, FeatureId> NameChambers(const std::vector<Wall>& walls, std::size_t outside,
                                              ChamberOf chamber_of) {
  std::map<std::size_t, std::vector<std::size_t>> walls_at;
  for (std::size_t i = 0; i < walls.size(); ++i) {
    for (const std::size_t cell : walls[i].cells) walls_at[chamber_of(cell)].push_back(i);
  }
  std::map<std::size_t, FeatureId> names;
  std::priority_queue<std::size_t, std::vector<std::size_t>, std::greater<>> ahead;
  const auto enter = [&](std::size_t chamber, FeatureId id) {
    if (!names.emplace(chamber, id).second) return;
    for (const std::size_t i : walls_at[chamber]) ahead.push(i);
  };
  enter(chamber_of(outside), kNoFeature);
  while (!ahead.empty()) {
    const Wall& wall = walls[ahead.top()];
    ahead.pop();
    for (const std::size_t cell : wall.cells) enter(chamber_of(cell), wall.polygon);
  }
  return names;
}

std::string NameOfChamber(const std::vector<FeatureId>& surfaces) {
  if (surfaces.empty()) return "no closed surface";
  return Concat(surfaces.size() == 1 ? "surface " : "surfaces ", io::FormatPolygons(surfaces));
}

}  // namespace

VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Face>& faces,
                         const std::vector<Feature>& features) {
  Findings findings("regions");
  const Components components(features, FindApart(mesh));
  absl::flat_hash_map<Corners, FeatureId> polygon_of;
  for (const auto& face : mesh.faces) {
    if (components.Has(face.owner)) polygon_of.emplace(face.corners, face.owner);
  }
  // Tetrahedra without a polygon in between are one cell; the outside of the box is one, too.
  const std::size_t beyond = mesh.tetrahedra.size();
  UnionFind joined(beyond + 1);
  const auto for_each_pair = [&](auto f) {
    ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
      const auto it = polygon_of.find(face->v);
      f(face[0].tetrahedron, count < 2 ? beyond : face[1].tetrahedron,
        it == polygon_of.end() ? kNoFeature : it->second);
    });
  };
  for_each_pair([&](std::size_t here, std::size_t there, FeatureId polygon) {
    if (polygon == kNoFeature) joined.Unite(here, there);
  });
  std::vector<std::size_t> cell_of(beyond + 1);
  std::map<std::size_t, std::size_t> cells;  // numbered consecutively
  for (std::size_t t = 0; t <= beyond; ++t) {
    cell_of[t] = cells.emplace(joined.Find(t), cells.size()).first->second;
  }
  std::vector<std::vector<Wall>> walls(components.size());
  for_each_pair([&](std::size_t here, std::size_t there, FeatureId polygon) {
    const auto [a, b] = std::minmax({cell_of[here], cell_of[there]});
    if (a != b) walls[components.Of(polygon)].push_back({polygon, {a, b}});
  });
  for (std::vector<Wall>& of_piece : walls) {
    std::sort(of_piece.begin(), of_piece.end());
    of_piece.erase(std::unique(of_piece.begin(), of_piece.end()), of_piece.end());
  }
  std::vector<std::vector<FeatureId>> inside(cells.size());
  for (std::size_t component = 0; component < components.size(); ++component) {
    UnionFind chambers(cells.size());
    for (std::size_t other = 0; other < components.size(); ++other) {
      if (other == component) continue;
      for (const Wall& wall : walls[other]) chambers.Unite(wall.cells[0], wall.cells[1]);
    }
    const auto chamber_of = [&](std::size_t cell) { return chambers.Find(cell); };
    const auto names = NameChambers(walls[component], cell_of[beyond], chamber_of);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      const auto name = names.find(chamber_of(cell));
      if (name != names.end() && name->second != kNoFeature) inside[cell].push_back(name->second);
    }
  }
  for (std::vector<FeatureId>& surfaces : inside) std::sort(surfaces.begin(), surfaces.end());
  const std::vector<FeatureId> none;
  for (std::uint32_t t = 0; t < beyond; ++t) {
    const std::uint32_t number = mesh.regions.Of(t);
    const std::vector<FeatureId>& said = number == 0 ? none : mesh.regions.polygons[number - 1];
    const std::vector<FeatureId>& wanted = inside[cell_of[t]];
    if (said == wanted) continue;
    findings.Add(Concat(TetrahedronName(t), " is in ", NameOfChamber(wanted), "; the mesh says ",
                        NameOfChamber(said)));
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
