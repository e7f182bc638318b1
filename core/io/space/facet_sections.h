// Facets of TetGen's `.poly` and `.smesh` files: one polygon in a `.smesh`; several polygons and
// positions of holes in a `.poly`. A polygon's corners may continue on further lines.
#ifndef DYNMESH_CORE_IO_SPACE_FACET_SECTIONS_H_
#define DYNMESH_CORE_IO_SPACE_FACET_SECTIONS_H_

#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/common/text_reader.h"
#include "core/io/common/triangle_sections.h"

namespace dynmesh::io {

struct FacetPolygon {
  std::vector<std::uint32_t> corners;  // vertices from 0; at least one
  int line = 0;
};

struct Facet {
  std::vector<FacetPolygon> polygons;
  std::vector<SeedRow> holes;
  std::uint64_t marker = 0;
  int line = 0;
};

// Both start at the next line of `reader`, with the header. O(file).
absl::StatusOr<std::vector<Facet>> ReadPolyFacets(TextReader& reader, const NodeSection& nodes);
absl::StatusOr<std::vector<Facet>> ReadSmeshFacets(TextReader& reader, const NodeSection& nodes);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SPACE_FACET_SECTIONS_H_
