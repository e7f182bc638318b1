#include "core/io/maps/line_work.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/base/rings.h"

namespace dynmesh::io {

namespace {

bool IsInDegrees(const std::array<double, 2>& p) {
  return std::abs(p[0]) <= 180 && std::abs(p[1]) <= 90;
}

}  // namespace

LineWork::Node LineWork::Add(const std::array<double, 2>& position, int line) {
  const double x = position[0] + 0.0, y = position[1] + 0.0;  // -0 is 0
  const Bits bits{std::bit_cast<std::uint64_t>(x), std::bit_cast<std::uint64_t>(y)};
  const auto [it, is_new] = node_at_.try_emplace(bits, static_cast<Node>(positions_.size()));
  if (is_new) {
    positions_.push_back({x, y});
    point_lines_.push_back(line);
  }
  return it->second;
}

void LineWork::Connect(Node from, Node to, int line) {
  if (from == to || !joined_.insert(std::minmax(from, to)).second) return;
  edges_.emplace_back(from, to);
  edge_lines_.push_back(line);
}

void LineWork::AddPolygon(std::vector<std::vector<Node>> rings, PolygonName names, int line) {
  for (std::vector<Node>& ring : rings) {
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
    if (ring.size() > 1 && ring.front() == ring.back()) ring.pop_back();
  }
  if (!rings.empty()) polygons_.push_back({std::move(rings), std::move(names), line});
}

bool LineWork::IsAcross(Node from, Node to) const {
  return std::abs(positions_[from][0] - positions_[to][0]) > 180;
}

FileFeatures LineWork::Take(const std::string& file) {
  FileFeatures input;
  input.point_file = file;
  input.segment_file = file;
  input.point_count = positions_.size();
  input.segment_count = edges_.size();
  input.features.reserve(positions_.size() + edges_.size() + polygons_.size());
  FeatureId id = 0;
  for (const auto& p : positions_) input.features.push_back(Feature::Point(++id, p[0], p[1]));
  for (const auto& [from, to] : edges_) {
    input.features.push_back(Feature::Segment(++id, FeatureId{from} + 1, FeatureId{to} + 1));
  }
  input.lines = std::move(point_lines_);
  input.lines.insert(input.lines.end(), edge_lines_.begin(), edge_lines_.end());
  absl::flat_hash_set<std::pair<Node, Node>> across;
  const auto note = [&](Node from, Node to) {
    if (IsAcross(from, to)) across.insert(std::minmax(from, to));
  };
  for (const auto& [from, to] : edges_) note(from, to);
  for (Polygon& polygon : polygons_) {
    Rings rings;
    for (const std::vector<Node>& ring : polygon.rings) {
      std::vector<FeatureId>& corners = rings.emplace_back();
      for (const Node corner : ring) corners.push_back(FeatureId{corner} + 1);
    }
    ForEachEdgeOf(polygon.rings, note);
    input.features.push_back(Feature::Polygon(++id, std::move(rings)));
    polygon.names.id = id;
    input.polygons.push_back(std::move(polygon.names));
    input.lines.push_back(polygon.line);
  }
  if (std::all_of(positions_.begin(), positions_.end(), IsInDegrees)) input.wraps = across.size();
  *this = {};
  return input;
}

}  // namespace dynmesh::io
