#include "client/preparation/open_edges.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cleaning/box_tree.h"
#include "client/cleaning/node_table.h"
#include "client/cleaning/vectors3.h"
#include "client/preparation/positions.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"

namespace dynmesh::preparation {
namespace {

using EdgeKey = std::pair<FeatureId, FeatureId>;

EdgeKey KeyOf(FeatureId p, FeatureId q) { return std::minmax(p, q); }

// In distances: an edge and what it becomes one with may both move, and a face between them go.
constexpr double kReach = 4;

bool IsPolygon(const Feature& f) { return Is<APolygon>(f, Not<APoint, ASegment, ASize>); }

// The squared distance of the middle of an edge to another one.
double SquaredDistanceTo(const OpenEdge& other, const OpenEdge& edge) {
  const cleaning::Point3 middle =
      cleaning::Along(edge.at_p, 0.5, cleaning::Minus(edge.at_q, edge.at_p));
  return cleaning::SquaredDistance<3>(middle, cleaning::FootOn(other.at_p, other.at_q, middle));
}

void DropUnusedPoints(std::vector<Feature>& features) {
  absl::flat_hash_set<FeatureId> used;
  for (const Feature& f : features) {
    ForEachPointOf(f, [&](FeatureId id) { used.insert(id); });
  }
  std::erase_if(features, [&](const Feature& f) { return IsPoint(f) && !used.contains(f.id); });
}

}  // namespace

std::vector<OpenEdge> OpenEdgesOf(const std::vector<Feature>& features) {
  absl::flat_hash_map<EdgeKey, int> faces_at;
  for (const Feature& f : features) {
    if (!IsPolygon(f)) continue;
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) { ++faces_at[KeyOf(p, q)]; });
  }
  const Positions at = PositionsOf(features);
  std::vector<OpenEdge> open;
  for (const auto& [edge, faces] : faces_at) {
    if (faces != 1) continue;
    const cleaning::Point3 ends[] = {at.at(edge.first), at.at(edge.second)};
    open.push_back({edge.first, edge.second, ends[0], ends[1], cleaning::Box3::Of(ends)});
  }
  return open;
}

bool MayBeClosed(const std::vector<OpenEdge>& open, double distance) {
  std::vector<cleaning::BoxEntry> boxes;
  for (std::uint32_t i = 0; i < open.size(); ++i) {
    boxes.emplace_back(cleaning::TreeBoxOf(open[i].box.Grown(kReach * distance)), i);
  }
  const cleaning::BoxTree tree(boxes.begin(), boxes.end());
  return std::ranges::all_of(open, [&](const OpenEdge& edge) {
    std::vector<cleaning::BoxEntry> found;
    tree.query(boost::geometry::index::intersects(cleaning::TreeBoxOf(edge.box)),
               std::back_inserter(found));
    return std::ranges::any_of(found, [&](const cleaning::BoxEntry& entry) {
      const OpenEdge& other = open[entry.second];
      return &other != &edge &&
             SquaredDistanceTo(other, edge) <= kReach * distance * kReach * distance;
    });
  });
}

std::size_t DropFlaps(const std::vector<FeatureId>& doubled, std::vector<Feature>& features) {
  if (doubled.empty()) return 0;
  const absl::flat_hash_set<FeatureId> may_go(doubled.begin(), doubled.end());
  absl::flat_hash_map<EdgeKey, int> faces_at;
  absl::flat_hash_map<EdgeKey, std::vector<FeatureId>> doubled_at;
  absl::flat_hash_map<FeatureId, const Rings*> rings_of;
  for (const Feature& f : features) {
    if (!IsPolygon(f)) continue;
    if (may_go.contains(f.id)) rings_of[f.id] = &f.rings;
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) {
      ++faces_at[KeyOf(p, q)];
      if (may_go.contains(f.id)) doubled_at[KeyOf(p, q)].push_back(f.id);
    });
  }
  absl::flat_hash_set<FeatureId> flaps;
  std::vector<FeatureId> left = doubled;
  while (!left.empty()) {
    const FeatureId id = left.back();
    left.pop_back();
    const auto it = rings_of.find(id);
    if (it == rings_of.end() || flaps.contains(id)) continue;
    bool is_open = false;
    ForEachEdgeOf(*it->second, [&](FeatureId p, FeatureId q) {
      is_open = is_open || faces_at.at(KeyOf(p, q)) == 1;
    });
    if (!is_open) continue;
    flaps.insert(id);
    ForEachEdgeOf(*it->second, [&](FeatureId p, FeatureId q) {
      if (--faces_at.at(KeyOf(p, q)) != 1) return;
      const std::vector<FeatureId>& there = doubled_at.at(KeyOf(p, q));
      left.insert(left.end(), there.begin(), there.end());
    });
  }
  if (flaps.empty()) return 0;
  std::erase_if(features, [&](const Feature& f) { return flaps.contains(f.id); });
  DropUnusedPoints(features);
  return flaps.size();
}

}  // namespace dynmesh::preparation
