#include "core/coplanar/lone_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "core/base/rings.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/plane_fit.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

// More than a region allows of a plane (coplanar_regions.cc), in roundings.
constexpr double kBeyond = 16;

struct Plane {
  Vector3 normal{};  // of length 1
  double width = 0;  // of the face, across its longest extent; 0: it has no plane
  double extent = 0;
  double rounding = 0;
};

// `points` is memory that is used again.
Plane PlaneOf(const std::vector<Point3>& positions, const std::vector<Vector3>& roundings,
              const CornerRing& ring, PointRing& points) {
  Plane plane;
  points.clear();
  for (const Corner c : ring) points.push_back(positions[c]);
  plane.normal = AreaVector(points);
  for (const Point3& p : points) {
    plane.extent = std::max(plane.extent, geometry::SquaredDistance(p, points.front()));
  }
  plane.extent = 2 * std::sqrt(plane.extent);
  const double area = std::sqrt(geometry::Dot(plane.normal, plane.normal));
  if (!(area > 0) || !(plane.extent > 0)) return plane;
  for (double& x : plane.normal) x /= area;
  plane.width = area / plane.extent;
  for (const Corner c : ring) {
    plane.rounding = std::max(plane.rounding, RoundingAlong(plane.normal, roundings[c]));
  }
  return plane;
}

}  // namespace

std::vector<bool> LoneFaces(const std::vector<Point3>& positions,
                            const std::vector<Vector3>& roundings,
                            const std::vector<CornerRing>& faces) {
  // Edges by their lesser corner: the other one, and the face.
  std::vector<std::size_t> first(positions.size() + 1, 0);
  for (const CornerRing& face : faces) {
    ForEachEdgeOf(std::span(&face, 1), [&](Corner p, Corner q) { ++first[std::min(p, q) + 1]; });
  }
  for (std::size_t c = 0; c < positions.size(); ++c) first[c + 1] += first[c];
  std::vector<std::pair<Corner, std::size_t>> edges(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  std::vector<Plane> planes(faces.size());
  PointRing points;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].empty()) continue;
    planes[f] = PlaneOf(positions, roundings, faces[f], points);
    ForEachEdgeOf(std::span(&faces[f], 1), [&](Corner p, Corner q) {
      edges[next[std::min(p, q)]++] = {std::max(p, q), f};
    });
  }
  // May the corners of g be in the plane of f, as far as f tells it?
  const auto may_be_in = [&](std::size_t g, std::size_t f, Corner on_both) {
    const Plane& plane = planes[f];
    if (!(plane.width > 0)) return true;
    const double far = (planes[f].extent + planes[g].extent) / plane.width;
    const double near = kBeyond * std::max(plane.rounding, planes[g].rounding) * std::max(far, 1.0);
    return std::all_of(faces[g].begin(), faces[g].end(), [&](Corner c) {
      const Vector3 d = geometry::Difference(positions[c].c, positions[on_both].c);
      return std::abs(geometry::Dot(plane.normal, d)) <= near;
    });
  };
  std::vector<bool> lone(faces.size(), true);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!faces[f].empty() && !(planes[f].width > kBeyond * planes[f].rounding)) lone[f] = false;
  }
  for (Corner c = 0; c < positions.size(); ++c) {
    const auto begin = edges.begin() + static_cast<std::ptrdiff_t>(first[c]);
    const auto end = edges.begin() + static_cast<std::ptrdiff_t>(first[c + 1]);
    std::sort(begin, end);
    for (auto from = begin; from != end;) {
      auto to = from;
      while (to != end && to->first == from->first) ++to;
      if (to - from == 2) {
        const std::size_t f = from->second, g = (from + 1)->second;
        if ((lone[f] || lone[g]) && (may_be_in(g, f, c) || may_be_in(f, g, c))) {
          lone[f] = lone[g] = false;
        }
      }
      from = to;
    }
  }
  return lone;
}

}  // namespace dynmesh::coplanar
