#include "core/regions/chambers.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <queue>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/geometry/circumball.h"
#include "core/plc/delta.h"
#include "core/regions/region_terms.h"

namespace dynmesh {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Vector3;
using plc::Facet;

// Side 2i of facet i is the one that its normal points to, 2i + 1 the other.
using Side = std::size_t;
constexpr Side kOutside = ~Side{0};

class Sides {
 public:
  explicit Sides(std::size_t facets) : parents_(2 * facets) {
    std::iota(parents_.begin(), parents_.end(), Side{0});
  }
  Side Find(Side side) {
    while (parents_[side] != side) side = parents_[side] = parents_[parents_[side]];
    return side;
  }
  void Join(Side a, Side b) { parents_[Find(a)] = Find(b); }

 private:
  std::vector<Side> parents_;
};

// A facet at an edge: its direction in a rotation about the edge, and its side that faces onward in
// that rotation.
struct AtEdge {
  double turn;  // increases with the angle, from 0 to below 4
  Side ahead;
  friend bool operator<(const AtEdge& a, const AtEdge& b) { return a.turn < b.turn; }
};

double TurnOf(double x, double y) {
  const double along = x / (std::fabs(x) + std::fabs(y));
  return y >= 0 ? 1 - along : 3 + along;
}

// Joins the sides that face each other between neighbouring facets at each edge.
void JoinAroundEdges(std::span<const Facet> component, Sides& sides) {
  absl::flat_hash_map<plc::EdgeKey, std::vector<std::pair<std::size_t, Facet::Corner>>> edges;
  for (std::size_t i = 0; i < component.size(); ++i) {
    for (const Facet::Corner& c : component[i].corners()) {
      edges[plc::KeyOf(c.id, component[i].Beside(c, true).id)].emplace_back(i, c);
    }
  }
  std::vector<AtEdge> around;
  for (const auto& [key, facets] : edges) {
    const auto& [first, corner] = facets.front();
    const Vector3 edge =
        Difference(component[first].PositionOf(component[first].Beside(corner, true)).c,
                   component[first].PositionOf(corner).c);
    // The zero of turns.
    const Vector3 x = component[first].InwardOf(corner), y = Cross(edge, x);
    const double length = std::sqrt(Dot(edge, edge));
    around.clear();
    for (const auto& [i, c] : facets) {
      const Vector3 inward = component[i].InwardOf(c);
      const bool normal_ahead = Dot(Cross(edge, inward), component[i].plane().normal) > 0;
      around.push_back(
          {TurnOf(Dot(inward, x), Dot(inward, y) / length), 2 * i + (normal_ahead ? 0 : 1)});
    }
    around.front().turn = 0;
    std::sort(around.begin(), around.end());
    for (std::size_t k = 0; k < around.size(); ++k) {
      sides.Join(around[k].ahead, around[(k + 1) % around.size()].ahead ^ 1);
    }
  }
}

// The area vector: along the normal, its length is the area.
Vector3 AreaOf(const Facet& facet) {
  Vector3 sum = {0, 0, 0};
  const geometry::Point3 origin = facet.plane().origin;
  for (const Facet::Corner& c : facet.corners()) {
    const Vector3 from = Difference(facet.PositionOf(c).c, origin.c);
    const Vector3 along =
        Difference(facet.PositionOf(facet.Beside(c, true)).c, facet.PositionOf(c).c);
    const double half = facet.IsInsideLeftOf(c) ? 0.5 : -0.5;
    const Vector3 twice = Cross(from, along);
    for (std::size_t k = 0; k < 3; ++k) sum[k] += half * twice[k];
  }
  return sum;
}

// For each side, a representative of its chamber, or kOutside.
std::vector<Side> ChambersOf(std::span<const Facet> component) {
  Sides sides(component.size());
  JoinAroundEdges(component, sides);
  std::vector<double> volume(2 * component.size(), 0);
  std::vector<Side> first(2 * component.size(), kOutside);
  for (std::size_t i = 0; i < component.size(); ++i) {
    const Vector3 area = AreaOf(component[i]);
    for (const Side side : {2 * i, 2 * i + 1}) {
      const Side chamber = sides.Find(side);
      if (first[chamber] == kOutside) first[chamber] = side;
      // Relative to the position of one of the chamber's corners: otherwise small chambers drown in
      // rounding.
      const Vector3 to =
          Difference(component[i].plane().origin.c, component[first[chamber] / 2].plane().origin.c);
      const double cone = Dot(to, area);
      volume[chamber] += side % 2 == 0 ? -cone : cone;
    }
  }
  std::vector<Side> chambers(2 * component.size());
  for (Side side = 0; side < chambers.size(); ++side) {
    const Side chamber = sides.Find(side);
    chambers[side] =
        volume[chamber] > 0 || !IsOn(RegionTerm::kChambersHaveVolume) ? chamber : kOutside;
  }
  return chambers;
}

}  // namespace

std::vector<SurfaceIds> FindSurfaces(std::span<const Facet> component) {
  const std::vector<Side> chambers = ChambersOf(component);
  // The walls of each chamber, last those of the outside.
  const auto slot_of = [&](Side chamber) {
    return chamber == kOutside ? chambers.size() : chamber;
  };
  std::vector<std::vector<std::size_t>> walls(chambers.size() + 1);
  for (Side side = 0; side < chambers.size(); ++side) {
    if (chambers[side] != chambers[side ^ 1]) walls[slot_of(chambers[side])].push_back(side / 2);
  }
  // From the outside: through the wall of least id that leads to a chamber without a name.
  std::vector<FeatureId> names(chambers.size() + 1, kNoFeature);
  using Wall = std::pair<FeatureId, std::size_t>;
  std::priority_queue<Wall, std::vector<Wall>, std::greater<>> ahead;
  const auto enter = [&](std::size_t slot) {
    for (const std::size_t i : walls[slot]) ahead.emplace(component[i].id(), i);
  };
  for (enter(chambers.size()); !ahead.empty();) {
    const auto [id, i] = ahead.top();
    ahead.pop();
    for (const Side side : {2 * i, 2 * i + 1}) {
      if (chambers[side] == kOutside || names[chambers[side]] != kNoFeature) continue;
      names[chambers[side]] = id;
      enter(chambers[side]);
    }
  }
  std::vector<SurfaceIds> surfaces(component.size());
  for (std::size_t i = 0; i < component.size(); ++i) {
    if (chambers[2 * i] == chambers[2 * i + 1]) continue;
    for (const Side side : {2 * i, 2 * i + 1}) {
      if (chambers[side] != kOutside) surfaces[i].push_back(names[chambers[side]]);
    }
    std::sort(surfaces[i].begin(), surfaces[i].end());
  }
  return surfaces;
}

}  // namespace dynmesh
