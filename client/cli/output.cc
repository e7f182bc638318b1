#include "client/cli/output.h"

#include <filesystem>
#include <system_error>

#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/text_reader.h"
#include "core/io/meshes/indexed_mesh.h"
#include "core/io/meshes/medit_writer.h"
#include "core/io/meshes/mesh_files.h"
#include "core/io/meshes/msh_writer.h"
#include "core/io/meshes/vtu_writer.h"
#include "core/io/pictures/leaf_svg.h"
#include "core/io/pictures/mesh_picture.h"
#include "core/io/pictures/svg_writer.h"
#include "core/io/quadtrees/leaf_list.h"
#include "core/io/script/edit_script.h"

namespace dynmesh::cli {
namespace {

using io::ExtensionOf;

bool IsTriangles(const std::string& extension) {
  return extension == ".node" || extension == ".ele" || extension == ".edge" ||
         extension == ".face" || extension == ".neigh" || extension == ".poly" ||
         extension == ".smesh";
}

bool IsKnown(const std::string& extension) {
  return IsTriangles(extension) || extension == ".vtu" || extension == ".msh" ||
         extension == ".mesh" || extension == ".svg" || extension == ".csv";
}

// "z=0.5", or "z" for the middle.
absl::Status ParseCut(std::string_view flag, std::string_view text, io::SvgOptions& svg) {
  const std::size_t axis =
      text.empty() ? std::string_view::npos : std::string_view("xyz").find(text[0]);
  double at = 0;
  const bool has_position = text.size() > 1;
  if (axis == std::string_view::npos ||
      (has_position && (text[1] != '=' || !io::ParseDouble(text.substr(2), &at)))) {
    return absl::InvalidArgumentError(text::Concat(
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
          "Where to write the mesh: .node (with .ele, .edge and, in 3D, .face beside it; .poly, "
          ".smesh or .neigh with that file, too), .vtu, .msh (Gmsh 4.1), .mesh (Medit) or .svg; of "
          "a quadtree .csv, .vtu or .svg; may "
          "be given several times")
      ->type_name("OUT")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--order", flags.order,
                  "Order of the elements in .node, .msh and .vtu; 2: with a node in the middle of "
                  "each edge (default: 1)")
      ->type_name("1|2")
      ->check(CLI::Range(1, 2));
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

absl::Status CheckOutputs(const OutputFlags& flags) {
  for (const std::string& path : flags.paths) {
    const std::string extension = ExtensionOf(path);
    if (extension == ".mesh" && flags.order == 2) {
      return absl::InvalidArgumentError(
          text::Concat(path, ": --order 2 is for .node, .msh and .vtu"));
    }
    if (IsKnown(extension)) continue;
    if (extension == ".png") {
      return absl::UnimplementedError(text::Concat(
          path, ": ", extension, " files as output are not supported yet in this version"));
    }
    return absl::InvalidArgumentError(text::Concat(
        path,
        ": the extension must tell what to write: .node, .vtu, .msh, .mesh or .svg, of a "
        "quadtree .csv, .vtu or .svg"));
  }
  return PictureOptions(flags, MeshOptions(), false).status();
}

absl::Status CheckNotInput(const OutputFlags& flags, const std::string& input) {
  if (flags.same_name || !IsTriangles(ExtensionOf(input))) return absl::OkStatus();
  for (const std::string& path : flags.paths) {
    std::error_code error;  // of a path that cannot be made absolute: it is no input then
    const auto stem_of = [&](const std::string& file) {
      return std::filesystem::weakly_canonical(
          std::filesystem::absolute(io::StemOfMeshFiles(file), error), error);
    };
    if (!IsTriangles(ExtensionOf(path)) || stem_of(path) != stem_of(input)) continue;
    return absl::InvalidArgumentError(text::Concat(
        path, ": files of this base name belong to the input ", input,
        ", and Triangle and TetGen would read what is written as a part of it; choose another "
        "name, as ",
        io::StemOfMeshFiles(path), ".1", ExtensionOf(path), ", or give --same-name"));
  }
  return absl::OkStatus();
}

absl::Status CheckOutputsOf(const MeshOptions& options, const OutputFlags& flags) {
  const bool is_quadtree = options.kind == MeshKind::kQuadtree;
  for (const std::string& path : flags.paths) {
    const std::string extension = ExtensionOf(path);
    if (is_quadtree && extension != ".csv" && extension != ".vtu" && extension != ".svg") {
      return absl::InvalidArgumentError(
          text::Concat(path, ": a quadtree is written as .csv, .vtu or .svg"));
    }
    if (extension == ".smesh" && options.dimension == 2) {
      return absl::InvalidArgumentError(
          text::Concat(path, ": a .smesh is of 3D; a 2D mesh takes .poly"));
    }
    if (!is_quadtree && extension == ".csv") {
      return absl::InvalidArgumentError(
          text::Concat(path, ": only the leaves of a quadtree are written as .csv"));
    }
  }
  if (!flags.clip.empty() && (is_quadtree || options.dimension == 2)) {
    return absl::InvalidArgumentError("--clip is for meshes of 3D");
  }
  if (flags.fill.empty()) return absl::OkStatus();
  const absl::StatusOr<io::SvgOptions::Fill> fill = io::ParseFill(flags.fill);
  if (!fill.ok()) return fill.status();
  const absl::Status status = io::CheckFill(*fill, options);
  if (status.ok()) return status;
  return absl::InvalidArgumentError(text::Concat("--fill: ", text::View(status.message())));
}

namespace {

absl::Status WriteLeaves(const Mesh& mesh, const MeshOptions& options, const OutputFlags& flags) {
  const absl::StatusOr<io::LeafList> list = io::LeavesOf(mesh, options);
  if (!list.ok()) return list.status();
  for (const std::string& path : flags.paths) {
    const std::string extension = ExtensionOf(path);
    absl::Status status;
    if (extension == ".csv") {
      status = io::WriteLeafCsv(*list, path);
    } else if (extension == ".vtu") {
      status = io::WriteLeafVtu(*list, path);
    } else {
      absl::StatusOr<io::SvgOptions> svg = PictureOptions(flags, options, false);
      if (!svg.ok()) return svg.status();
      status = io::WriteLeafSvg(*list, *svg, path);
    }
    if (!status.ok()) return status;
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
  for (const std::string& path : flags.paths) {
    const std::string extension = ExtensionOf(path);
    absl::Status status;
    if (extension == ".vtu") {
      status = io::WriteVtu(*indexed, options.quality, path, options.min_dihedral);
    } else if (extension == ".msh") {
      status = io::WriteMsh(*indexed, path);
    } else if (extension == ".mesh") {
      status = io::WriteMedit(*indexed, path);
    } else if (extension == ".svg") {
      absl::StatusOr<io::SvgOptions> svg = PictureOptions(flags, options, !highlight.empty());
      if (!svg.ok()) return svg.status();
      const io::IndexedMesh& shown = flags.order == 2 ? first_order : *indexed;
      if (!highlight.empty()) svg->highlight = io::FindSimplices(shown, highlight);
      status = io::WriteSvg(shown, *svg, path);
    } else {
      io::MeshFileOptions files;
      files.from_zero = flags.from_zero;
      files.neighbours = flags.neighbours;
      files.voronoi = flags.voronoi;
      files.is_part = labels.is_part;
      files.rho = options.quality;
      files.min_dihedral = options.min_dihedral;
      files.holes = labels.holes;
      status = io::WriteMeshFiles(*indexed, path, files);
    }
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

}  // namespace dynmesh::cli
