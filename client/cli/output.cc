#include "client/cli/output.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <thread>

#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/text_reader.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/mesh_output.h"
#include "core/io/pictures/mesh_picture.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// Is it one of Triangle's or TetGen's files of a mesh, with a common base name?
bool IsMeshPart(const std::string& path) { return io::StemOfMeshFiles(path) != path; }

// "z=0.5", or "z" for the middle.
absl::Status ParseCut(std::string_view flag, std::string_view text, io::SvgOptions& svg) {
  const std::size_t axis =
      text.empty() ? std::string_view::npos : std::string_view("xyz").find(text[0]);
  double at = 0;
  const bool has_position = text.size() > 1;
  if (axis == std::string_view::npos ||
      (has_position && (text[1] != '=' || !io::ParseDouble(text.substr(2), &at)))) {
    return absl::InvalidArgumentError(Concat(
        flag, ": expected an axis and a place as z=0.5, or an axis, found ", text::Quoted(text)));
  }
  svg.cut_axis = static_cast<int>(axis);
  if (has_position) svg.cut_at = at;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<io::SvgOptions> PictureOptions(const OutputFlags& flags, const MeshOptions& options,
                                              bool highlighting) {
  io::SvgOptions svg;
  // Highlights need a plain background.
  const std::string usual = options.kind == MeshKind::kQuadtree ? "size"
                            : highlighting                      ? "plain"
                                                                : "angle";
  const std::string chosen = flags.fill.empty() ? usual : flags.fill;
  const absl::StatusOr<io::SvgOptions::Fill> fill = io::ParseFill(chosen);
  if (!fill.ok()) return fill.status();
  svg.fill = *fill;
  svg.width = flags.width;
  svg.rho = options.quality;
  svg.min_dihedral = options.min_dihedral;
  svg.crop = options.box;
  svg.is_clip = !flags.clip.empty();
  svg.legend = flags.legend;
  for (const auto& [flag, text] : {std::pair("--cut", &flags.cut), {"--clip", &flags.clip}}) {
    if (text->empty()) continue;
    if (auto status = ParseCut(flag, *text, svg); !status.ok()) return status;
  }
  if (flags.crop == "all") {
    svg.crop.reset();
  } else if (!flags.crop.empty()) {
    const absl::StatusOr<Box> crop = io::ParseBox(flags.crop);
    if (!crop.ok()) return crop.status();
    // In the picture's axes. Across them the box stays, since a cut is in its middle.
    const auto axes = io::AxesAcross(options.dimension == 3 ? svg.cut_axis : 2);
    for (std::size_t k = 0; k < 2; ++k) {
      svg.crop->lo[axes[k]] = crop->lo[k];
      svg.crop->hi[axes[k]] = crop->hi[k];
    }
  }
  return svg;
}

void AddOutputFlags(CLI::App& command, OutputFlags& flags) {
  command
      .add_option(
          "-o,--output", flags.paths,
          Concat(
              "Where to write the mesh: ",
              io::ListOfFormats([](const io::Format& f) { return f.write_mesh && f.IsMainFile(); },
                                "or", true),
              "; of a quadtree ",
              io::ListOfFormats([](const io::Format& f) { return f.write_leaves != nullptr; }),
              "; may be given several times"))
      ->type_name("OUT")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--order", flags.order,
                  Concat("Order of the elements in ", io::SecondOrderFormats(),
                         "; 2: with a node in the middle of each edge (default: 1)"))
      ->type_name("1|2")
      ->check(CLI::Range(1, 2));
  command
      .add_option("--msh-version", flags.msh_version,
                  "Version of a .msh: 4.1, or 2.2 for programs that read no other (default: 4.1)")
      ->type_name("4.1|2.2");
  command.add_flag("--binary", flags.binary,
                   "Write the numbers of a .msh as bytes, which are read faster");
  command.add_flag("--zero-based", flags.from_zero,
                   "In .node and the files beside it, number from 0");
  command.add_flag("--neighbours,--neighbors", flags.neighbours,
                   "With a .node, write the neighbours of triangles or tetrahedra to .neigh");
  command.add_flag("--voronoi", flags.voronoi,
                   "With a .node, write the Voronoi diagram to .v.node and .v.edge");
  command.add_flag("--same-name", flags.same_name,
                   "A .node and the files beside it may have the base name of the input, though "
                   "Triangle and TetGen read some of them as a part of it");
  command
      .add_option("--threads", flags.threads,
                  "Threads that write a large mesh, at most, beside one that measures it; files do "
                  "not depend on it "
                  "(default: one for each processor, at most 8)")
      ->type_name("N")
      ->check(CLI::Range(1, 256));
  command
      .add_option("--fill", flags.fill,
                  "Colours of a picture (default: angle; plain with --highlight; size of a "
                  "quadtree, which has size, plain and none): by least angle, "
                  "in 3D dihedral (dihedral: with a legend), by circumradius / shortest edge, by "
                  "shortest edge, by whether a small input angle excuses a triangle over rho and, "
                  "with a legend, which tetrahedra are below --min-dihedral, by the polygons it "
                  "lies in")
      ->type_name("angle|dihedral|quality|size|exempt|region|plain|none");
  command
      .add_option("--crop", flags.crop,
                  "What a picture shows (default: the box of the features), of a cut along its "
                  "two axes; `all`: with the surroundings")
      ->type_name("X0,Y0,X1,Y1");
  command
      .add_option("--cut", flags.cut,
                  "Of a 3D mesh, a picture shows a cut across an axis, as z=0.5 (default: "
                  "across z, in the middle of the box)")
      ->type_name("AXIS=PLACE");
  command
      .add_option("--clip", flags.clip,
                  "Of a 3D mesh, a picture shows the tetrahedra below a place along an axis, as "
                  "z=0.5, in perspective; polygons are brown")
      ->type_name("AXIS=PLACE")
      ->excludes("--cut");
  command.add_flag("--legend", flags.legend,
                   "A picture says below what its colours mean (with --fill dihedral and exempt it "
                   "always does)");
  command.add_option("--width", flags.width, "Width of a picture in pixels (default: 1000)")
      ->type_name("PX")
      ->check(CLI::Range(1.0, 1e5));
}

int ThreadsOf(const OutputFlags& flags) {
  constexpr unsigned kUsual = 8;
  if (flags.threads != 0) return flags.threads;
  return static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1U, kUsual));
}

absl::Status CheckOutputs(const OutputFlags& flags) {
  for (const std::string& path : flags.paths) {
    if (auto status = io::CheckMeshOutput(path); !status.ok()) return status;
    const bool has_elements = io::FindFormat(path)->write_mesh != nullptr;
    if (!has_elements) continue;
    if (auto status = io::CheckOrder(flags.order, "--order", path); !status.ok()) return status;
  }
  if (auto s = io::MshVersionOf(flags.msh_version, "--msh-version"); !s.ok()) return s.status();
  return PictureOptions(flags, MeshOptions(), false).status();
}

absl::Status CheckNotInput(const OutputFlags& flags, const std::string& input) {
  if (flags.same_name || !IsMeshPart(input)) return absl::OkStatus();
  for (const std::string& path : flags.paths) {
    std::error_code error;  // of a path that cannot be made absolute: it is no input then
    const auto stem_of = [&](const std::string& file) {
      return std::filesystem::weakly_canonical(
          std::filesystem::absolute(io::StemOfMeshFiles(file), error), error);
    };
    if (!IsMeshPart(path) || stem_of(path) != stem_of(input)) continue;
    return absl::InvalidArgumentError(Concat(
        path, ": files of this base name belong to the input ", input,
        ", and Triangle and TetGen would read what is written as a part of it; choose another "
        "name, as ",
        io::StemOfMeshFiles(path), ".1", io::ExtensionOf(path), ", or give --same-name"));
  }
  return absl::OkStatus();
}

absl::Status CheckOutputsOf(const MeshOptions& options, const OutputFlags& flags) {
  const bool is_quadtree = options.kind == MeshKind::kQuadtree;
  for (const std::string& path : flags.paths) {
    if (auto status = io::CheckMeshOutputOf(options, path); !status.ok()) return status;
  }
  if (!flags.clip.empty() && (is_quadtree || options.dimension == 2)) {
    return absl::InvalidArgumentError("--clip is for meshes of 3D");
  }
  if (flags.fill.empty()) return absl::OkStatus();
  const absl::StatusOr<io::SvgOptions::Fill> fill = io::ParseFill(flags.fill);
  if (!fill.ok()) return fill.status();
  const absl::Status status = io::CheckFill(*fill, options);
  if (status.ok()) return status;
  return absl::InvalidArgumentError(Concat("--fill: ", text::View(status.message())));
}

namespace {

absl::Status WriteLeaves(const Mesh& mesh, const MeshOptions& options, const OutputFlags& flags) {
  const absl::StatusOr<io::LeafList> list = io::LeavesOf(mesh, options);
  if (!list.ok()) return list.status();
  const absl::StatusOr<io::SvgOptions> picture = PictureOptions(flags, options, false);
  if (!picture.ok()) return picture.status();
  io::MeshOutput output;
  output.picture = *picture;
  for (const std::string& path : flags.paths) {
    if (auto status = io::WriteLeafFile(*list, output, path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status WriteOutputs(const Mesh& mesh, const MeshOptions& options, const OutputFlags& flags,
                          const MeshLabels& labels, const SimplexColumn& highlight) {
  if (flags.paths.empty()) return absl::OkStatus();
  if (options.kind == MeshKind::kQuadtree) return WriteLeaves(mesh, options, flags);
  absl::StatusOr<io::IndexedMesh> indexed = io::IndexMesh(mesh);
  if (!indexed.ok()) return absl::InternalError(indexed.status().message());
  ApplyLabels(labels, *indexed);
  const io::IndexedMesh first_order =
      flags.order == 2 ? *indexed : io::IndexedMesh();  // for pictures
  if (flags.order == 2) io::AddMidpoints(*indexed);
  io::MeshOutput output;
  output.shown = flags.order == 2 ? &first_order : &*indexed;
  const absl::StatusOr<io::SvgOptions> picture = PictureOptions(flags, options, !highlight.empty());
  if (!picture.ok()) return picture.status();
  output.picture = *picture;
  if (!highlight.empty()) output.picture.highlight = io::FindSimplices(*output.shown, highlight);
  const auto msh_version = io::MshVersionOf(flags.msh_version, "--msh-version");
  if (!msh_version.ok()) return msh_version.status();
  output.msh_version = *msh_version;
  output.binary = flags.binary;
  output.files.from_zero = flags.from_zero;
  output.files.neighbours = flags.neighbours;
  output.files.voronoi = flags.voronoi;
  output.files.is_part = labels.is_part;
  output.files.threads = ThreadsOf(flags);
  if (indexed->has_plain_ids) output.files.hash = mesh.hash;
  io::NoteOptions(options, output.files);
  output.files.holes = labels.holes;
  for (const std::string& path : flags.paths) {
    if (auto status = io::WriteMeshFile(*indexed, output, path); !status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace dynmesh::cli
