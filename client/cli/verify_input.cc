// Is the input in the mesh, and nothing in the mesh that is not in the input?
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cli/verify_internal.h"
#include "core/data/text.h"

namespace dynmesh::cli {
namespace {

using data::Concat;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Place = std::pair<std::uint64_t, std::uint64_t>;

// Vertices that refinement puts on a segment are rounded to the grid of doubles; each
// may inherit the roundings of those it was placed between.
constexpr double kStraightnessUlps = 16;

Place PlaceOf(double x, double y) {
  return {std::bit_cast<std::uint64_t>(x + 0.0), std::bit_cast<std::uint64_t>(y + 0.0)};
}

class InputCheck {
 public:
  InputCheck(const io::IndexedMesh& mesh, const std::vector<Feature>& features)
      : mesh_(mesh), features_(features), tolerance_(kStraightnessUlps * LargestUlp(mesh)) {
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
      vertex_at_.emplace(PlaceOf(mesh.vertices[v].x, mesh.vertices[v].y), v);
    }
    for (const auto& e : mesh.edges) {
      if (e.owner != kNoFeature && e.owner != kBoxFeature) edges_of_[e.owner].push_back(e);
    }
    for (const Feature& f : features) {
      if (f.kind == FeatureKind::kPoint) points_.emplace(f.id, &f);
    }
  }

  VerifyCheck Run() {
    for (const Feature& f : features_) {
      if (f.kind == FeatureKind::kPoint) CheckPoint(f);
    }
    for (const Feature& f : features_) {
      if (f.kind == FeatureKind::kSegment) CheckSegment(f);
    }
    CheckNoOther();
    return findings_.Take();
  }

 private:
  std::optional<std::uint32_t> VertexOf(const Feature& point) const {
    const auto it = vertex_at_.find(PlaceOf(point.position[0], point.position[1]));
    if (it == vertex_at_.end()) return std::nullopt;
    return it->second;
  }

  void CheckPoint(const Feature& f) {
    const std::optional<std::uint32_t> v = VertexOf(f);
    if (!v) {
      findings_.Add(Concat("input point ", f.id, " is no vertex"));
      return;
    }
    const auto& vertex = mesh_.vertices[*v];
    if (vertex.containing_dimension != 0 || vertex.owner != f.id) {
      findings_.Add(Concat("input point ", f.id, " is ", VertexName(*v),
                           ", which does not carry it as marker"));
    }
  }

  void CheckSegment(const Feature& f) {
    const auto p = points_.find(f.ends[0]);
    const auto q = points_.find(f.ends[1]);
    if (p == points_.end() || q == points_.end()) {
      findings_.Add(Concat("input segment ", f.id, " has an end that is no input point"));
      return;
    }
    const std::optional<std::uint32_t> from = VertexOf(*p->second);
    const std::optional<std::uint32_t> to = VertexOf(*q->second);
    if (!from || !to) return;  // said already
    const std::vector<std::uint32_t> chain = FollowChain(f.id, *from, *to);
    if (chain.empty()) {
      findings_.Add(Concat("input segment ", f.id, " is no chain of edges with its marker"));
    } else if (!IsStraight(chain)) {
      findings_.Add(Concat("input segment ", f.id, " is a chain that is not straight"));
    }
  }

  // The vertices from one end to the other, through every edge with the marker; empty
  // if they do not form such a path.
  std::vector<std::uint32_t> FollowChain(FeatureId id, std::uint32_t from, std::uint32_t to) {
    used_.insert(id);
    const auto it = edges_of_.find(id);
    if (it == edges_of_.end()) return {};
    const std::vector<io::IndexedMesh::Edge>& edges = it->second;
    std::multimap<std::uint32_t, std::uint32_t> next;
    for (const auto& e : edges) {
      next.emplace(e.a, e.b);
      next.emplace(e.b, e.a);
    }
    std::vector<std::uint32_t> chain = {from};
    while (chain.back() != to && chain.size() <= edges.size()) {
      const std::uint32_t here = chain.back();
      const auto [begin, end] = next.equal_range(here);
      std::optional<std::uint32_t> step;
      for (auto n = begin; n != end; ++n) {
        if (chain.size() > 1 && n->second == chain[chain.size() - 2]) continue;
        if (step) return {};  // branches
        step = n->second;
      }
      if (!step) return {};
      chain.push_back(*step);
    }
    if (chain.back() != to || chain.size() != edges.size() + 1) return {};
    return chain;
  }

  Kernel::Point_2 At(std::uint32_t v) const { return {mesh_.vertices[v].x, mesh_.vertices[v].y}; }

  // Every step goes forward (exactly), no vertex is off the line by more than rounding.
  bool IsStraight(const std::vector<std::uint32_t>& chain) const {
    const auto& p = mesh_.vertices[chain.front()];
    const auto& q = mesh_.vertices[chain.back()];
    const long double dx = static_cast<long double>(q.x) - p.x;
    const long double dy = static_cast<long double>(q.y) - p.y;
    const long double length = std::hypot(dx, dy);
    for (std::size_t i = 1; i < chain.size(); ++i) {
      if (CGAL::angle(At(chain.front()), At(chain.back()), At(chain[i - 1]), At(chain[i])) !=
          CGAL::ACUTE) {
        return false;
      }
      const auto& v = mesh_.vertices[chain[i]];
      const long double off = (dx * (v.y - static_cast<long double>(p.y)) -
                               dy * (v.x - static_cast<long double>(p.x))) /
                              length;
      if (!(std::abs(off) <= tolerance_)) return false;
    }
    return true;
  }

  void CheckNoOther() {
    for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
      const auto& vertex = mesh_.vertices[v];
      if (vertex.containing_dimension != 0 || vertex.owner == kBoxFeature) continue;
      const auto it = points_.find(vertex.owner);
      if (it == points_.end()) {
        findings_.Add(
            Concat(VertexName(v), " has the marker ", vertex.owner, ", which is no input point"));
      } else if (VertexOf(*it->second) != v) {
        findings_.Add(Concat(VertexName(v), " has the marker ", vertex.owner,
                             ", but that point is elsewhere"));
      }
    }
    for (const auto& [id, edges] : edges_of_) {
      if (used_.contains(id)) continue;
      findings_.Add(Concat(EdgeName(edges.front().a, edges.front().b), " has the marker ", id,
                           ", which is no input segment"));
    }
  }

  const io::IndexedMesh& mesh_;
  const std::vector<Feature>& features_;
  const double tolerance_;
  absl::flat_hash_map<Place, std::uint32_t> vertex_at_;
  std::map<FeatureId, std::vector<io::IndexedMesh::Edge>> edges_of_;
  std::set<FeatureId> used_;
  absl::flat_hash_map<FeatureId, const Feature*> points_;
  Findings findings_{"input"};
};

}  // namespace

VerifyCheck CheckInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features) {
  return InputCheck(mesh, features).Run();
}

}  // namespace dynmesh::cli
