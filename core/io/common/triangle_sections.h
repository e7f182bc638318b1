// The sections of Triangle's and TetGen's files: vertices, segments or edges, faces, triangles or
// tetrahedra, holes, regions. Each is a header line with a count, then that many rows, numbered
// from 0 or 1 as the vertices are. Blank lines and `#` comments are allowed anywhere.
#ifndef DYNMESH_CORE_IO_COMMON_TRIANGLE_SECTIONS_H_
#define DYNMESH_CORE_IO_COMMON_TRIANGLE_SECTIONS_H_

#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "core/io/common/text_reader.h"

namespace dynmesh::io {

// Vertices in file order; in 2D the third coordinate is 0. Markers are read as 64 bits, -1 as 2^64
// - 1.
struct NodeSection {
  int dimension = 2;
  std::uint64_t base = 1;  // the first vertex's number: 0 or 1
  std::uint64_t attributes = 0;
  bool has_markers = false;
  std::vector<std::array<double, 3>> positions;
  std::vector<double> values;          // `attributes` a vertex
  std::vector<std::uint64_t> markers;  // all 0 if the file has none
  std::vector<int> lines;
};

// The number of nonzero markers.
inline std::uint64_t CountMarkers(const std::vector<std::uint64_t>& markers) {
  return markers.size() -
         static_cast<std::size_t>(std::count(markers.begin(), markers.end(), std::uint64_t{0}));
}

// K vertices a row, as indices from 0: segments and edges, or faces.
template <std::size_t K>
struct TupleSection {
  bool has_markers = false;
  std::vector<std::array<std::uint32_t, K>> ends;
  std::vector<std::uint64_t> markers;
  std::vector<int> lines;
};
using PairSection = TupleSection<2>;

// Simplices of dimension D.
template <int D>
struct SimplexSection {
  std::vector<std::array<std::uint32_t, D + 1>> corners;
  std::vector<double>
      attributes;  // the first of each row, NaN if it is no number; empty if there are none
  std::vector<int> lines;
};

// A position in a hole or in a region.
struct SeedRow {
  std::array<double, 3> position{};  // in 2D the third is 0
  std::vector<double> more;          // of a region: an attribute and a largest area, if present
  int line = 0;
  std::string name = {};  // of the region, in a mesh with named groups
  friend bool operator==(const SeedRow&, const SeedRow&) = default;
};

// All start at the next line of `reader` and read no further than the section's last row.
// `dimension` is 2 or 3; for vertices also kStatedDimension: the one in the header, 2 if it has
// none.
inline constexpr int kStatedDimension = 0;
absl::StatusOr<NodeSection> ReadNodeSection(TextReader& reader, int dimension);
// `what`: "segment", "edge" or "face"; K is 2 or 3.
template <std::size_t K>
absl::StatusOr<TupleSection<K>> ReadTupleSection(TextReader& reader, const char* what,
                                                 const NodeSection& nodes);
// D is 2 or 3.
template <int D>
absl::StatusOr<SimplexSection<D>> ReadSimplexSection(TextReader& reader, const NodeSection& nodes);
// Empty if the file has no such section.
absl::StatusOr<std::vector<SeedRow>> ReadHoleSection(TextReader& reader, int dimension);
absl::StatusOr<std::vector<SeedRow>> ReadRegionSection(TextReader& reader, int dimension);
// `count` rows of such a section: "number x y" or "number x y z", and up to `more` other values.
absl::StatusOr<std::vector<SeedRow>> ReadSeedRows(TextReader& reader, const char* what,
                                                  std::uint64_t count, int dimension,
                                                  std::size_t more);

// OK if only comments are left.
absl::Status ExpectEnd(TextReader& reader);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_COMMON_TRIANGLE_SECTIONS_H_
