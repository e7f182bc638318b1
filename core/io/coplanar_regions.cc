#include "core/io/coplanar_regions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>
#include <tuple>

#include "absl/container/flat_hash_map.h"
#include "core/base/ring_walk.h"
#include "core/base/rings.h"
#include "core/geometry/space_predicates.h"
#include "core/io/facet_rings.h"

namespace dynmesh::io {

using geometry::Point3;

namespace {

double NormOf(const std::array<double, 3>& v) {
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

// The plane of a ring, as thick as the tolerance says to either side.
class Plane {
 public:
  Plane(const PointRing& ring, AxisView view, double tolerance)
      : three_(LeastCorner(ring, view)),
        normal_(AreaVector(ring)),
        reach_(tolerance * NormOf(normal_)) {}

  bool Contains(const Point3& p) const {
    if (geometry::Orientation(three_[0], three_[1], three_[2], p) == 0) return true;
    if (!(reach_ > 0)) return false;
    const Point3& o = three_[1];
    return std::abs(normal_[0] * (p[0] - o[0]) + normal_[1] * (p[1] - o[1]) +
                    normal_[2] * (p[2] - o[2])) <= reach_;
  }

 private:
  std::array<Point3, 3> three_;
  std::array<double, 3> normal_;
  double reach_;
};

class Finder {
 public:
  Finder(const std::vector<Point3>& places, const std::vector<FaceRings>& faces, double tolerance)
      : places_(places), faces_(faces), tolerance_(tolerance), state_(faces.size()) {
    for (std::size_t f = 0; f < faces.size(); ++f) AddUses(f);
    std::sort(uses_.begin(), uses_.end(), [](const Use& a, const Use& b) {
      return std::tie(a.edge, a.face, a.ring) < std::tie(b.edge, b.face, b.ring);
    });
    uses_of_.resize(faces.size());
    for (std::size_t i = 0; i < uses_.size(); ++i) uses_of_[uses_[i].face].push_back(i);
  }

  std::vector<FlatRegion> Run() {
    std::vector<FlatRegion> regions;
    for (const std::size_t seed : LargestFirst()) {
      if (state_[seed].taken) continue;
      std::optional<FlatRegion> region = Grow(seed);
      if (region) regions.push_back(*std::move(region));
    }
    return regions;
  }

 private:
  struct Use {  // of an edge, by a ring of a face
    CornerPair edge;
    std::size_t face;
    std::size_t ring;
    bool up;  // goes from the lesser corner to the greater
  };
  struct State {
    bool taken = false;
    // In the view of the region to which the face belongs: does a ring have the face on its left?
    std::vector<bool> is_left;
  };

  void AddUses(std::size_t f) {
    for (std::size_t r = 0; r < faces_[f].size(); ++r) {
      ForEachEdgeOf(std::array{faces_[f][r]}, [&](Corner p, Corner q) {
        uses_.push_back({std::minmax(p, q), f, r, p < q});
      });
    }
  }

  PointRing PlacesOf(const CornerRing& ring) const {
    PointRing places;
    for (const Corner c : ring) places.push_back(places_[c]);
    return places;
  }

  // The ring around all others of its face, and twice its area.
  std::pair<PointRing, double> OuterRing(std::size_t f) const {
    std::pair<PointRing, double> outer = {{}, -1};
    for (const CornerRing& ring : faces_[f]) {
      PointRing places = PlacesOf(ring);
      const double area = NormOf(AreaVector(places));
      if (area > outer.second) outer = {std::move(places), area};
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

  bool IsIn(const Plane& plane, std::size_t f) const {
    for (const CornerRing& ring : faces_[f]) {
      for (const Corner c : ring) {
        if (!plane.Contains(places_[c])) return false;
      }
    }
    return true;
  }

  // None if a ring is degenerate in the view, or touches another one everywhere.
  std::optional<std::vector<bool>> SidesOf(std::size_t f, AxisView view) const {
    std::vector<PointRing> rings;
    for (const CornerRing& ring : faces_[f]) rings.push_back(PlacesOf(ring));
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

  // Does the edge go up, walked with the face on the left? REQUIRES: the face's sides are known.
  bool GoesUp(const Use& use) const { return use.up == state_[use.face].is_left[use.ring]; }

  // The only other use of the edge, if it has two.
  const Use* Other(std::size_t i) const {
    const CornerPair& edge = uses_[i].edge;
    const bool before = i > 0 && uses_[i - 1].edge == edge;
    const bool behind = i + 1 < uses_.size() && uses_[i + 1].edge == edge;
    if (before == behind) return nullptr;
    if (before) return i > 1 && uses_[i - 2].edge == edge ? nullptr : &uses_[i - 1];
    return i + 2 < uses_.size() && uses_[i + 2].edge == edge ? nullptr : &uses_[i + 1];
  }

  std::optional<FlatRegion> Grow(std::size_t seed) {
    state_[seed].taken = true;
    const PointRing outer = OuterRing(seed).first;
    const std::optional<AxisView> view = ViewOf(outer);
    if (!view) return std::nullopt;
    const Plane plane(outer, *view, tolerance_);
    std::optional<std::vector<bool>> sides = SidesOf(seed, *view);
    if (!sides || !IsIn(plane, seed)) return std::nullopt;
    state_[seed].is_left = *std::move(sides);
    FlatRegion region = {{seed}, {}};
    for (std::size_t k = 0; k < region.faces.size(); ++k) {
      for (const std::size_t i : uses_of_[region.faces[k]]) {
        const Use* const other = Other(i);
        if (other == nullptr || state_[other->face].taken || !IsIn(plane, other->face)) continue;
        sides = SidesOf(other->face, *view);
        if (!sides) continue;
        State& state = state_[other->face];
        state.is_left = *std::move(sides);
        if (GoesUp(*other) == GoesUp(uses_[i])) continue;
        state.taken = true;
        region.faces.push_back(other->face);
      }
    }
    if (region.faces.size() == 1) return std::nullopt;
    std::optional<std::vector<CornerPair>> boundary = BoundaryOf(region.faces);
    if (!boundary) return std::nullopt;
    region.rings = CutIntoRings(*std::move(boundary));
    return region;
  }

  // Edges with the faces on one side only, from corner to corner with that on the left. None if
  // on one side of an edge there are two faces.
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

  const std::vector<Point3>& places_;
  const std::vector<FaceRings>& faces_;
  const double tolerance_;
  std::vector<State> state_;                       // of faces
  std::vector<Use> uses_;                          // sorted by edge
  std::vector<std::vector<std::size_t>> uses_of_;  // by face
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

std::vector<FlatRegion> FindFlatRegions(const std::vector<Point3>& places,
                                        const std::vector<FaceRings>& faces, double tolerance) {
  return Finder(places, faces, tolerance).Run();
}

}  // namespace dynmesh::io
