// Checks that the subfacets of every polygon cover it exactly once. Modulo 2, the area covered by
// triangles is determined by their border: if the border is the polygon's rings, each point inside
// is covered an odd number of times and each point outside an even number. If the areas sum up as
// well, these numbers are 1 and 0.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/verify/flat_polygon.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Flat = FlatPolygon::Flat;
using Ends = std::pair<std::uint32_t, std::uint32_t>;

class FacetCheck {
 public:
  FacetCheck(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
             const Chains& chains)
      : mesh_(mesh),
        features_(features),
        chains_(chains),
        tolerance_(kStraightnessUlps * LargestUlp(mesh)) {
    for (const Feature& f : features) {
      if (IsPoint(f)) points_.emplace(f.id, FlatPolygon::ToVector(f.position));
    }
    for (const auto& f : mesh.faces) {
      if (f.owner != kNoFeature && f.owner != kBoxFeature) faces_of_[f.owner].push_back(f.corners);
    }
  }

  VerifyCheck Run() {
    std::set<FeatureId> polygons;
    for (const Feature& f : features_) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      polygons.insert(f.id);
      CheckPolygon(f);
    }
    for (const auto& [owner, faces] : faces_of_) {
      if (polygons.contains(owner) || faces.empty()) continue;
      findings_.Add(Concat(FaceName(faces.front()), " has the marker ", owner,
                           ", which is no input polygon"));
    }
    return findings_.Take();
  }

 private:
  void CheckPolygon(const Feature& f) {
    std::optional<std::vector<std::vector<Vector>>> rings = CornersOf(f);
    if (!rings) return;
    const FlatPolygon polygon(*std::move(rings));
    if (!polygon.HasPlane()) {
      findings_.Add(Concat("input polygon ", f.id, " has no area"));
      return;
    }
    const auto& faces = faces_of_[f.id];
    if (!AreFlat(f, polygon, faces) || !IsBorderRight(f, faces)) return;
    Real area = 0;
    for (const auto& face : faces) {
      Flat p[3];
      for (std::size_t k = 0; k < 3; ++k) p[k] = polygon.Project(At(face[k]));
      area += std::abs(FlatPolygon::Twice(p[0], p[1], p[2])) / 2;
    }
    const Real wanted = polygon.Area();
    const Real allowed = 1e-9L * wanted + 4 * tolerance_ * polygon.Perimeter();
    if (!(std::abs(area - wanted) <= allowed)) {
      findings_.Add(Concat("the subfacets of input polygon ", f.id, " have ",
                           static_cast<double>(area / wanted), " times its area"));
    }
  }

  std::optional<std::vector<std::vector<Vector>>> CornersOf(const Feature& f) {
    std::vector<std::vector<Vector>> rings;
    for (const auto& ring : f.rings) {
      std::vector<Vector>& corners = rings.emplace_back();
      for (const FeatureId id : ring) {
        const auto point = points_.find(id);
        if (point == points_.end()) {
          findings_.Add(Concat("input polygon ", f.id, " has a corner that is no input point"));
          return std::nullopt;
        }
        corners.push_back(point->second);
      }
      if (corners.size() < 3) {
        findings_.Add(Concat("input polygon ", f.id, " has a ring of fewer than 3 corners"));
        return std::nullopt;
      }
    }
    return rings;
  }

  bool AreFlat(const Feature& f, const FlatPolygon& polygon,
               const std::vector<std::array<std::uint32_t, 3>>& faces) {
    for (const auto& face : faces) {
      for (const std::uint32_t v : face) {
        const Real off = polygon.Distance(At(v));
        if (off <= tolerance_ + polygon.bend()) continue;
        findings_.Add(Concat(FaceName(face), " of input polygon ", f.id, " has ", VertexName(v),
                             ", which is ", static_cast<double>(off), " off its plane"));
        return false;
      }
    }
    return true;
  }

  // True if every edge of the subfacets is an edge of two of them, or of one and on a ring, and
  // every edge on a ring is an edge of one.
  bool IsBorderRight(const Feature& f, const std::vector<std::array<std::uint32_t, 3>>& faces) {
    std::map<Ends, int> uses;
    for (const auto& face : faces) {
      for (std::size_t k = 0; k < 3; ++k) ++uses[std::minmax(face[k], face[(k + 1) % 3])];
    }
    std::set<Ends> border;
    for (const auto& ring : f.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const auto chain = chains_.find(std::minmax(ring[i], ring[(i + 1) % ring.size()]));
        if (chain == chains_.end()) {
          findings_.Add(Concat("input polygon ", f.id, " has an edge, ", ring[i], " - ",
                               ring[(i + 1) % ring.size()], ", that is not in the mesh"));
          return false;
        }
        const std::vector<std::uint32_t>& v = chain->second;
        for (std::size_t k = 0; k + 1 < v.size(); ++k) border.insert(std::minmax(v[k], v[k + 1]));
      }
    }
    for (const Ends& e : border) uses.try_emplace(e, 0);
    for (const auto& [e, count] : uses) {
      const int wanted = border.contains(e) ? 1 : 2;
      if (count == wanted) continue;
      findings_.Add(Concat(EdgeName(e.first, e.second), " has ", count,
                           " subfacets of input polygon ", f.id,
                           wanted == 1 ? ", which has it on an edge" : ", in which it is"));
      return false;
    }
    return true;
  }

  Vector At(std::uint32_t v) const { return FlatPolygon::ToVector(mesh_.vertices[v].position()); }

  const io::IndexedMesh& mesh_;
  const std::vector<Feature>& features_;
  const Chains& chains_;
  const Real tolerance_;
  absl::flat_hash_map<FeatureId, Vector> points_;
  std::map<FeatureId, std::vector<std::array<std::uint32_t, 3>>> faces_of_;
  Findings findings_{"facets"};
};

}  // namespace

VerifyCheck CheckFacets(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                        const Chains& chains) {
  return FacetCheck(mesh, features, chains).Run();
}

}  // namespace dynmesh::cli
