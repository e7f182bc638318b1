// The visible part of a picture, and its scale. Pure functions.
#ifndef DYNMESH_CORE_IO_PICTURES_PICTURE_FRAME_H_
#define DYNMESH_CORE_IO_PICTURES_PICTURE_FRAME_H_

#include <algorithm>
#include <array>
#include <cstddef>

namespace dynmesh::io {

struct PictureFrame {
  using Position = std::array<double, 2>;

  // Shows the box from lo to hi with a margin; each side is at least a tenth of the other. A box
  // without extent shows a little around it. `width` in pixels.
  PictureFrame(const Position& from, const Position& to, double width) {
    double extent = std::max(to[0] - from[0], to[1] - from[1]);
    if (!(extent > 0)) extent = 1;
    for (std::size_t i = 0; i < 2; ++i) {
      const double grow = 0.02 * extent + std::max(0.0, 0.1 * extent - (to[i] - from[i])) / 2;
      lo[i] = from[i] - grow;
      hi[i] = to[i] + grow;
    }
    scale = width / (hi[0] - lo[0]);
    height = (hi[1] - lo[1]) * scale;
  }

  bool Shows(const Position& from, const Position& to) const {
    return from[0] <= hi[0] && to[0] >= lo[0] && from[1] <= hi[1] && to[1] >= lo[1];
  }
  // In pixels, from the upper left corner.
  double XOf(double x) const { return (x - lo[0]) * scale; }
  double YOf(double y) const { return (hi[1] - y) * scale; }

  Position lo, hi;
  double scale;   // pixels a unit
  double height;  // pixels
};

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_PICTURE_FRAME_H_
