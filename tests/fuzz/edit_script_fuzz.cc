#include <map>
#include <utility>

#include "core/io/script/edit_script.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

absl::StatusOr<io::EditScript> Parse(std::string text, bool require_header) {
  io::ScriptParseOptions options;
  options.require_header = require_header;
  return io::ParseEditScript(io::TextReader("fuzz", std::move(text)), options);
}

std::string Print(const io::EditScript& script) {
  std::string text;
  if (script.has_header) text = io::FormatMeshLine(script.Options()) + "\n";
  for (const io::ScriptBatch& batch : script.batches) {
    for (const Edit& edit : batch.edits) text += io::FormatEdit(edit, script.dimension) + "\n";
    text += "commit\n";
  }
  return text;
}

// The features after the last line, as far as that makes sense: unknown ones are replaced
// and removed without complaint.
std::vector<Feature> LastFeatures(const io::EditScript& script) {
  std::map<FeatureId, Feature> present;
  for (const io::ScriptBatch& batch : script.batches) {
    for (const Edit& edit : batch.edits) {
      if (edit.action == Edit::Action::kRemove) {
        present.erase(edit.feature.id);
      } else {
        present[edit.feature.id] = edit.feature;
      }
    }
  }
  std::vector<Feature> features;
  for (const auto& [id, feature] : present) features.push_back(feature);
  return features;
}

std::string Check(std::string_view bytes, bool require_header) {
  const absl::StatusOr<io::EditScript> script = Parse(std::string(bytes), require_header);
  if (!script.ok()) {
    const bool placed = script.status().message().substr(0, 5) == "fuzz:";
    return placed ? "" : "an error without a line: " + script.status().ToString();
  }
  const std::string text = Print(*script);
  const absl::StatusOr<io::EditScript> again = Parse(text, require_header && script->has_header);
  if (!again.ok()) return "the printed form is refused: " + again.status().ToString();
  if (Print(*again) != text) return "the printed form reads as something else:\n" + text;
  if (again->batches.size() != script->batches.size()) return "the printed form lost a batch";
  for (std::size_t b = 0; b < script->batches.size(); ++b) {
    const io::ScriptBatch& batch = script->batches[b];
    if (batch.edits != again->batches[b].edits) return "the printed form has other edits";
    if (batch.lines.size() != batch.edits.size()) return "an edit without a line";
  }
  if (script->has_header && !(script->Options() == again->Options())) {
    return "the printed form has other options";
  }
  return MeshOrRefuse(LastFeatures(*script), script->Options());
}

}  // namespace

std::string FuzzEditScript(std::string_view bytes) {
  const std::string problem = Check(bytes, /*require_header=*/true);
  return problem.empty() ? Check(bytes, /*require_header=*/false) : problem;
}

}  // namespace dynmesh::fuzz
