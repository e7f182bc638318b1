// Target lengths from files, as sizing features: a raster (ESRI ASCII `.asc`, numpy's `.npy`), a
// view of Gmsh (`.pos`), TetGen's `.mtr`.
//
// A cell of a raster has its value; cells of nearly the same value are joined to boxes. In an
// element of a view or of a background mesh the length is linear; the element is cut until its
// pieces are no longer than twice the least length, and each becomes a disc (3D: ball) with that
// length. So no place gets a larger target than the file says there. Values that are not above 0
// say nothing.
//
// INVALID_ARGUMENT as `file:line: what is wrong` (of a `.npy` without a line), also if there would
// be more than kMostSizes features; NOT_FOUND and the like if a file cannot be read. Thread-safe.
#ifndef DYNMESH_CORE_IO_SIZES_SIZE_FIELDS_H_
#define DYNMESH_CORE_IO_SIZES_SIZE_FIELDS_H_

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "core/io/common/text_reader.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::io {

inline constexpr std::size_t kMostSizes = 2'000'000;

// A box of cells, x fastest. 2D: one layer.
struct SizeRaster {
  std::string file;
  int dimension = 2;
  std::array<std::size_t, 3> counts = {0, 0, 1};
  Box box;
  std::vector<double> values;  // not above 0 or NaN: none
};
absl::StatusOr<SizeRaster> ParseEsriAscii(TextReader reader);
// Rows of an array of two (three) dimensions go along y (z), from the least on; `box` is what the
// array covers. Reals or whole numbers in C order. A first dimension of one row that is one too
// many is left out, as (1, y, x) in 2D.
absl::StatusOr<SizeRaster> ParseNpy(const std::string& name, const std::string& bytes,
                                    const Box& box, int dimension);
// Features with ids from `first` on; only of boxes that meet `within`.
absl::StatusOr<std::vector<Feature>> SizesOf(const SizeRaster& raster, const Box& within,
                                             FeatureId first, int dimension);

// Points and simplices with a length at each corner.
struct SizeElement {
  std::vector<std::array<double, 3>> corners;  // 1 to 4
  std::vector<double> values;
};
struct SizeView {
  std::string file;
  std::vector<SizeElement> elements;
};
// Scalar points, lines, triangles and tetrahedra of all views, the first step.
absl::StatusOr<SizeView> ParsePos(const std::string& name, const std::string& text);
absl::StatusOr<std::vector<Feature>> SizesOf(const SizeView& view, const Box& within,
                                             FeatureId first, int dimension);

// The lengths of an `.mtr`: one for each row.
absl::StatusOr<std::vector<double>> ParseMtr(TextReader reader);

// What a file of target lengths is for.
struct SizedInput {
  const std::vector<Feature>& features;  // an `.mtr` without a mesh of its own is about its points
  const MeshOptions& options;            // dimension and box
  FeatureId first = 1;                   // id of the first size
};
// Files by their format (formats/formats.h chooses by the extension). An `.mtr` has a mesh of its
// own if there is an .ele of the same name.
absl::StatusOr<std::vector<Feature>> ReadAscFile(const std::string& path, const SizedInput& input);
absl::StatusOr<std::vector<Feature>> ReadNpyFile(const std::string& path, const SizedInput& input);
absl::StatusOr<std::vector<Feature>> ReadPosFile(const std::string& path, const SizedInput& input);
absl::StatusOr<std::vector<Feature>> ReadMtrFile(const std::string& path, const SizedInput& input);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SIZES_SIZE_FIELDS_H_
