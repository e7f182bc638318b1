// dynmesh mesh INPUT [-o OUT] [--server ADDR]: makes a mesh from scratch, in process or on a
// server.
#include <algorithm>
#include <chrono>
#include <future>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cli/command.h"
#include "client/cli/facet_map_file.h"
#include "client/cli/input.h"
#include "client/cli/json.h"
#include "client/cli/memory_flag.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/output.h"
#include "client/cli/packed_points.h"
#include "client/cli/progress_bar.h"
#include "client/cli/refusals.h"
#include "client/cli/region_volumes.h"
#include "client/cli/remote_mesher.h"
#include "client/cli/selection.h"
#include "client/cli/size_flags.h"
#include "client/cli/unsplit_flag.h"
#include "client/cli/vertex_limit.h"
#include "client/cli/words.h"
#include "client/preparation/attempts.h"
#include "core/base/text.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/quadtree.h"
#include "dynmesh/quality.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

struct MeshCommand {
  std::string input;
  InputFlags reading;
  MeshFlags mesh;
  OutputFlags output;
  SizeFlags sizes;
  std::string unsplit;
  SelectionFlags selection;
  std::string markers;
  std::string max_memory;
  std::string map;
  bool all_refusals = false;
  bool json = false;
  std::shared_ptr<RemoteMesher> remote;  // may be null
};

void AddTo(JsonObject& summary, const preparation::Report& report) {
  JsonObject changes;
  for (const auto& [what, count] : report.changes) {
    std::string key = what;
    std::ranges::replace(key, ' ', '_');
    changes.Add(key, count);
  }
  summary.Add("mended", report.is_mended)
      .Add("thinned", report.is_thinned)
      .Add("within", report.within)
      .Add("mending_tolerance", report.tolerance)
      .Add("farthest", report.farthest)
      .Add("open_edges_read", report.open_edges)
      .Add("open_edges", report.open_edges_after)
      .Add("open_loops", report.open_loops.size())
      .Add("prepare_seconds", report.seconds)
      .AddObject("changes", changes);
  if (report.least_tolerance) summary.Add("least_tolerance", *report.least_tolerance);
  if (report.is_thinned)
    summary.Add("triangles_read", report.triangles_read).Add("triangles", report.triangles);
  std::vector<JsonObject> loops;
  for (const preparation::OpenLoop& loop : report.open_loops) {
    if (loops.size() == kMostTold) break;
    JsonObject& told = loops.emplace_back();
    told.Add("edges", loop.corners.size()).Add("length", loop.length);
    told.Add("x", loop.middle[0]).Add("y", loop.middle[1]).Add("z", loop.middle[2]);
  }
  if (!loops.empty()) summary.AddObjects("shortest_loops", loops);
  if (!report.unfilled.ok()) summary.AddText("unfilled", text::View(report.unfilled.message()));
  if (!report.found.ok()) summary.AddText("found", text::View(report.found.message()));
}

std::string Summarise(const Mesh& mesh, const QualityReport& quality, const MeshOptions& options,
                      double build_seconds, const Input& input, bool json) {
  if (json) {
    JsonObject object;
    object.Add("vertices", mesh.vertices.size())
        .Add("simplices", mesh.simplex_count())
        .Add("subsegments", mesh.subsegments.size())
        .Add("subfacets", mesh.subfacets.size())
        .Add("worst_radius_edge", quality.worst_radius_edge)
        .Add("min_angle_deg", quality.min_angle_deg)
        .Add("max_angle_deg", quality.max_angle_deg)
        .Add("over_rho", quality.over_rho)
        .Add("exempt", quality.exempt)
        .Add("exempt_by_guard", quality.exempt_by_guard)
        .Add("below_dihedral", quality.below_dihedral)
        .Add("exempt_dihedral", quality.exempt_dihedral)
        .Add("build_seconds", build_seconds)
        .AddText("hash", mesh.hash.ToHex());
    if (quality.exempt_by_unsplit != 0) {
      object.Add("exempt_by_unsplit", quality.exempt_by_unsplit);
    }
    if (input.preparation) AddTo(object, *input.preparation);
    return object.ToLine();
  }
  const bool in_space = mesh.dimension == 3;
  const std::string over_rho =
      options.kind == MeshKind::kTriangulation
          ? ""
          : absl::StrFormat(
                "over rho           %d (%d exempt, %d of them by the termination guard%s)\n",
                quality.over_rho, quality.exempt, quality.exempt_by_guard,
                ByUnsplitText(quality.exempt_by_unsplit));
  return absl::StrFormat(
      "vertices           %d\n"
      "%-17s  %d\n"
      "subsegments        %d\n"
      "%s"
      "%-17s  %.2f to %.2f degrees\n"
      "worst radius-edge  %.6g\n"
      "%s%s"
      "built in           %.3f s\n"
      "hash               %s\n",
      mesh.vertices.size(), SimplicesWord(mesh.dimension), mesh.simplex_count(),
      mesh.subsegments.size(),
      in_space ? absl::StrFormat("subfacets          %d\n", mesh.subfacets.size()) : "",
      AnglesWord(mesh.dimension), quality.min_angle_deg, quality.max_angle_deg,
      quality.worst_radius_edge, over_rho,
      BelowDihedralText(quality.below_dihedral, quality.exempt_dihedral, options.min_dihedral),
      build_seconds, mesh.hash.ToHex());
}

std::string SummariseQuadtree(const Mesh& mesh, const MeshOptions& options, double build_seconds,
                              bool json) {
  int coarsest = std::numeric_limits<int>::max(), finest = 0;
  const auto width = static_cast<std::size_t>(mesh.dimension);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const auto cell = QuadtreeCellAt(options, &mesh.vertices.coordinates[i * width]);
    coarsest = std::min(coarsest, cell->level);
    finest = std::max(finest, cell->level);
  }
  if (json) {
    return JsonObject()
        .Add("leaves", mesh.vertices.size())
        .Add("coarsest_level", coarsest)
        .Add("finest_level", finest)
        .Add("build_seconds", build_seconds)
        .AddText("hash", mesh.hash.ToHex())
        .ToLine();
  }
  return absl::StrFormat(
      "leaves             %d\n"
      "levels             %d to %d\n"
      "built in           %.3f s\n"
      "hash               %s\n",
      mesh.vertices.size(), coarsest, finest, build_seconds, mesh.hash.ToHex());
}

// An input, which may be one of several that a file can become.
struct Surface : Input {
  bool is_told = false;  // its warnings are printed
};

absl::StatusOr<Surface> ReadSurface(const std::string& path, const InputFlags& reading) {
  absl::StatusOr<Input> input = LoadInput(path, reading);
  if (!input.ok()) return input.status();
  return Surface{*std::move(input)};
}

bool IsRemote(const MeshCommand& command) {
  return command.remote != nullptr && command.remote->is_chosen();
}

// May a larger tolerance be tried where the mesh is too fine? What was asked for may be the reason
// as well; and features of sizes are none of the file.
bool MayMendMore(const MeshCommand& command) {
  const io::Format* const format = io::FindFormat(command.input);
  const MeshFlags& mesh = command.mesh;
  const SizeFlags& sizes = command.sizes;
  return format != nullptr && format->Is(io::kSurface) && !IsRemote(command) &&
         !mesh.max_vertices && !mesh.max_edge && !mesh.max_volume && command.max_memory.empty() &&
         sizes.files.empty() && sizes.of.empty() && sizes.grades.empty();
}

// Reports that there is no mesh of `input`. Returns the exit code.
int ReportNoMesh(const MeshCommand& command, const Input& input, const absl::Status& refusal,
                 const std::string& limit_reason) {
  const io::Format* const format = io::FindFormat(command.input);
  const absl::Status named = NameOption(refusal, command.mesh, input.where_option);
  if (absl::IsResourceExhausted(named)) {
    return ReportTooLarge(named, input, IsRemote(command) ? "" : limit_reason);
  }
  RefusalWishes wishes;
  wishes.is_merged = command.reading.merge_coplanar;
  wishes.is_refined = command.reading.refine;
  wishes.all = command.all_refusals;
  if (input.preparation && input.preparation->within > 0) {
    wishes.mended_within = input.preparation->within;
  }
  if (format != nullptr && !format->Is(io::kScript)) {
    wishes.mending = command.reading.prepare ? "--within D" : "the command without --exact";
  }
  return ReportRefusals(named, input, wishes);
}

// Makes the mesh, of no more vertices than `most`, and writes it. The exit code; if there is no
// mesh, why, and the reason for the limit of vertices: that is still to be reported.
absl::StatusOr<int> MakeAndWrite(MeshCommand& command, std::optional<std::uint64_t> most,
                                 Surface* input, std::string& limit_reason) {
  ProgressBar bar(ErrorIsTerminal());
  if (auto status = AddSeedPolygons(*input); !status.ok()) return ReportError(status);
  const io::Format* const format = io::FindFormat(command.input);
  command.selection.inside_by_default =
      format != nullptr && !command.reading.refine && command.mesh.kind != "quadtree" &&
      (format->Is(io::kSurface) ||
       (format->Is(io::kMap) && (command.reading.polygons || command.reading.is_map_of_polygons)));
  const absl::StatusOr<Selection> selection = Selection::Parse(command.selection, *input, true);
  if (!selection.ok()) return ReportError(selection.status());
  // Of what is to be enclosed.
  if (input->preparation && !selection->IsEverything() && !input->is_told) {
    const std::string loops = preparation::TextOfLoops(*input->preparation);
    if (!loops.empty()) input->warnings.push_back(Concat(command.input, ": ", loops));
  }
  MeshLabels labels;
  labels.features = input->labels;
  labels.regions = input->regions;
  labels.holes = input->holes;
  if (auto status = ParseMarkersFlag(command.markers, labels); !status.ok()) {
    return ReportError(status);
  }
  if (command.markers.empty() && !input->labels->markers.empty() && !input->is_told) {
    input->warnings.push_back(absl::StrFormat(
        "%s: %d marker(s) of the input: files other than .vtu have ids of features as markers; "
        "--markers input keeps those of the input",
        command.input, input->labels->markers.size()));
  }
  if (!std::exchange(input->is_told, true)) {
    for (const std::string& warning : input->warnings) PrintWarning(warning);
  }
  // It is of the prepared surface, whether or not a mesh is made of that.
  if (!command.map.empty()) {
    if (auto status = WriteFacetMap(command.input, *input, command.map); !status.ok()) {
      return ReportError(status);
    }
  }
  if (auto status = CheckNotInput(command.output, command.input); !status.ok()) {
    return ReportError(status);
  }
  MeshOptions options = input->options;
  if (auto status = ApplyMeshFlags(command.mesh, options, MeshLife::kFromScratch); !status.ok()) {
    return ReportError(status);
  }
  if (auto status = CheckOutputsOf(options, command.output); !status.ok()) {
    return ReportError(status);
  }
  input->options = options;
  if (auto status = ApplyUnsplitFlag(command.unsplit, input->features); !status.ok()) {
    return ReportError(status);
  }
  if (auto status = ApplySizeFlags(command.sizes, *input); !status.ok()) {
    return ReportError(status);
  }
  absl::StatusOr<MemoryBudget> memory = ParseMemory(command.max_memory);
  if (!memory.ok()) return ReportError(memory.status());
  const bool is_remote = IsRemote(command);
  const VertexLimit limit =
      VertexLimitOf(input->features, options, command.mesh.max_vertices.has_value(), *memory);
  limit_reason = limit.reason;
  if (!is_remote && !most) input->options.limits.max_vertices = limit.most;
  if (!is_remote) options.limits.max_vertices = std::min(limit.most, most.value_or(limit.most));
  const auto start = std::chrono::steady_clock::now();
  BuildOptions build;
  if (command.mesh.engine == "svr") build.engine = BuildEngine::kSvr;
  // Above the default angle it would leave slivers inside that are cured otherwise.
  build.only_inside = selection->IsInside() && options.dimension == 3 &&
                      options.min_dihedral <= kDefaultMinDihedral3D;
  if (input->verdict && input->verdict->ok()) build.valid = **input->verdict;
  build.progress = [&](const ApplyProgress& p) { bar.Show(p.done, p.total, WordOf(p.stage)); };
  build.interrupted = [&] { return memory->IsExceeded(); };
  PackedPoints packed;
  build.features_read = [&] { packed.Pack(input->features); };
  const auto make = [&] {
    packed.Unpack(input->features);
    return is_remote ? command.remote->Build(input->features, options, build)
                     : WithinMemory(*memory, kMemoryAdvice,
                                    [&] { return BuildMesh(input->features, options, build); });
  };
  absl::StatusOr<Mesh> mesh = BuildWithinVolumes(make, *input);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  bar.End();
  if (!mesh.ok()) {
    packed.Unpack(input->features);
    return mesh.status();
  }
  if (options.kind == MeshKind::kQuadtree) {
    if (!selection->IsEverything()) {
      return ReportError(absl::InvalidArgumentError(
          "--inside, --region, --outside: a quadtree has no simplices, which lie in regions"));
    }
    if (auto status = WriteOutputs(*mesh, options, command.output); !status.ok()) {
      return ReportError(status);
    }
    return PrintOut(SummariseQuadtree(*mesh, options, took.count(), command.json)) ? kExitDone
                                                                                   : kExitFailed;
  }
  absl::StatusOr<Mesh> opened = Mesh();
  if (!selection->IsEverything()) {
    const std::size_t all = mesh->simplex_count();
    if (selection->IsOpened()) opened = selection->OpenedOf(*mesh);
    if (!opened.ok()) return ReportError(opened.status());
    mesh = selection->Of(*mesh);
    if (build.only_inside && mesh.ok() && mesh->simplex_count() == all && Encloses(*mesh)) {
      build.only_inside = false;  // all that is enclosed are cavities, and so all is written
      mesh = BuildWithinVolumes(make, *input);
      bar.End();
      if (!mesh.ok()) {
        packed.Unpack(input->features);
        return mesh.status();
      }
    }
    if (!mesh.ok()) return ReportError(mesh.status());
    labels.is_part = mesh->simplex_count() != all;
  }
  // A large one is measured while it is being written.
  constexpr std::size_t kLarge = 20'000;
  const bool is_beside = ThreadsOf(command.output) > 1 && !command.output.paths.empty() &&
                         mesh->simplex_count() > kLarge;
  std::future<QualityReport> quality =
      std::async(is_beside ? std::launch::async | std::launch::deferred : std::launch::deferred,
                 [&] { return MeasureQuality(*mesh, options, input->features); });
  if (!command.output.paths.empty()) bar.Show(0, 0, Concat("writing ", command.output.paths[0]));
  const absl::Status written =
      WriteOutputs(selection->IsOpened() ? *opened : *mesh, options, command.output, labels);
  bar.End();
  if (const absl::Status& status = written; !status.ok()) {
    return ReportError(status);
  }
  return PrintOut(Summarise(*mesh, quality.get(), options, took.count(), *input, command.json))
             ? kExitDone
             : kExitFailed;
}

int Run(MeshCommand command) {
  command.selection.inside |= command.reading.refine;
  if (auto status = CheckOutputs(command.output); !status.ok()) return ReportError(status);
  ProgressBar bar(ErrorIsTerminal());
  bar.Show(0, 0, Concat("reading ", command.input));
  absl::StatusOr<Surface> input = ReadSurface(command.input, command.reading);
  bar.End();
  if (!input.ok()) return ReportError(input.status());
  absl::StatusOr<int> code = kExitFailed;
  std::string limit_reason;
  const auto make = [&](Surface& surface, std::optional<std::uint64_t> most) {
    code = MakeAndWrite(command, most, &surface, limit_reason);
    return code.status();
  };
  const auto prepare = [&](double tolerance) {
    InputFlags reading = command.reading;
    reading.least_tolerance = tolerance;
    return ReadSurface(command.input, reading);
  };
  const auto tell = [&](const std::string& why) { PrintWarning(Concat(command.input, ": ", why)); };
  const absl::Status made = MayMendMore(command)
                                ? preparation::MakeOfSurface(*input, make, prepare, tell)
                                : make(*input, std::nullopt);
  return made.ok() ? *code : ReportNoMesh(command, *input, made, limit_reason);
}

}  // namespace

void RegisterMeshCommand(CLI::App& app, CommandSlot& slot, std::shared_ptr<RemoteMesher> remote) {
  auto command = std::make_shared<MeshCommand>();
  command->remote = std::move(remote);
  CLI::App* const sub = AddCommand(app, slot, "mesh", "Make a mesh from scratch",
                                   [command] { return Run(*command); });
  sub->add_option("INPUT", command->input, io::GeometryFormats())->required();
  AddInputFlags(*sub, command->reading);
  AddMapFlags(*sub, command->reading);
  AddPreparationFlags(*sub, command->reading);
  sub->add_flag(
      "-r,--refine", command->reading.refine,
      Concat("INPUT is a mesh (.node with .ele, ",
             io::ListOfFormats([](const io::Format& f) { return f.read_elements != nullptr; }),
             "): its vertices become points, its constrained edges and faces segments "
             "and polygons, largest areas or volumes of a .area or .vol sizes; with "
             "--inside"));
  AddMeshFlags(*sub, command->mesh);
  sub->get_option("--max-vertices")
      ->description(
          Concat("Give up when the mesh would have more vertices (default: ", kFewestVertices,
                 ", or ", kVerticesForFeature, " for each feature; with target lengths ",
                 Limits().max_vertices, "; no more than fit into --max-memory)"));
  AddMemoryFlag(*sub, command->max_memory);
  sub->add_flag("--all", command->all_refusals,
                "Of an input that is refused, look for all refusals, not for the first ten");
  AddSizeFlags(*sub, command->sizes);
  AddUnsplitFlag(*sub, command->unsplit);
  AddOutputFlags(*sub, command->output);
  sub->add_option("--map", command->map,
                  "Of a surface file: write, as JSON, the indices of its facets, from 0, that each "
                  "polygon of the prepared surface is made of; the mesh's borders have the "
                  "polygons' ids")
      ->type_name("FILE");
  AddSelectionFlags(*sub, command->selection);
  AddSurroundingsFlag(*sub, command->selection);
  AddMarkersFlag(*sub, command->markers);
  sub->add_flag("--json", command->json, "Print one JSON object");
  if (command->remote != nullptr) command->remote->AddFlags(*sub);
}

}  // namespace dynmesh::cli
