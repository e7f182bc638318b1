#include "client/verify/excuses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

#include "core/base/union_find.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {
namespace {

// Of 70 degrees.
constexpr long double kNarrowCosine = 0.342L;

}  // namespace

Excuses::Excuses(const io::IndexedMesh& mesh, double ulp)
    : mesh_(mesh), tolerance_(16 * ulp), segment_(mesh.vertices.size()) {
  // Subsegments with a common vertex inside a segment are of the same segment.
  UnionFind segments(mesh.vertices.size());
  const auto is_inner = [&](std::uint32_t v) { return mesh.vertices[v].containing_dimension == 1; };
  const auto is_input = [](const auto& e) {
    return e.owner != kNoFeature && e.owner != kBoxFeature;
  };
  for (const auto& e : mesh.edges) {
    if (is_input(e) && is_inner(e.a) && is_inner(e.b)) segments.Unite(e.a, e.b);
  }
  for (std::size_t v = 0; v < segment_.size(); ++v) {
    segment_[v] = static_cast<std::uint32_t>(segments.Find(v));
  }
  for (const auto& e : mesh.edges) {
    if (!is_input(e) || is_inner(e.a) == is_inner(e.b)) continue;
    ends_[segment_[is_inner(e.a) ? e.a : e.b]].push_back(is_inner(e.a) ? e.b : e.a);
  }
  if (mesh.dimension == 3) FindNarrowCorners();
}

// A corner is narrow if an edge there, or a segment, makes less than 70 degrees with its foot on a
// triangle of a polygon.
void Excuses::FindNarrowCorners() {
  std::map<std::uint32_t, std::vector<std::uint32_t>> ways;  // by corner: next vertices
  std::map<std::uint32_t, std::vector<const io::IndexedMesh::Face*>> faces;  // by corner
  std::map<FeatureId, std::set<std::uint32_t>> corners;                      // of a polygon
  const auto is_corner = [&](std::uint32_t v) {
    return mesh_.vertices[v].containing_dimension == 0;
  };
  const auto is_input = [](FeatureId id) { return id != kNoFeature && id != kBoxFeature; };
  for (const auto& e : mesh_.edges) {
    if (!is_input(e.owner)) continue;
    if (is_corner(e.a)) ways[e.a].push_back(e.b);
    if (is_corner(e.b)) ways[e.b].push_back(e.a);
  }
  for (const auto& face : mesh_.faces) {
    if (!is_input(face.owner)) continue;
    for (const std::uint32_t v : face.corners) {
      if (!is_corner(v)) continue;
      faces[v].push_back(&face);
      corners[face.owner].insert(v);
    }
  }
  std::set<std::uint32_t> narrow;
  for (const auto& [corner, at] : faces) {
    for (const std::uint32_t way : ways[corner]) {
      for (const auto* face : at) {
        if (!narrow.contains(corner) && IsNarrow(way, *face, corner)) narrow.insert(corner);
      }
    }
    for (const auto* face : at) {
      for (const auto* other : at) {
        if (face->owner < other->owner && AreNarrow(*face, *other, corner)) narrow.insert(corner);
      }
    }
  }
  if (narrow.empty()) return;
  narrow_.resize(mesh_.vertices.size());
  for (const auto& face : mesh_.faces) {
    if (!is_input(face.owner)) continue;
    for (const std::uint32_t c : corners[face.owner]) {
      if (!narrow.contains(c)) continue;
      for (const std::uint32_t v : face.corners) narrow_[v].insert(c);
    }
  }
  for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
    const auto ends = ends_.find(segment_[v]);
    if (mesh_.vertices[v].containing_dimension != 1 || ends == ends_.end()) continue;
    for (const std::uint32_t c : ends->second) {
      if (narrow.contains(c)) narrow_[v].insert(c);
    }
  }
}

// Do the triangles have an edge at the corner in common, and less than 70 degrees between them?
bool Excuses::AreNarrow(const io::IndexedMesh::Face& f, const io::IndexedMesh::Face& g,
                        std::uint32_t corner) const {
  for (const std::uint32_t end : f.corners) {
    if (end == corner || std::ranges::find(g.corners, end) == g.corners.end()) continue;
    const auto a = mesh_.vertices[corner].position(), b = mesh_.vertices[end].position();
    const auto across = [&](const io::IndexedMesh::Face& face) {
      std::array<Real, 3> d = {}, e = {};
      for (const std::uint32_t v : face.corners) {
        if (v == corner || v == end) continue;
        const auto c = mesh_.vertices[v].position();
        Real along = 0, length2 = 0;
        for (std::size_t k = 0; k < 3; ++k) {
          d[k] = Real{c[k]} - a[k];
          e[k] = Real{b[k]} - a[k];
          along += d[k] * e[k];
          length2 += e[k] * e[k];
        }
        for (std::size_t k = 0; k < 3; ++k) d[k] -= along / length2 * e[k];
      }
      const Real height = std::hypot(d[0], d[1], d[2]);
      for (Real& x : d) x /= height;
      return d;
    };
    const auto u = across(f), w = across(g);
    if (u[0] * w[0] + u[1] * w[1] + u[2] * w[2] > kNarrowCosine) return true;
  }
  return false;
}

bool Excuses::IsNarrow(std::uint32_t way, const io::IndexedMesh::Face& face,
                       std::uint32_t corner) const {
  const auto to = [&](std::uint32_t v) {
    const auto a = mesh_.vertices[corner].position(), b = mesh_.vertices[v].position();
    Vector d = {Real{b[0]} - a[0], Real{b[1]} - a[1], Real{b[2]} - a[2]};
    const Real length = std::hypot(d[0], d[1], d[2]);
    for (Real& x : d) x /= length;
    return d;
  };
  const auto dot = [](const Vector& u, const Vector& w) {
    return u[0] * w[0] + u[1] * w[1] + u[2] * w[2];
  };
  std::vector<Vector> sides;
  for (const std::uint32_t v : face.corners) {
    if (v == way) return false;  // it is a side
    if (v != corner) sides.push_back(to(v));
  }
  if (sides.size() != 2) return false;  // a corner stands twice
  // The foot of d is x u + y w.
  const Vector d = to(way), &u = sides[0], &w = sides[1];
  const Real c = dot(u, w), det = 1 - c * c;
  const Real x = (dot(d, u) - c * dot(d, w)) / det, y = (dot(d, w) - c * dot(d, u)) / det;
  constexpr Real kLeast = 1e-9L;
  return x > -kLeast && y > -kLeast &&
         x * x + 2 * x * y * c + y * y > kNarrowCosine * kNarrowCosine;
}

bool Excuses::Excused(std::uint32_t p, std::uint32_t q) const {
  return IsOfSegments(p, q) || (!narrow_.empty() && IsOfFacets(p, q));
}

bool Excuses::AreOpposite(const io::IndexedMesh::Tetrahedron& t) const {
  const bool is_by_facets = std::ranges::any_of(
      t, [this](std::uint32_t v) { return mesh_.vertices[v].containing_dimension == 2; });
  return is_by_facets && ((Excused(t[0], t[1]) && Excused(t[2], t[3])) ||
                          (Excused(t[0], t[2]) && Excused(t[1], t[3])) ||
                          (Excused(t[0], t[3]) && Excused(t[1], t[2])));
}

bool Excuses::AreEqual(Real to_p, Real to_q) const {
  constexpr Real kSkew = 0x1p-17;
  const Real skew = mesh_.dimension == 3 ? kSkew * std::min(to_p, to_q) : 0;
  return std::abs(to_p - to_q) <= tolerance_ + skew;
}

bool Excuses::IsOfFacets(std::uint32_t p, std::uint32_t q) const {
  const Real across = Distance(p, q);
  return std::ranges::any_of(narrow_[p], [&](std::uint32_t c) {
    if (!narrow_[q].contains(c)) return false;
    const Real to_p = Distance(c, p), to_q = Distance(c, q);
    return AreEqual(to_p, to_q) && across < std::max(to_p, to_q);
  });
}

bool Excuses::IsOfSegments(std::uint32_t p, std::uint32_t q) const {
  const auto &vp = mesh_.vertices[p], &vq = mesh_.vertices[q];
  if (vp.containing_dimension != 1 || vq.containing_dimension != 1) return false;
  const auto s = ends_.find(segment_[p]), t = ends_.find(segment_[q]);
  if (s == t || s == ends_.end() || t == ends_.end()) return false;
  for (const std::uint32_t apex : s->second) {
    if (std::ranges::find(t->second, apex) == t->second.end()) continue;
    const Real to_p = Distance(apex, p), to_q = Distance(apex, q), across = Distance(p, q);
    // By the chord: across = 2 r sin(angle / 2), and sin 30 degrees = 1/2.
    if (AreEqual(to_p, to_q) && across < std::max(to_p, to_q)) return true;
  }
  return false;
}

Real Excuses::Distance(std::uint32_t p, std::uint32_t q) const {
  const auto a = mesh_.vertices[p].position(), b = mesh_.vertices[q].position();
  return std::hypot(Real{a[0]} - b[0], Real{a[1]} - b[1], Real{a[2]} - b[2]);
}

}  // namespace dynmesh::cli
