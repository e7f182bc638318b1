// Does every tetrahedron say which closed surfaces it lies inside of? Outside of the box it is
// none. From there to any tetrahedron leads a way through faces, and what it passes through an odd
// number of times is what the tetrahedron lies inside of: so it is enough that labels differ by
// the surface of the face between two neighbours, and agree where there is none. CheckFacets finds
// that subfacets are the polygons, exactly once, and other checks that tetrahedra fill the box.
#include <algorithm>
#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/cli/verify_internal.h"
#include "core/data/text.h"

namespace dynmesh::cli {
namespace {

using data::Concat;
using Joint = std::pair<FeatureId, FeatureId>;
using Corners = std::array<std::uint32_t, 3>;

// By the definition of dynmesh/mesh.h: the surface of each polygon that is part of one.
class Surfaces {
 public:
  explicit Surfaces(const std::vector<Feature>& features) {
    for (const Feature& f : features) {
      if (f.kind != FeatureKind::kPolygon) continue;
      for (const auto& ring : f.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          const Joint joint = std::minmax(ring[i], ring[(i + 1) % ring.size()]);
          joints_[f.id].push_back(joint);
          polygons_[joint].insert(f.id);
        }
      }
    }
    DropWhatDangles();
    while (!joints_.empty()) TakePiece(joints_.begin()->first);
  }

  // kNoFeature if there is none.
  FeatureId Of(FeatureId polygon) const {
    const auto it = surface_of_.find(polygon);
    return it == surface_of_.end() ? kNoFeature : it->second;
  }

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

  // All that hangs together with the polygon leaves joints_.
  void TakePiece(FeatureId polygon) {
    std::set<FeatureId> piece = {polygon};
    std::vector<FeatureId> ahead = {polygon};
    bool is_closed = true;
    while (!ahead.empty()) {
      const FeatureId next = ahead.back();
      ahead.pop_back();
      for (const Joint& joint : joints_[next]) {
        const std::set<FeatureId>& there = polygons_[joint];
        is_closed = is_closed && there.size() % 2 == 0;
        for (const FeatureId other : there) {
          if (piece.insert(other).second) ahead.push_back(other);
        }
      }
    }
    for (const FeatureId part : piece) {
      if (is_closed) surface_of_[part] = *piece.begin();
      joints_.erase(part);
    }
  }

  std::map<FeatureId, std::vector<Joint>> joints_;
  std::map<Joint, std::set<FeatureId>> polygons_;
  std::map<FeatureId, FeatureId> surface_of_;
};

// What is in one and not in the other is `step` alone, or nothing if that is kNoFeature.
bool DifferBy(const std::vector<FeatureId>& one, const std::vector<FeatureId>& other,
              FeatureId step) {
  std::vector<FeatureId> difference;
  std::set_symmetric_difference(one.begin(), one.end(), other.begin(), other.end(),
                                std::back_inserter(difference));
  return step == kNoFeature ? difference.empty() : difference == std::vector<FeatureId>{step};
}

std::string NameOf(const std::vector<FeatureId>& surfaces) {
  if (surfaces.empty()) return "no closed surface";
  return Concat(surfaces.size() == 1 ? "surface " : "surfaces ", io::FormatPolygons(surfaces));
}

}  // namespace

VerifyCheck CheckRegions(const io::IndexedMesh& mesh, const std::vector<Face>& faces,
                         const std::vector<Feature>& features) {
  Findings findings("regions");
  const Surfaces surfaces(features);
  absl::flat_hash_map<Corners, FeatureId> walls;
  for (const auto& face : mesh.faces) {
    if (const FeatureId surface = surfaces.Of(face.owner)) walls.emplace(face.corners, surface);
  }
  const std::vector<FeatureId> none;
  const auto region_of = [&](const Face& face) -> const std::vector<FeatureId>& {
    const std::uint32_t number = mesh.regions.Of(face.tetrahedron);
    return number == 0 ? none : mesh.regions.polygons[number - 1];
  };
  ForEachTriangle(faces, [&](const Face* face, std::size_t count) {
    const auto wall = walls.find(face->v);
    const FeatureId step = wall == walls.end() ? kNoFeature : wall->second;
    const std::vector<FeatureId>& here = region_of(face[0]);
    const std::vector<FeatureId>& beyond = count < 2 ? none : region_of(face[1]);
    if (DifferBy(here, beyond, step)) return;
    findings.Add(
        Concat(FaceName(face->v), " is on ", NameOf(step == kNoFeature ? none : std::vector{step}),
               "; ", TetrahedronName(face->tetrahedron), " says that it is in ", NameOf(here), ", ",
               count < 2 ? "beyond it is the outside"
                         : Concat(TetrahedronName(face[1].tetrahedron), " in ", NameOf(beyond))));
  });
  return findings.Take();
}

}  // namespace dynmesh::cli
