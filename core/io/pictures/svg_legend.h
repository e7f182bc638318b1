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

struct Scale {
  std::string title;
  std::vector<std::string> colours;
  struct Tick {
    double at;  // from 0, where the first colour begins, to 1
    std::string label;
  };
  std::vector<Tick> ticks;
};

// The colours side by side, with the ticks below.
void WriteScale(const Scale& scale, double top, double width, FileWriter& out);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_SVG_LEGEND_H_
