#include "core/io/plane/planar_input.h"

#include <utility>

#include "core/io/common/triangle_sections.h"

namespace dynmesh::io {
namespace {

void AddSegments(const PairSection& segments, const std::string& file, FileFeatures& input) {
  input.segment_file = file;
  input.segment_count = segments.ends.size();
  AddMarkers(segments.markers, input.point_count + 1, input.labels);
  for (std::size_t i = 0; i < segments.ends.size(); ++i) {
    input.features.push_back(Feature::Segment(input.point_count + i + 1,
                                              FeatureId{segments.ends[i][0]} + 1,
                                              FeatureId{segments.ends[i][1]} + 1));
    input.lines.push_back(segments.lines[i]);
  }
}

}  // namespace

absl::StatusOr<FileFeatures> ParseNodeText(TextReader nodes) { return ParsePoints(nodes, 2); }

absl::StatusOr<FileFeatures> ParsePolyText(TextReader poly, const OpenNodes& open_nodes) {
  FileFeatures input;
  const absl::StatusOr<NodeSection> nodes = ReadPointsOfPoly(poly, 2, open_nodes, input);
  if (!nodes.ok()) return nodes.status();
  const absl::StatusOr<PairSection> segments = ReadTupleSection<2>(poly, "segment", *nodes);
  if (!segments.ok()) return segments.status();
  AddSegments(*segments, poly.name(), input);
  if (auto status = ReadSeedSections(poly, 2, input); !status.ok()) return status;
  return input;
}

absl::StatusOr<FileFeatures> ReadNodeFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParseNodeText(*std::move(reader));
}

absl::StatusOr<FileFeatures> ReadPolyFile(const std::string& path) {
  absl::StatusOr<TextReader> reader = TextReader::Open(path);
  if (!reader.ok()) return reader.status();
  return ParsePolyText(*std::move(reader), OpenNodesBeside(path));
}

}  // namespace dynmesh::io
