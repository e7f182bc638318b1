// Checks the input of a part of a mesh: what of it lies in the part is there.
//
// The border of a part need not be the input's, so a joint may be there wholly, not at all, or in
// pieces. It is followed along edges with its marker, from both ends. Where the edges end, the rest
// of the joint must lead out of the part.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/verify/containment.h"
#include "client/verify/simplex_boxes.h"
#include "client/verify/vectors.h"
#include "client/verify/verify_internal.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

using text::Concat;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

class PartInputCheck {
 public:
  PartInputCheck(const io::IndexedMesh& mesh, const std::vector<Feature>& features)
      : mesh_(mesh), features_(features), tolerance_(kStraightnessUlps * LargestUlp(mesh)) {
    for (const Feature& f : features) {
      if (IsPoint(f)) points_.emplace(f.id, &f);
    }
  }

  VerifyCheck Run(bool has_edges) {
    CheckPoints();
    FindMissingPoints();
    if (has_edges) CheckJoints();
    return findings_.Take();
  }

 private:
  struct Arm {
    std::uint32_t to = 0;
    std::uint32_t edge = 0;  // an index of mesh_.edges
  };

  // Points of the part lie where the input has them.
  void CheckPoints() {
    for (std::uint32_t v = 0; v < mesh_.vertices.size(); ++v) {
      const auto& vertex = mesh_.vertices[v];
      if (vertex.containing_dimension != 0 || vertex.owner == kBoxFeature) continue;
      const auto point = points_.find(vertex.owner);
      if (point == points_.end()) {
        findings_.Add(
            Concat(VertexName(v), " has the marker ", vertex.owner, ", which is no point"));
        continue;
      }
      const std::array<double, 3>& at = point->second->position;
      if (at[0] != vertex.x || at[1] != vertex.y || (mesh_.dimension == 3 && at[2] != vertex.z)) {
        findings_.Add(Concat(VertexName(v), " is not at point ", vertex.owner));
      } else {
        vertex_of_.emplace(vertex.owner, v);
      }
    }
  }

  // An input point that lies in a simplex is one of its corners.
  void FindMissingPoints() {
    absl::flat_hash_set<PositionKey> there;
    for (const auto& vertex : mesh_.vertices) {
      there.insert(PositionKeyOf(vertex.position(), mesh_.dimension));
    }
    std::vector<const Feature*> elsewhere;
    for (const Feature& f : features_) {
      if (IsPoint(f) && !there.contains(PositionKeyOf(f.position, mesh_.dimension))) {
        elsewhere.push_back(&f);
      }
    }
    if (elsewhere.empty()) return;
    std::vector<Box3> places;
    for (const Feature* f : elsewhere) places.push_back({f->position, f->position});
    const boxes::BoxTree<3> points(std::move(places));
    std::set<std::uint32_t> missing;
    ForEachSimplex(mesh_, [&](const auto& simplex) {
      points.ForEachMeeting(BoxOf(mesh_, simplex), [&](std::uint32_t i) {
        if (Contains(mesh_, simplex, elsewhere[i]->position)) missing.insert(i);
      });
    });
    for (const std::uint32_t i : missing) {
      findings_.Add(
          Concat("point ", elsewhere[i]->id, " of the input is in the part, and no vertex"));
    }
  }

  void CheckJoints() {
    for (std::uint32_t e = 0; e < mesh_.edges.size(); ++e) {
      const auto& edge = mesh_.edges[e];
      if (edge.owner == kNoFeature || edge.owner == kBoxFeature) continue;
      arms_[{edge.owner, edge.a}].push_back({edge.b, e});
      arms_[{edge.owner, edge.b}].push_back({edge.a, e});
    }
    used_.assign(mesh_.edges.size(), false);
    std::map<FeatureId, std::vector<Joint>> joints_of;  // by owner
    for (const Joint& joint : JointsOf(features_)) {
      joints_of[joint.feature->id].push_back(joint);
      Follow(joint);
    }
    for (std::uint32_t e = 0; e < mesh_.edges.size(); ++e) {
      const auto& edge = mesh_.edges[e];
      if (edge.owner == kNoFeature || edge.owner == kBoxFeature || used_[e]) continue;
      const auto joints = joints_of.find(edge.owner);
      if (joints == joints_of.end()) {
        findings_.Add(Concat(EdgeName(edge.a, edge.b), " has the marker ", edge.owner,
                             ", which is no input segment and no polygon's"));
      } else if (std::ranges::none_of(joints->second,
                                      [&](const Joint& joint) { return IsOn(edge, joint); })) {
        findings_.Add(Concat(EdgeName(edge.a, edge.b), " has the marker ", edge.owner,
                             ", but is on nothing that this feature joins"));
      }
    }
  }

  // How a joint that is followed from one end goes on.
  enum class Course { kWhole, kLeavesPart, kMissing };

  void Follow(const Joint& joint) {
    const auto p = points_.find(joint.from), q = points_.find(joint.to);
    if (p == points_.end() || q == points_.end()) return;  // no mesh was made of that
    const auto from = vertex_of_.find(joint.from), to = vertex_of_.find(joint.to);
    std::optional<std::uint32_t> end;
    if (to != vertex_of_.end()) end = to->second;
    if (from != vertex_of_.end() &&
        Walk(joint, from->second, Line(*p->second, *q->second, mesh_.dimension), end) !=
            Course::kLeavesPart) {
      return;
    }
    if (end) Walk(joint, *end, Line(*q->second, *p->second, mesh_.dimension), std::nullopt);
  }

  // From one end of a joint to the other.
  struct Line {
    Line(const Feature& p, const Feature& q, int dimension)
        : from(p.position[0], p.position[1], dimension == 3 ? p.position[2] : 0),
          to(q.position[0], q.position[1], dimension == 3 ? q.position[2] : 0) {
      for (int k = 0; k < 3; ++k) along[static_cast<std::size_t>(k)] = Real{to[k]} - from[k];
      length = std::hypot(along[0], along[1], along[2]);
    }
    Kernel::Point_3 from, to;
    Vector along;
    Real length;
  };

  // From vertex `start`, at the line's beginning.
  Course Walk(const Joint& joint, std::uint32_t start, const Line& line,
              std::optional<std::uint32_t> end) {
    std::uint32_t v = start;
    while (const Arm* const next = NextOn(line, joint.feature->id, v)) {
      used_[next->edge] = true;
      v = next->to;
      if (end && v == *end) return Course::kWhole;
    }
    if (!LeadsIn(line, v)) return Course::kLeavesPart;
    findings_.Add(Concat("edge ", joint.from, " - ", joint.to, " of input feature ",
                         joint.feature->id, " has no edge with its marker from ", VertexName(v),
                         " on, in the part"));
    return Course::kMissing;
  }

  Kernel::Point_3 At(std::uint32_t v) const {
    const auto& p = mesh_.vertices[v];
    return {p.x, p.y, mesh_.dimension == 3 ? p.z : 0};
  }

  Real DistanceFrom(const Line& line, std::uint32_t v) const {
    const Kernel::Point_3 at = At(v);
    Vector d;
    for (int k = 0; k < 3; ++k) d[static_cast<std::size_t>(k)] = Real{at[k]} - line.from[k];
    const Vector& a = line.along;
    return std::hypot(a[1] * d[2] - a[2] * d[1], a[2] * d[0] - a[0] * d[2],
                      a[0] * d[1] - a[1] * d[0]) /
           line.length;
  }

  // Forward exactly, on the line but for rounding, and not beyond its end.
  bool IsStep(const Line& line, std::uint32_t v, std::uint32_t w) const {
    return CGAL::angle(line.from, line.to, At(v), At(w)) == CGAL::ACUTE &&
           (At(w) == line.to || CGAL::angle(line.from, line.to, At(w), line.to) == CGAL::ACUTE) &&
           DistanceFrom(line, w) <= tolerance_;
  }

  const Arm* NextOn(const Line& line, FeatureId owner, std::uint32_t v) const {
    const auto arms = arms_.find({owner, v});
    if (arms == arms_.end()) return nullptr;
    const Arm* best = nullptr;
    for (const Arm& arm : arms->second) {
      if (used_[arm.edge] || !IsStep(line, v, arm.to)) continue;
      if (best == nullptr || DistanceFrom(line, arm.to) < DistanceFrom(line, best->to)) best = &arm;
    }
    return best;
  }

  bool IsOn(const io::IndexedMesh::Edge& edge, const Joint& joint) const {
    const auto p = points_.find(joint.from), q = points_.find(joint.to);
    if (p == points_.end() || q == points_.end()) return false;
    const Line line(*p->second, *q->second, mesh_.dimension);
    const bool forward = CGAL::angle(line.from, line.to, At(edge.a), At(edge.b)) == CGAL::ACUTE;
    const std::uint32_t v = forward ? edge.a : edge.b, w = forward ? edge.b : edge.a;
    return IsStep(line, v, w) && DistanceFrom(line, v) <= tolerance_ &&
           (At(v) == line.from || CGAL::angle(line.from, line.to, line.from, At(v)) == CGAL::ACUTE);
  }

  // Is the line beyond v in a simplex of the part, by more than rounding? An edge along it without
  // any marker counts.
  bool LeadsIn(const Line& line, std::uint32_t v) {
    CollectSimplices();
    for (std::uint32_t i = first_at_[v]; i < first_at_[v + 1]; ++i) {
      const std::uint32_t s = simplices_at_[i];
      if (mesh_.dimension == 2) {
        if (LeadsInto(line, v, mesh_.triangles[s])) return true;
      } else if (LeadsInto(line, v, mesh_.tetrahedra[s])) {
        return true;
      }
    }
    return false;
  }

  template <std::size_t N>
  bool LeadsInto(const Line& line, std::uint32_t v, const std::array<std::uint32_t, N>& simplex) {
    std::vector<std::uint32_t> others;
    for (const std::uint32_t corner : simplex) {
      if (corner == v) continue;
      others.push_back(corner);
      if (IsStep(line, v, corner)) return !IsMarked(v, corner);
    }
    // The end of the line is on the same side of each side at v as the opposite corner.
    for (std::size_t i = 0; i < others.size(); ++i) {
      const std::uint32_t b = others[(i + 1) % others.size()];
      CGAL::Orientation here, wanted;
      if constexpr (N == 3) {
        const auto flat = [](const Kernel::Point_3& p) { return Kernel::Point_2(p.x(), p.y()); };
        here = CGAL::orientation(flat(At(v)), flat(At(b)), flat(line.to));
        wanted = CGAL::orientation(flat(At(v)), flat(At(b)), flat(At(others[i])));
        if (DistanceFrom(line, b) <= tolerance_) return false;
      } else {
        const std::uint32_t c = others[(i + 2) % others.size()];
        here = CGAL::orientation(At(v), At(b), At(c), line.to);
        wanted = CGAL::orientation(At(v), At(b), At(c), At(others[i]));
      }
      if (here == CGAL::ZERO || here != wanted) return false;
    }
    return true;
  }

  bool IsMarked(std::uint32_t a, std::uint32_t b) {
    if (marked_.empty()) {
      for (const auto& edge : mesh_.edges) {
        if (edge.owner != kNoFeature) marked_.insert(std::minmax(edge.a, edge.b));
      }
    }
    return marked_.contains(std::minmax(a, b));
  }

  void CollectSimplices() {
    if (!first_at_.empty()) return;
    first_at_.assign(mesh_.vertices.size() + 2, 0);
    ForEachSimplex(mesh_, [&](const auto& simplex) {
      for (const std::uint32_t v : simplex) ++first_at_[v + 2];
    });
    for (std::size_t v = 2; v < first_at_.size(); ++v) first_at_[v] += first_at_[v - 1];
    simplices_at_.resize(first_at_.back());
    std::uint32_t s = 0;
    ForEachSimplex(mesh_, [&](const auto& simplex) {
      for (const std::uint32_t v : simplex) simplices_at_[first_at_[v + 1]++] = s;
      ++s;
    });
  }

  const io::IndexedMesh& mesh_;
  const std::vector<Feature>& features_;
  const double tolerance_;
  absl::flat_hash_map<FeatureId, const Feature*> points_;
  absl::flat_hash_map<FeatureId, std::uint32_t> vertex_of_;  // points of the part
  absl::flat_hash_map<std::pair<FeatureId, std::uint32_t>, std::vector<Arm>> arms_;
  std::vector<bool> used_;                              // by edge: it is on a joint
  std::vector<std::uint32_t> first_at_, simplices_at_;  // simplices by vertex
  std::set<std::pair<std::uint32_t, std::uint32_t>> marked_;
  Findings findings_{"input"};
};

}  // namespace

VerifyCheck CheckPartInput(const io::IndexedMesh& mesh, const std::vector<Feature>& features,
                           bool has_edges) {
  return PartInputCheck(mesh, features).Run(has_edges);
}

}  // namespace dynmesh::cli
