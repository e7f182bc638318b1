#include "client/cleaning/seed_faces.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <optional>
#include <set>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/polygon_rings.h"
#include "core/base/feature_kinds.h"
#include "core/base/ring_walk.h"

namespace dynmesh::cleaning {
namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Exact = Kernel::Point_2;
using Half = std::uint32_t;    // of segment e: 2 e from its lesser vertex, 2 e + 1 the opposite
using Vertex = std::uint32_t;  // numbered in the order of the features
using Cycle = std::uint32_t;   // a closed chain of half-edges with a common face on the left

Half Twin(Half h) { return h ^ 1U; }

class Faces {
 public:
  explicit Faces(const std::vector<Feature>& features) {
    Enter(features);
    TraceCycles();
    FindParts();
  }

  // The segment that contains the point.
  FeatureId SegmentAt(const Exact& at) const {
    for (std::size_t e = 0; e < segments_.size(); ++e) {
      const Exact &p = points_[from_[2 * e]], &q = points_[from_[2 * e + 1]];
      if (CGAL::collinear(p, q, at) && CGAL::collinear_are_ordered_along_line(p, at, q)) {
        return segments_[e];
      }
    }
    return kNoFeature;
  }

  // The outer boundary cycle of the point's face; none in the unbounded face.
  std::optional<Cycle> CycleAround(const Exact& at) const {
    const std::vector<std::uint32_t> parts = PartsAround(at);
    if (parts.empty()) return std::nullopt;
    // Parts around one point are nested.
    const std::uint32_t innermost =
        *std::max_element(parts.begin(), parts.end(),
                          [&](std::uint32_t p, std::uint32_t q) { return depth_[p] < depth_[q]; });
    std::set<Cycle> odd;
    for (const Half h : halves_of_[innermost]) {
      if (cycle_[h] != outer_[innermost] && cycle_[h] != cycle_[Twin(h)] && CrossesRay(h, at)) {
        Toggle(odd, cycle_[h]);
      }
    }
    // None only if segments cross.
    return odd.empty() ? std::nullopt : std::optional(*odd.begin());
  }

  // The boundary of the face inside `cycle`.
  Rings Boundary(Cycle cycle) const {
    std::vector<Half> sides = OneSided(cycle);
    const std::uint32_t part = part_of_cycle_[cycle];
    for (std::uint32_t p = 0; p < outer_.size(); ++p) {
      // A direct hole: one level deeper, and not in another face of this part.
      if (depth_[p] != depth_[part] + 1 || !IsIn(cycle, points_[least_[p]])) continue;
      const std::vector<Half> hole = OneSided(outer_[p]);
      sides.insert(sides.end(), hole.begin(), hole.end());
    }
    return CutIntoRings(std::move(sides));
  }

 private:
  template <class T>
  static void Toggle(std::set<T>& set, T value) {
    if (!set.insert(value).second) set.erase(value);
  }

  void Enter(const std::vector<Feature>& features) {
    absl::flat_hash_map<FeatureId, const Feature*> points;
    for (const Feature& f : features) {
      if (IsPoint(f)) points.emplace(f.id, &f);
    }
    absl::flat_hash_map<FeatureId, Vertex> number;
    std::set<std::pair<Vertex, Vertex>> joined;
    for (const Feature& f : features) {
      if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>) || f.ends[0] == f.ends[1]) continue;
      if (!points.contains(f.ends[0]) || !points.contains(f.ends[1])) continue;
      Vertex v[2];
      for (std::size_t i = 0; i < 2; ++i) {
        const Feature& p = *points.at(f.ends[i]);
        const auto [it, fresh] = number.try_emplace(p.id, static_cast<Vertex>(ids_.size()));
        v[i] = it->second;
        if (!fresh) continue;
        ids_.push_back(p.id);
        points_.emplace_back(p.position[0], p.position[1]);
      }
      if (points_[v[0]] == points_[v[1]] || !joined.insert(std::minmax(v[0], v[1])).second)
        continue;
      segments_.push_back(f.id);
      from_.insert(from_.end(), {std::min(v[0], v[1]), std::max(v[0], v[1])});
    }
  }

  // Counter-clockwise, beginning after straight down.
  bool TurnsBefore(Half g, Half h) const {
    const Exact &at = points_[from_[g]], &p = points_[from_[Twin(g)]], &q = points_[from_[Twin(h)]];
    const bool left_p = p < at, left_q = q < at;  // lexicographically
    if (left_p != left_q) return left_q;
    const CGAL::Orientation turn = CGAL::orientation(at, p, q);
    return turn == CGAL::COLLINEAR ? g < h : turn == CGAL::LEFT_TURN;
  }

  void TraceCycles() {
    around_.resize(points_.size());
    for (Half h = 0; h < from_.size(); ++h) around_[from_[h]].push_back(h);
    std::vector<Half> before(from_.size());  // the clockwise predecessor around its start
    for (std::vector<Half>& halves : around_) {
      std::sort(halves.begin(), halves.end(), [&](Half g, Half h) { return TurnsBefore(g, h); });
      for (std::size_t i = 0; i < halves.size(); ++i) {
        before[halves[i]] = halves[(i + halves.size() - 1) % halves.size()];
      }
    }
    constexpr Cycle kNone = ~Cycle{0};
    cycle_.assign(from_.size(), kNone);
    for (Half start = 0; start < from_.size(); ++start) {
      if (cycle_[start] != kNone) continue;
      const auto cycle = static_cast<Cycle>(halves_in_.size());
      halves_in_.emplace_back();
      for (Half h = start; cycle_[h] == kNone; h = before[Twin(h)]) {
        cycle_[h] = cycle;
        halves_in_.back().push_back(h);
      }
    }
  }

  // Connected parts, their outer cycles, and the number of other parts around each.
  void FindParts() {
    std::vector<std::uint32_t> part(points_.size(), 0);
    std::vector<bool> seen(points_.size(), false);
    part_of_cycle_.resize(halves_in_.size());
    for (Vertex v = 0; v < points_.size(); ++v) {
      if (seen[v] || around_[v].empty()) continue;
      const auto p = static_cast<std::uint32_t>(least_.size());
      least_.push_back(v);
      halves_of_.emplace_back();
      std::vector<Vertex> open = {v};
      seen[v] = true;
      while (!open.empty()) {
        const Vertex at = open.back();
        open.pop_back();
        if (points_[at] < points_[least_[p]]) least_[p] = at;
        for (const Half h : around_[at]) {
          halves_of_[p].push_back(h);
          part_of_cycle_[cycle_[h]] = p;
          const Vertex next = from_[Twin(h)];
          if (!seen[next]) open.push_back(next);
          seen[next] = true;
        }
      }
      // All half-edges at the leftmost point go right; left of the last one is the outside.
      outer_.push_back(cycle_[around_[least_[p]].back()]);
    }
    for (std::uint32_t p = 0; p < least_.size(); ++p) {
      depth_.push_back(static_cast<int>(PartsAround(points_[least_[p]], p).size()));
    }
  }

  // True if a ray from the point to the right crosses the edge. An edge includes its lower end
  // only.
  bool CrossesRay(Half h, const Exact& at) const {
    const Exact &p = points_[from_[h]], &q = points_[from_[Twin(h)]];
    if ((p.y() > at.y()) == (q.y() > at.y())) return false;
    if (p.x() < at.x() && q.x() < at.x()) return false;
    if (p.x() > at.x() && q.x() > at.x()) return true;
    return CGAL::orientation(p.y() < q.y() ? p : q, p.y() < q.y() ? q : p, at) == CGAL::LEFT_TURN;
  }

  bool IsIn(Cycle cycle, const Exact& at) const {
    bool in = false;
    for (const Half h : halves_in_[cycle]) {
      if (cycle_[Twin(h)] != cycle && CrossesRay(h, at)) in = !in;
    }
    return in;
  }

  std::vector<std::uint32_t> PartsAround(const Exact& at,
                                         std::optional<std::uint32_t> but = {}) const {
    std::vector<std::uint32_t> parts;
    for (std::uint32_t p = 0; p < outer_.size(); ++p) {
      if (p != but && IsIn(outer_[p], at)) parts.push_back(p);
    }
    return parts;
  }

  std::vector<Half> OneSided(Cycle cycle) const {
    std::vector<Half> sides;
    for (const Half h : halves_in_[cycle]) {
      if (cycle_[Twin(h)] != cycle) sides.push_back(h);
    }
    return sides;
  }

  // In each point as many half-edges end as begin, so each walk is closed.
  Rings CutIntoRings(std::vector<Half> sides) const {
    std::sort(sides.begin(), sides.end());
    absl::flat_hash_map<Vertex, std::vector<Half>> leaving;
    for (auto h = sides.rbegin(); h != sides.rend(); ++h) leaving[from_[*h]].push_back(*h);
    const auto step = [&](Vertex v) -> std::optional<Vertex> {
      std::vector<Half>& halves = leaving[v];
      if (halves.empty()) return std::nullopt;
      const Half h = halves.back();
      halves.pop_back();
      return from_[Twin(h)];
    };
    std::vector<std::vector<Vertex>> loops;
    for (const Half start : sides) WalkRings(from_[start], step, loops);
    Rings rings;
    for (std::vector<Vertex>& loop : loops) {
      std::rotate(loop.begin(), std::min_element(loop.begin(), loop.end()), loop.end());
      std::vector<FeatureId>& ring = rings.emplace_back();
      for (const Vertex v : loop) ring.push_back(ids_[v]);
    }
    return rings;
  }

  std::vector<FeatureId> ids_;  // of vertices
  std::vector<Exact> points_;
  std::vector<FeatureId> segments_;
  std::vector<Vertex> from_;               // start vertex of a half-edge
  std::vector<std::vector<Half>> around_;  // half-edges from a vertex, counter-clockwise
  std::vector<Cycle> cycle_;               // of half-edges
  std::vector<std::vector<Half>> halves_in_;
  std::vector<std::uint32_t> part_of_cycle_;
  // By connected part.
  std::vector<std::vector<Half>> halves_of_;
  std::vector<Vertex> least_;  // the leftmost point, the lowest one of several
  std::vector<Cycle> outer_;
  std::vector<int> depth_;
};

}  // namespace

std::vector<SeedFace> FindSeedFaces(const std::vector<Feature>& features,
                                    std::span<const Point> seeds) {
  std::vector<SeedFace> result(seeds.size());
  if (seeds.empty()) return result;
  const Faces faces(features);
  absl::flat_hash_map<Cycle, std::size_t> first;  // first seed in a face
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    const Exact at(seeds[i][0], seeds[i][1]);
    result[i].on = faces.SegmentAt(at);
    if (result[i].on != kNoFeature) continue;
    const std::optional<Cycle> cycle = faces.CycleAround(at);
    if (!cycle) continue;
    const auto [it, fresh] = first.emplace(*cycle, i);
    if (fresh) {
      result[i].rings = faces.Boundary(*cycle);
    } else {
      result[i].same_as = it->second;
    }
  }
  return result;
}

}  // namespace dynmesh::cleaning
