// Queries of a LiveMesh: snapshot, point location, counts, audit.
#include <algorithm>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "absl/container/flat_hash_set.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/dynamic_mesh/meshed_features.h"
#include "core/geometry/predicates.h"
#include "core/geometry/space_predicates.h"
#include "core/meshing/trace_audit.h"

namespace dynmesh {
namespace {

// Is p on the side of simplex t that is opposite to corner i? Exact. REQUIRES: t contains p.
template <int D>
bool IsOnSide(const meshing::TriangulationOf<D>& triangulation, std::uint32_t t, int i,
              const geometry::Point<D>& p) {
  std::array<geometry::Point<D>, D + 1> corners;
  for (std::size_t k = 0; k <= D; ++k)
    corners[k] = triangulation.position(triangulation.vertices(t)[k]);
  corners[static_cast<std::size_t>(i)] = p;
  return std::apply([](const auto&... c) { return geometry::Orientation(c...); }, corners) == 0;
}

// The simplex whose ids are the least, in lexicographical order, among those that contain p. One of
// these is t. O(their number).
template <int D>
std::array<VertexId, D + 1> FirstOfThoseAt(const DiffBuilder<D>& mesh, std::uint32_t t,
                                           const geometry::Point<D>& p) {
  const auto& triangulation = mesh.triangulation();
  auto first = mesh.CanonicalIds(t);
  std::vector<std::uint32_t> found = {t};
  absl::flat_hash_set<std::uint32_t> seen;
  for (std::size_t next = 0; next < found.size(); ++next) {
    for (int i = 0; i <= D; ++i) {
      if (!IsOnSide<D>(triangulation, found[next], i, p)) continue;
      const std::uint32_t beside = triangulation.Opposite({found[next], i}).simplex;
      if (triangulation.IsInfinite(beside) || beside == t || !seen.insert(beside).second) continue;
      first = std::min(first, mesh.CanonicalIds(beside));
      found.push_back(beside);
    }
  }
  return first;
}

}  // namespace

template <int D>
Mesh LiveMesh<D>::Snapshot() const {
  Mesh mesh = mesh_->state->diffs.Snapshot(mesh_->state->refinement, mesh_->state->features);
  mesh.revision = this->revision();
  mesh.labels = this->labels().All();
  return mesh;
}

template <int D>
SimplexColumn LiveMesh<D>::Locate(std::span<const double> points) const {
  SimplexColumn result;
  result.reserve(points.size() / D * (D + 1));
  const auto& triangulation = mesh_->state->diffs.triangulation();
  const auto& rules = mesh_->state->refinement.complex().rules;
  meshing::VertexIndex near = 0;
  for (; points.size() >= D; points = points.subspan(D)) {
    geometry::Point<D> p;
    bool inside = true;
    for (int k = 0; k < D; ++k) {
      p[k] = points[static_cast<std::size_t>(k)];
      inside = inside && rules.lo()[k] <= p[k] && p[k] <= rules.hi()[k];
    }
    std::array<VertexId, D + 1> ids = {};
    if (inside) {
      const auto t = triangulation.Locate(p, near);
      if (!triangulation.IsInfinite(t)) {
        near = triangulation.vertices(t)[0];
        ids = FirstOfThoseAt<D>(mesh_->state->diffs, t, p);
      }
    }
    result.insert(result.end(), ids.begin(), ids.end());
  }
  return result;
}

template <int D>
MeshStats LiveMesh<D>::Stats() const {
  const MeshState<D>& s = *mesh_->state;
  MeshStats stats;
  stats.revision = this->revision();
  stats.features = mesh_->plc.size();
  stats.vertices = s.refinement.vertex_count();
  stats.simplices = s.diffs.triangulation().simplex_count();
  stats.subsegments = s.diffs.subsegment_count();
  stats.subfacets = s.diffs.subfacet_count();
  stats.operations = s.refinement.engine().operation_count();
  stats.trace_bytes = s.refinement.trace_bytes();
  stats.mesh_bytes = s.refinement.bytes() + s.diffs.bytes() + s.features.bytes() +
                     mesh_->plc.bytes() + this->labels().bytes();
  return stats;
}

template <int D>
AuditReport LiveMesh<D>::Audit() const {
  AuditReport report;
  const std::uint64_t trace = meshing::Audit(mesh_->state->refinement, &report.problems);
  report.trace = {trace, mesh_->state->refinement.engine().operation_count()};
  std::string why;
  if (!mesh_->state->diffs.triangulation().Check(&why))
    report.problems.emplace_back("mesh: " + why);
  if (!mesh_->state->diffs.CheckLabels()) {
    report.problems.emplace_back("regions of neighbours do not agree with the edges between them");
  }
  const Mesh mesh = Snapshot();
  if (!(ComputeHash(mesh) == mesh.hash)) {
    report.problems.emplace_back("the hash kept is not that of the mesh");
  }
  if (mesh.vertices.size() != mesh_->state->diffs.triangulation().vertex_count()) {
    report.problems.emplace_back("the triangulation's vertices are not those present");
  }
  return report;
}

template <int D>
std::string LiveMesh<D>::FirstDifference(const LiveMesh& other) const {
  std::vector<std::string> problems;
  std::vector<meshing::OperationHash> ours, theirs;
  meshing::Audit(mesh_->state->refinement, &problems, &ours);
  meshing::Audit(other.mesh_->state->refinement, &problems, &theirs);
  std::size_t i = 0;
  const std::size_t shared = std::min(ours.size(), theirs.size());
  while (i < shared && ours[i].identity == theirs[i].identity && ours[i].whole == theirs[i].whole) {
    ++i;
  }
  if (i == ours.size() && i == theirs.size()) return "";
  const auto describe = [i](const auto& refinement, const auto& operations) {
    return i < operations.size() ? meshing::Describe(refinement, operations[i].op) : "no operation";
  };
  return "operation " + std::to_string(i) +
         "\n  here:  " + describe(mesh_->state->refinement, ours) +
         "\n  there: " + describe(other.mesh_->state->refinement, theirs);
}

template <int D>
std::string LiveMesh<D>::FirstUnreproduced() const {
  return meshing::FirstUnreproduced(mesh_->state->refinement);
}

template Mesh LiveMesh<2>::Snapshot() const;
template Mesh LiveMesh<3>::Snapshot() const;
template SimplexColumn LiveMesh<2>::Locate(std::span<const double>) const;
template SimplexColumn LiveMesh<3>::Locate(std::span<const double>) const;
template MeshStats LiveMesh<2>::Stats() const;
template MeshStats LiveMesh<3>::Stats() const;
template AuditReport LiveMesh<2>::Audit() const;
template AuditReport LiveMesh<3>::Audit() const;
template std::string LiveMesh<2>::FirstDifference(const LiveMesh& other) const;
template std::string LiveMesh<3>::FirstDifference(const LiveMesh& other) const;
template std::string LiveMesh<2>::FirstUnreproduced() const;
template std::string LiveMesh<3>::FirstUnreproduced() const;

}  // namespace dynmesh
