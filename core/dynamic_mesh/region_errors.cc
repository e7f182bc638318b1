#include "core/dynamic_mesh/region_errors.h"

#include <algorithm>
#include <iterator>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "dynmesh/mesh.h"

namespace dynmesh {
namespace {

// "{1, 2, 5, and 3 more}"
std::string ListOf(const std::vector<FeatureId>& polygons) {
  constexpr std::size_t kMost = 4;
  std::string list;
  for (std::size_t i = 0; i < std::min(kMost, polygons.size()); ++i) {
    list += (i == 0 ? "{" : ", ") + std::to_string(polygons[i]);
  }
  if (polygons.size() > kMost) list += ", and " + std::to_string(polygons.size() - kMost) + " more";
  return list + "}";
}

}  // namespace

absl::Status CollisionError(int dimension, const RegionSets::Collision& collision) {
  const auto& [first, second] = collision;
  // A polygon that is not in both.
  std::vector<FeatureId> either;
  std::ranges::set_symmetric_difference(first, second, std::back_inserter(either));
  const FeatureId id = either.back();
  const std::string what = dimension == 2 ? "polygons " : "closed surfaces ";
  return MakeError(
      absl::StatusCode::kFailedPrecondition,
      (second.empty() ? "the region of " + what + ListOf(first) + " would have a reserved id"
                      : "the regions of " + what + ListOf(first) + " and " + ListOf(second) +
                            " would have the same id") +
          ", a hash of polygons' ids; give polygon " + std::to_string(id) + " another id",
      {reason::kIdCollision, {id}, {}});
}

absl::Status TooManyPolygonsError(int dimension, std::span<const FeatureId> polygons) {
  const FeatureId last = polygons.back();
  return MakeError(
      absl::StatusCode::kResourceExhausted,
      (dimension == 2 ? "polygon " : "the closed surface of polygon ") + std::to_string(last) +
          " lies over " + std::to_string(polygons.size() - 1) + " others, " +
          std::to_string(polygons[0]) + " and " + std::to_string(polygons[1]) +
          " among them, and no place may lie in more than " +
          std::to_string(kMostPolygonsAtAPlace) + " polygons; move or remove some of them",
      {reason::kPolygonLimit, {last}, {}});
}

}  // namespace dynmesh
