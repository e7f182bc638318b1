// What the colours of a picture mean: a strip below it, as wide as the picture is.
#ifndef DYNMESH_CORE_IO_SVG_LEGEND_H_
#define DYNMESH_CORE_IO_SVG_LEGEND_H_

#include <string>
#include <vector>

#include "core/io/file_writer.h"

namespace dynmesh::io {

struct LegendEntry {
  std::string colour;  // "#rrggbb"
  std::string label;   // without characters that XML gives a meaning to
};

// How high the strip of a picture `width` pixels wide is, in pixels.
double LegendHeight(double width);

// A box and its label for each of `entries`, side by side; `top` is where the strip begins, in
// pixels. White behind them: what sticks out of the picture does not show.
void WriteLegend(const std::vector<LegendEntry>& entries, double top, double width,
                 FileWriter& out);

// `colours` side by side as one scale from 0 to `end`, with a number at every multiple of `step`.
void WriteScale(const std::vector<std::string>& colours, const std::string& title, double end,
                double step, double top, double width, FileWriter& out);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_SVG_LEGEND_H_
