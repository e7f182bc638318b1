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
#include "client/verify/verify_internal.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Real = long double;
using Vector = std::array<Real, 3>;
using Flat = std::array<Real, 2>;
using Ends = std::pair<std::uint32_t, std::uint32_t>;

Vector Minus(const Vector& u, const Vector& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
Vector Cross(const Vector& u, const Vector& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}
Real Dot(const Vector& u, const Vector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
Vector ToVector(const std::array<double, 3>& p) { return {p[0], p[1], p[2]}; }

// A polygon's plane, by its largest ring, and its rings projected along the axis with the largest
// component of the normal.
class FlatPolygon {
 public:
  explicit FlatPolygon(std::vector<std::vector<Vector>> rings) : rings_(std::move(rings)) {
    for (const auto& ring : rings_) {
      Vector normal = {0, 0, 0};  // twice the area as length
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector c =
            Cross(Minus(ring[i], ring[0]), Minus(ring[(i + 1) % ring.size()], ring[0]));
        for (std::size_t k = 0; k < 3; ++k) normal[k] += c[k];
      }
      if (Dot(normal, normal) > Dot(normal_, normal_)) normal_ = normal, origin_ = ring[0];
    }
    const Real length = std::sqrt(Dot(normal_, normal_));
    for (Real& c : normal_) c /= length;
    for (std::size_t k = 1; k < 3; ++k) {
      if (std::abs(normal_[k]) > std::abs(normal_[axis_])) axis_ = k;
    }
    for (const auto& ring : rings_) {
      for (const Vector& p : ring) bend_ = std::max(bend_, Distance(p));
    }
  }

  bool HasPlane() const { return std::isfinite(normal_[axis_]); }
  // Distance from the plane.
  Real Distance(const Vector& p) const { return std::abs(Dot(Minus(p, origin_), normal_)); }
  // Largest distance of its own corners from the plane.
  Real bend() const { return bend_; }

  Flat Project(const Vector& p) const {
    return {p[(axis_ + 1) % 3] - origin_[(axis_ + 1) % 3],
            p[(axis_ + 2) % 3] - origin_[(axis_ + 2) % 3]};
  }

  // Projected area of the points in an odd number of rings. Edges of rings meet in corners only. So
  // along each edge the number of other rings around both sides is constant, and its midpoint
  // decides it.
  Real Area() const {
    Real sum = 0;
    const Flat origin = Project(rings_[0][0]);
    for (const auto& ring : rings_) {
      Real twice = 0, inside = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Flat p = Project(ring[i]), q = Project(ring[(i + 1) % ring.size()]);
        const Flat middle = {(p[0] + q[0]) / 2, (p[1] + q[1]) / 2};
        bool is_border_of_hole = false;
        for (const auto& other : rings_) {
          if (&other != &ring && IsInside(middle, other)) is_border_of_hole = !is_border_of_hole;
        }
        const Real part = Twice(origin, p, q);
        twice += part;
        inside += is_border_of_hole ? -part : part;
      }
      sum += (twice > 0 ? inside : -inside) / 2;
    }
    return sum;
  }

  Real Perimeter() const {
    Real sum = 0;
    for (const auto& ring : rings_) {
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vector d = Minus(ring[(i + 1) % ring.size()], ring[i]);
        sum += std::sqrt(Dot(d, d));
      }
    }
    return sum;
  }

  // Twice the signed area.
  static Real Twice(const Flat& a, const Flat& b, const Flat& c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  }

 private:
  bool IsInside(const Flat& at, const std::vector<Vector>& ring) const {
    bool inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      Flat p = Project(ring[i]), q = Project(ring[(i + 1) % ring.size()]);
      if (p[1] > q[1]) std::swap(p, q);
      if (at[1] < p[1] || at[1] >= q[1]) continue;
      if (Twice(p, q, at) > 0) inside = !inside;
    }
    return inside;
  }

  std::vector<std::vector<Vector>> rings_;
  Vector origin_ = {0, 0, 0};
  Vector normal_ = {0, 0, 0};
  std::size_t axis_ = 0;
  Real bend_ = 0;
};

class FacetCheck {
 public:
  FacetCheck(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
             const Chains& chains)
      : mesh_(mesh),
        features_(features),
        chains_(chains),
        tolerance_(kStraightnessUlps * LargestUlp(mesh)) {
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPoint) points_.emplace(f.id, ToVector(f.position));
    }
    for (const auto& f : mesh.faces) {
      if (f.owner != kNoFeature && f.owner != kBoxFeature) faces_of_[f.owner].push_back(f.corners);
    }
  }

  VerifyCheck Run() {
    std::set<FeatureId> polygons;
    for (const Feature& f : features_) {
      if (f.kind != FeatureKind::kPolygon) continue;
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

  Vector At(std::uint32_t v) const { return ToVector(mesh_.vertices[v].position()); }

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
