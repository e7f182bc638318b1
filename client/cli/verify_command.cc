// dynmesh verify MESH [--input INPUT [--lfs]] [--rho R] [--min-dihedral DEGREES]: checks a mesh
// file, or the leaves of a quadtree.
#include <memory>
#include <optional>

#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/input.h"
#include "client/cli/json.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/quadtree_text.h"
#include "client/cli/size_conformity.h"
#include "client/cli/unsplit_flag.h"
#include "client/cli/words.h"
#include "client/verify/owners.h"
#include "client/verify/verify.h"
#include "client/verify/verify_quadtree.h"
#include "core/base/text.h"
#include "core/io/formats/mesh_input.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

struct VerifyCommand {
  std::string mesh;
  std::string input;
  InputFlags reading;
  std::string unsplit;
  std::optional<double> rho, min_dihedral;
  bool lfs = false;
  bool part = false;
  bool no_refine = false;
  bool foreign = false;
  bool json = false;
};

void AddChecks(const std::vector<VerifyCheck>& made, JsonObject& object) {
  JsonObject checks;
  std::vector<std::string> problems;
  for (const VerifyCheck& check : made) {
    checks.Add(check.name, check.failures == 0);
    for (const std::string& example : check.examples) {
      problems.push_back(check.name + ": " + example);
    }
  }
  object.AddObject("checks", checks).AddTexts("problems", problems);
}

std::string ChecksText(const std::vector<VerifyCheck>& made) {
  std::string text;
  bool is_good = true;
  for (const VerifyCheck& check : made) {
    if (check.failures == 0) {
      text += absl::StrFormat("  %-12s ok\n", check.name);
      continue;
    }
    is_good = false;
    text += absl::StrFormat("  %-12s FAILED, %d\n", check.name, check.failures);
    for (const std::string& example : check.examples) text += "      " + example + "\n";
    if (check.failures > check.examples.size()) text += "      ...\n";
  }
  return text + (is_good ? "good\n" : "not good\n");
}

std::string FormatJson(const VerifyReport& report, double rho, std::optional<double> min_dihedral,
                       const std::optional<SizeConformity>& conformity) {
  JsonObject object;
  object.Add("ok", report.Passed())
      .Add("vertices", report.vertices)
      .Add("simplices", report.simplices)
      .Add("subsegments", report.subsegments)
      .Add("subfacets", report.subfacets)
      .Add("rho", rho)
      .Add("worst_radius_edge", report.worst_radius_edge)
      .Add("min_angle_deg", report.min_angle_deg)
      .Add("max_angle_deg", report.max_angle_deg)
      .Add("over_rho", report.over_rho)
      .Add("exempt", report.exempt)
      .Add("exempt_by_guard", report.exempt_by_guard);
  if (report.exempt_by_unsplit != 0) object.Add("exempt_by_unsplit", report.exempt_by_unsplit);
  if (report.dimension == 3) object.Add("min_dihedral_deg", report.min_angle_deg);
  if (min_dihedral) {
    object.Add("below_dihedral", report.below_dihedral)
        .Add("exempt_dihedral", report.exempt_dihedral);
  }
  if (conformity) object.AddObject("lfs_over_lms", ConformityJson(*conformity));
  if (report.not_delaunay != 0) object.Add("not_delaunay", report.not_delaunay);
  object.AddText("hash", report.hash.ToHex());
  AddChecks(report.checks, object);
  return object.ToLine();
}

std::string FormatText(const VerifyReport& report, double rho, std::optional<double> min_dihedral,
                       const std::optional<SizeConformity>& conformity) {
  const std::string subfacets =
      report.dimension == 3 ? absl::StrFormat("%d subfacets, ", report.subfacets) : "";
  std::string text = absl::StrFormat(
      "%d vertices, %d %s, %d subsegments, %s%s %.2f to %.2f degrees\n"
      "worst circumradius / shortest edge %.6g, %d over %.6g (%d exempt, %d of them by the "
      "termination guard%s)\n",
      report.vertices, report.simplices, SimplicesWord(report.dimension), report.subsegments,
      subfacets, AnglesWord(report.dimension), report.min_angle_deg, report.max_angle_deg,
      report.worst_radius_edge, report.over_rho, rho, report.exempt, report.exempt_by_guard,
      ByUnsplitText(report.exempt_by_unsplit));
  if (min_dihedral) {
    text += absl::StrFormat("tetrahedra with a dihedral angle below %.6g degrees: %d",
                            *min_dihedral, report.below_dihedral);
    if (report.exempt_dihedral != 0) {
      text +=
          absl::StrFormat(" (and %d exempt at small angles of the input)", report.exempt_dihedral);
    }
    text += "\n";
  }
  if (conformity) text += ConformityText(*conformity);
  if (report.not_delaunay != 0) {
    text += absl::StrFormat("not Delaunay at %d sides\n", report.not_delaunay);
  }
  return text + ChecksText(report.checks);
}

// The leaves of a quadtree.
int RunQuadtree(const VerifyCommand& command) {
  for (const auto& [flag, is_given] : {std::pair("--rho", command.rho.has_value()),
                                       {"--min-dihedral", command.min_dihedral.has_value()}}) {
    if (is_given) {
      return ReportError(absl::InvalidArgumentError(absl::StrFormat(
          "%s: %s has the leaves of a quadtree, and simplices have that", flag, command.mesh)));
    }
  }
  const absl::StatusOr<io::LeafList> list = io::ReadLeaves(command.mesh);
  if (!list.ok()) return ReportError(list.status());
  Input input;
  if (!command.input.empty()) {
    absl::StatusOr<Input> loaded =
        LoadInputOfMesh("--input", command.input, list->dimension, command.reading);
    if (!loaded.ok()) return ReportError(loaded.status());
    input = *std::move(loaded);
  }
  const QuadtreeReport report =
      VerifyQuadtree(*list, command.input.empty() ? nullptr : &input.features);
  JsonObject object;
  object.Add("ok", report.Passed());
  AddChecks(report.checks, QuadtreeJson(report, object));
  if (!PrintOut(command.json ? object.ToLine()
                             : QuadtreeText(report) + "\n" + ChecksText(report.checks))) {
    return kExitFailed;
  }
  return report.Passed() ? kExitDone : kExitFailed;
}

struct JudgedMesh : io::MeshFiles {
  MeshScope scope = MeshScope::kWhole;
};

// A file that records no hash is another mesher's, unless its input's markers are the reason.
absl::StatusOr<JudgedMesh> ReadJudgedMesh(const VerifyCommand& command) {
  JudgedMesh mesh;
  if (io::IsElementFile(command.mesh)) {
    const absl::StatusOr<io::ElementMesh> elements = io::ReadElements(command.mesh);
    if (!elements.ok()) return elements.status();
    mesh.mesh = io::ToIndexed(*elements);
    mesh.scope = MeshScope::kForeign;
    return mesh;
  }
  absl::StatusOr<io::MeshFiles> files = io::ReadMeshFiles(command.mesh);
  if (!files.ok()) return files.status();
  const bool is_ours = files->recorded_hash.has_value() || files->has_input_markers;
  if (command.foreign || (!is_ours && !command.part)) {
    const absl::StatusOr<io::ElementMesh> elements = io::ReadElements(command.mesh);
    if (!elements.ok()) return elements.status();
    mesh.mesh = io::ToIndexed(*elements);
    mesh.scope = MeshScope::kForeign;
    return mesh;
  }
  static_cast<io::MeshFiles&>(mesh) = *std::move(files);
  mesh.is_triangulation |= command.no_refine;
  if (command.part || mesh.is_part || mesh.has_input_markers) mesh.scope = MeshScope::kPart;
  return mesh;
}

int Run(const VerifyCommand& command) {
  if (io::IsLeafFile(command.mesh)) return RunQuadtree(command);
  if (auto status = CheckRhoFlag(command.rho); !status.ok()) return ReportError(status);
  if (auto status = CheckMinDihedralFlag(command.min_dihedral); !status.ok()) {
    return ReportError(status);
  }
  absl::StatusOr<JudgedMesh> files = ReadJudgedMesh(command);
  if (!files.ok()) return ReportError(files.status());
  if (auto status = CheckMinDihedralFlag(command.min_dihedral, command.mesh, files->mesh.dimension);
      !status.ok()) {
    return ReportError(status);
  }
  Input input;
  if (!command.input.empty()) {
    absl::StatusOr<Input> loaded =
        LoadInputOfMesh("--input", command.input, files->mesh.dimension, command.reading);
    if (!loaded.ok()) return ReportError(loaded.status());
    input = *std::move(loaded);
    if (auto status = AddSeedPolygons(input); !status.ok()) return ReportError(status);
    if (auto status = ApplyUnsplitFlag(command.unsplit, input.features); !status.ok()) {
      return ReportError(status);
    }
    if (files->has_input_markers) FindOwners(input.features, files->mesh);
  }
  const double rho =
      command.rho.value_or(files->rho.value_or(DefaultQuality(files->mesh.dimension)));
  const VerifyReport report =
      VerifyMesh(*files, rho, command.input.empty() ? nullptr : &input.features,
                 command.min_dihedral, files->scope, command.rho.has_value());
  std::optional<SizeConformity> conformity;
  if (command.lfs) conformity = MeasureConformity(files->mesh, input.features);
  if (!PrintOut(command.json ? FormatJson(report, rho, command.min_dihedral, conformity)
                             : FormatText(report, rho, command.min_dihedral, conformity))) {
    return kExitFailed;
  }
  if (!report.Passed() && files->has_input_markers && command.input.empty()) {
    PrintWarning(absl::StrFormat(
        "%s has the input's markers: give --input, which tells what small angles of it excuse",
        command.mesh));
  }
  return report.Passed() ? kExitDone : kExitFailed;
}

}  // namespace

void RegisterVerifyCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<VerifyCommand>();
  const auto is_of_elements = [](const io::Format& f) { return f.read_elements != nullptr; };
  CLI::App* const sub =
      AddCommand(app, slot, "verify",
                 "Check a mesh file with exact predicates: exit code 0 if it is good, 1 if not",
                 [command] { return Run(*command); });
  sub->add_option(
         "MESH", command->mesh,
         Concat("A mesh as .node, .ele and .edge, in 3D with .face; ",
                io::ListOfFormats(is_of_elements), "; or the leaves of a quadtree as ",
                io::ListOfFormats([](const io::Format& f) { return f.read_leaves != nullptr; })))
      ->required();
  sub->add_flag("--part", command->part,
                "The mesh does not fill a box (default: what its comments say)");
  sub->add_flag("--no-refine", command->no_refine,
                "The mesh is a constrained Delaunay triangulation without Steiner points, and no "
                "angle is judged but by --rho (default: what its comments say)");
  sub->add_flag(
      "--foreign", command->foreign,
      Concat("The mesh is another mesher's: it must be a mesh, and good enough if --rho is given "
             "(default: if it records no hash, and of ",
             io::ListOfFormats(is_of_elements, "and"), ")"));
  CLI::Option* const input =
      sub->add_option("--input", command->input, "What it was made of: " + io::GeometryFormats())
          ->type_name("INPUT");
  sub->add_flag("--lfs", command->lfs,
                "Tell how the distance of each vertex to its nearest neighbour follows the local "
                "feature size, the radius of the least ball that meets two disjoint features")
      ->needs(input);
  AddInputFlags(*sub, command->reading);
  AddMapFlags(*sub, command->reading);
  AddPreparationFlags(*sub, command->reading);
  AddUnsplitFlag(*sub, command->unsplit);
  sub->get_option("--unsplit")->needs(input);
  sub->add_option("--rho", command->rho,
                  "The quality asked for (default: what the file says, else sqrt 2, in 3D 2)")
      ->type_name("R");
  sub->add_option("--min-dihedral", command->min_dihedral,
                  "In 3D: no dihedral angle may be below this, 0 to 20 degrees; a mesh made "
                  "with --min-dihedral may have a few (default: not judged)")
      ->type_name("DEGREES");
  sub->add_flag("--json", command->json, "Print one JSON object");
}

}  // namespace dynmesh::cli
