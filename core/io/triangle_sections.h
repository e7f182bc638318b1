// The parts that Triangle's files are made of: vertices, segments or edges,
// triangles, holes, regions. Each part is a header line with a count, then that many
// rows, numbered from 0 or 1 as the vertices are.
// Blank lines and `#` comments may stand anywhere.
#ifndef DYNMESH_CORE_IO_TRIANGLE_SECTIONS_H_
#define DYNMESH_CORE_IO_TRIANGLE_SECTIONS_H_

#include <array>
#include <cstdint>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/text_reader.h"

namespace dynmesh::io {

// Vertices in file order. Markers are read as 64 bits, -1 as 2^64 - 1.
struct NodeSection {
  std::uint64_t base = 1;  // the first vertex's number: 0 or 1
  std::uint64_t attributes = 0;
  bool has_markers = false;
  std::vector<std::array<double, 2>> positions;
  std::vector<std::uint64_t> markers;  // all 0 if there are none
  std::vector<int> lines;
};

// Pairs of vertices (segments, edges), as indices into the vertices from 0.
struct PairSection {
  bool has_markers = false;
  std::vector<std::array<std::uint32_t, 2>> ends;
  std::vector<std::uint64_t> markers;
  std::vector<int> lines;
};

struct TriangleSection {
  std::vector<std::array<std::uint32_t, 3>> corners;
  std::vector<double> attributes;  // the first one of each row, NaN if it is no number; or none
  std::vector<int> lines;
};

// All start at the next line of `reader`; what follows their last row is not touched.
absl::StatusOr<NodeSection> ReadNodeSection(TextReader& reader);
// `what`: "segment" or "edge".
absl::StatusOr<PairSection> ReadPairSection(TextReader& reader, const char* what,
                                            const NodeSection& nodes);
absl::StatusOr<TriangleSection> ReadTriangleSection(TextReader& reader, const NodeSection& nodes);
// Checks the form of hole and region rows and returns their number; a section that
// the file does not have counts 0.
absl::StatusOr<std::uint64_t> ReadHoleSection(TextReader& reader);
absl::StatusOr<std::uint64_t> ReadRegionSection(TextReader& reader);

// OK if nothing but comments is left.
absl::Status ExpectEnd(TextReader& reader);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_TRIANGLE_SECTIONS_H_
