#include "client/cli/input.h"

#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/text.h"
#include "core/io/formats/mesh_input.h"
#include "core/plc/facet_rules.h"
#include "core/plc/rules.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// Merges coplanar faces of 3D input, with the tolerance that the mesh requires of polygons.
absl::StatusOr<Input> Finish(io::Geometry geometry, const std::string& path,
                             const InputFlags& flags) {
  Input input;
  static_cast<io::Geometry&>(input) = std::move(geometry);
  const bool in_space = input.options.dimension == 3;
  if (flags.merge_coplanar && !in_space) {
    return absl::InvalidArgumentError(
        Concat("--merge-coplanar: ", path, " is 2D; it joins faces of 3D input"));
  }
  // Faces of a mesh, cut into triangles, have angles that are no input of a mesh.
  if (!in_space || !(flags.merge_coplanar || flags.refine)) return input;
  // Coordinates out of range are refused with their feature, by this or by the mesh.
  const double limit = ValidateOptions(input.options).ok() ? plc::CloseLimit(input.options) : 0;
  const auto most = [&](double extent) { return plc::PlanarityTolerance(extent, limit); };
  const absl::Status joined = io::JoinFaces(flags.coplanar_tolerance, most, path, input);
  if (!joined.ok()) return joined;
  return input;
}

absl::Status CheckFormat(const std::string& path, const InputFlags& flags) {
  const io::Format* const format = io::FindFormat(path);
  if (flags.polygons && (format == nullptr || !format->Is(io::kMap))) {
    return absl::InvalidArgumentError(
        Concat("--polygons: ", path, " is no map; give a ",
               io::ListOfFormats([](const io::Format& f) { return f.Is(io::kMap); })));
  }
  if (!flags.refine && format != nullptr && format->read_sizes != nullptr) {
    return absl::InvalidArgumentError(Concat(path, ": ", format->extension,
                                             " files have target lengths: give it with --size, "
                                             "beside a geometry"));
  }
  return absl::OkStatus();
}

// Reads the file, and prepares it if the flags say so.
absl::StatusOr<io::Geometry> Read(const std::string& path, const InputFlags& flags,
                                  const io::GeometryOptions& options,
                                  std::optional<preparation::Report>& report) {
  const preparation::PrepareOptions preparing = {flags.within, flags.fill_holes,
                                                 flags.least_tolerance};
  if (!flags.prepare || flags.refine || flags.merge_coplanar ||
      !preparation::MayBePrepared(path, preparing)) {
    return io::ReadGeometry(path, options);
  }
  absl::StatusOr<preparation::Prepared> prepared = preparation::Prepare(path, options, preparing);
  if (!prepared.ok()) return prepared.status();
  report = std::move(prepared->report);
  if (report->is_mended || report->is_thinned) {
    prepared->geometry.warnings.push_back(Concat(
        path, report->is_mended ? ": mended: " : ": thinned: ", preparation::TextOf(*report)));
  }
  return std::move(prepared->geometry);
}

std::vector<Feature> FacesAsTheyCome(const std::string& path) {
  io::GeometryOptions options;
  options.faces = io::FaceRules::kAsTheyCome;
  absl::StatusOr<io::Geometry> geometry = io::ReadGeometry(path, options);
  return geometry.ok() ? std::move(geometry->features) : std::vector<Feature>();
}

}  // namespace

void AddInputFlags(CLI::App& command, InputFlags& flags) {
  command.add_flag(
      "--keep-facets", flags.keep_facets,
      Concat("Of a ", io::ListOfFormats([](const io::Format& f) { return f.Is(io::kSurface); }),
             ": keep faces as they are. Otherwise those in one plane within the rounding of the "
             "file's numbers become one polygon, whose corners move onto the plane, by 4 roundings "
             "at most, and `mesh`, `verify` and `load` make faces that are finer than --within "
             "fewer"));
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

void AddMapFlags(CLI::App& command, InputFlags& flags) {
  flags.is_map_of_polygons = true;
  CLI::Option* const polygons = command.get_option("--polygons");
  polygons->description("Polygons of a map become polygon features (the default)");
  command
      .add_flag("!--segments", flags.is_map_of_polygons,
                "Polygons of a map become segments, not polygon features")
      ->excludes(polygons);
}

void AddPreparationFlags(CLI::App& command, InputFlags& flags) {
  flags.prepare = true;
  CLI::Option* const exact =
      command.add_flag("!--exact", flags.prepare,
                       "Refuse what a mesh refuses, and keep a surface's faces. Otherwise a "
                       "surface, a map or a 2D .poly or .node that a mesh "
                       "refuses is mended first, and so are cracks between a surface's open edges");
  command
      .add_option(
          "--within", flags.within,
          "How far mending and thinning a surface may move an edge or a face, to both "
          "sides (default: 1e-4 of the diagonal of the input's box). Given, 3D .poly, .smesh, .msh "
          "and .mesh are mended, too")
      ->type_name("D")
      ->excludes(exact);
  command
      .add_option("--fill-holes", flags.fill_holes,
                  "Of a surface: fill holes, loops of edges with one face, up to this length. Flat "
                  "ones become a polygon, others triangles of their corners")
      ->type_name("LENGTH")
      ->excludes(exact);
  command
      .add_option(
          "--mending-tolerance", flags.least_tolerance,
          "Of a surface: mend it with no lesser tolerance, even if a mesh accepts it. `mesh` "
          "does so by itself where it would take too many vertices, and says with which one")
      ->type_name("T")
      ->excludes(exact);
}

absl::StatusOr<Input> InputOfElements(const io::ElementMesh& mesh, const std::string& path,
                                      const InputFlags& flags) {
  return Finish(io::GeometryOfElements(mesh, path, flags.refine), path, flags);
}

absl::StatusOr<Input> LoadInput(const std::string& path, const InputFlags& flags) {
  if (auto status = CheckFormat(path, flags); !status.ok()) return status;
  const io::Format* const format = io::FindFormat(path);
  io::GeometryOptions options = flags;
  options.any_script = true;
  options.polygons |= flags.is_map_of_polygons && format != nullptr && format->Is(io::kMap);
  std::optional<preparation::Report> report;
  absl::StatusOr<io::Geometry> geometry = Read(path, flags, options, report);
  if (!geometry.ok()) return geometry.status();
  const bool is_script = !flags.refine && (format == nullptr || format->Is(io::kScript));
  const bool is_empty = geometry->features.empty() && !is_script;
  absl::StatusOr<Input> input = Finish(*std::move(geometry), path, flags);
  if (input.ok()) {
    input->preparation = std::move(report);
    if (format != nullptr && format->Is(io::kSurface)) {
      input->read_faces = [path] { return FacesAsTheyCome(path); };
    }
  }
  if (!input.ok() || !is_empty) return input;
  if (const std::uint64_t dropped = input->mended.dropped; dropped != 0) {
    return absl::InvalidArgumentError(Concat(path, ": nothing is left: 0 polygons and 0 segments; ",
                                             dropped, " ring(s) without an area"));
  }
  return absl::InvalidArgumentError(
      Concat(path, ":1: the file has no points, segments or polygons"));
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

}  // namespace dynmesh::cli
