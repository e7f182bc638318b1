#include "core/io/formats/geometry.h"

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/base/text.h"
#include "core/coplanar/merge_coplanar.h"
#include "core/io/common/extension.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/mesh_input.h"
#include "core/io/script/script_features.h"

namespace dynmesh::io {
namespace {

using text::Concat;

// Keeps only the places of features in the file.
void SetWhere(FileFeatures file, Geometry& geometry) {
  file.features.clear();
  auto source = std::make_shared<const FileFeatures>(std::move(file));
  geometry.where = [source](FeatureId id) { return source->Where(id); };
}

// The file's labels, with the names of a map's polygons.
void TakeLabels(FileFeatures& file, Geometry& geometry) {
  for (const PolygonName& polygon : file.polygons) {
    const std::string& name = polygon.name.empty() ? polygon.key : polygon.name;
    if (!name.empty()) file.labels.names[polygon.id] = name;
  }
  geometry.labels = std::make_shared<const FeatureLabels>(std::move(file.labels));
}

void TakeSeeds(FileFeatures& file, const std::string& path, Geometry& geometry) {
  geometry.holes = std::move(file.holes);
  geometry.regions = std::move(file.regions);
  geometry.seed_file = path;
}

// A segment along each edge between faces of different markers: it keeps them from being joined.
// Ids are above all others.
void DivideByMarkers(const FeatureLabels& labels, std::vector<Feature>& features) {
  if (labels.markers.empty()) return;
  FeatureId next_id = 0;
  std::map<std::pair<FeatureId, FeatureId>, std::int64_t> marker_of;
  std::set<std::pair<FeatureId, FeatureId>> divided;
  for (const Feature& f : features) {
    next_id = std::max(next_id, f.id);
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    const std::int64_t marker = labels.MarkerOf(f.id);
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) {
      const auto [it, is_new] = marker_of.emplace(std::minmax(p, q), marker);
      if (!is_new && it->second != marker) divided.insert(it->first);
    });
  }
  for (const auto& [p, q] : divided) features.push_back(Feature::Segment(++next_id, p, q));
}

// The script without its batches.
EditScript HeaderOf(const EditScript& script) {
  EditScript header = script;
  header.batches.clear();
  return header;
}

absl::Status NoGeometry(const std::string& path) {
  const std::string extension = ExtensionOf(path);
  const Format* const format = FindFormat(path);
  if (format != nullptr && format->read_sizes != nullptr) {
    return absl::InvalidArgumentError(Concat(
        path, ": ", extension, " files have target lengths: they are read beside a geometry"));
  }
  if (format != nullptr || IsOtherFormat(path)) {
    return absl::UnimplementedError(
        Concat(path, ": ", extension, " files as input are not supported yet in this version; use ",
               GeometryFormats()));
  }
  return absl::InvalidArgumentError(
      Concat(path, ": the extension must be ",
             ListOfFormats([](const Format& f) { return f.read_geometry != nullptr; })));
}

}  // namespace

Geometry GeometryOfPlane(FileFeatures file, const std::string& path) {
  Geometry geometry;
  geometry.options.box = BoundingBox(file.features);
  if (file.heights != 0) {
    geometry.warnings.push_back(Concat(path, ": ", file.heights, " height(s) ignored"));
  }
  TakeLabels(file, geometry);
  if (file.wraps != 0) {
    geometry.warnings.push_back(Concat(path, ": ", file.wraps,
                                       " segment(s) span more than 180 degrees and are drawn right "
                                       "across the map; cut lines at the antimeridian"));
  }
  if (file.gaps != 0) {
    geometry.warnings.push_back(
        Concat(path, ": ", file.gaps, " gap(s) in rings closed with an edge"));
  }
  TakeSeeds(file, path, geometry);
  geometry.features = std::move(file.features);
  geometry.polygon_names = std::move(file.polygons);
  SetWhere(std::move(file), geometry);
  return geometry;
}

Geometry GeometryOfSpace(FileFeatures file, const std::string& path) {
  Geometry geometry;
  geometry.options.dimension = 3;
  geometry.options.quality = DefaultQuality(3);
  geometry.options.min_dihedral = DefaultMinDihedral(3);
  geometry.options.box = BoundingBox(file.features, 3);
  TakeLabels(file, geometry);
  TakeSeeds(file, path, geometry);
  geometry.features = std::move(file.features);
  geometry.rounding = file.rounding;
  SetWhere(std::move(file), geometry);
  return geometry;
}

Geometry GeometryOfElements(const ElementMesh& mesh, const std::string& path, bool refine) {
  FileFeatures file =
      FeaturesOf(mesh, refine ? ElementVertices::kAll : ElementVertices::kOfConstraints);
  if (refine) AddLimits(mesh, file);
  return mesh.dimension == 2 ? GeometryOfPlane(std::move(file), path)
                             : GeometryOfSpace(std::move(file), path);
}

absl::StatusOr<Geometry> GeometryOfScript(const EditScript& script) {
  absl::StatusOr<ScriptFeatures> last = FeaturesAfter(script);
  if (!last.ok()) return last.status();
  Geometry geometry;
  geometry.options = script.Options();
  geometry.features = std::move(last->features);
  geometry.labels = std::make_shared<const FeatureLabels>(script.labels);
  geometry.where = [places = std::make_shared<const std::map<FeatureId, std::string>>(
                        std::move(last->places))](FeatureId id) {
    const auto it = places->find(id);
    return it == places->end() ? std::string() : it->second;
  };
  geometry.where_option = [header = HeaderOf(script)](std::string_view option) {
    return header.WhereOption(option);
  };
  return geometry;
}

absl::StatusOr<Geometry> ReadGeometry(const std::string& path, const GeometryOptions& options) {
  if (options.refine) {
    const absl::StatusOr<ElementMesh> mesh = ReadElements(path);
    if (!mesh.ok()) return mesh.status();
    return GeometryOfElements(*mesh, path, true);
  }
  const Format* const format = FindFormat(path);
  if (format != nullptr && format->read_geometry != nullptr) {
    return format->read_geometry(path, options);
  }
  if (format != nullptr || IsOtherFormat(path) || !options.any_script) return NoGeometry(path);
  const absl::StatusOr<EditScript> script = ReadEditScript(path);
  return script.ok() ? GeometryOfScript(*script) : script.status();
}

void KeepPlacesOfParts(const std::vector<std::pair<FeatureId, FeatureId>>& parts,
                       Geometry& geometry) {
  if (parts.empty()) return;
  auto labels = std::make_shared<FeatureLabels>(*geometry.labels);
  KeepLabelsOfParts(parts, *labels);
  std::map<FeatureId, FeatureId> whole_of(parts.begin(), parts.end());
  geometry.labels = std::move(labels);
  geometry.where = [whole_of =
                        std::make_shared<const std::map<FeatureId, FeatureId>>(std::move(whole_of)),
                    where = std::move(geometry.where)](FeatureId id) {
    const auto it = whole_of->find(id);
    return where(it == whole_of->end() ? id : it->second);
  };
}

absl::Status JoinFaces(double tolerance, const std::function<double(double)>& most,
                       const std::string& path, Geometry& geometry) {
  FeatureId last = 0;
  for (const Feature& f : geometry.features) last = std::max(last, f.id);
  DivideByMarkers(*geometry.labels, geometry.features);
  absl::StatusOr<coplanar::MergedFaces> merged =
      coplanar::MergeCoplanar(geometry.features, tolerance, most);
  if (!merged.ok()) return Locate(merged.status(), geometry.where);
  if (merged->too_thick != 0) {
    geometry.warnings.push_back(Concat(path, ": ", merged->too_thick,
                                       " part(s) within the tolerance of a plane not joined: a "
                                       "mesh wants polygons flat to 1e-9 of their extent"));
  }
  geometry.features = std::move(merged->features);
  std::erase_if(geometry.features, [&](const Feature& f) { return f.id > last; });
  return absl::OkStatus();
}

}  // namespace dynmesh::io
