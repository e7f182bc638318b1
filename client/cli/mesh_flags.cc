#include "client/cli/mesh_flags.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "client/cli/command.h"
#include "core/base/text.h"
#include "core/io/elements/size_limits.h"
#include "core/io/script/edit_script.h"
#include "dynmesh/error.h"

namespace dynmesh::cli {
namespace {

absl::Status Flag(const char* flag, const absl::Status& status) {
  return absl::InvalidArgumentError(text::Concat(flag, ": ", text::View(status.message())));
}

// "ID,ID,...", ids of `what`. `word` is the alternative that the flag accepts, with ", or " before
// it.
absl::StatusOr<std::vector<FeatureId>> ParseIds(const char* flag, const std::string& text,
                                                const char* word, const char* what = "polygons") {
  std::vector<FeatureId> ids;
  for (const std::string_view part : text::Split(text, ',')) {
    FeatureId id = kNoFeature;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), id);
    if (error != std::errc() || end != part.data() + part.size() || id == kNoFeature ||
        id == kBoxFeature) {
      return Flag(flag, absl::InvalidArgumentError(text::Concat("expected ids of ", what,
                                                                ", separated by commas", word,
                                                                ", found ", text::Quoted(part))));
    }
    ids.push_back(id);
  }
  return ids;
}

}  // namespace

absl::Status CheckRhoFlag(std::optional<double> rho) {
  if (!rho || (*rho >= kMinQuality2D && *rho <= kMaxQuality)) return absl::OkStatus();
  return absl::InvalidArgumentError("--rho must be 1 to 100");
}

absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral) {
  if (!min_dihedral || (*min_dihedral >= 0 && *min_dihedral <= kMaxMinDihedral)) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError("--min-dihedral must be 0 to 20 degrees");
}

absl::Status CheckMinDihedralFlag(std::optional<double> min_dihedral, const std::string& path,
                                  int dimension) {
  if (!min_dihedral || dimension == 3) return absl::OkStatus();
  return absl::InvalidArgumentError(
      text::Concat("--min-dihedral: ", path, " is 2D, and dihedral angles are of 3D"));
}

void AddBoxFlag(CLI::App& command, std::string& text) {
  command.add_option("--box", text, "Where features may lie (default: the input's bounding box)")
      ->type_name("X0,Y0,X1,Y1");
}

absl::Status ApplyBoxFlag(const std::string& text, MeshOptions& options) {
  if (text.empty()) return absl::OkStatus();
  const absl::StatusOr<Box> box = io::ParseBox(text, options.dimension);
  if (!box.ok()) return Flag("--box", box.status());
  for (std::size_t k = 0; k < static_cast<std::size_t>(options.dimension); ++k) {
    if (box->lo[k] != box->hi[k]) continue;
    const bool in_space = options.dimension == 3;
    return absl::InvalidArgumentError(
        text::Concat("--box: ", text, " is empty, since both of its corners have the same ",
                     std::string(1, "xyz"[k]), "; a box is two corners, as ",
                     in_space ? "0,0,0,2,1,1" : "0,0,2,1", ", not a range for each axis"));
  }
  options.box = *box;
  return absl::OkStatus();
}

void AddRegionFlag(CLI::App& command, std::string& text) {
  command
      .add_option("--region", text,
                  "Only what lies in at least one of these polygons (any: in any at all); in 3D "
                  "in closed surfaces, each by the id that `dynmesh stats` has for it")
      ->type_name("ID[,ID...]|any");
}

absl::StatusOr<mesh_data::RegionChoice> ParseRegionFlag(const std::string& text) {
  mesh_data::RegionChoice choice;
  if (text.empty()) return choice;
  if (text == "any") {
    choice.in_any = true;
    return choice;
  }
  absl::StatusOr<std::vector<FeatureId>> ids = ParseIds("--region", text, ", or any");
  if (!ids.ok()) return ids.status();
  choice.in = *std::move(ids);
  mesh_data::Normalize(choice);
  return choice;
}

absl::StatusOr<std::vector<FeatureId>> ParseOpenFlag(const std::string& text) {
  return ParseIds("--open", text, "", "segments or polygons");
}

void AddOutsideFlag(CLI::App& command, std::string& text) {
  command
      .add_option("--outside", text,
                  "Nothing that lies in one of these polygons (holes: in what a .poly or .smesh "
                  "marks as a hole); in 3D in closed surfaces, each by the id that "
                  "`dynmesh stats` has for it")
      ->type_name("ID[,ID...]|holes");
}

absl::Status ApplyOutsideFlag(const std::string& text, const std::vector<FeatureId>* holes,
                              mesh_data::RegionChoice& choice) {
  if (text.empty()) return absl::OkStatus();
  if (text == "holes" && holes != nullptr) {
    choice.out = *holes;
  } else {
    absl::StatusOr<std::vector<FeatureId>> ids =
        ParseIds("--outside", text, ", or the word holes for a .poly");
    if (!ids.ok()) return ids.status();
    choice.out = *std::move(ids);
  }
  mesh_data::Normalize(choice);
  return absl::OkStatus();
}

void AddMeshFlags(CLI::App& command, MeshFlags& flags) {
  command
      .add_option(
          "--kind", flags.kind,
          "A quality Delaunay mesh; a size-conforming quadtree (in 3D octree); or in 2D a "
          "constrained Delaunay triangulation. The last two have none of --rho, --criterion, "
          "--hmax and --min-dihedral (default: delaunay)")
      ->type_name("delaunay|quadtree|triangulation");
  command.add_flag("--no-refine", flags.no_refine,
                   "In 2D: only points and segments as they are, no Steiner points; as --kind "
                   "triangulation");
  command
      .add_option("--rho", flags.rho,
                  "Largest circumradius / shortest edge, 1 to 100 (default: sqrt 2, no angle "
                  "below 20.7 degrees); from 1.4142 with criterion thesis. In 3D 1.2 to 100, "
                  "from 1.4 with polygons (default: 2); from 2 with criterion thesis")
      ->type_name("R");
  command
      .add_option("-q,--min-angle", flags.min_angle,
                  "In 2D: no angle below this, up to 30 degrees; rho is then 1 / (2 sin A)")
      ->type_name("A");
  command.add_option("--criterion", flags.criterion, "When refinement is done (default: edge)")
      ->type_name("edge|thesis");
  command
      .add_option(
          "--engine", flags.engine,
          "Which mesher (default: dynamic); svr: Sparse Voronoi Refinement, from scratch only")
      ->type_name("dynamic|svr");
  AddBoxFlag(command, flags.box);
  command.get_option("--box")->type_name(kBoxOfEither);
  command
      .add_option("--hmax", flags.max_edge,
                  "No edge in the box longer than sqrt 2 times this (default: any)")
      ->type_name("H");
  command
      .add_option("-a,--max-area", flags.max_area,
                  "In 2D: no triangle in the box larger; hmax is then sqrt(A / 0.866)")
      ->type_name("A");
  command
      .add_option("--max-volume", flags.max_volume,
                  "In 3D: no tetrahedron in the box larger; hmax is then (3 V)^(1/3)")
      ->type_name("V");
  command
      .add_option("--min-dihedral", flags.min_dihedral,
                  "In 3D: no dihedral angle below this, 0 to 20 degrees, where Steiner points can "
                  "see to it; 0: slivers stay (default: 10)")
      ->type_name("DEGREES");
  command
      .add_option("--max-vertices", flags.max_vertices,
                  "Give up when the mesh would have more vertices")
      ->type_name("N");
}

void WarnOfUnknownRegions(const mesh_data::RegionChoice& choice, const Mesh& mesh) {
  if (choice.in.empty() && choice.out.empty()) return;
  const absl::flat_hash_set<RegionId> regions(mesh.regions.begin(), mesh.regions.end());
  absl::flat_hash_set<FeatureId> known;
  for (const RegionId region : regions) {
    const std::vector<FeatureId> polygons = PolygonsOf(region, mesh.region_sets);
    known.insert(polygons.begin(), polygons.end());
  }
  for (const auto& [flag, ids] : {std::pair("--region", &choice.in), {"--outside", &choice.out}}) {
    for (const FeatureId id : *ids) {
      if (known.contains(id)) continue;
      PrintWarning(
          text::Concat(flag, ": nothing of the mesh lies in ", id,
                       mesh.dimension == 3
                           ? "; a closed surface goes by one of its polygons, mostly the least id"
                           : ""));
    }
  }
}

absl::Status NameOption(const absl::Status& status, const MeshFlags& flags,
                        const std::function<std::string(std::string_view)>& where) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail || detail->reason != reason::kBadOption) return status;
  // Such a message begins with the option's name.
  const std::string_view message = text::View(status.message());
  const std::string_view name = message.substr(0, message.find(':'));
  std::string word;
  for (const auto& [option, flag, is_given] :
       {std::tuple{"quality", "--rho", flags.rho.has_value()},
        std::tuple{"box", "--box", !flags.box.empty()},
        std::tuple{"max_edge", "--hmax", flags.max_edge.has_value()},
        std::tuple{"min_dihedral", "--min-dihedral", flags.min_dihedral.has_value()},
        std::tuple{"criterion", "--criterion", !flags.criterion.empty()},
        std::tuple{"kind", flags.no_refine ? "--no-refine" : "--kind",
                   flags.no_refine || !flags.kind.empty()},
        std::tuple{"engine", "--engine", true},
        std::tuple{"limits.max_vertices", "--max-vertices", flags.max_vertices.has_value()}}) {
    if (name == option && is_given) word = flag;
  }
  if (word.empty()) word = where(name);
  if (word.empty()) return status;
  return absl::Status(status.code(), text::Concat(word, message.substr(name.size())));
}

namespace {

// --min-angle, --max-area and --max-volume.
absl::Status ApplyOtherWords(const MeshFlags& flags, MeshOptions& options) {
  const auto error = [](const char* flag, const char* what) {
    return absl::InvalidArgumentError(text::Concat(flag, ": ", what));
  };
  constexpr double kDegree = 3.141592653589793 / 180;
  if (flags.min_angle) {
    if (flags.rho) return error("--min-angle", "--rho says the same in other words: give one");
    if (options.dimension != 2) return error("--min-angle", "of 2D: in 3D give --rho");
    if (!(*flags.min_angle > 0 && *flags.min_angle <= 30)) {
      return error("--min-angle", "must be above 0 and at most 30 degrees");
    }
    options.quality = std::max(kMinQuality2D, 1 / (2 * std::sin(*flags.min_angle * kDegree)));
  }
  for (const auto& [flag, value, dimension] :
       {std::tuple("--max-area", flags.max_area, 2), {"--max-volume", flags.max_volume, 3}}) {
    if (!value) continue;
    if (flags.max_edge) return error(flag, "--hmax says the same in other words: give one");
    if (options.dimension != dimension) {
      return error(flag, dimension == 2 ? "the mesh is 3D: give --max-volume"
                                        : "the mesh is 2D: give --max-area");
    }
    if (!(*value > 0)) return error(flag, "must be above 0");
    options.max_edge = dimension == 2 ? io::TargetOfArea(*value) : io::TargetOfVolume(*value);
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ApplyMeshFlags(const MeshFlags& flags, MeshOptions& options, MeshLife life) {
  if (flags.engine != "dynamic" && flags.engine != "svr") {
    return absl::InvalidArgumentError(
        text::Concat("--engine: expected dynamic or svr, found ", text::Quoted(flags.engine)));
  }
  if (flags.engine == "svr" && life == MeshLife::kDynamic) {
    return absl::InvalidArgumentError(
        "--engine: svr makes meshes from scratch only: use dynmesh mesh, or engine dynamic");
  }
  // SVR has no cures.
  if (flags.engine == "svr" && !flags.min_dihedral) options.min_dihedral = 0;
  if (flags.no_refine && !flags.kind.empty() && flags.kind != "triangulation") {
    return absl::InvalidArgumentError(
        "--no-refine: is --kind triangulation; leave out the other --kind");
  }
  if (!flags.kind.empty() || flags.no_refine) {
    const absl::StatusOr<MeshKind> kind =
        flags.no_refine ? MeshKind::kTriangulation : MeshKindOf(flags.kind);
    if (!kind.ok()) return Flag("--kind", kind.status());
    if (*kind != options.kind) {
      MeshOptions usual;
      usual.dimension = options.dimension;
      usual.box = options.box;
      usual.quality = DefaultQuality(options.dimension);
      usual.min_dihedral = DefaultMinDihedral(options.dimension, *kind);
      usual.limits = options.limits;
      usual.kind = *kind;
      options = usual;
    }
  }
  if (flags.rho) options.quality = *flags.rho;
  if (auto status = ApplyOtherWords(flags, options); !status.ok()) return status;
  if (flags.max_edge) options.max_edge = *flags.max_edge;
  if (flags.min_dihedral) options.min_dihedral = *flags.min_dihedral;
  if (flags.max_vertices) options.limits.max_vertices = *flags.max_vertices;
  if (!flags.criterion.empty()) {
    const absl::StatusOr<Criterion> criterion = io::ParseCriterion(flags.criterion);
    if (!criterion.ok()) return Flag("--criterion", criterion.status());
    options.criterion = *criterion;
  }
  return ApplyBoxFlag(flags.box, options);
}

}  // namespace dynmesh::cli
