#include "core/io/plane/planar_input.h"
#include "core/io/script/edit_script.h"
#include "tests/fuzz/small_mesh.h"
#include "tests/fuzz/targets.h"

namespace dynmesh::fuzz {
namespace {

std::string Check(const absl::StatusOr<io::FileFeatures>& input) {
  if (!input.ok()) return input.status().message().empty() ? "an error without a message" : "";
  if (input->features.size() != input->point_count + input->segment_count ||
      input->lines.size() != input->features.size()) {
    return "counts disagree";
  }
  if (input->labels.values.size() != input->point_count * input->labels.attributes) {
    return "attributes disagree";
  }
  for (const auto& [id, marker] : input->labels.markers) {
    if (id < 1 || id > input->features.size() || marker == 0) return "a marker of nothing";
  }
  for (std::size_t i = 0; i < input->features.size(); ++i) {
    const Feature& f = input->features[i];
    if (f.id != i + 1) return "ids are not in file order";
    if (input->Where(f.id).empty()) return "a feature without a place";
    if (f.kind != FeatureKind::kSegment) continue;
    for (const FeatureId end : f.ends) {
      if (end < 1 || end > input->point_count) return "a segment's end is no point";
    }
  }
  MeshOptions options;
  options.box = io::BoundingBox(input->features);
  return MeshOrRefuse(input->features, options);
}

}  // namespace

std::string FuzzPlanarInput(std::string_view bytes) {
  const std::vector<std::string_view> files = SplitFiles(bytes);
  const auto open_nodes = [&]() -> absl::StatusOr<io::TextReader> {
    if (files.size() < 2) return absl::NotFoundError("beside.node: no such file");
    return io::TextReader("beside.node", std::string(files[1]));
  };
  const std::string problem =
      Check(io::ParsePolyText(io::TextReader("fuzz.poly", std::string(files[0])), open_nodes));
  if (!problem.empty()) return problem;
  return Check(io::ParseNodeText(io::TextReader("fuzz.node", std::string(bytes))));
}

}  // namespace dynmesh::fuzz
