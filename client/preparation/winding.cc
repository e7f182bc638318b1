#include "client/preparation/winding.h"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/vectors3.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"

namespace dynmesh::preparation {
namespace {

using cleaning::Cross;
using cleaning::Dot;
using cleaning::Minus;
using cleaning::Point3;
using Corner = std::uint32_t;

struct Faces {
  std::vector<Point3> corners;
  std::vector<std::array<Corner, 3>> triangles;  // fans of the polygons
  bool is_oriented = true;
};

Faces FacesOf(const std::vector<Feature>& features) {
  Faces faces;
  absl::flat_hash_map<Point3, Corner> at;
  absl::flat_hash_map<FeatureId, Corner> corner_of;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    const auto [it, is_new] = at.emplace(f.position, static_cast<Corner>(faces.corners.size()));
    if (is_new) faces.corners.push_back(f.position);
    corner_of[f.id] = it->second;
  }
  // Of each edge: how many faces go along it from its lesser corner, and from the other one.
  absl::flat_hash_map<std::pair<Corner, Corner>, std::array<int, 2>> uses;
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) {
      const Corner a = corner_of.at(p), b = corner_of.at(q);
      if (a != b) ++uses[std::minmax(a, b)][a < b ? 0 : 1];
    });
    for (const std::vector<FeatureId>& ring : f.rings) {
      for (std::size_t i = 2; i < ring.size(); ++i) {
        faces.triangles.push_back(
            {corner_of.at(ring[0]), corner_of.at(ring[i - 1]), corner_of.at(ring[i])});
      }
    }
  }
  for (const auto& [edge, count] : uses) {
    if (count[0] + count[1] == 2 && count[0] != 1) faces.is_oriented = false;
  }
  return faces;
}

// Of triangle abc seen from the origin, by its orientation (A. van Oosterom and J. Strackee, 1983).
double SolidAngle(const Point3& a, const Point3& b, const Point3& c) {
  const double la = std::sqrt(Dot(a, a)), lb = std::sqrt(Dot(b, b)), lc = std::sqrt(Dot(c, c));
  const double volume = Dot(a, Cross(b, c));
  return 2 * std::atan2(volume, la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb);
}

}  // namespace

std::optional<std::vector<double>> WindingNumbers(const std::vector<Feature>& features,
                                                  std::span<const std::array<double, 3>> places) {
  const Faces faces = FacesOf(features);
  if (!faces.is_oriented) return std::nullopt;
  std::vector<double> numbers;
  for (const Point3& place : places) {
    double sum = 0;
    for (const auto& [a, b, c] : faces.triangles) {
      sum += SolidAngle(Minus(faces.corners[a], place), Minus(faces.corners[b], place),
                        Minus(faces.corners[c], place));
    }
    numbers.push_back(sum / (4 * std::numbers::pi));
  }
  return numbers;
}

}  // namespace dynmesh::preparation
