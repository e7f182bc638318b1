#include "client/preparation/open_loops.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/hole_triangulation.h"
#include "client/cleaning/vectors3.h"
#include "client/preparation/open_edges.h"
#include "client/preparation/positions.h"
#include "core/base/feature_kinds.h"

namespace dynmesh::preparation {
namespace {

using cleaning::Point3;

// Of the extent: corners are nearer than this to the plane of a loop that becomes one polygon. A
// mesh allows ten times as much.
constexpr double kFlat = 1e-10;

// The graph of the open edges. Corners and edges are in the order of their coordinates.
class EdgeGraph {
 public:
  EdgeGraph(const std::vector<OpenEdge>& open, const Positions& at) {
    for (const OpenEdge& edge : open) ids_.insert(ids_.end(), {edge.p, edge.q});
    const auto by_place = [&](FeatureId a, FeatureId b) {
      return std::pair(at.at(a), a) < std::pair(at.at(b), b);
    };
    std::ranges::sort(ids_, by_place);
    ids_.erase(std::ranges::unique(ids_).begin(), ids_.end());
    absl::flat_hash_map<FeatureId, std::size_t> index;
    for (std::size_t i = 0; i < ids_.size(); ++i) index[ids_[i]] = i;
    edges_.resize(ids_.size());
    for (const OpenEdge& edge : open) {
      const std::size_t p = index.at(edge.p), q = index.at(edge.q);
      edges_[p].push_back(q);
      edges_[q].push_back(p);
    }
    for (std::vector<std::size_t>& others : edges_) std::ranges::sort(others, std::greater<>());
  }

  // Takes all edges; calls f(corners) for each loop.
  template <class F>
  void TakeLoops(const F& f) {
    std::vector<bool> is_on_path(ids_.size());
    for (std::size_t start = 0; start < ids_.size(); ++start) {
      std::vector<std::size_t> path = {start};
      is_on_path[start] = true;
      while (!path.empty()) {
        const std::optional<std::size_t> next = TakeEdge(path.back());
        if (!next) {
          // The end of a chain that is no loop, or of what begins at `start`.
          is_on_path[path.back()] = false;
          path.pop_back();
        } else if (!is_on_path[*next]) {
          is_on_path[*next] = true;
          path.push_back(*next);
        } else {
          const auto begin = std::ranges::find(path, *next);
          std::vector<FeatureId> corners;
          for (auto it = begin; it != path.end(); ++it) corners.push_back(ids_[*it]);
          for (auto it = begin + 1; it != path.end(); ++it) is_on_path[*it] = false;
          path.erase(begin + 1, path.end());
          f(std::move(corners));
        }
      }
    }
  }

 private:
  // The first edge at `corner` that is left: its other end.
  std::optional<std::size_t> TakeEdge(std::size_t corner) {
    if (edges_[corner].empty()) return std::nullopt;
    const std::size_t next = edges_[corner].back();
    edges_[corner].pop_back();
    std::erase(edges_[next], corner);
    return next;
  }

  std::vector<FeatureId> ids_;
  std::vector<std::vector<std::size_t>> edges_;  // by corner; descending
};

std::vector<Point3> ChainOf(const OpenLoop& loop, const Positions& at) {
  std::vector<Point3> chain;
  for (const FeatureId id : loop.corners) chain.push_back(at.at(id));
  return chain;
}

bool AreInOnePlane(const std::vector<Point3>& chain) {
  Point3 normal = {};
  double extent = 0;
  for (std::size_t i = 0; i + 1 < chain.size(); ++i) {
    const Point3 part = cleaning::NormalOf(chain[0], chain[i], chain[i + 1]);
    for (std::size_t k = 0; k < 3; ++k) normal[k] += part[k];
    extent = std::max(extent, cleaning::SquaredDistance<3>(chain[0], chain[i]));
  }
  const double most = kFlat * std::sqrt(extent * cleaning::Dot(normal, normal));
  return most > 0 && std::ranges::all_of(chain, [&](const Point3& p) {
           return std::abs(cleaning::Dot(normal, cleaning::Minus(p, chain[0]))) <= most;
         });
}

// The triangles among the polygons, at each of their corners.
class TrianglesAt {
 public:
  explicit TrianglesAt(const std::vector<Feature>& features) {
    for (const Feature& f : features) {
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      const auto& ring = f.rings.front();
      if (f.rings.size() != 1 || ring.size() != 3) continue;
      for (const FeatureId id : ring) at_[id].push_back({ring[0], ring[1], ring[2]});
    }
  }

  // Those with all corners on the loop, as ascending indices of its corners.
  std::vector<std::array<std::size_t, 3>> On(const OpenLoop& loop) const {
    absl::flat_hash_map<FeatureId, std::size_t> index;
    for (std::size_t i = 0; i < loop.corners.size(); ++i) index[loop.corners[i]] = i;
    std::vector<std::array<std::size_t, 3>> found;
    for (const FeatureId id : loop.corners) {
      for (const auto& [a, b, c] : At(id)) {
        const auto i = index.find(a), j = index.find(b), k = index.find(c);
        if (i == index.end() || j == index.end() || k == index.end()) continue;
        found.push_back({i->second, j->second, k->second});
        std::ranges::sort(found.back());
      }
    }
    std::ranges::sort(found);
    found.erase(std::ranges::unique(found).begin(), found.end());
    return found;
  }

 private:
  using Triangles = std::vector<std::array<FeatureId, 3>>;

  const Triangles& At(FeatureId id) const {
    static const Triangles kNone;
    const auto it = at_.find(id);
    return it == at_.end() ? kNone : it->second;
  }

  absl::flat_hash_map<FeatureId, Triangles> at_;
};

}  // namespace

std::vector<OpenLoop> OpenLoopsOf(const std::vector<Feature>& features) {
  const std::vector<OpenEdge> open = OpenEdgesOf(features);
  if (open.empty()) return {};
  const Positions at = PositionsOf(features);
  std::vector<OpenLoop> loops;
  EdgeGraph(open, at).TakeLoops([&](std::vector<FeatureId> corners) {
    OpenLoop& loop = loops.emplace_back();
    loop.corners = std::move(corners);
    const std::vector<Point3> chain = ChainOf(loop, at);
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const Point3& next = chain[(i + 1) % chain.size()];
      loop.length += std::sqrt(cleaning::SquaredDistance<3>(chain[i], next));
      for (std::size_t k = 0; k < 3; ++k) {
        loop.middle[k] += chain[i][k] / static_cast<double>(chain.size());
      }
    }
  });
  std::ranges::sort(loops, [](const OpenLoop& a, const OpenLoop& b) {
    return std::pair(a.length, a.middle) < std::pair(b.length, b.middle);
  });
  return loops;
}

std::size_t FillLoops(double longest, std::vector<Feature>& features) {
  const std::vector<OpenLoop> loops = OpenLoopsOf(features);
  if (loops.empty() || !(loops.front().length <= longest)) return 0;
  const Positions at = PositionsOf(features);
  const TrianglesAt triangles_at(features);
  FeatureId last = 0;
  for (const Feature& f : features) last = std::max(last, f.id);
  std::size_t filled = 0;
  for (const OpenLoop& loop : loops) {
    if (!(loop.length <= longest)) break;
    const std::vector<FeatureId>& corners = loop.corners;
    if (corners.size() > kMostCornersFilled) continue;
    const std::vector<Point3> chain = ChainOf(loop, at);
    const auto there = triangles_at.On(loop);
    if (AreInOnePlane(chain) && there.empty()) {
      features.push_back(Feature::Polygon(++last, {corners}));
      ++filled;
      continue;
    }
    const auto triangles = cleaning::TriangulateHole(chain, cleaning::HoleMeasure::kArea, there);
    if (!triangles.empty()) ++filled;
    for (const auto& [i, j, k] : triangles) {
      features.push_back(Feature::Polygon(++last, {{corners[i], corners[j], corners[k]}}));
    }
  }
  return filled;
}

}  // namespace dynmesh::preparation
