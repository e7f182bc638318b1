#include "core/io/common/node_input.h"

#include <filesystem>
#include <utility>

#include "core/base/text.h"

namespace dynmesh::io {
namespace {

std::string NodeFileBeside(const std::string& path) {
  return std::filesystem::path(path).replace_extension(".node").string();
}

absl::StatusOr<NodeSection> ParseNodes(TextReader& reader, int dimension) {
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(reader, dimension);
  if (!nodes.ok()) return nodes.status();
  if (auto status = ExpectEnd(reader); !status.ok()) return status;
  return nodes;
}

void AddPoints(const NodeSection& nodes, const std::string& file, FileFeatures& input) {
  input.point_file = file;
  input.point_count = nodes.positions.size();
  input.labels.attributes = nodes.attributes;
  input.labels.values = nodes.values;
  AddMarkers(nodes.markers, 1, input.labels);
  input.features.reserve(nodes.positions.size());
  input.lines.reserve(nodes.positions.size());
  for (std::size_t i = 0; i < nodes.positions.size(); ++i) {
    const auto& [x, y, z] = nodes.positions[i];
    input.features.push_back(Feature::Point(i + 1, x, y, z));
    input.lines.push_back(nodes.lines[i]);
  }
}

}  // namespace

void AddMarkers(std::span<const std::uint64_t> markers, FeatureId first, FeatureLabels& labels) {
  for (std::size_t i = 0; i < markers.size(); ++i) {
    if (markers[i] != 0) labels.markers[first + i] = static_cast<std::int64_t>(markers[i]);
  }
}

absl::StatusOr<FileFeatures> ParsePoints(TextReader& nodes, int dimension) {
  const absl::StatusOr<NodeSection> section = ParseNodes(nodes, dimension);
  if (!section.ok()) return section.status();
  FileFeatures input;
  AddPoints(*section, nodes.name(), input);
  return input;
}

OpenNodes OpenNodesBeside(const std::string& path) {
  return [path] { return TextReader::Open(NodeFileBeside(path)); };
}

absl::StatusOr<NodeSection> ReadPointsOfPoly(TextReader& poly, int dimension,
                                             const OpenNodes& open_nodes, FileFeatures& input) {
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(poly, dimension);
  if (!nodes.ok()) return nodes.status();
  if (!nodes->positions.empty()) {
    AddPoints(*nodes, poly.name(), input);
    return nodes;
  }
  absl::StatusOr<TextReader> external = open_nodes();
  if (absl::IsNotFound(external.status())) {
    return poly.Error(text::Concat("the file has no vertices, and there is no ",
                                   NodeFileBeside(poly.name()), " to have them"));
  }
  if (!external.ok()) return external.status();
  nodes = ParseNodes(*external, dimension);
  if (nodes.ok()) AddPoints(*nodes, external->name(), input);
  return nodes;
}

absl::Status ReadSeedSections(TextReader& poly, int dimension, FileFeatures& input) {
  absl::StatusOr<std::vector<SeedRow>> holes = ReadHoleSection(poly, dimension);
  if (!holes.ok()) return holes.status();
  input.holes = *std::move(holes);
  absl::StatusOr<std::vector<SeedRow>> regions = ReadRegionSection(poly, dimension);
  if (!regions.ok()) return regions.status();
  input.regions = *std::move(regions);
  return ExpectEnd(poly);
}

}  // namespace dynmesh::io
