#include "client/verify/excuses.h"

#include <cmath>

#include "core/base/union_find.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::cli {

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
}

bool Excuses::Excused(std::uint32_t p, std::uint32_t q) const {
  const auto &vp = mesh_.vertices[p], &vq = mesh_.vertices[q];
  if (vp.containing_dimension != 1 || vq.containing_dimension != 1) return false;
  const auto s = ends_.find(segment_[p]), t = ends_.find(segment_[q]);
  if (s == t || s == ends_.end() || t == ends_.end()) return false;
  for (const std::uint32_t apex : s->second) {
    if (std::ranges::find(t->second, apex) == t->second.end()) continue;
    const Real to_p = Distance(apex, p), to_q = Distance(apex, q), across = Distance(p, q);
    // By the chord: across = 2 r sin(angle / 2), and sin 30 degrees = 1/2.
    if (std::abs(to_p - to_q) <= tolerance_ && across < std::max(to_p, to_q)) return true;
  }
  return false;
}

Excuses::Real Excuses::Distance(std::uint32_t p, std::uint32_t q) const {
  const auto a = mesh_.vertices[p].position(), b = mesh_.vertices[q].position();
  return std::hypot(Real{a[0]} - b[0], Real{a[1]} - b[1], Real{a[2]} - b[2]);
}

}  // namespace dynmesh::cli
