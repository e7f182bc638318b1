// The colours of simplices in a picture, and the legend that says what they mean. Pure functions.
#ifndef DYNMESH_CORE_IO_PICTURES_SIMPLEX_COLOURS_H_
#define DYNMESH_CORE_IO_PICTURES_SIMPLEX_COLOURS_H_

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/io/meshes/indexed_mesh.h"
#include "core/io/pictures/svg_legend.h"
#include "core/io/pictures/svg_writer.h"

namespace dynmesh::io {

inline constexpr std::string_view kPlainFill = "#eaf1f6";
inline constexpr std::string_view kHighlightFill = "#f6a821";

struct SimplexColours {
  std::vector<std::string> of;       // "#rrggbb" of each simplex asked for; empty for lines only
  Scale scale;                       // of the legend, if the colours are values
  std::vector<LegendEntry> entries;  // of the legend, if they are kinds
};

// The colours of these `simplices` (indices) by options.fill. O(size).
SimplexColours ColoursOf(const IndexedMesh& mesh, const SvgOptions& options,
                         std::span<const std::uint32_t> simplices);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_SIMPLEX_COLOURS_H_
