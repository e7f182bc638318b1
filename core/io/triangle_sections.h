// The parts that Triangle's files are made of: vertices, segments or edges,
// triangles, holes, regions. Vertices, holes and regions are those of TetGen's as well, with
// three coordinates. Each part is a header line with a count, then that many
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

// Vertices in file order; in the plane the third coordinate is 0. Markers are read as 64 bits, -1
// as 2^64 - 1.
struct NodeSection {
  std::uint64_t base = 1;  // the first vertex's number: 0 or 1
  std::uint64_t attributes = 0;
  bool has_markers = false;
  std::vector<std::array<double, 3>> positions;
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

// A place in a hole or in a region.
struct SeedRow {
  std::array<double, 3> position{};  // in the plane the third is 0
  std::vector<double> more;  // of a region: an attribute and a largest area, if they are there
  int line = 0;
  friend bool operator==(const SeedRow&, const SeedRow&) = default;
};

// All start at the next line of `reader`; what follows their last row is not touched. The
// `dimension` is 2 or 3.
absl::StatusOr<NodeSection> ReadNodeSection(TextReader& reader, int dimension);
// `what`: "segment" or "edge".
absl::StatusOr<PairSection> ReadPairSection(TextReader& reader, const char* what,
                                            const NodeSection& nodes);
absl::StatusOr<TriangleSection> ReadTriangleSection(TextReader& reader, const NodeSection& nodes);
// None for a section that the file does not have.
absl::StatusOr<std::vector<SeedRow>> ReadHoleSection(TextReader& reader, int dimension);
absl::StatusOr<std::vector<SeedRow>> ReadRegionSection(TextReader& reader, int dimension);
// `count` rows of such a section: "number x y" or "number x y z", and up to `more` other values.
absl::StatusOr<std::vector<SeedRow>> ReadSeedRows(TextReader& reader, const char* what,
                                                  std::uint64_t count, int dimension,
                                                  std::size_t more);

// OK if nothing but comments is left.
absl::Status ExpectEnd(TextReader& reader);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_TRIANGLE_SECTIONS_H_
