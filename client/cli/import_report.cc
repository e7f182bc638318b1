#include "client/cli/import_report.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/common/file_writer.h"
#include "core/io/formats/mesh_output.h"
#include "core/plc/rules.h"

namespace dynmesh::cli {

using text::Concat;

absl::StatusOr<double> ToleranceOf(std::optional<double> given, const MeshOptions& options,
                                   double default_limits, double least_limits) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  const double limit = plc::CloseLimit(options);
  if (!given) return default_limits * limit;
  if (!std::isfinite(*given) || *given < least_limits * limit) {
    return absl::InvalidArgumentError(Concat("--tolerance: in this box it must be at least ",
                                             io::FormatDouble(least_limits * limit), ", found ",
                                             io::FormatDouble(*given)));
  }
  return *given;
}

absl::Status CheckOutput(int dimension, const std::string& path) {
  const absl::Status status = io::CheckFeatureOutput(dimension, path);
  if (status.ok()) return status;
  return absl::Status(status.code(), Concat("-o: ", text::View(status.message())));
}

std::string ChangeLine(const char* name, const std::vector<FeatureId>& ids,
                       std::span<const double> from, std::span<const double> to) {
  constexpr std::string_view kAxes[] = {"x", "y", "z"};
  std::vector<std::string> texts;
  for (const FeatureId id : ids) texts.push_back(Concat(id));
  JsonObject object;
  object.AddText("change", name).AddTexts("ids", texts);
  for (std::size_t i = 0; i < from.size(); ++i) object.Add(kAxes[i], from[i]);
  for (std::size_t i = 0; i < to.size(); ++i) object.Add(Concat("to_", kAxes[i]), to[i]);
  return object.ToLine();
}

void ImportSummary::AddCounts(const std::vector<Feature>& before,
                              const std::vector<Feature>& after) {
  const auto add = [&]<class View, class... Others>(const char* what, Kinds<Others...> others) {
    counts_.push_back({what, CountOf<View>(before, others), CountOf<View>(after, others)});
  };
  add.operator()<APoint>("points", Not<ASegment, APolygon, ASize>);
  add.operator()<ASegment>("segments", Not<APoint, APolygon, ASize>);
  add.operator()<APolygon>("polygons", Not<APoint, ASegment, ASize>);
}

void ImportSummary::AddCleaning(std::vector<std::string> names, double tolerance, int rounds,
                                double seconds) {
  for (std::string& name : names) changes_.push_back({std::move(name)});
  tolerance_ = tolerance;
  rounds_ = rounds;
  seconds_ = seconds;
}

void ImportSummary::AddChange(std::size_t kind, double step) {
  ++changes_[kind].count;
  largest_step_ = std::max(largest_step_, step);
}

JsonObject ImportSummary::ToJson() const {
  JsonObject object;
  object.Add("summary", true);
  for (const Count& c : counts_) object.Add(Concat(c.what, "_read"), c.before);
  for (const Count& c : counts_) object.Add(c.what, c.after);
  if (surface_) {
    object.Add("points_made_one", surface_->points)
        .Add("faces_twice", surface_->faces_twice)
        .Add("faces_without_area", surface_->faces_without_area)
        .Add("faces_cut", surface_->cut)
        .Add("faces_joined", surface_->joined)
        .Add("polygons_of_joined", surface_->polygons)
        .Add("corners_moved", surface_->moved)
        .Add("most_moved", surface_->most_moved);
  }
  object.Add("cleaned", is_cleaned());
  if (!is_cleaned()) return object;
  object.Add("rings_closed", rings_.closed)
      .Add("rings_dropped", rings_.dropped)
      .Add("rings_to_points", rings_.points);
  std::size_t all = 0;
  for (const auto& [name, count] : changes_) {
    std::string key = name;
    std::ranges::replace(key, ' ', '_');
    object.Add(key, count);
    all += count;
  }
  return object.Add("changes", all)
      .Add("largest_step", largest_step_)
      .Add("tolerance", tolerance_)
      .Add("rounds", rounds_)
      .Add("clean_seconds", seconds_);
}

std::string ImportSummary::ToText() const {
  std::string text;
  for (const Count& c : counts_) {
    text += absl::StrFormat("%-18s %d (%d read)\n", c.what, c.after, c.before);
  }
  if (!is_cleaned()) return text;
  for (const auto& [what, count] : {std::pair("rings closed", rings_.closed),
                                    {"rings dropped", rings_.dropped},
                                    {"rings to points", rings_.points}}) {
    if (count != 0) text += absl::StrFormat("%-18s %d\n", what, count);
  }
  for (const auto& [name, count] : changes_) text += absl::StrFormat("%-18s %d\n", name, count);
  return text + absl::StrFormat(
                    "largest step       %.6g\n"
                    "tolerance          %.6g\n"
                    "cleaned in         %.3f s, %d rounds\n",
                    largest_step_, tolerance_, seconds_, rounds_);
}

}  // namespace dynmesh::cli
