#include "client/cli/import_surface.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <vector>

#include "absl/strings/str_format.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/cli/command.h"
#include "client/cli/json.h"
#include "client/cli/progress_bar.h"
#include "client/cli/refusals.h"
#include "core/base/text.h"
#include "core/io/common/extension.h"
#include "core/io/common/file_writer.h"
#include "core/io/plane/planar_output.h"
#include "core/io/space/surface_output.h"
#include "core/plc/rules.h"
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

std::size_t CountOf(const std::vector<Feature>& features, FeatureKind kind) {
  return static_cast<std::size_t>(std::ranges::count(features, kind, &Feature::kind));
}

double DistanceOf(const SurfaceChange& change) {
  // For these kinds `from` and `to` are two places, not a motion.
  if (change.kind == SurfaceChangeKind::kFaceDoubled ||
      change.kind == SurfaceChangeKind::kSegmentDoubled) {
    return 0;
  }
  return std::hypot(change.from[0] - change.to[0], change.from[1] - change.to[1],
                    change.from[2] - change.to[2]);
}

std::string ToJson(const SurfaceChange& change) {
  std::vector<std::string> ids;
  for (const FeatureId id : change.ids) ids.push_back(Concat(id));
  return JsonObject()
      .AddText("change", cleaning::NameOf(change.kind))
      .AddTexts("ids", ids)
      .Add("x", change.from[0])
      .Add("y", change.from[1])
      .Add("z", change.from[2])
      .Add("to_x", change.to[0])
      .Add("to_y", change.to[1])
      .Add("to_z", change.to[2])
      .ToLine();
}

// What the summary tells.
class Summary {
 public:
  void AddCount(const char* what, FeatureKind kind, const std::vector<Feature>& before,
                const std::vector<Feature>& after) {
    counts_.push_back({what, CountOf(before, kind), CountOf(after, kind)});
  }

  void AddCleaning(const SurfaceCleanResult& result, double seconds, Refusals refusals) {
    is_cleaned_ = true;
    for (const SurfaceChange& change : result.changes) {
      ++changes_[static_cast<std::size_t>(change.kind)];
      largest_step_ = std::max(largest_step_, DistanceOf(change));
    }
    all_changes_ = result.changes.size();
    rounds_ = result.rounds;
    tolerance_ = result.tolerance;
    seconds_ = seconds;
    refusals_ = std::move(refusals);
  }

  std::string ToJson() const {
    JsonObject object;
    object.Add("summary", true);
    for (const Count& c : counts_) object.Add(Concat(c.what, "_read"), c.before);
    for (const Count& c : counts_) object.Add(c.what, c.after);
    object.Add("cleaned", is_cleaned_);
    if (!is_cleaned_) return object.ToLine();
    for (std::size_t k = 0; k < changes_.size(); ++k) {
      std::string key = NameOf(k);
      for (char& c : key) c = c == ' ' ? '_' : c;
      object.Add(key, changes_[k]);
    }
    JsonObject reasons;
    for (const auto& [reason, count] : refusals_.by_reason) reasons.Add(reason, count);
    return object.Add("changes", all_changes_)
        .Add("largest_step", largest_step_)
        .Add("tolerance", tolerance_)
        .Add("rounds", rounds_)
        .Add("clean_seconds", seconds_)
        .Add("refused", refusals_.count)
        .Add("refused_all_counted", refusals_.is_complete)
        .AddObject("refused_by_reason", reasons)
        .ToLine();
  }

  std::string ToText() const {
    std::string text;
    for (const Count& c : counts_) {
      text += absl::StrFormat("%-18s %d (%d read)\n", c.what, c.after, c.before);
    }
    if (!is_cleaned_) return text;
    for (std::size_t k = 0; k < changes_.size(); ++k) {
      text += absl::StrFormat("%-18s %d\n", NameOf(k), changes_[k]);
    }
    text += absl::StrFormat(
        "largest step       %.6g\n"
        "tolerance          %.6g\n"
        "cleaned in         %.3f s, %d rounds\n"
        "refused by a mesh  %s%d",
        largest_step_, tolerance_, seconds_, rounds_, refusals_.is_complete ? "" : "at least ",
        refusals_.count);
    std::string reasons;
    for (const auto& [reason, count] : refusals_.by_reason) {
      reasons += Concat(reasons.empty() ? " (" : ", ", reason, " ", count);
    }
    return text + reasons + (reasons.empty() ? "\n" : ")\n");
  }

 private:
  struct Count {
    const char* what;
    std::size_t before, after;
  };

  static std::string NameOf(std::size_t kind) {
    return cleaning::NameOf(static_cast<SurfaceChangeKind>(kind));
  }

  std::vector<Count> counts_;
  std::array<std::size_t, cleaning::kSurfaceChangeKinds> changes_{};
  std::size_t all_changes_ = 0;
  double largest_step_ = 0;
  int rounds_ = 0;
  double tolerance_ = 0;
  double seconds_ = 0;
  bool is_cleaned_ = false;
  Refusals refusals_;
};

absl::StatusOr<double> ToleranceOf(const SurfaceImport& command, const MeshOptions& options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  const double limit = plc::CloseLimit(options);
  if (!command.tolerance) return kDefaultCloseLimits * limit;
  if (!std::isfinite(*command.tolerance) || *command.tolerance < kLeastCloseLimits * limit) {
    return absl::InvalidArgumentError(Concat("--tolerance: in this box it must be at least ",
                                             io::FormatDouble(kLeastCloseLimits * limit),
                                             ", found ", io::FormatDouble(*command.tolerance)));
  }
  return *command.tolerance;
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
  Summary summary;
  io::FeatureLabels labels = *input.labels;
  if (command.clean) {
    const absl::StatusOr<double> tolerance = ToleranceOf(command, input.options);
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
    summary.AddCleaning(result, seconds.count(),
                        FindRefusals(result.features, input.options, kMostWork));
    KeepLabels(result, command.input, labels);
  } else {
    result.features = input.features;
  }
  summary.AddCount("points", FeatureKind::kPoint, input.features, result.features);
  summary.AddCount("segments", FeatureKind::kSegment, input.features, result.features);
  summary.AddCount("polygons", FeatureKind::kPolygon, input.features, result.features);
  if (auto status = Write(command, input, result.features, labels); !status.ok()) {
    return ReportError(status);
  }
  std::string report;
  if (command.json) {
    for (const SurfaceChange& change : result.changes) report += ToJson(change);
  }
  report += command.json ? summary.ToJson() : summary.ToText();
  return PrintOut(report) ? kExitDone : kExitFailed;
}

}  // namespace dynmesh::cli
