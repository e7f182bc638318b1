// dynmesh import INPUT -o OUT: converts any input to .poly or an edit script, cleaned on request.
// Of 3D input: import_surface.h.
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cleaning/clean_input.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/cleaning/feature_edges.h"
#include "client/cli/command.h"
#include "client/cli/finest_gap.h"
#include "client/cli/import_report.h"
#include "client/cli/import_surface.h"
#include "client/cli/input.h"
#include "client/cli/json.h"
#include "client/cli/mesh_flags.h"
#include "client/cli/progress_bar.h"
#include "client/cli/vertex_limit.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/formats/mesh_output.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {
namespace {

using cleaning::Change;
using cleaning::ChangeKind;
using cleaning::CleanResult;
using text::Concat;

// The least tolerance, in units of the distance below which a mesh refuses features as too close: 2
// would leave nothing for rounding and a smaller box.
constexpr double kLeastCloseLimits = 2.5;

struct ImportCommand {
  std::string input;
  std::string output;
  std::string box;
  std::optional<double> tolerance, feature_angle, within;
  bool clean = false;
  bool polygons = false;
  bool keep_facets = false;
  std::uint64_t max_steps = 0;
  bool all = false;
  bool json = false;
};

double DistanceOf(const Change& change) {
  // For these kinds `from` and `to` are the ends of an edge, not a motion.
  if (change.kind == ChangeKind::kDoubled || change.kind == ChangeKind::kCancelled) return 0;
  return std::hypot(change.from[0] - change.to[0], change.from[1] - change.to[1]);
}

// The remaining polygons with the map's own names for them.
std::string ToJson(const std::vector<io::PolygonName>& names,
                   const std::vector<Feature>& features) {
  std::set<FeatureId> left;
  for (const Feature& f : features) {
    if (Is<APolygon>(f, Not<APoint, ASegment, ASize>)) left.insert(f.id);
  }
  std::string lines;
  for (const io::PolygonName& polygon : names) {
    if (!left.contains(polygon.id)) continue;
    JsonObject object;
    object.AddText("polygon", Concat(polygon.id));
    if (!polygon.key.empty()) object.AddText("id", polygon.key);
    if (!polygon.name.empty()) object.AddText("name", polygon.name);
    lines += object.ToLine();
  }
  return lines;
}

// Checks that a mesh accepts these: the result of cleaning is verified, too. However many vertices
// it would have.
absl::Status ValidateFeatures(const std::vector<Feature>& features, MeshOptions options) {
  options.limits.max_vertices = MostVertices(options.dimension);
  const auto mesh = DynamicMesh::Create(options);
  if (!mesh.ok()) return mesh.status();
  return (*mesh)->Validate(AddAll(features));
}

// An input's own box contains it; a given box may not.
absl::Status CheckInside(const Input& input) {
  const Box& box = input.options.box;
  for (const Feature& f : input.features) {
    if (!IsPoint(f)) continue;
    for (std::size_t i = 0; i < static_cast<std::size_t>(input.options.dimension); ++i) {
      if (f.position[i] >= box.lo[i] && f.position[i] <= box.hi[i]) continue;
      const std::string place = input.where(f.id);
      return absl::InvalidArgumentError(
          Concat(place, place.empty() ? "" : ": ", "point ", f.id, " at (", f.position[0], ", ",
                 f.position[1], input.options.dimension == 3 ? Concat(", ", f.position[2]) : "",
                 ") is outside --box; give a larger box"));
    }
  }
  return absl::OkStatus();
}

absl::Status Clean(const ImportCommand& command, const Input& input, CleanResult& result,
                   ImportSummary& summary) {
  const absl::StatusOr<double> tolerance = ToleranceOf(
      command.tolerance, input.options, cleaning::kDefaultCloseLimits, kLeastCloseLimits);
  if (!tolerance.ok()) return tolerance.status();
  cleaning::CleanOptions options;
  options.tolerance = *tolerance;
  const auto start = std::chrono::steady_clock::now();
  absl::StatusOr<CleanResult> cleaned = cleaning::CleanInput(input.features, options);
  if (!cleaned.ok()) return Locate(cleaned.status(), input.where);
  result = *std::move(cleaned);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  const absl::Status status = ValidateFeatures(result.features, input.options);
  if (!status.ok() && !absl::IsResourceExhausted(status)) return Locate(status, input.where);
  summary.AddRings(input.mended);
  summary.AddCleaning(NamesOf<ChangeKind>(cleaning::kChangeKinds), *tolerance, result.rounds,
                      seconds.count());
  for (const Change& change : result.changes) {
    summary.AddChange(static_cast<std::size_t>(change.kind), DistanceOf(change));
  }
  return absl::OkStatus();
}

// Where what cleaning leaves is so fine that `mesh` would refuse it by default.
void WarnOfFinestGap(const std::vector<Feature>& features, const Input& input) {
  MeshOptions options = input.options;
  options.limits.max_vertices = DefaultMostVertices(features, options);
  const std::optional<FinestGap> gap = FindFinestGap(features, options);
  if (!gap || gap->vertices <= static_cast<double>(options.limits.max_vertices)) return;
  PrintWarning(Concat("a mesh of this takes at least ", absl::StrFormat("%.2g", gap->vertices),
                      " vertices; ", TextOf(*gap, options.dimension, input.where)));
  PrintWarning(AdviceFor(*gap));
}

// Of points that reach much farther than all others, the first one.
std::optional<FeatureId> FarPoint(const Input& input) {
  constexpr double kFar = 1000;
  for (std::size_t k = 0; k < 2; ++k) {
    std::vector<std::pair<double, FeatureId>> sorted;
    for (const Feature& f : input.features) {
      if (IsPoint(f)) sorted.emplace_back(f.position[k], f.id);
    }
    if (sorted.size() < 4) return std::nullopt;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t last = sorted.size() - 1;
    const double without_first = sorted[last].first - sorted[1].first;
    const double without_last = sorted[last - 1].first - sorted[0].first;
    const double all = sorted[last].first - sorted[0].first;
    if (all > kFar * without_last) return sorted[last].second;
    if (all > kFar * without_first) return sorted[0].second;
  }
  return std::nullopt;
}

// Polygons that cleaning dropped: says so. If they were all there was with a length or an area,
// that is an error.
absl::Status CheckWhatIsLeft(const ImportCommand& command, const Input& input,
                             const CleanResult& result) {
  const auto drawn = [](const std::vector<Feature>& features) {
    return CountOf<ASegment, APolygon>(features, Not<APoint, ASize>);
  };
  const bool has_polygons = CountOf<APolygon>(input.features, Not<APoint, ASegment, ASize>) != 0;
  constexpr std::size_t kMostNamed = 10;
  std::size_t dropped = 0;
  std::string places;
  for (const Change& change : result.changes) {
    const bool is_polygon = change.kind == ChangeKind::kPolygonDropped;
    if (!is_polygon && change.kind != ChangeKind::kZeroLength) continue;
    if (!is_polygon && has_polygons) continue;
    if (dropped++ >= kMostNamed) continue;
    const std::string where = input.where(change.ids.front());
    places += Concat(places.empty() ? "" : ", ", is_polygon ? "polygon " : "segment ",
                     change.ids.front(), " at (", change.from[0], ", ", change.from[1], ")",
                     where.empty() ? "" : Concat(" (", where, ")"));
  }
  if (dropped > kMostNamed) places += Concat(" and ", dropped - kMostNamed, " more");
  const bool is_empty = drawn(result.features) == 0;
  if (is_empty && drawn(input.features) != 0) {
    std::string message = Concat(command.input, ": nothing is left: 0 polygons and 0 segments");
    if (!places.empty()) message += Concat("; without an area or a length: ", places);
    if (const auto far = FarPoint(input)) {
      message += Concat("; point ", *far,
                        " is so far from all others that the tolerance is larger "
                        "than what they are apart: leave it out, or give --tolerance and --box");
    }
    return absl::InvalidArgumentError(message + "; nothing is written");
  }
  if (has_polygons && dropped != 0) {
    PrintWarning(Concat(dropped, " polygon(s) without an area left out: ", places));
  }
  return absl::OkStatus();
}

// Features that the format of `path` cannot represent.
absl::Status CheckKept(const std::string& path, const std::vector<Feature>& features) {
  const io::Format& format = *io::FindFormat(path);
  const std::size_t polygons = CountOf<APolygon>(features, Not<APoint, ASegment, ASize>);
  if (polygons != 0 && !format.Is(io::kKeepsPolygons)) {
    return absl::InvalidArgumentError(Concat("-o: ", path, ": a ", format.extension,
                                             " has no place for the ", polygons,
                                             " polygon(s); write a .dynmesh"));
  }
  const std::size_t sizes = CountOf<ASize>(features, Not<APoint, ASegment, APolygon>);
  if (sizes != 0 && !format.Is(io::kKeepsSizes)) {
    PrintWarning(
        Concat(path, ": ", sizes, " sizing feature(s) left out; a .dynmesh has place for them"));
  }
  return absl::OkStatus();
}

// Makes polygons for the holes and regions of `input`, from the segments in `features`.
absl::Status MarkSeeds(bool cleaned, Input& input, std::vector<Feature>& features) {
  if (input.holes.empty() && input.regions.empty()) return absl::OkStatus();
  if (!cleaned && !ValidateFeatures(features, input.options).ok()) {
    PrintWarning(Concat(input.seed_file,
                        ": holes and regions left out, as the segments are not "
                        "what a mesh accepts; --clean mends that"));
    return absl::OkStatus();
  }
  const std::size_t told = input.warnings.size();
  input.features.swap(features);
  const absl::Status status = AddSeedPolygons(input);
  input.features.swap(features);
  for (std::size_t i = told; i < input.warnings.size(); ++i) PrintWarning(input.warnings[i]);
  return status;
}

// Flags that do not go together, and values out of range.
absl::Status CheckFlags(const ImportCommand& command) {
  if (command.tolerance && !command.clean) {
    return absl::InvalidArgumentError("--tolerance needs --clean");
  }
  if (command.feature_angle && !command.clean) {
    return absl::InvalidArgumentError("--feature-angle needs --clean");
  }
  if (command.within && !command.feature_angle) {
    return absl::InvalidArgumentError("--within needs --feature-angle");
  }
  constexpr double kLeast = cleaning::kLeastFeatureAngle, kMost = cleaning::kMostFeatureAngle;
  if (const auto& angle = command.feature_angle; angle && !(*angle >= kLeast && *angle <= kMost)) {
    return absl::InvalidArgumentError(Concat("--feature-angle: it must be from ", kLeast, " to ",
                                             kMost, " degrees, found ", *angle));
  }
  if (command.within && !(*command.within > 0 && std::isfinite(*command.within))) {
    return absl::InvalidArgumentError(
        Concat("--within: it must be above 0, found ", *command.within));
  }
  return absl::OkStatus();
}

int Run(const ImportCommand& command) {
  if (const absl::Status status = CheckFlags(command); !status.ok()) return ReportError(status);
  InputFlags reading;
  reading.polygons = command.polygons;
  reading.keep_facets = command.keep_facets;
  if (const io::Format* const format = io::FindFormat(command.output); format != nullptr) {
    reading.holes_of_polygons = format->Is(io::kKeepsPolygonHoles);
  }
  if (command.clean) reading.faces = io::FaceRules::kAsTheyCome;
  reading.mend_rings = command.clean;
  ProgressBar bar(ErrorIsTerminal());
  bar.Show(0, 0, Concat("reading ", command.input));
  absl::StatusOr<Input> input = LoadInput(command.input, reading);
  bar.End();
  if (!input.ok()) return ReportError(input.status());
  for (const std::string& warning : input->warnings) PrintWarning(warning);
  if (!command.box.empty()) {
    const absl::Status given = ApplyBoxFlag(command.box, input->options);
    if (!given.ok()) return ReportError(given);
    if (const absl::Status status = CheckInside(*input); !status.ok()) return ReportError(status);
  }
  if (input->options.dimension == 3) {
    return ImportSurface(
        {command.input, command.output, command.tolerance, command.feature_angle, command.within,
         command.max_steps, command.clean, command.all, command.json},
        *std::move(input));
  }
  if (command.feature_angle) {
    return ReportError(absl::InvalidArgumentError(
        Concat("--feature-angle is for surfaces; ", command.input, " is 2D")));
  }
  if (auto status = CheckOutput(2, command.output); !status.ok()) return ReportError(status);
  const bool keeps_seeds = io::FindFormat(command.output)->Is(io::kKeepsSeeds);
  ImportSummary summary;
  CleanResult result;
  if (command.clean) {
    bar.Show(0, 0, "cleaning");
    const absl::Status status = Clean(command, *input, result, summary);
    bar.End();
    if (!status.ok()) return ReportError(status);
    if (auto left = CheckWhatIsLeft(command, *input, result); !left.ok()) return ReportError(left);
    WarnOfFinestGap(result.features, *input);
  } else {
    result.features = input->features;
  }
  summary.AddCounts(input->features, result.features);
  if (auto status = CheckKept(command.output, result.features); !status.ok()) {
    return ReportError(status);
  }
  if (!keeps_seeds) {
    const absl::Status marked = MarkSeeds(command.clean, *input, result.features);
    if (!marked.ok()) return ReportError(marked);
  }
  // Cleaning splits and merges what has them; polygons keep their ids.
  io::FeatureLabels labels = *input->labels;
  if (command.clean) {
    if (const std::size_t lost = labels.markers.size() + labels.attributes; lost != 0) {
      PrintWarning(Concat(command.input, ": markers and attributes left out by --clean"));
    }
    labels.markers.clear();
    labels.attributes = 0;
  }
  const absl::Status written = io::WriteFeatureFile(
      command.output, {input->options, result.features, input->holes, input->regions, labels});
  if (!written.ok()) return ReportError(written);
  std::string report;
  if (command.json) {
    for (const Change& change : result.changes) {
      report += ChangeLine(cleaning::NameOf(change.kind), change.ids, change.from, change.to);
    }
    report += ToJson(input->polygon_names, result.features);
    report += summary.ToJson().ToLine();
  } else {
    report = summary.ToText();
  }
  return PrintOut(report) ? kExitDone : kExitFailed;
}

}  // namespace

void RegisterImportCommand(CLI::App& app, CommandSlot& slot) {
  auto command = std::make_shared<ImportCommand>();
  CLI::App* const sub =
      AddCommand(app, slot, "import", "Read a map, a surface or other input, clean it, write it",
                 [command] { return Run(*command); });
  sub->add_option("INPUT", command->input, io::GeometryFormats())->required();
  sub->add_option("-o,--output", command->output, "Where to: " + io::FeatureOutputFormats())
      ->required()
      ->type_name("OUT");
  sub->add_flag("--clean", command->clean,
                "Mend what a mesh refuses: merge, split, drop (all is reported)");
  sub->add_flag("--polygons", command->polygons,
                "Polygons of a map become polygon features, not segments");
  sub->add_flag(
      "--keep-facets", command->keep_facets,
      "Of a surface file, without --clean: do not join faces in one plane, as `mesh` with this "
      "flag");
  sub->add_option("--tolerance", command->tolerance,
                  "Points nearer to each other than this are merged (default: 4 times, in 3D 8 "
                  "times, what a mesh refuses as too close)")
      ->type_name("T");
  sub->add_option("--feature-angle", command->feature_angle,
                  "With --clean: of a surface keep only edges sharper than A degrees (0.1 to 89), "
                  "and corners; nearly flat patches get fewer, larger triangles")
      ->type_name("A");
  sub->add_option("--within", command->within,
                  "With --feature-angle: the new surface and the old one are this near to each "
                  "other everywhere (default: 0.001 of the diagonal of the surface's box)")
      ->type_name("D");
  AddBoxFlag(*sub, command->box);
  sub->add_option("--max-steps", command->max_steps,
                  Concat("Give up cleaning a surface after so many comparisons, about a "
                         "microsecond each (default: ",
                         cleaning::kLeastSteps, ", or ", cleaning::kStepsForFeature,
                         " for each feature if that is more)"))
      ->type_name("N")
      ->check(CLI::PositiveNumber);
  sub->add_flag(
      "--all", command->all,
      "With --clean of a surface: count all that a mesh still refuses, not the first ten");
  sub->add_flag("--json", command->json,
                "Print every change, a map's polygons with their names, and a summary, one object "
                "a line");
}

}  // namespace dynmesh::cli
