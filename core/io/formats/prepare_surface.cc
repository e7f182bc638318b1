#include "core/io/formats/prepare_surface.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "core/base/feature_kinds.h"
#include "core/base/rounding.h"
#include "core/base/text.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/join_flat.h"
#include "core/io/space/surface_mending.h"
#include "core/plc/conflicts.h"
#include "dynmesh/options.h"

namespace dynmesh::io {
namespace {

// The options of a mesh of the features.
MeshOptions OptionsOf(const std::vector<Feature>& features) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = DefaultQuality(3);
  options.min_dihedral = DefaultMinDihedral(3);
  options.box = BoundingBox(features, 3);
  return options;
}

// What a mesh of the features refuses.
void FindConflicts(const std::vector<Feature>& features,
                   const std::function<bool(FeatureId)>& is_looked_at,
                   const std::function<bool(FeatureId)>& is_new,
                   const std::function<void(FeatureId)>& found) {
  const MeshOptions options = OptionsOf(features);
  if (ValidateOptions(options).ok()) {
    plc::FindConflicts(options, features, is_looked_at, is_new, found);
  }
}

bool HasFacesToCut(const std::vector<Feature>& features) {
  return std::ranges::any_of(features, [](const Feature& f) {
    return Is<APolygon>(f, Not<APoint, ASegment, ASize>) && f.rings.front().size() > 3;
  });
}

coplanar::JoinedFaces Join(const GeometryOptions& options, const NumberRounding& rounding,
                           const FeatureLabels& labels, std::vector<Feature> features,
                           std::optional<Verdict>& verdict) {
  coplanar::JoinOptions joining;
  joining.join = !options.keep_facets;
  joining.holes = options.holes_of_polygons;
  joining.rounding = [&](double x) { return rounding.Of(x); };
  joining.conflicts = FindConflicts;
  if (options.judge) {
    joining.accepts = [&](const std::vector<Feature>& result) {
      verdict = options.judge(result, OptionsOf(result));
      return verdict->ok() || absl::IsResourceExhausted(verdict->status());
    };
  }
  LabelNumbers numbers(labels);
  joining.group = [&](FeatureId id) { return numbers.Of(id); };
  coplanar::JoinedFaces joined = coplanar::JoinFlat(std::move(features), joining);
  if (!joined.is_accepted) verdict.reset();
  return joined;
}

bool AreInDomain(const std::vector<Feature>& features) {
  return std::ranges::all_of(features,
                             [](const Feature& f) { return coplanar::IsInDomain(f.position); });
}

SurfaceCounts CountsOf(const SurfaceMends& mends, const coplanar::JoinedFaces& joined) {
  SurfaceCounts counts;
  counts.points = mends.equal_points + mends.near_points;
  counts.faces_twice = mends.faces_twice;
  counts.faces_without_area = mends.faces_without_area + joined.needles;
  counts.cut = joined.cut;
  counts.joined = joined.joined;
  counts.polygons = joined.polygons;
  counts.moved = joined.moved;
  counts.most_moved = joined.most_moved;
  return counts;
}

// What was done, for users: "2 point(s) made one with others, 12 faces joined into 6 polygon(s)".
// Empty if nothing.
std::string TextOf(const SurfaceCounts& counts) {
  std::string text;
  const auto add = [&](std::size_t count, const auto&... what) {
    if (count != 0) text += text::Concat(text.empty() ? "" : ", ", count, " ", what...);
  };
  add(counts.points, "point(s) made one with others");
  add(counts.faces_twice, "face(s) twice left out");
  add(counts.faces_without_area, "face(s) without area left out");
  add(counts.cut, "face(s) not flat cut into triangles");
  add(counts.joined, "faces joined into ", counts.polygons, " polygon(s)");
  add(counts.moved, "corner(s) moved by up to ", static_cast<float>(counts.most_moved));
  return text;
}

}  // namespace

absl::StatusOr<Geometry> PrepareSurface(FileFeatures file, const std::string& path,
                                        const GeometryOptions& options) {
  const MeshOptions mesh = OptionsOf(file.features);
  // Coordinates out of range are refused with their feature, by the mesh.
  const double near = ValidateOptions(mesh).ok() ? LeastDistance(mesh) : 0;
  const SurfaceMends mends = MendSurface(near, file);
  coplanar::JoinedFaces joined;
  std::optional<Verdict> verdict;
  if ((!options.keep_facets || HasFacesToCut(file.features)) && AreInDomain(file.features)) {
    joined = Join(options, file.rounding, file.labels, std::move(file.features), verdict);
    for (const auto& [part, whole] : joined.parts) {
      file.lines.resize(part, 1);
      file.lines[part - 1] = file.lines[whole - 1];
    }
    file.features = std::move(joined.features);
  }
  const SurfaceCounts counts = CountsOf(mends, joined);
  Geometry geometry = GeometryOfSpace(std::move(file), path);
  geometry.surface = counts;
  geometry.verdict = std::move(verdict);
  if (const std::string done = TextOf(counts); !done.empty()) {
    geometry.warnings.push_back(text::Concat(path, ": ", done));
  }
  return geometry;
}

SurfaceCounts JoinFacesInOnePlane(const GeometryOptions& options, Geometry& geometry) {
  geometry.verdict.reset();
  if (options.keep_facets || !AreInDomain(geometry.features)) return {};
  coplanar::JoinedFaces joined = Join(options, geometry.rounding, *geometry.labels,
                                      std::move(geometry.features), geometry.verdict);
  geometry.features = std::move(joined.features);
  KeepPlacesOfParts(joined.parts, geometry);
  geometry.options.box = BoundingBox(geometry.features, 3);
  return CountsOf({}, joined);
}

}  // namespace dynmesh::io
