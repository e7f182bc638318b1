#include "core/io/planar_input.h"

#include <filesystem>
#include <utility>

#include "core/data/text.h"
#include "core/io/text_reader.h"
#include "core/io/triangle_sections.h"

namespace dynmesh::io {

using data::Concat;
namespace {

void AddPoints(const NodeSection& nodes, const std::string& file, PlanarInput& input) {
  input.point_file = file;
  input.point_count = nodes.positions.size();
  input.attributes = nodes.attributes;
  for (std::size_t i = 0; i < nodes.positions.size(); ++i) {
    input.features.push_back(Feature::Point(i + 1, nodes.positions[i][0], nodes.positions[i][1]));
    input.lines.push_back(nodes.lines[i]);
  }
}

void AddSegments(const PairSection& segments, const std::string& file, PlanarInput& input) {
  input.segment_file = file;
  input.segment_count = segments.ends.size();
  for (std::size_t i = 0; i < segments.ends.size(); ++i) {
    input.features.push_back(Feature::Segment(input.point_count + i + 1,
                                              FeatureId{segments.ends[i][0]} + 1,
                                              FeatureId{segments.ends[i][1]} + 1));
    input.lines.push_back(segments.lines[i]);
  }
}

// All of a `.node` file.
absl::StatusOr<NodeSection> ParseNodes(TextReader& reader) {
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(reader);
  if (!nodes.ok()) return nodes.status();
  if (auto status = ExpectEnd(reader); !status.ok()) return status;
  return nodes;
}

std::string NodeFileBeside(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".node").string();
}

}  // namespace

std::string PlanarInput::Where(FeatureId id) const {
  if (id == kNoFeature || id > lines.size()) return "";
  return Concat(id <= point_count ? point_file : segment_file, ":", lines[id - 1]);
}

absl::StatusOr<PlanarInput> ParseNodeText(TextReader nodes) {
  const absl::StatusOr<NodeSection> section = ParseNodes(nodes);
  if (!section.ok()) return section.status();
  PlanarInput input;
  AddPoints(*section, nodes.name(), input);
  return input;
}

absl::StatusOr<PlanarInput> ParsePolyText(TextReader poly, const OpenNodes& open_nodes) {
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(poly);
  if (!nodes.ok()) return nodes.status();
  PlanarInput input;
  if (nodes->positions.empty()) {
    absl::StatusOr<TextReader> external = open_nodes();
    if (absl::IsNotFound(external.status())) {
      return poly.Error(Concat("the file has no vertices, and there is no ",
                               NodeFileBeside(poly.name()), " to have them"));
    }
    if (!external.ok()) return external.status();
    nodes = ParseNodes(*external);
    if (!nodes.ok()) return nodes.status();
    AddPoints(*nodes, external->name(), input);
  } else {
    AddPoints(*nodes, poly.name(), input);
  }
  const absl::StatusOr<PairSection> segments = ReadPairSection(poly, "segment", *nodes);
  if (!segments.ok()) return segments.status();
  AddSegments(*segments, poly.name(), input);
  absl::StatusOr<std::vector<SeedRow>> holes = ReadHoleSection(poly);
  if (!holes.ok()) return holes.status();
  input.holes = *std::move(holes);
  absl::StatusOr<std::vector<SeedRow>> regions = ReadRegionSection(poly);
  if (!regions.ok()) return regions.status();
  input.regions = *std::move(regions);
  if (auto status = ExpectEnd(poly); !status.ok()) return status;
  return input;
}

absl::StatusOr<PlanarInput> ReadNodeFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseNodeText(*std::move(reader));
}

absl::StatusOr<PlanarInput> ReadPolyFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParsePolyText(*std::move(reader),
                       [&path] { return TextReader::Open(NodeFileBeside(path)); });
}

}  // namespace dynmesh::io
