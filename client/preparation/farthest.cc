#include "client/preparation/farthest.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <set>
#include <span>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/box_tree.h"
#include "client/cleaning/patch_distance.h"
#include "client/cleaning/vectors3.h"
#include "client/preparation/positions.h"
#include "client/preparation/triangles.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"

namespace dynmesh::preparation {
namespace {

using cleaning::Along;
using cleaning::Box3;
using cleaning::Dot;
using cleaning::Minus;
using cleaning::Point3;

// A part of an edge may be cut so often, and more for each target.
constexpr std::size_t kPieces = 64, kPiecesOfTarget = 8;

// ---- edges: a line segment by its ends, the lesser one first

using Edge = std::array<Point3, 2>;

std::vector<Edge> EdgesOf(const std::vector<Feature>& features) {
  const auto at = PositionsOf(features);
  std::vector<Edge> edges;
  const auto add = [&](FeatureId p, FeatureId q) {
    Edge edge = {at.at(p), at.at(q)};
    edge[0][2] = edge[1][2] = 0;  // in 2D it has no meaning
    if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
    if (edge[0] != edge[1]) edges.push_back(edge);
  };
  for (const Feature& f : features) {
    Visit(
        f, [&](const ASegment& s) { add(s.ends[0], s.ends[1]); },
        [&](const APolygon& p) { ForEachEdgeOf(p.rings, add); }, Ignore<APoint, ASize>);
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

double SquaredDistanceTo(const Edge& edge, const Point3& p) {
  return cleaning::SquaredDistance<3>(p, cleaning::FootOn(edge[0], edge[1], p));
}

bool IsWithin(const Edge& edge, std::span<const Edge> targets, double distance) {
  const double most = distance * distance;
  const Point3 along = Minus(edge[1], edge[0]);
  std::size_t left = kPieces + kPiecesOfTarget * targets.size();
  std::vector<std::pair<double, double>> pieces = {{0, 1}};
  while (!pieces.empty()) {
    if (left-- == 0) return false;
    const auto [s, t] = pieces.back();
    pieces.pop_back();
    const double middle = s + (t - s) / 2;
    const Point3 center = Along(edge[0], middle, along);
    const auto nearest = std::ranges::min_element(
        targets, {}, [&](const Edge& target) { return SquaredDistanceTo(target, center); });
    if (nearest == targets.end() || !(SquaredDistanceTo(*nearest, center) <= most)) return false;
    const auto is_near = [&](double at) {
      return SquaredDistanceTo(*nearest, Along(edge[0], at, along)) <= most;
    };
    if (is_near(s) && is_near(t)) continue;
    double cut = middle;  // where the target ends, if that is in between
    for (const Point3& end : *nearest) {
      const double at = cleaning::NearestAlong(edge[0], edge[1], end);
      if (at > s && at < t && !(is_near(s) && at < middle) && !(is_near(t) && at > middle)) {
        cut = at;
      }
    }
    pieces.emplace_back(s, cut);
    pieces.emplace_back(cut, t);
  }
  return true;
}

// ---- faces: triangles by their corners, ascending

using cleaning::TriangleCorners;

std::vector<TriangleCorners> CornersOf(const std::vector<Feature>& features) {
  std::vector<TriangleCorners> triangles;
  for (const PolygonPart& part : TrianglesOf(features)) {
    std::ranges::sort(triangles.emplace_back(part.corners));
  }
  std::ranges::sort(triangles);
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  return triangles;
}

// Where a triangle has many targets, cleaning::IsWithin may give up: its halves have fewer.
constexpr int kHalvings = 16;

bool IsWithin(const TriangleCorners& triangle, std::span<const cleaning::DistanceTarget> targets,
              double distance, int halvings) {
  const Box3 box = Box3::Of(triangle);
  std::vector<cleaning::DistanceTarget> near;
  for (const cleaning::DistanceTarget& target : targets) {
    if (target.box.Meets(box, distance)) near.push_back(target);
  }
  std::vector<std::uint32_t> used;
  if (cleaning::IsWithin(triangle, near, distance, used)) return true;
  const auto& [a, b, c] = triangle;
  const Point3 middle =
      Along(Along(a, 0.5, Minus(b, a)), 1.0 / 3, Minus(c, Along(a, 0.5, Minus(b, a))));
  const bool is_there = std::ranges::any_of(near, [&](const cleaning::DistanceTarget& target) {
    return cleaning::SquaredDistance<3>(middle, cleaning::NearestOn(target.corners, middle)) <=
           distance * distance;
  });
  if (!is_there || halvings == 0) return false;
  std::size_t longest = 0;
  const auto length = [&](std::size_t i) {
    return cleaning::SquaredDistance<3>(triangle[i], triangle[(i + 1) % 3]);
  };
  for (std::size_t i = 1; i < 3; ++i) {
    if (length(i) > length(longest)) longest = i;
  }
  const Point3 p = triangle[longest], q = triangle[(longest + 1) % 3],
               r = triangle[(longest + 2) % 3];
  const Point3 half = Along(p, 0.5, Minus(q, p));
  return IsWithin({p, half, r}, near, distance, halvings - 1) &&
         IsWithin({half, q, r}, near, distance, halvings - 1);
}

bool IsWithin(const TriangleCorners& triangle, std::span<const TriangleCorners> targets,
              double distance) {
  std::vector<cleaning::DistanceTarget> near;
  for (const TriangleCorners& target : targets) {
    // One without area is a line, which its neighbours have too.
    const Point3 normal = cleaning::NormalOf(target[0], target[1], target[2]);
    if (Dot(normal, normal) > 0) near.emplace_back(target);
  }
  return IsWithin(triangle, near, distance, kHalvings);
}

template <class Piece>
std::optional<double> Bound(const std::vector<Piece>& from, const std::vector<Piece>& to,
                            double least, double most) {
  std::vector<Piece> changed;
  std::ranges::set_difference(from, to, std::back_inserter(changed));
  if (changed.empty()) return least;
  std::vector<cleaning::BoxEntry> boxes;
  for (std::uint32_t i = 0; i < to.size(); ++i) {
    boxes.emplace_back(cleaning::TreeBoxOf(Box3::Of(to[i])), i);
  }
  const cleaning::BoxTree tree(boxes.begin(), boxes.end());
  double bound = least;
  for (const Piece& piece : changed) {
    while (true) {
      std::vector<cleaning::BoxEntry> found;
      tree.query(
          boost::geometry::index::intersects(cleaning::TreeBoxOf(Box3::Of(piece).Grown(bound))),
          std::back_inserter(found));
      std::vector<Piece> targets;
      for (const cleaning::BoxEntry& entry : found) targets.push_back(to[entry.second]);
      std::ranges::sort(targets);
      if (IsWithin(piece, targets, bound)) break;
      if (bound == most) return std::nullopt;
      bound = std::min(2 * bound, most);
    }
  }
  return bound;
}

}  // namespace

std::optional<double> FarthestBound(const std::vector<Feature>& from,
                                    const std::vector<Feature>& to, int dimension, double least,
                                    double most) {
  return dimension == 2 ? Bound(EdgesOf(from), EdgesOf(to), least, most)
                        : Bound(CornersOf(from), CornersOf(to), least, most);
}

}  // namespace dynmesh::preparation
