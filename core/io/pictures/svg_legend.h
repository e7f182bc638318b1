// The legend of a picture: a strip below it, as wide as the picture.
#ifndef DYNMESH_CORE_IO_PICTURES_SVG_LEGEND_H_
#define DYNMESH_CORE_IO_PICTURES_SVG_LEGEND_H_

#include <string>
#include <vector>

#include "core/io/common/file_writer.h"

namespace dynmesh::io {

struct LegendEntry {
  std::string colour;  // "#rrggbb"
  std::string label;   // without XML's special characters
};

// The height of the strip for a picture `width` pixels wide, in pixels.
double LegendHeight(double width);

// A box and its label for each of `entries`, side by side; `top` is the top of the strip, in
// pixels. On white, which hides what extends beyond the picture.
void WriteLegend(const std::vector<LegendEntry>& entries, double top, double width,
                 FileWriter& out);

// `colours` side by side as one scale from 0 to `end`, with a number at every multiple of `step`.
void WriteScale(const std::vector<std::string>& colours, const std::string& title, double end,
                double step, double top, double width, FileWriter& out);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_SVG_LEGEND_H_
