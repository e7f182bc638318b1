// Plane input as features, and Triangle's `.node` and `.poly` files: points of the file become
// 1..n and its segments n+1..n+m, in file order.
#ifndef DYNMESH_CORE_IO_PLANAR_INPUT_H_
#define DYNMESH_CORE_IO_PLANAR_INPUT_H_

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/text_reader.h"
#include "core/io/triangle_sections.h"
#include "dynmesh/feature.h"

namespace dynmesh::io {

// What a map calls a polygon: empty where it says nothing.
struct PolygonName {
  FeatureId id = kNoFeature;
  std::string key;   // its "id"
  std::string name;  // the "name" of its properties
};

struct PlanarInput {
  std::vector<Feature> features;  // points, then segments, then polygons
  std::size_t point_count = 0;
  std::size_t segment_count = 0;
  std::vector<PolygonName> polygons;  // of a map, one for each polygon
  // Of a .poly: places whose faces are holes or regions. Which face that is, is not for here.
  std::vector<SeedRow> holes;
  std::vector<SeedRow> regions;
  // What the file has and the mesh will not show.
  std::uint64_t attributes = 0;  // a vertex
  std::uint64_t heights = 0;     // positions with more than x and y
  // Edges, those of polygons included, that span more than half of the way round in a map that
  // seems to be in degrees: they were meant to go the other way round.
  std::uint64_t wraps = 0;

  // Places where rings of a topology's polygons were closed with an edge.
  std::uint64_t gaps = 0;

  // Where a feature stands: "file:line". Empty for an id that it does not have.
  std::string Where(FeatureId id) const;

  std::string point_file;    // not `file` if a .poly names an external .node
  std::string segment_file;  // empty for a .node
  std::vector<int> lines;    // of features[i]
};

// INVALID_ARGUMENT as `file:line: what is wrong`, UNIMPLEMENTED for 3 dimensions,
// NOT_FOUND and the like if a file cannot be read. Geometry is not judged here.
absl::StatusOr<PlanarInput> ReadNodeFile(const std::string& path);
// With no vertices of its own the file takes those of the `.node` beside it.
absl::StatusOr<PlanarInput> ReadPolyFile(const std::string& path);

// The same of text that is there already. `open_nodes` is called for the vertices of a
// .poly that has none of its own; NOT_FOUND from it becomes an error of the .poly.
absl::StatusOr<PlanarInput> ParseNodeText(TextReader nodes);
using OpenNodes = std::function<absl::StatusOr<TextReader>()>;
absl::StatusOr<PlanarInput> ParsePolyText(TextReader poly, const OpenNodes& open_nodes);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PLANAR_INPUT_H_
