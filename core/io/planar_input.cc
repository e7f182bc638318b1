#include "core/io/planar_input.h"

#include <filesystem>

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

absl::StatusOr<NodeSection> ReadNodesOf(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(*reader);
  if (!nodes.ok()) return nodes.status();
  if (auto status = ExpectEnd(*reader); !status.ok()) return status;
  return nodes;
}

}  // namespace

std::string PlanarInput::Where(FeatureId id) const {
  if (id == kNoFeature || id > lines.size()) return "";
  return Concat(id <= point_count ? point_file : segment_file, ":", lines[id - 1]);
}

absl::StatusOr<PlanarInput> ReadNodeFile(const std::string& path) {
  const absl::StatusOr<NodeSection> nodes = ReadNodesOf(path);
  if (!nodes.ok()) return nodes.status();
  PlanarInput input;
  AddPoints(*nodes, path, input);
  return input;
}

absl::StatusOr<PlanarInput> ReadPolyFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  absl::StatusOr<NodeSection> nodes = ReadNodeSection(*reader);
  if (!nodes.ok()) return nodes.status();
  PlanarInput input;
  if (nodes->positions.empty()) {
    const std::string node_path = std::filesystem::path(path).replace_extension(".node").string();
    absl::StatusOr<NodeSection> external = ReadNodesOf(node_path);
    if (!external.ok()) {
      if (!absl::IsNotFound(external.status())) return external.status();
      return TextReader::ErrorAt(
          path, reader->line(),
          Concat("the file has no vertices, and there is no ", node_path, " to have them"));
    }
    nodes = *std::move(external);
    AddPoints(*nodes, node_path, input);
  } else {
    AddPoints(*nodes, path, input);
  }
  const absl::StatusOr<PairSection> segments = ReadPairSection(*reader, "segment", *nodes);
  if (!segments.ok()) return segments.status();
  AddSegments(*segments, path, input);
  const absl::StatusOr<std::uint64_t> holes = ReadHoleSection(*reader);
  if (!holes.ok()) return holes.status();
  input.holes = *holes;
  const absl::StatusOr<std::uint64_t> regions = ReadRegionSection(*reader);
  if (!regions.ok()) return regions.status();
  input.regions = *regions;
  if (auto status = ExpectEnd(*reader); !status.ok()) return status;
  return input;
}

}  // namespace dynmesh::io
