#include "client/cli/unsplit_flag.h"

#include <algorithm>

#include "absl/strings/numbers.h"
#include "absl/strings/str_split.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cli {

void AddUnsplitFlag(CLI::App& command, std::string& ids) {
  command
      .add_option("--unsplit", ids,
                  "2D: these segments and polygons (ids, with commas between them, or all) stay "
                  "whole: no vertex is put on them, and some triangles beside them may be worse; "
                  "those of an edit script may be marked there")
      ->type_name("IDS|all");
}

absl::Status ApplyUnsplitFlag(const std::string& ids, std::vector<Feature>& features) {
  if (ids.empty()) return absl::OkStatus();
  const auto may_be = [](const Feature& f) {
    return Is<ASegment, APolygon>(f, Not<APoint, ASize>);
  };
  if (ids == "all") {
    for (Feature& f : features) f.unsplit = f.unsplit || may_be(f);
    return absl::OkStatus();
  }
  for (const std::string& part : std::vector<std::string>(absl::StrSplit(ids, ','))) {
    FeatureId id = kNoFeature;
    const bool is_id = absl::SimpleAtoi(part, &id);
    const auto at = std::ranges::find_if(
        features, [&](const Feature& f) { return is_id && f.id == id && may_be(f); });
    if (at == features.end()) {
      return absl::InvalidArgumentError(
          text::Concat("--unsplit ", ids, ": ", text::Quoted(part),
                       " is no id of a segment or a polygon of the input"));
    }
    at->unsplit = true;
  }
  return absl::OkStatus();
}

}  // namespace dynmesh::cli
