#include "client/cli/input.h"

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cli/sizes_of_limits.h"
#include "core/base/rings.h"
#include "core/base/text.h"
#include "core/coplanar/merge_coplanar.h"
#include "core/io/common/extension.h"
#include "core/io/maps/map_files.h"
#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "core/io/space/space_input.h"
#include "core/io/space/surface_files.h"
#include "core/plc/facet_rules.h"
#include "core/plc/rules.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// Keeps only the positions of features in the file.
void SetWhere(io::FileFeatures file, Input& input) {
  file.features.clear();
  auto source = std::make_shared<const io::FileFeatures>(std::move(file));
  input.where = [source](FeatureId id) { return source->Where(id); };
}

// The file's labels, with the names of a map's polygons.
void TakeLabels(io::FileFeatures& file, Input& input) {
  for (const io::PolygonName& polygon : file.polygons) {
    const std::string& name = polygon.name.empty() ? polygon.key : polygon.name;
    if (!name.empty()) file.labels.names[polygon.id] = name;
  }
  input.labels = std::make_shared<const io::FeatureLabels>(std::move(file.labels));
}

Input FromPlanar(io::FileFeatures planar, const std::string& path) {
  Input input;
  input.options.box = io::BoundingBox(planar.features);
  const auto ignored = [&](std::uint64_t count, const char* what) {
    if (count != 0) input.warnings.push_back(Concat(path, ": ", count, " ", what, " ignored"));
  };
  ignored(planar.heights, "height(s)");
  TakeLabels(planar, input);
  if (planar.wraps != 0) {
    input.warnings.push_back(Concat(path, ": ", planar.wraps,
                                    " segment(s) span more than 180 degrees and are drawn right "
                                    "across the map; cut lines at the antimeridian"));
  }
  if (planar.gaps != 0) {
    input.warnings.push_back(
        Concat(path, ": ", planar.gaps, " gap(s) in rings closed with an edge"));
  }
  input.features = std::move(planar.features);
  input.holes = std::move(planar.holes);
  input.regions = std::move(planar.regions);
  input.seed_file = path;
  input.polygon_names = std::move(planar.polygons);
  SetWhere(std::move(planar), input);
  return input;
}

// A segment along each edge between faces of different markers: it keeps them from being joined.
// Ids are above all others.
void DivideByMarkers(const io::FeatureLabels& labels, std::vector<Feature>& features) {
  if (labels.markers.empty()) return;
  FeatureId next_id = 0;
  std::map<std::pair<FeatureId, FeatureId>, std::int64_t> marker_of;
  std::set<std::pair<FeatureId, FeatureId>> divided;
  for (const Feature& f : features) {
    next_id = std::max(next_id, f.id);
    if (f.kind != FeatureKind::kPolygon) continue;
    const std::int64_t marker = labels.MarkerOf(f.id);
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) {
      const auto [it, is_new] = marker_of.emplace(std::minmax(p, q), marker);
      if (!is_new && it->second != marker) divided.insert(it->first);
    });
  }
  for (const auto& [p, q] : divided) features.push_back(Feature::Segment(++next_id, p, q));
}

// Merges coplanar faces of 3D input, with the tolerance that the mesh requires of polygons.
absl::Status Merge(const std::string& path, const InputFlags& flags,
                   const std::function<std::string(FeatureId)>& where, Input& input) {
  // Coordinates out of range are refused with their feature, by this or by the mesh.
  const double limit = ValidateOptions(input.options).ok() ? plc::CloseLimit(input.options) : 0;
  FeatureId last = 0;
  for (const Feature& f : input.features) last = std::max(last, f.id);
  DivideByMarkers(*input.labels, input.features);
  absl::StatusOr<coplanar::MergedFaces> merged = coplanar::MergeCoplanar(
      input.features, flags.coplanar_tolerance,
      [&](double extent) { return plc::PlanarityTolerance(extent, limit); });
  if (!merged.ok()) return Locate(merged.status(), where);
  if (merged->too_thick != 0) {
    input.warnings.push_back(Concat(path, ": ", merged->too_thick,
                                    " part(s) within the tolerance of a plane not joined: a mesh "
                                    "wants polygons flat to 1e-9 of their extent"));
  }
  input.features = std::move(merged->features);
  std::erase_if(input.features, [&](const Feature& f) { return f.id > last; });
  return absl::OkStatus();
}

absl::Status RefuseMerge(const std::string& path) {
  return absl::InvalidArgumentError(
      Concat("--merge-coplanar: ", path, " is 2D; it joins faces of 3D input"));
}

absl::StatusOr<Input> FromSpace(io::FileFeatures file, const std::string& path,
                                const InputFlags& flags) {
  Input input;
  input.options.dimension = 3;
  input.options.quality = DefaultQuality(3);
  input.options.min_dihedral = DefaultMinDihedral(3);
  input.options.box = io::BoundingBox(file.features, 3);
  TakeLabels(file, input);
  if (flags.merge_coplanar) {
    input.features = std::move(file.features);
    const auto where = [&](FeatureId id) { return file.Where(id); };
    if (auto s = Merge(path, flags, where, input); !s.ok()) return s;
    file.features = std::move(input.features);
  }
  input.holes = std::move(file.holes);
  input.regions = std::move(file.regions);
  input.seed_file = path;
  input.features = std::move(file.features);
  SetWhere(std::move(file), input);
  return input;
}

// The features after a script's last line, and the line of the last edit of each.
class ScriptState {
 public:
  absl::Status Apply(const Edit& edit, const std::string& where) {
    const FeatureId id = edit.feature.id;
    const auto it = features_.find(id);
    const bool present = it != features_.end();
    if (edit.action == Edit::Action::kAdd) {
      if (present) return Error(where, Concat("feature ", id, " is there already: use set"));
      features_[id] = {edit.feature, where};
      return absl::OkStatus();
    }
    if (!present) return Error(where, Concat("there is no feature ", id));
    if (edit.action == Edit::Action::kRemove) {
      features_.erase(it);
      return absl::OkStatus();
    }
    if (edit.action == Edit::Action::kMove && it->second.first.kind != FeatureKind::kPoint) {
      return Error(where, Concat("feature ", id, " is no point: it cannot be moved"));
    }
    it->second = {edit.feature, where};
    return absl::OkStatus();
  }

  Input Finish(const MeshOptions& options) const {
    Input input;
    input.options = options;
    auto places = std::make_shared<std::map<FeatureId, std::string>>();
    for (const auto& [id, entry] : features_) {
      input.features.push_back(entry.first);
      places->emplace(id, entry.second);
    }
    input.where = [places](FeatureId id) {
      const auto it = places->find(id);
      return it == places->end() ? std::string() : it->second;
    };
    return input;
  }

 private:
  static absl::Status Error(const std::string& where, const std::string& message) {
    return absl::InvalidArgumentError(Concat(where, ": ", message));
  }

  std::map<FeatureId, std::pair<Feature, std::string>> features_;
};

// The script without its batches.
io::EditScript HeaderOf(const io::EditScript& script) {
  io::EditScript header = script;
  header.batches.clear();
  return header;
}

absl::StatusOr<Input> FromScript(const io::EditScript& script, const std::string& path,
                                 const InputFlags& flags) {
  ScriptState state;
  for (std::size_t b = 0; b < script.batches.size(); ++b) {
    const io::ScriptBatch& batch = script.batches[b];
    for (std::size_t e = 0; e < batch.edits.size(); ++e) {
      if (auto s = state.Apply(batch.edits[e], script.Where(b, e)); !s.ok()) return s;
    }
  }
  Input input = state.Finish(script.Options());
  input.labels = std::make_shared<const io::FeatureLabels>(script.labels);
  input.where_option = [header = HeaderOf(script)](std::string_view option) {
    return header.WhereOption(option);
  };
  if (!flags.merge_coplanar) return input;
  if (input.options.dimension == 2) return RefuseMerge(path);
  if (auto s = Merge(path, flags, input.where, input); !s.ok()) return s;
  return input;
}

// The most area or volume of simplices of a mesh as sizes: in 2D polygons, in 3D the inscribed
// balls. Ids follow the others'.
void AddLimits(const io::ElementMesh& mesh, io::FileFeatures& file) {
  FeatureId next_id = file.features.size();
  file.files_from[next_id + 1] = io::ElementMesh::Or(mesh.limit_file, mesh.file);
  for (std::size_t i = 0; i < mesh.limits.size(); ++i) {
    if (!(mesh.limits[i] > 0)) continue;
    if (mesh.dimension == 2) {
      const auto& corners = mesh.triangles[i].corners;
      std::vector<FeatureId> ring;
      for (const std::uint32_t v : corners) ring.push_back(FeatureId{v} + 1);
      file.features.push_back(
          Feature::SizePolygon(++next_id, {std::move(ring)}, TargetOfArea(mesh.limits[i])));
    } else {
      transfer::Corners<3> corners;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = mesh.positions[mesh.tetrahedra[i].corners[k]];
      }
      const InscribedBall ball = InscribedBallOf(corners);
      file.features.push_back(
          Feature::Size(++next_id, ball.centre,
                        {SizeShape::kDisc, TargetOfVolume(mesh.limits[i]), ball.radius, {}}));
    }
    file.lines.push_back(mesh.limit_lines[i]);
  }
}

absl::StatusOr<Input> FromElements(const std::string& path, const InputFlags& flags) {
  const absl::StatusOr<io::ElementMesh> mesh = io::ReadElements(path);
  if (!mesh.ok()) return mesh.status();
  return InputOfElements(*mesh, path, flags);
}

bool IsMap(const std::string& path) {
  const std::string extension = io::ExtensionOf(path);
  return extension == ".geojson" || extension == ".topojson" || extension == ".json";
}

// Extensions of geometry and meshes that cannot be read: not to be taken for edit scripts.
bool IsOtherGeometry(std::string_view extension) {
  constexpr std::array<std::string_view, 34> kKinds = {
      ".3ds",  ".3mf",  ".bdf", ".brep", ".cdb",   ".cgns", ".csv", ".dae", ".dxf",
      ".e",    ".edge", ".ele", ".exo",  ".face",  ".fbx",  ".geo", ".glb", ".gltf",
      ".iges", ".igs",  ".inp", ".med",  ".meshb", ".nas",  ".png", ".shp", ".sldprt",
      ".step", ".stp",  ".svg", ".unv",  ".vtk",   ".vtp",  ".wkt"};
  return std::find(kKinds.begin(), kKinds.end(), extension) != kKinds.end();
}

bool IsSizes(std::string_view extension) {
  return extension == ".asc" || extension == ".npy" || extension == ".pos" || extension == ".mtr";
}

absl::StatusOr<Input> LoadMap(const std::string& path, const InputFlags& flags) {
  io::MapOptions options;
  options.polygons = flags.polygons;
  io::MendedRings mended;
  if (flags.mend_rings) options.mended = &mended;
  absl::StatusOr<io::FileFeatures> map = io::ReadMapFile(path, options);
  if (!map.ok()) return map.status();
  Input input = FromPlanar(*std::move(map), path);
  input.mended = mended;
  return input;
}

}  // namespace

void AddInputFlags(CLI::App& command, InputFlags& flags) {
  CLI::Option* const merge =
      command.add_flag("--merge-coplanar", flags.merge_coplanar,
                       "Of 3D input: join faces that lie in one plane and share edges");
  command
      .add_option("--coplanar-tolerance", flags.coplanar_tolerance,
                  "How far from the plane corners may be for that (default: 0, exactly in it); "
                  "polygons that would not be flat to 1e-9 of their extent, as a mesh wants them, "
                  "are not made")
      ->type_name("T")
      ->needs(merge)
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--polygons", flags.polygons,
                   "Polygons of a map become polygon features, not segments");
}

namespace {

// All but edit scripts: those have no extension of their own.
absl::StatusOr<std::optional<Input>> LoadGeometry(const std::string& path,
                                                  const InputFlags& flags) {
  const std::string extension = io::ExtensionOf(path);
  if (flags.polygons && !IsMap(path)) {
    return absl::InvalidArgumentError(
        Concat("--polygons: ", path, " is no map; give a .geojson, .topojson or .json"));
  }
  if (flags.refine || io::IsElementFile(path)) return FromElements(path, flags);
  using Read = absl::StatusOr<io::FileFeatures> (*)(const std::string&, io::FaceRules);
  const std::map<std::string, Read> in_space = {
      {".node", [](const std::string& file, io::FaceRules) { return io::ReadSpaceNodeFile(file); }},
      {".poly", io::ReadSpacePolyFile},
      {".smesh", io::ReadSmeshFile},
      {".off", io::ReadOffFile},
      {".stl", io::ReadStlFile},
      {".obj", io::ReadObjFile},
      {".ply", io::ReadPlyFile}};
  if (extension == ".node" || extension == ".poly") {
    absl::StatusOr<io::FileFeatures> planar =
        extension == ".node" ? io::ReadNodeFile(path) : io::ReadPolyFile(path);
    if (planar.ok()) {
      if (flags.merge_coplanar) return RefuseMerge(path);
      return FromPlanar(*std::move(planar), path);
    }
    // The 2D readers report 3D files so.
    if (!absl::IsUnimplemented(planar.status())) return planar.status();
  }
  if (const auto read = in_space.find(extension); read != in_space.end()) {
    absl::StatusOr<io::FileFeatures> file = read->second(path, flags.faces);
    if (!file.ok()) return file.status();
    return FromSpace(*std::move(file), path, flags);
  }
  if (IsMap(path)) {
    if (flags.merge_coplanar) return RefuseMerge(path);
    return LoadMap(path, flags);
  }
  if (IsOtherGeometry(extension)) {
    return absl::UnimplementedError(Concat(path, ": ", extension,
                                           " files as input are not supported yet in this version; "
                                           "use ",
                                           kSpaceInputKinds));
  }
  if (IsSizes(extension)) {
    return absl::InvalidArgumentError(Concat(path, ": ", extension,
                                             " files have target lengths: give it with --size, "
                                             "beside a geometry"));
  }
  return std::nullopt;
}

}  // namespace

absl::StatusOr<Input> InputOfElements(const io::ElementMesh& mesh, const std::string& path,
                                      InputFlags flags) {
  io::FileFeatures file = io::FeaturesOf(
      mesh, flags.refine ? io::ElementVertices::kAll : io::ElementVertices::kOfConstraints);
  if (flags.refine) AddLimits(mesh, file);
  if (mesh.dimension == 2) {
    if (flags.merge_coplanar) return RefuseMerge(path);
    return FromPlanar(std::move(file), path);
  }
  // Faces cut into triangles have angles that are no input of a mesh.
  flags.merge_coplanar |= flags.refine;
  return FromSpace(std::move(file), path, flags);
}

absl::StatusOr<Input> LoadInput(const std::string& path, const InputFlags& flags) {
  absl::StatusOr<std::optional<Input>> geometry = LoadGeometry(path, flags);
  if (!geometry.ok()) return geometry.status();
  if (*geometry) {
    if (!(*geometry)->features.empty()) return **std::move(geometry);
    if (const std::uint64_t dropped = (*geometry)->mended.dropped; dropped != 0) {
      return absl::InvalidArgumentError(Concat(path,
                                               ": nothing is left: 0 polygons and 0 segments; ",
                                               dropped, " ring(s) without an area"));
    }
    return absl::InvalidArgumentError(
        Concat(path, ":1: the file has no points, segments or polygons"));
  }
  const absl::StatusOr<io::EditScript> script = io::ReadEditScript(path);
  if (!script.ok()) return script.status();
  return FromScript(*script, path, flags);
}

absl::StatusOr<Input> LoadInputOfMesh(const char* flag, const std::string& path, int dimension,
                                      const InputFlags& flags) {
  absl::StatusOr<Input> input = LoadInput(path, flags);
  if (input.ok() && input->options.dimension != dimension) {
    return absl::InvalidArgumentError(absl::StrFormat("%s: %s is of %d dimensions, the mesh of %d",
                                                      flag, path, input->options.dimension,
                                                      dimension));
  }
  return input;
}

std::string LabelsLeftOut(const Input& input, const std::string& path) {
  const io::FeatureLabels& labels = *input.labels;
  std::string what;
  const auto add = [&](std::uint64_t count, const char* of_what) {
    if (count != 0) what += Concat(what.empty() ? "" : ", ", count, " ", of_what);
  };
  add(labels.attributes, "attribute(s) of points");
  return what.empty() ? "" : Concat(path, ": ", what, " left out: a server's mesh has none");
}

absl::Status Locate(const absl::Status& status,
                    const std::function<std::string(FeatureId)>& where) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  return detail ? LocateFeatures(status, detail->features, where) : status;
}

absl::Status LocateFeatures(const absl::Status& status, const std::vector<FeatureId>& features,
                            const std::function<std::string(FeatureId)>& where) {
  if (status.ok()) return status;
  std::string before;
  std::string after;
  for (const FeatureId id : features) {
    const std::string place = where(id);
    if (place.empty()) continue;
    if (before.empty()) {
      before = place + ": ";
    } else {
      after += Concat(after.empty() ? " (" : ", ", id, " at ", place);
    }
  }
  if (!after.empty()) after += ")";
  return absl::Status(status.code(), Concat(before, text::View(status.message()), after));
}

}  // namespace dynmesh::cli
