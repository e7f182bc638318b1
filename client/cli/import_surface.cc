#include "client/cli/import_surface.h"

#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/cleaning/feature_edges.h"
#include "client/cli/command.h"
#include "client/cli/import_report.h"
#include "client/cli/json.h"
#include "client/cli/progress_bar.h"
#include "client/cli/refusals.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/formats/mesh_output.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {
namespace {

using cleaning::SurfaceChange;
using cleaning::SurfaceChangeKind;
using cleaning::SurfaceCleanResult;
using text::Concat;

// The least tolerance, in units of the distance below which a mesh refuses features as too close.
constexpr double kLeastSurfaceLimits = 5;

double DistanceOf(const SurfaceChange& change) {
  // For these kinds `from` and `to` are two places, not a motion.
  if (change.kind == SurfaceChangeKind::kFaceDoubled ||
      change.kind == SurfaceChangeKind::kSegmentDoubled ||
      change.kind == SurfaceChangeKind::kPointDropped) {
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

// Of what was done to keep feature edges only.
struct FeatureEdgeReport {
  double angle = 0, within = 0, seconds = 0;
  std::size_t sharp_edges = 0, corners = 0;
};

std::string ToText(const FeatureEdgeReport& report) {
  return absl::StrFormat(
      "sharp edges        %d, sharper than %.6g degrees\n"
      "corners            %d\n"
      "surface within     %.6g\n"
      "simplified in      %.3f s\n",
      report.sharp_edges, report.angle, report.corners, report.within, report.seconds);
}

void AddTo(JsonObject& summary, const FeatureEdgeReport& report) {
  summary.Add("feature_angle", report.angle)
      .Add("sharp_edges", report.sharp_edges)
      .Add("corners", report.corners)
      .Add("within", report.within)
      .Add("simplify_seconds", report.seconds);
}

void DropAttributes(const std::string& path, io::FeatureLabels& labels) {
  if (labels.attributes != 0) {
    PrintWarning(Concat(path, ": attributes of points left out by --clean"));
  }
  labels.attributes = 0;
  labels.values.clear();
}

// Replaces the features of `result`.
absl::Status KeepFeatureEdges(const SurfaceImport& command, SurfaceCleanResult& result,
                              io::FeatureLabels& labels, FeatureEdgeReport& report) {
  cleaning::FeatureEdgeOptions options;
  options.angle = *command.feature_angle;
  options.within = command.within.value_or(cleaning::DefaultWithin(result.features));
  options.tolerance = result.tolerance;
  io::LabelNumbers numbers(labels);
  options.group = [&](FeatureId id) { return numbers.Of(id); };
  const auto start = std::chrono::steady_clock::now();
  auto kept = cleaning::KeepFeatureEdges(result.features, options);
  if (!kept.ok()) return kept.status();
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  report = {options.angle, options.within, seconds.count(), kept->sharp_edges, kept->corners};
  io::KeepLabelsOfParts(kept->parts, labels);
  result.features = std::move(kept->features);
  result.changes.insert(result.changes.end(), kept->changes.begin(), kept->changes.end());
  return absl::OkStatus();
}

absl::Status Write(const SurfaceImport& command, const Input& input,
                   const std::vector<Feature>& features, const io::FeatureLabels& labels) {
  const io::Format& format = *io::FindFormat(command.output);
  const auto left_out = [&](io::FormatFlag keeps, std::size_t count, const char* what) {
    if (count == 0 || format.Is(keeps)) return;
    PrintWarning(Concat(command.output, ": ", count, " ", what, " left out"));
  };
  left_out(io::kKeepsSizes, CountOf<ASize>(features, Not<APoint, ASegment, APolygon>),
           "sizing feature(s)");
  left_out(io::kKeepsNames, labels.names.size(), "name(s)");
  left_out(io::kKeepsSegments, CountOf<ASegment>(features, Not<APoint, APolygon, ASize>),
           "segment(s)");
  left_out(io::kKeepsMarkers, labels.markers.size(), "marker(s)");
  left_out(io::kKeepsSeeds, input.holes.size() + input.regions.size(),
           "position(s) of holes and regions");
  return io::WriteFeatureFile(command.output,
                              {input.options, features, input.holes, input.regions, labels});
}

}  // namespace

int ImportSurface(const SurfaceImport& command, Input input) {
  if (auto status = CheckOutput(3, command.output); !status.ok()) return ReportError(status);
  SurfaceCleanResult result;
  ImportSummary summary;
  Refusals refusals;
  std::optional<FeatureEdgeReport> edges;
  io::FeatureLabels labels = *input.labels;
  if (command.clean) {
    const absl::StatusOr<double> tolerance = ToleranceOf(
        command.tolerance, input.options, cleaning::kDefaultSurfaceLimits, kLeastSurfaceLimits);
    if (!tolerance.ok()) return ReportError(tolerance.status());
    cleaning::SurfaceCleanOptions options;
    options.tolerance = *tolerance;
    options.max_steps = command.max_steps;
    options.holes = io::FindFormat(command.output)->Is(io::kKeepsPolygonHoles);
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
    io::KeepLabelsOfParts(result.parts, labels);
    DropAttributes(command.input, labels);
    if (command.feature_angle) {
      bar.Show(0, 0, "making nearly flat patches coarse");
      const absl::Status status = KeepFeatureEdges(command, result, labels, edges.emplace());
      bar.End();
      if (!status.ok()) return ReportError(status);
    }
    for (const SurfaceChange& change : result.changes) {
      summary.AddChange(static_cast<std::size_t>(change.kind), DistanceOf(change));
    }
    refusals = FindRefusals(result.features, input.options, command.all);
  } else {
    result.features = input.features;
  }
  summary.AddCounts(input.features, result.features);
  if (input.surface) summary.AddSurface(*input.surface);
  if (auto status = Write(command, input, result.features, labels); !status.ok()) {
    return ReportError(status);
  }
  std::string report;
  if (command.json) {
    for (const SurfaceChange& change : result.changes) {
      report += ChangeLine(cleaning::NameOf(change.kind), change.ids, change.from, change.to);
    }
    JsonObject object = summary.ToJson();
    if (edges) AddTo(object, *edges);
    if (command.clean) AddTo(object, refusals);
    report += object.ToLine();
  } else {
    report =
        summary.ToText() + (edges ? ToText(*edges) : "") + (command.clean ? ToText(refusals) : "");
  }
  return PrintOut(report) ? kExitDone : kExitFailed;
}

}  // namespace dynmesh::cli
