// What unsplit segments excuse, and the check that they are whole. Whether a corner lies in a
// circle is decided exactly, by CGAL's kernel.
#include "client/verify/unsplit.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "absl/container/flat_hash_map.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr Real kRounded = 1e-6L;  // of squared radii: points are rounded

Vector CornerAt(const io::IndexedMesh& mesh, std::uint32_t v) {
  return {mesh.vertices[v].x, mesh.vertices[v].y, 0};
}

Vector CircumcentreOf(const Vector& a, const Vector& b, const Vector& c) {
  const Vector u = Minus(b, a), v = Minus(c, a);
  const Real twice = 2 * (u[0] * v[1] - u[1] * v[0]), u2 = Dot(u, u), v2 = Dot(v, v);
  return {a[0] + (v[1] * u2 - u[1] * v2) / twice, a[1] + (u[0] * v2 - v[0] * u2) / twice, 0};
}

// The apex, left of pq, of the isosceles triangle over pq with circumradius rho |pq|.
Vector JustGoodApex(const Vector& p, const Vector& q, Real rho) {
  const Real height = rho + std::sqrt(rho * rho - Real{0.25});
  return {(p[0] + q[0]) / 2 - height * (q[1] - p[1]), (p[1] + q[1]) / 2 + height * (q[0] - p[0]),
          0};
}

}  // namespace

std::vector<std::pair<FeatureId, FeatureId>> UnsplitJoints(const std::vector<Feature>& features) {
  std::vector<std::pair<FeatureId, FeatureId>> joints;
  const auto add = [&](FeatureId a, FeatureId b) { joints.emplace_back(a, b); };
  for (const Feature& f : features) {
    if (!f.unsplit) continue;
    Visit(
        f, [&](const ASegment& s) { add(s.ends[0], s.ends[1]); },
        [&](const APolygon& p) { ForEachEdgeOf(p.rings, add); }, Ignore<APoint, ASize>);
  }
  return joints;
}

UnsplitCircles::UnsplitCircles(const std::vector<Feature>* features) {
  if (features == nullptr) return;
  absl::flat_hash_map<FeatureId, Vector> points;
  for (const Feature& f : *features) {
    if (IsPoint(f)) points[f.id] = {f.position[0], f.position[1], 0};
  }
  std::vector<boxes::Box<2>> around;
  for (const auto& [from, to] : UnsplitJoints(*features)) {
    if (!points.contains(from) || !points.contains(to)) continue;
    const Vector &a = points[from], &b = points[to];
    const Real radius = Norm(Minus(b, a)) / 2 * (1 + kRounded);
    boxes::Box<2> box{};
    for (std::size_t k = 0; k < 2; ++k) {
      box.low[k] = static_cast<double>((a[k] + b[k]) / 2 - radius);
      box.high[k] = static_cast<double>((a[k] + b[k]) / 2 + radius);
    }
    circles_.push_back({a, b});
    around.push_back(box);
  }
  tree_ = boxes::BoxTree<2>(std::move(around));
}

bool UnsplitCircles::Meet(const Vector& x, const Vector& y) const {
  boxes::Box<2> box{};
  for (std::size_t k = 0; k < 2; ++k) {
    box.low[k] = static_cast<double>(std::min(x[k], y[k]));
    box.high[k] = static_cast<double>(std::max(x[k], y[k]));
  }
  bool meet = false;
  tree_.ForEachMeeting(box, [&](std::uint32_t i) {
    const auto& [a, b] = circles_[i];
    const Vector centre = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2, 0}, u = Minus(y, x);
    const Real u2 = Dot(u, u);
    const Real t = u2 > 0 ? std::clamp<Real>(Dot(Minus(centre, x), u) / u2, 0, 1) : 0;
    const Vector nearest = {x[0] + t * u[0], x[1] + t * u[1], 0};
    const Vector away = Minus(nearest, centre), along = Minus(b, a);
    meet = meet || 4 * Dot(away, away) <= Dot(along, along) * (1 + kRounded);
  });
  return meet;
}

bool UnsplitCircles::Excuse(const io::IndexedMesh& mesh, const io::IndexedMesh::Triangle& t,
                            double rho) const {
  if (circles_.empty()) return false;
  const Vector centre =
      CircumcentreOf(CornerAt(mesh, t[0]), CornerAt(mesh, t[1]), CornerAt(mesh, t[2]));
  const Real radius = Norm(Minus(centre, CornerAt(mesh, t[0])));
  if (!std::isfinite(radius)) return false;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector p = CornerAt(mesh, t[i]), q = CornerAt(mesh, t[(i + 1) % 3]),
                 c = CornerAt(mesh, t[(i + 2) % 3]);
    const Real edge = Norm(Minus(q, p));
    if (radius <= rho * edge || Dot(Minus(p, c), Minus(q, c)) <= 0) continue;
    const Vector apex = JustGoodApex(p, q, rho);
    const bool is_nearer = radius < Norm(Minus(apex, p));
    if (Meet(is_nearer ? centre : apex, apex)) return true;
  }
  return false;
}

bool UnsplitCircles::ExcuseSize(const io::IndexedMesh& mesh,
                                const io::IndexedMesh::Triangle& t) const {
  if (circles_.empty()) return false;
  const Vector centre =
      CircumcentreOf(CornerAt(mesh, t[0]), CornerAt(mesh, t[1]), CornerAt(mesh, t[2]));
  if (!std::isfinite(centre[0]) || !std::isfinite(centre[1])) return false;
  if (Meet(centre, centre)) return true;
  const Real radius = Norm(Minus(centre, CornerAt(mesh, t[0])));
  for (std::size_t i = 0; i < 3; ++i) {
    const Vector p = CornerAt(mesh, t[i]), q = CornerAt(mesh, t[(i + 1) % 3]);
    const Vector apex = JustGoodApex(p, q, 1);  // rho is 1 or more: none is nearer
    if (Norm(Minus(apex, p)) < radius && Meet(apex, centre)) return true;
  }
  return false;
}

VerifyCheck CheckUnsplit(const io::IndexedMesh& mesh, const std::vector<Side>& sides,
                         const std::vector<Feature>& features) {
  Findings findings("unsplit");
  absl::flat_hash_map<FeatureId, std::uint32_t> vertex_of;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (mesh.vertices[v].containing_dimension == 0) vertex_of.emplace(mesh.vertices[v].owner, v);
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::pair<const Side*, std::size_t>> edges;
  ForEachEdge(sides, [&](const Side* first, std::size_t count) {
    edges[{first->a, first->b}] = {first, count};
  });
  const auto at = [&](std::uint32_t v) {
    return Kernel::Point_2(mesh.vertices[v].x, mesh.vertices[v].y);
  };
  for (const auto& [from, to] : UnsplitJoints(features)) {
    const auto p = vertex_of.find(from), q = vertex_of.find(to);
    if (p == vertex_of.end() || q == vertex_of.end()) continue;  // that points are there: input
    const auto edge = edges.find(std::minmax(p->second, q->second));
    if (edge == edges.end()) {
      findings.Add(text::Concat("points ", from, " and ", to,
                                ", of something unsplit, are joined by no edge"));
      continue;
    }
    const auto& [first, count] = edge->second;
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t apex = mesh.triangles[first[i].triangle][(first[i].k + 2U) % 3];
      if (CGAL::angle(at(p->second), at(apex), at(q->second)) != CGAL::OBTUSE) continue;
      findings.Add(text::Concat(VertexName(apex), " lies in the circle over unsplit ",
                                EdgeName(p->second, q->second)));
    }
  }
  return findings.Take();
}

}  // namespace dynmesh::cli
