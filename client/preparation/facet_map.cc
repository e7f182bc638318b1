#include "client/preparation/facet_map.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/box_tree.h"
#include "client/cleaning/patch_distance.h"
#include "client/cleaning/vectors3.h"
#include "client/preparation/triangles.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"

namespace dynmesh::preparation {
namespace {

using cleaning::Point3;

// Of a surface that is not prepared: what joining moves corners by, and more, in diagonals.
constexpr double kNear = 1e-6;

struct Middle {
  Point3 at{};
  double area2 = 0;  // of the largest triangle, squared
};

absl::flat_hash_map<FeatureId, Middle> MiddlesOf(const std::vector<Feature>& facets) {
  absl::flat_hash_map<FeatureId, Middle> middles;
  for (const PolygonPart& part : TrianglesOf(facets)) {
    const auto& [a, b, c] = part.corners;
    const Point3 normal = cleaning::NormalOf(a, b, c);
    const double area2 = cleaning::Dot(normal, normal);
    Middle& middle = middles[part.polygon];
    if (!(area2 > middle.area2)) continue;
    middle.area2 = area2;
    for (std::size_t k = 0; k < 3; ++k) middle.at[k] = a[k] + ((b[k] - a[k]) + (c[k] - a[k])) / 3;
  }
  return middles;
}

}  // namespace

std::vector<FeatureId> NearestPolygons(const std::vector<Feature>& facets,
                                       const std::vector<Feature>& prepared, double within) {
  namespace index = boost::geometry::index;
  const std::vector<PolygonPart> parts = TrianglesOf(prepared);
  std::vector<cleaning::BoxEntry> boxes;
  boxes.reserve(parts.size());
  for (std::uint32_t i = 0; i < parts.size(); ++i) {
    boxes.emplace_back(cleaning::TreeBoxOf(cleaning::Box3::Of(parts[i].corners)), i);
  }
  const cleaning::BoxTree tree(boxes.begin(), boxes.end());
  const auto nearest_to = [&](const Point3& at) {
    FeatureId nearest = kNoFeature;
    double least = within * within;
    const cleaning::Box3 near = cleaning::Box3{at, at}.Grown(within);
    for (auto it = tree.qbegin(index::intersects(cleaning::TreeBoxOf(near))); it != tree.qend();
         ++it) {
      const PolygonPart& part = parts[it->second];
      const double distance =
          cleaning::SquaredDistance<3>(at, cleaning::NearestOn(part.corners, at));
      if (distance > least) continue;
      if (distance == least && nearest != kNoFeature && nearest <= part.polygon) continue;
      least = distance;
      nearest = part.polygon;
    }
    return nearest;
  };
  const absl::flat_hash_map<FeatureId, Middle> middles = MiddlesOf(facets);
  std::vector<FeatureId> map;
  for (const Feature& f : facets) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    const auto middle = middles.find(f.id);
    const bool has_area = middle != middles.end() && middle->second.area2 > 0;
    map.push_back(has_area ? nearest_to(middle->second.at) : kNoFeature);
  }
  return map;
}

absl::StatusOr<std::vector<FeatureId>> PolygonsOfFacets(const std::string& path,
                                                        const io::Geometry& prepared,
                                                        double within) {
  const io::Format* const format = io::FindFormat(path);
  if (format == nullptr || !format->Is(io::kSurface)) {
    return absl::InvalidArgumentError(
        text::Concat(path, " is no surface file: its polygons have the file's ids"));
  }
  io::GeometryOptions options;
  options.faces = io::FaceRules::kAsTheyCome;
  const absl::StatusOr<io::Geometry> given = io::ReadGeometry(path, options);
  if (!given.ok()) return given.status();
  double diagonal2 = 0;
  const Box& box = prepared.options.box;
  for (std::size_t k = 0; k < 3; ++k) diagonal2 += std::pow(box.hi[k] - box.lo[k], 2);
  return NearestPolygons(given->features, prepared.features,
                         std::max(within, kNear * std::sqrt(diagonal2)));
}

}  // namespace dynmesh::preparation
