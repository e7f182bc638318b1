#include "core/coplanar/lone_faces.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "absl/container/flat_hash_map.h"
#include "core/base/rings.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/plane_fit.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

// More than a region allows of a plane (coplanar_regions.cc), in roundings.
constexpr double kBeyond = 16;

constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();

struct Plane {
  Vector3 normal{};  // of length 1
  double width = 0;  // of the face, across its longest extent; 0: it has no plane
  double extent = 0;
  double rounding = 0;
};

Plane PlaneOf(const std::vector<Point3>& positions, const std::vector<Vector3>& roundings,
              const CornerRing& ring) {
  Plane plane;
  PointRing points;
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
  struct Sides {
    std::size_t first = kNone, second = kNone;
    bool has_more = false;
  };
  absl::flat_hash_map<CornerPair, Sides> sides;
  sides.reserve(faces.size() * 2);
  std::vector<Plane> planes(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (faces[f].empty()) continue;
    planes[f] = PlaneOf(positions, roundings, faces[f]);
    ForEachEdgeOf(std::span(&faces[f], 1), [&](Corner p, Corner q) {
      Sides& at = sides[std::minmax(p, q)];
      if (at.first == kNone) {
        at.first = f;
      } else if (at.second == kNone) {
        at.second = f;
      } else {
        at.has_more = true;
      }
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
  for (const auto& [edge, at] : sides) {
    if (at.second == kNone || at.has_more) continue;
    if (!lone[at.first] && !lone[at.second]) continue;
    if (!may_be_in(at.second, at.first, edge.first) &&
        !may_be_in(at.first, at.second, edge.first)) {
      continue;
    }
    lone[at.first] = lone[at.second] = false;
  }
  return lone;
}

}  // namespace dynmesh::coplanar
