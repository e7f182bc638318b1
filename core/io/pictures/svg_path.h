// Paths of an SVG, in hundredths of a pixel: small files, and relative moves without accumulated
// error.
#ifndef DYNMESH_CORE_IO_PICTURES_SVG_PATH_H_
#define DYNMESH_CORE_IO_PICTURES_SVG_PATH_H_

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/io/common/file_writer.h"
#include "core/io/pictures/picture_frame.h"

namespace dynmesh::io {

struct Pixel {
  std::int64_t x, y;
};

inline Pixel PixelAt(const PictureFrame& frame, const PictureFrame::Position& position) {
  // Far outside a narrow crop precision is irrelevant, the range is not.
  constexpr double kFar = 1e15;
  return {std::llround(std::clamp(frame.XOf(position[0]) * 100, -kFar, kFar)),
          std::llround(std::clamp(frame.YOf(position[1]) * 100, -kFar, kFar))};
}

inline void WriteHundredths(std::int64_t value, FileWriter& out) {
  if (value < 0) out << '-';
  const std::uint64_t magnitude = static_cast<std::uint64_t>(value < 0 ? -value : value);
  out << magnitude / 100;
  const std::uint64_t rest = magnitude % 100;
  if (rest == 0) return;
  out << '.' << static_cast<char>('0' + rest / 10);
  if (rest % 10 != 0) out << static_cast<char>('0' + rest % 10);
}

inline void WritePixel(char command, Pixel p, FileWriter& out) {
  out << command;
  WriteHundredths(p.x, out);
  out << ' ';
  WriteHundredths(p.y, out);
}

// A line through the pixels, without closing it.
inline void WriteLinePath(std::span<const Pixel> pixels, FileWriter& out) {
  WritePixel('M', pixels[0], out);
  for (std::size_t k = 1; k < pixels.size(); ++k) {
    WritePixel('l', {pixels[k].x - pixels[k - 1].x, pixels[k].y - pixels[k - 1].y}, out);
  }
}

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_SVG_PATH_H_
