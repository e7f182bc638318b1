#include "client/verify/owners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/verify/flat_polygon.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::cli {
namespace {

class OwnerSearch {
 public:
  OwnerSearch(const std::vector<Feature>& features, io::IndexedMesh& mesh)
      : features_(features),
        mesh_(mesh),
        tolerance_(kStraightnessUlps * LargestUlp(mesh)),
        lines_(mesh.vertices.size()),
        by_x_(mesh.vertices.size()) {
    std::iota(by_x_.begin(), by_x_.end(), 0);
    std::sort(by_x_.begin(), by_x_.end(), [&](std::uint32_t v, std::uint32_t w) {
      return mesh.vertices[v].x < mesh.vertices[w].x;
    });
    for (const Feature& f : features) {
      if (IsPoint(f)) points_.emplace(f.id, &f);
    }
  }

  void Run() {
    for (auto& v : mesh_.vertices) v.owner = kNoFeature, v.containing_dimension = mesh_.dimension;
    for (auto& e : mesh_.edges) e.owner = kNoFeature;
    for (auto& f : mesh_.faces) f.owner = kNoFeature;
    FindPoints();
    FindLines();
    if (mesh_.dimension == 3) FindPolygons();
  }

 private:
  Vector At(std::uint32_t v) const { return FlatPolygon::ToVector(mesh_.vertices[v].position()); }

  // Of several features of one dimension the least id, as readers of mesh files choose.
  void Own(std::uint32_t v, int dimension, FeatureId id) {
    auto& vertex = mesh_.vertices[v];
    if (vertex.containing_dimension < dimension) return;
    const bool is_other = vertex.containing_dimension == dimension && vertex.owner != kNoFeature;
    vertex.owner = is_other ? std::min(vertex.owner, id) : id;
    vertex.containing_dimension = dimension;
  }

  // Calls f(v) for the vertices with an x in the range of `places`.
  template <class F>
  void ForEachNear(const std::vector<Vector>& places, F f) const {
    Real lo = places[0][0], hi = lo;
    for (const Vector& p : places) lo = std::min(lo, p[0]), hi = std::max(hi, p[0]);
    auto it =
        std::lower_bound(by_x_.begin(), by_x_.end(), lo - tolerance_,
                         [&](std::uint32_t v, Real x) { return Real{mesh_.vertices[v].x} < x; });
    for (; it != by_x_.end() && mesh_.vertices[*it].x <= hi + tolerance_; ++it) f(*it);
  }

  void FindPoints() {
    std::map<std::array<double, 3>, FeatureId> at;
    for (const auto& [id, f] : points_) at.emplace(f->position, id);
    for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
      const auto it = at.find(mesh_.vertices[v].position());
      if (it != at.end()) Own(v, 0, it->second);
    }
  }

  std::optional<Vector> PlaceOf(FeatureId point) const {
    const auto it = points_.find(point);
    if (it == points_.end()) return std::nullopt;
    return FlatPolygon::ToVector(it->second->position);
  }

  bool IsOn(const Vector& p, const Vector& q, const Vector& x) const {
    Real along = 0, length2 = 0, off2 = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      along += (x[k] - p[k]) * (q[k] - p[k]);
      length2 += (q[k] - p[k]) * (q[k] - p[k]);
    }
    const Real part = std::clamp<Real>(along / length2, 0, 1);
    for (std::size_t k = 0; k < 3; ++k) {
      const Real off = x[k] - p[k] - part * (q[k] - p[k]);
      off2 += off * off;
    }
    return off2 <= tolerance_ * tolerance_;
  }

  void FindLines() {
    const std::vector<Joint> joints = JointsOf(features_);
    for (std::uint32_t line = 0; line < joints.size(); ++line) {
      const auto p = PlaceOf(joints[line].from), q = PlaceOf(joints[line].to);
      if (!p || !q) continue;
      ForEachNear({*p, *q}, [&](std::uint32_t v) {
        if (!IsOn(*p, *q, At(v))) return;
        lines_[v].push_back(line);
        Own(v, 1, joints[line].feature->id);
      });
    }
    for (auto& e : mesh_.edges) {
      const auto &of_a = lines_[e.a], &of_b = lines_[e.b];
      const auto common = std::find_first_of(of_a.begin(), of_a.end(), of_b.begin(), of_b.end());
      if (common != of_a.end()) e.owner = joints[*common].feature->id;
    }
  }

  void FindPolygons() {
    absl::flat_hash_map<std::uint32_t, std::vector<io::IndexedMesh::Face*>> faces;  // by a corner
    for (auto& face : mesh_.faces) faces[face.corners[0]].push_back(&face);
    for (const Feature& f : features_) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      std::vector<std::vector<Vector>> rings;
      std::vector<Vector> corners;
      for (const auto& ring : f.rings) {
        rings.emplace_back();
        for (const FeatureId id : ring) {
          if (const auto p = PlaceOf(id)) rings.back().push_back(*p), corners.push_back(*p);
        }
      }
      if (corners.empty()) continue;
      const FlatPolygon polygon(rings);
      if (!polygon.HasPlane()) continue;
      const auto is_in_plane = [&](std::uint32_t v) {
        return polygon.Distance(At(v)) <= tolerance_ + polygon.bend();
      };
      ForEachNear(corners, [&](std::uint32_t v) {
        if (!is_in_plane(v)) return;
        // A vertex on the rings has an owner already.
        if (mesh_.vertices[v].containing_dimension >= 2 && polygon.Covers(At(v))) Own(v, 2, f.id);
        const auto at = faces.find(v);
        if (at == faces.end()) return;
        for (io::IndexedMesh::Face* const face : at->second) {
          const auto& [a, b, c] = face->corners;
          if (face->owner != kNoFeature || !is_in_plane(b) || !is_in_plane(c)) continue;
          Vector centre = At(a);
          for (std::size_t k = 0; k < 3; ++k) centre[k] = (centre[k] + At(b)[k] + At(c)[k]) / 3;
          if (polygon.Covers(centre)) face->owner = f.id;
        }
      });
    }
  }

  const std::vector<Feature>& features_;
  io::IndexedMesh& mesh_;
  const Real tolerance_;
  absl::flat_hash_map<FeatureId, const Feature*> points_;
  std::vector<std::vector<std::uint32_t>> lines_;  // by vertex: the joints it is on, ascending
  std::vector<std::uint32_t> by_x_;
};

}  // namespace

void FindOwners(const std::vector<Feature>& features, io::IndexedMesh& mesh) {
  OwnerSearch(features, mesh).Run();
}

}  // namespace dynmesh::cli
