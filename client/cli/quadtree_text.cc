#include "client/cli/quadtree_text.h"

#include <cmath>

#include "absl/strings/str_format.h"

namespace dynmesh::cli {

std::string QuadtreeText(const QuadtreeReport& report) {
  std::string text = absl::StrFormat("leaves             %d\n", report.leaves);
  if (!std::isnan(report.least_ratio)) {
    text += absl::StrFormat("lfs / side         %.3f to %.3f\n", report.least_ratio,
                            report.greatest_ratio);
  }
  text += absl::StrFormat("hash               %s\n\n  level          side        leaves\n",
                          report.hash.ToHex());
  for (const auto& [level, leaves] : report.leaves_of_level) {
    text +=
        absl::StrFormat("%7d  %12.6g  %12d\n", level, std::ldexp(report.root_side, -level), leaves);
  }
  return text;
}

JsonObject& QuadtreeJson(const QuadtreeReport& report, JsonObject& object) {
  std::vector<JsonObject> levels;
  for (const auto& [level, leaves] : report.leaves_of_level) {
    levels.push_back(JsonObject()
                         .Add("level", level)
                         .Add("side", std::ldexp(report.root_side, -level))
                         .Add("leaves", leaves));
  }
  object.Add("dimension", report.dimension).Add("leaves", report.leaves);
  if (!std::isnan(report.least_ratio)) {
    object.AddObject("lfs_over_side",
                     JsonObject().Add("min", report.least_ratio).Add("max", report.greatest_ratio));
  }
  return object.AddText("hash", report.hash.ToHex()).AddObjects("levels", levels);
}

}  // namespace dynmesh::cli
