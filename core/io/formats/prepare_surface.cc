#include "core/io/formats/prepare_surface.h"

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

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
                   const std::function<void(FeatureId, FeatureId)>& found) {
  const MeshOptions options = OptionsOf(features);
  if (ValidateOptions(options).ok()) {
    plc::FindConflicts(options, features, is_looked_at, found);
  }
}

bool HasFacesToCut(const std::vector<Feature>& features) {
  return std::ranges::any_of(features, [](const Feature& f) {
    return f.kind == FeatureKind::kPolygon && f.rings.front().size() > 3;
  });
}

coplanar::JoinedFaces Join(const GeometryOptions& options, FileFeatures& file) {
  coplanar::JoinOptions joining;
  joining.join = options.join_flat;
  joining.holes = options.holes_of_polygons;
  joining.rounding = [&](double x) { return file.rounding.Of(x); };
  joining.conflicts = FindConflicts;
  coplanar::JoinedFaces joined = coplanar::JoinFlat(file.features, joining);
  for (const auto& [part, whole] : joined.parts) {
    file.lines.resize(part, 1);
    file.lines[part - 1] = file.lines[whole - 1];
  }
  file.features = std::move(joined.features);
  return joined;
}

// What was done, for users: "2 point(s) made one with others, 12 faces joined into 6 polygon(s)".
// Empty if nothing.
std::string TextOf(const SurfaceMends& mends, const coplanar::JoinedFaces& joined) {
  std::string text;
  const auto add = [&](std::size_t count, const auto&... what) {
    if (count != 0) text += text::Concat(text.empty() ? "" : ", ", count, " ", what...);
  };
  add(mends.equal_points + mends.near_points, "point(s) made one with others");
  add(mends.faces_twice, "face(s) twice left out");
  add(mends.faces_without_area + joined.needles, "face(s) without area left out");
  add(joined.cut, "face(s) not flat cut into triangles");
  add(joined.joined, "faces joined into ", joined.polygons, " polygon(s)");
  add(joined.moved, "corner(s) moved by up to ", static_cast<float>(joined.most_moved));
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
  if ((options.join_flat || HasFacesToCut(file.features)) &&
      std::ranges::all_of(file.features,
                          [](const Feature& f) { return coplanar::IsInDomain(f.position); })) {
    joined = Join(options, file);
  }
  Geometry geometry = GeometryOfSpace(std::move(file), path);
  if (const std::string done = TextOf(mends, joined); !done.empty()) {
    geometry.warnings.push_back(text::Concat(path, ": ", done));
  }
  return geometry;
}

}  // namespace dynmesh::io
