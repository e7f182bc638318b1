#include "core/coplanar/coplanar_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <span>
#include <tuple>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/ring_walk.h"
#include "core/base/rings.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/plane_fit.h"
#include "core/coplanar/region_plane.h"
#include "core/geometry/circumball.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/space_predicates.h"

namespace dynmesh::coplanar {

using geometry::Point3;

namespace {

// The edges with a growing region on one side only, and their number at each corner.
class Rim {
 public:
  void Toggle(const FaceRings& face) {
    ForEachEdgeOf(face, [&](Corner p, Corner q) {
      const bool comes = edges_.insert(std::minmax(p, q)).second;
      if (!comes) edges_.erase(std::minmax(p, q));
      for (const Corner c : {p, q}) degree_[c] += comes ? 1 : -1;
    });
  }
  bool Has(const CornerPair& edge) const { return edges_.contains(edge); }
  bool Has(Corner c) const {
    const auto it = degree_.find(c);
    return it != degree_.end() && it->second > 0;
  }

 private:
  absl::flat_hash_set<CornerPair> edges_;
  absl::flat_hash_map<Corner, int> degree_;
};

class Finder {
 public:
  Finder(const std::vector<Point3>& positions, const std::vector<FaceRings>& faces,
         const Kept& kept, double tolerance, const Thickness& most)
      : positions_(positions),
        faces_(faces),
        kept_(kept),
        tolerance_(tolerance),
        most_(most),
        state_(faces.size()),
        faces_at_(positions.size()) {
    for (std::size_t f = 0; f < faces.size(); ++f) AddUses(f);
    std::sort(uses_.begin(), uses_.end(), [](const Use& a, const Use& b) {
      return std::tie(a.edge, a.face, a.ring) < std::tie(b.edge, b.face, b.ring);
    });
    uses_of_.resize(faces.size());
    for (std::size_t i = 0; i < uses_.size(); ++i) uses_of_[uses_[i].face].push_back(i);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      for (const CornerRing& ring : faces[f]) {
        for (const Corner c : ring) faces_at_[c].push_back(f);
      }
    }
    for (const auto& [p, q] : kept.edges) {
      segments_at_[p].push_back(q);
      segments_at_[q].push_back(p);
    }
  }

  FlatRegions Run() {
    FlatRegions found;
    for (const std::size_t seed : LargestFirst()) {
      if (state_[seed].taken) continue;
      const double tolerance = state_[seed].exact_only ? 0 : tolerance_;
      std::optional<FlatRegion> region = Grow(seed, tolerance);
      if (region && tolerance > 0 && IsTooThick(region->rings)) {
        ++found.too_thick;
        for (const std::size_t f : region->faces) {
          state_[f].taken = false;
          state_[f].exact_only = true;
        }
        region = Grow(seed, 0);
      }
      if (region) found.regions.push_back(*std::move(region));
    }
    return found;
  }

  std::vector<FlatRegion> RunRounded(const std::vector<geometry::Vector3>& roundings,
                                     const std::vector<std::size_t>& groups,
                                     const std::vector<bool>& stay) {
    std::vector<FlatRegion> found;
    is_rounded_ = true;
    groups_ = &groups;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (stay[f]) state_[f] = {true, false, 0, {}};
    }
    for (const std::size_t seed : LargestFirst()) {
      if (state_[seed].taken) continue;
      ++region_;
      group_ = groups[seed];
      std::optional<FlatRegion> region = GrowRounded(seed, roundings);
      if (region) found.push_back(*std::move(region));
    }
    return found;
  }

 private:
  struct Use {  // of an edge, by a ring of a face
    CornerPair edge;
    std::size_t face;
    std::size_t ring;
    bool up;  // from the lesser corner to the greater
  };
  struct State {
    bool taken = false;
    bool exact_only = false;  // was in a region that was too thick: do not try the tolerance again
    std::size_t region = 0;   // of rounded positions: the one that took it
    // In the view of the face's region: is the face on the left of each ring?
    std::vector<bool> is_left;
  };

  void AddUses(std::size_t f) {
    for (std::size_t r = 0; r < faces_[f].size(); ++r) {
      ForEachEdgeOf(std::array{faces_[f][r]}, [&](Corner p, Corner q) {
        uses_.push_back({std::minmax(p, q), f, r, p < q});
      });
    }
  }

  PointRing PositionsOf(const CornerRing& ring) const {
    PointRing positions;
    for (const Corner c : ring) positions.push_back(positions_[c]);
    return positions;
  }

  // The outer ring of a face, and twice its area.
  std::pair<PointRing, double> OuterRing(std::size_t f) const {
    std::pair<PointRing, double> outer = {{}, -1};
    for (const CornerRing& ring : faces_[f]) {
      PointRing positions = PositionsOf(ring);
      const double area = NormOf(AreaVector(positions));
      if (area > outer.second) outer = {std::move(positions), area};
    }
    return outer;
  }

  std::vector<std::size_t> LargestFirst() const {
    std::vector<double> areas;
    for (std::size_t f = 0; f < faces_.size(); ++f) areas.push_back(OuterRing(f).second);
    std::vector<std::size_t> order(faces_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(), [&](std::size_t f, std::size_t g) {
      if (areas[f] != areas[g]) return areas[f] > areas[g];
      return faces_[f] < faces_[g];
    });
    return order;
  }

  bool IsIn(const RegionPlane& plane, std::size_t f) const {
    for (const CornerRing& ring : faces_[f]) {
      for (const Corner c : ring) {
        if (!plane.Contains(c, positions_[c])) return false;
      }
    }
    return true;
  }

  // None if a ring is degenerate in the view, or has all corners on another one.
  std::optional<std::vector<bool>> SidesOf(std::size_t f, AxisView view) const {
    std::vector<PointRing> rings;
    for (const CornerRing& ring : faces_[f]) rings.push_back(PositionsOf(ring));
    const std::optional<std::vector<int>> depths = DepthsOf(rings, view);
    if (!depths) return std::nullopt;
    std::vector<bool> is_left;
    for (std::size_t r = 0; r < rings.size(); ++r) {
      const int sign = SignOf(rings[r], view);
      if (sign == 0) return std::nullopt;
      is_left.push_back((sign > 0) == ((*depths)[r] % 2 == 0));
    }
    return is_left;
  }

  // Does the edge go up, with the face on the left? REQUIRES: the face's sides are known.
  bool GoesUp(const Use& use) const { return use.up == state_[use.face].is_left[use.ring]; }

  // The only other use of the edge; null unless it has exactly two.
  const Use* Other(std::size_t i) const {
    const CornerPair& edge = uses_[i].edge;
    const bool before = i > 0 && uses_[i - 1].edge == edge;
    const bool behind = i + 1 < uses_.size() && uses_[i + 1].edge == edge;
    if (before == behind) return nullptr;
    if (before) return i > 1 && uses_[i - 2].edge == edge ? nullptr : &uses_[i - 1];
    return i + 2 < uses_.size() && uses_[i + 2].edge == edge ? nullptr : &uses_[i + 1];
  }

  // Does the corner have a feature outside the plane, or one other than faces?
  bool IsNeeded(Corner c, const RegionPlane& plane) const {
    return kept_.corners[c] || std::any_of(faces_at_[c].begin(), faces_at_[c].end(),
                                           [&](std::size_t f) { return IsOther(plane, f); });
  }
  // Is it in another plane, or in a region of another one, or of another group?
  bool IsOther(const RegionPlane& plane, std::size_t f) const {
    return !IsIn(plane, f) || IsOfOtherGroup(f) ||
           (is_rounded_ && state_[f].taken && state_[f].region != region_);
  }
  bool IsOfOtherGroup(std::size_t f) const { return groups_ != nullptr && (*groups_)[f] != group_; }
  bool IsNeeded(const CornerPair& edge, const RegionPlane& plane) const {
    if (std::binary_search(kept_.edges.begin(), kept_.edges.end(), edge)) return true;
    const std::span<const Use> uses = UsesOf(edge);
    if (uses.size() > 2 && std::any_of(uses.begin(), uses.end(),
                                       [&](const Use& use) { return IsOther(plane, use.face); })) {
      return true;
    }
    const auto is_below = [&](Corner from, Corner to) {
      const auto at = segments_at_.find(from);
      return at != segments_at_.end() &&
             std::any_of(at->second.begin(), at->second.end(), [&](Corner c) {
               return plane.IsSharpOver(positions_[from], positions_[to], positions_[c]);
             });
    };
    return is_below(edge.first, edge.second) || is_below(edge.second, edge.first);
  }

  std::span<const Use> UsesOf(const CornerPair& edge) const {
    const auto [first, last] =
        std::equal_range(uses_.begin(), uses_.end(), Use{edge, 0, 0, false},
                         [](const Use& a, const Use& b) { return a.edge < b.edge; });
    return std::span(uses_).subspan(static_cast<std::size_t>(first - uses_.begin()),
                                    static_cast<std::size_t>(last - first));
  }

  // Adds a face to the rim, unless a needed edge or corner would then not be on it.
  bool Enclose(std::size_t f, const RegionPlane& plane, Rim& rim) const {
    rim.Toggle(faces_[f]);
    bool good = true;
    ForEachEdgeOf(faces_[f], [&](Corner p, Corner q) {
      const CornerPair edge = std::minmax(p, q);
      good =
          good && (rim.Has(edge) || !IsNeeded(edge, plane)) && (rim.Has(p) || !IsNeeded(p, plane));
    });
    if (!good) rim.Toggle(faces_[f]);
    return good;
  }

  // As the mesh will measure it, except for rounding that differs without straight corners.
  bool IsTooThick(const FaceRings& rings) const {
    if (!most_) return false;
    std::vector<PointRing> outline;
    for (const CornerRing& ring : rings) outline.push_back(PositionsOf(ring));
    const geometry::FacetPlane plane = geometry::PlaneOf(outline);
    const geometry::FacetBounds bounds = geometry::BoundsOf(outline, plane);
    double extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, bounds.hi[k] - bounds.lo[k]);
    return !(bounds.deviation * (1 + 1e-6) <= most_(extent));
  }

  std::optional<FlatRegion> Grow(std::size_t seed, double tolerance) {
    state_[seed].taken = true;
    const PointRing outer = OuterRing(seed).first;
    const std::optional<AxisView> view = ViewOf(outer);
    if (!view) return std::nullopt;
    std::optional<FlatRegion> region =
        GrowIn(seed, RegionPlane(outer, *view, tolerance), *view, tolerance);
    return region && Close(*region) ? std::move(region) : std::nullopt;
  }

  // The corners of the faces, in their order.
  std::vector<Corner> CornersOf(const std::vector<std::size_t>& faces) const {
    std::vector<Corner> corners;
    for (const std::size_t f : faces) {
      for (const CornerRing& ring : faces_[f]) {
        corners.insert(corners.end(), ring.begin(), ring.end());
      }
    }
    std::sort(corners.begin(), corners.end());
    corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
    return corners;
  }

  std::optional<FlatRegion> GrowRounded(std::size_t seed,
                                        const std::vector<geometry::Vector3>& roundings) {
    state_[seed].taken = true;
    state_[seed].region = region_;
    const PointRing outer = OuterRing(seed).first;
    const std::optional<AxisView> view = ViewOf(outer);
    if (!view) return std::nullopt;
    const std::array<double, 3> area = AreaVector(outer);
    if (!(geometry::Dot(area, area) > 0)) return std::nullopt;
    std::vector<std::size_t> faces = {seed};
    std::optional<FlatRegion> region;
    constexpr int kMostTurns = 12;
    for (int turn = 0;; ++turn) {
      const std::vector<Corner> corners = CornersOf(faces);
      const PlaneFit fit(PositionsOf(corners), area, RoundingsAlong(area, corners, roundings));
      const bool is_last = turn >= kMostTurns;
      const RegionPlane plane =
          is_last ? RegionPlane(fit, roundings, kBand, 0) : RegionPlane(fit, roundings, 1.5, 1.5);
      if (region) Free(*region, seed);
      region = GrowIn(seed, plane, *view, 0);
      if (!region) return std::nullopt;
      if (turn == 0 && region->faces.size() == 1) return std::nullopt;
      if (is_last) break;
      std::vector<std::size_t> now = region->faces;
      std::sort(now.begin(), now.end());
      if (now == faces) turn = kMostTurns - 1;  // then within the band
      faces = std::move(now);
    }
    if (Close(*region)) return region;
    Free(*region, seed);
    return std::nullopt;
  }

  void Free(const FlatRegion& region, std::size_t seed) {
    for (const std::size_t f : region.faces) {
      if (f != seed) state_[f].taken = false;
    }
  }

  // The faces around the seed that are in the plane.
  std::optional<FlatRegion> GrowIn(std::size_t seed, const RegionPlane& plane, AxisView view,
                                   double tolerance) {
    std::optional<std::vector<bool>> sides = SidesOf(seed, view);
    if (!sides || !IsIn(plane, seed)) return std::nullopt;
    state_[seed].is_left = *std::move(sides);
    FlatRegion region = {{seed}, {}};
    Rim rim;
    rim.Toggle(faces_[seed]);
    for (std::size_t k = 0; k < region.faces.size(); ++k) {
      for (const std::size_t i : uses_of_[region.faces[k]]) {
        const Use* const other = Other(i);
        if (other == nullptr || state_[other->face].taken || IsOfOtherGroup(other->face)) continue;
        if (!IsIn(plane, other->face)) continue;
        if (tolerance > 0 && state_[other->face].exact_only) continue;
        sides = SidesOf(other->face, view);
        if (!sides) continue;
        State& state = state_[other->face];
        state.is_left = *std::move(sides);
        if (GoesUp(*other) == GoesUp(uses_[i])) continue;
        if (!Enclose(other->face, plane, rim)) continue;
        state.taken = true;
        state.region = region_;
        region.faces.push_back(other->face);
      }
    }
    return region;
  }

  // Its rings; false for a single face, or faces that overlap.
  bool Close(FlatRegion& region) const {
    if (region.faces.size() == 1) return false;
    std::optional<std::vector<CornerPair>> boundary = BoundaryOf(region.faces);
    if (!boundary) return false;
    region.rings = CutIntoRings(*std::move(boundary));
    return true;
  }

  // Edges with the faces on one side only, from corner to corner with the faces on the left. None
  // if an edge has two faces on one side.
  std::optional<std::vector<CornerPair>> BoundaryOf(const std::vector<std::size_t>& faces) const {
    std::vector<CornerPair> up, down;
    for (const std::size_t f : faces) {
      for (const std::size_t i : uses_of_[f]) {
        (GoesUp(uses_[i]) ? up : down).push_back(uses_[i].edge);
      }
    }
    std::sort(up.begin(), up.end());
    std::sort(down.begin(), down.end());
    const auto has_twice = [](const std::vector<CornerPair>& edges) {
      return std::adjacent_find(edges.begin(), edges.end()) != edges.end();
    };
    if (has_twice(up) || has_twice(down)) return std::nullopt;
    std::vector<CornerPair> boundary, back;
    std::set_difference(up.begin(), up.end(), down.begin(), down.end(),
                        std::back_inserter(boundary));
    std::set_difference(down.begin(), down.end(), up.begin(), up.end(), std::back_inserter(back));
    for (const auto& [low, high] : back) boundary.emplace_back(high, low);
    return boundary;
  }

  static FaceRings CutIntoRings(std::vector<CornerPair> directed) {
    std::sort(directed.begin(), directed.end());
    absl::flat_hash_map<Corner, std::vector<Corner>> leaving;
    for (auto e = directed.rbegin(); e != directed.rend(); ++e) {
      leaving[e->first].push_back(e->second);
    }
    const auto step = [&](Corner v) -> std::optional<Corner> {
      std::vector<Corner>& ends = leaving[v];
      if (ends.empty()) return std::nullopt;
      const Corner end = ends.back();
      ends.pop_back();
      return end;
    };
    FaceRings rings;
    for (const CornerPair& edge : directed) WalkRings(edge.first, step, rings);
    return Canonical(std::move(rings));
  }

  const std::vector<Point3>& positions_;
  const std::vector<FaceRings>& faces_;
  const Kept& kept_;
  const double tolerance_;
  const Thickness& most_;
  std::vector<State> state_;                        // of faces
  std::vector<Use> uses_;                           // sorted by edge
  std::vector<std::vector<std::size_t>> uses_of_;   // by face
  std::vector<std::vector<std::size_t>> faces_at_;  // by corner
  absl::flat_hash_map<Corner, std::vector<Corner>> segments_at_;
  bool is_rounded_ = false;
  std::size_t region_ = 0;  // the number of the growing one
  const std::vector<std::size_t>* groups_ = nullptr;
  std::size_t group_ = 0;  // of the growing one
};

}  // namespace

FaceRings Canonical(FaceRings rings) {
  for (CornerRing& ring : rings) {
    std::rotate(ring.begin(), std::min_element(ring.begin(), ring.end()), ring.end());
    if (ring.size() > 2 && ring.back() < ring[1]) std::reverse(ring.begin() + 1, ring.end());
  }
  std::sort(rings.begin(), rings.end());
  return rings;
}

FlatRegions FindFlatRegions(const std::vector<Point3>& positions,
                            const std::vector<FaceRings>& faces, const Kept& kept, double tolerance,
                            const Thickness& most) {
  return Finder(positions, faces, kept, tolerance, most).Run();
}

std::vector<FlatRegion> FindRoundedRegions(const std::vector<Point3>& positions,
                                           const std::vector<geometry::Vector3>& roundings,
                                           const std::vector<CornerRing>& faces, const Kept& kept,
                                           const std::vector<std::size_t>& groups,
                                           const std::vector<bool>& stay) {
  // What stays matters only at the corners of what does not.
  std::vector<bool> is_near(positions.size(), false);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (stay[f]) continue;
    for (const Corner c : faces[f]) is_near[c] = true;
  }
  std::vector<std::size_t> chosen, their_groups;
  std::vector<FaceRings> their_faces;
  std::vector<bool> they_stay;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (std::none_of(faces[f].begin(), faces[f].end(), [&](Corner c) { return is_near[c]; })) {
      continue;
    }
    chosen.push_back(f);
    their_faces.push_back(Canonical({faces[f]}));
    their_groups.push_back(groups[f]);
    they_stay.push_back(stay[f]);
  }
  const Thickness none;
  std::vector<FlatRegion> regions =
      Finder(positions, their_faces, kept, 0, none).RunRounded(roundings, their_groups, they_stay);
  for (FlatRegion& region : regions) {
    for (std::size_t& f : region.faces) f = chosen[f];
  }
  return regions;
}

}  // namespace dynmesh::coplanar
