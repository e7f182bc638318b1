#include "client/cli/import_surface.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include "client/cleaning/clean_surfaces.h"
#include "client/cli/command.h"
#include "client/cli/import_report.h"
#include "client/cli/json.h"
#include "client/cli/progress_bar.h"
#include "client/cli/refusals.h"
#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/plane/planar_output.h"
#include "core/io/space/surface_output.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {
namespace {

using cleaning::SurfaceChange;
using cleaning::SurfaceChangeKind;
using cleaning::SurfaceCleanResult;
using text::Concat;

// Tolerances in units of the distance below which a mesh refuses features as too close. Cleaning
// keeps a fourth of the tolerance from faces.
constexpr double kDefaultCloseLimits = 8;
constexpr double kLeastCloseLimits = 5;
// Features looked at to count what a mesh refuses: some seconds.
constexpr std::size_t kMostWork = 1'000'000;

double DistanceOf(const SurfaceChange& change) {
  // For these kinds `from` and `to` are two places, not a motion.
  if (change.kind == SurfaceChangeKind::kFaceDoubled ||
      change.kind == SurfaceChangeKind::kSegmentDoubled) {
    return 0;
  }
  return std::hypot(change.from[0] - change.to[0], change.from[1] - change.to[1],
                    change.from[2] - change.to[2]);
}

std::string ToText(const Refusals& refusals) {
  std::string reasons;
  for (const auto& [reason, count] : refusals.by_reason) {
    reasons += Concat(reasons.empty() ? " (" : ", ", reason, " ", count);
  }
  return Concat("refused by a mesh  ", refusals.is_complete ? "" : "at least ", refusals.count,
                reasons, reasons.empty() ? "\n" : ")\n");
}

void AddTo(JsonObject& summary, const Refusals& refusals) {
  JsonObject reasons;
  for (const auto& [reason, count] : refusals.by_reason) reasons.Add(reason, count);
  summary.Add("refused", refusals.count)
      .Add("refused_all_counted", refusals.is_complete)
      .AddObject("refused_by_reason", reasons);
}

// Parts have the labels of what they are a part of. Attributes of points are left out.
void KeepLabels(const SurfaceCleanResult& result, const std::string& path,
                io::FeatureLabels& labels) {
  for (const auto& [part, whole] : result.parts) {
    if (const std::int64_t marker = labels.MarkerOf(whole); marker != 0) {
      labels.markers[part] = marker;
    }
    if (const std::string name = labels.NameOf(whole); !name.empty()) labels.names[part] = name;
  }
  if (labels.attributes != 0) {
    PrintWarning(Concat(path, ": attributes of points left out by --clean"));
  }
  labels.attributes = 0;
  labels.values.clear();
}

absl::Status Write(const SurfaceImport& command, const Input& input,
                   const std::vector<Feature>& features, const io::FeatureLabels& labels) {
  const std::string extension = io::ExtensionOf(command.output);
  const auto left_out = [&](std::size_t count, const char* what) {
    if (count != 0) PrintWarning(Concat(command.output, ": ", count, " ", what, " left out"));
  };
  if (extension == ".dynmesh") {
    left_out(input.holes.size() + input.regions.size(), "position(s) of holes and regions");
    return io::WriteFeatureScript(command.output, input.options, features, labels);
  }
  left_out(CountOf(features, FeatureKind::kSize), "sizing feature(s)");
  left_out(labels.names.size(), "name(s)");
  if (extension == ".off") {
    left_out(CountOf(features, FeatureKind::kSegment), "segment(s)");
    left_out(labels.markers.size(), "marker(s)");
    left_out(input.holes.size() + input.regions.size(), "position(s) of holes and regions");
    return io::WriteOffFile(command.output, features);
  }
  const auto write = extension == ".poly" ? io::WriteSpacePolyFile : io::WriteSmeshFile;
  return write(command.output, features, input.holes, input.regions, labels);
}

}  // namespace

int ImportSurface(const SurfaceImport& command, Input input) {
  const std::string extension = io::ExtensionOf(command.output);
  constexpr std::array<std::string_view, 4> kKinds = {".poly", ".smesh", ".off", ".dynmesh"};
  if (std::ranges::find(kKinds, extension) == kKinds.end()) {
    return ReportError(absl::InvalidArgumentError(
        Concat("-o: ", command.output,
               " is neither a .poly, .smesh or .off nor a .dynmesh (an edit script)")));
  }
  SurfaceCleanResult result;
  ImportSummary summary;
  Refusals refusals;
  io::FeatureLabels labels = *input.labels;
  if (command.clean) {
    const absl::StatusOr<double> tolerance =
        ToleranceOf(command.tolerance, input.options, kDefaultCloseLimits, kLeastCloseLimits);
    if (!tolerance.ok()) return ReportError(tolerance.status());
    cleaning::SurfaceCleanOptions options;
    options.tolerance = *tolerance;
    options.holes = extension == ".dynmesh";
    ProgressBar bar(ErrorIsTerminal());
    bar.Show(0, 0, "cleaning");
    const auto start = std::chrono::steady_clock::now();
    absl::StatusOr<SurfaceCleanResult> cleaned = cleaning::CleanSurfaces(input.features, options);
    bar.End();
    if (!cleaned.ok()) return ReportError(Locate(cleaned.status(), input.where));
    result = *std::move(cleaned);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    summary.AddCleaning(NamesOf<SurfaceChangeKind>(cleaning::kSurfaceChangeKinds), result.tolerance,
                        result.rounds, seconds.count());
    for (const SurfaceChange& change : result.changes) {
      summary.AddChange(static_cast<std::size_t>(change.kind), DistanceOf(change));
    }
    refusals = FindRefusals(result.features, input.options, kMostWork);
    KeepLabels(result, command.input, labels);
  } else {
    result.features = input.features;
  }
  summary.AddCounts(input.features, result.features);
  if (auto status = Write(command, input, result.features, labels); !status.ok()) {
    return ReportError(status);
  }
  std::string report;
  if (command.json) {
    for (const SurfaceChange& change : result.changes) {
      report += ChangeLine(cleaning::NameOf(change.kind), change.ids, change.from, change.to);
    }
    JsonObject object = summary.ToJson();
    if (command.clean) AddTo(object, refusals);
    report += object.ToLine();
  } else {
    report = summary.ToText() + (command.clean ? ToText(refusals) : "");
  }
  return PrintOut(report) ? kExitDone : kExitFailed;
}

}  // namespace dynmesh::cli
