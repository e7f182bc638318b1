// Histograms as a picture, one below the other.
#ifndef DYNMESH_CORE_IO_PICTURES_HISTOGRAM_SVG_H_
#define DYNMESH_CORE_IO_PICTURES_HISTOGRAM_SVG_H_

#include <cstdint>
#include <string>
#include <vector>

#include "absl/status/status.h"

namespace dynmesh::io {

struct Histogram {
  struct Mark {
    double value = 0;
    std::string label;
  };
  std::string title;
  std::string unit;                   // of the axis, printed below it
  double hi = 1;                      // the end of the axis; it starts at 0
  double tick = 1;                    // the distance of numbers at the axis, at most 1000 of them
  std::vector<std::uint64_t> counts;  // of equal intervals of the axis
  std::vector<Mark> marks;            // vertical lines; those outside the axis are omitted
};

struct HistogramOptions {
  double width = 1000;     // pixels
  bool log_scale = false;  // logarithmic heights of bars
};

// INVALID_ARGUMENT for bad options; UNAVAILABLE, naming the path, if it cannot be written. The same
// histograms and options give the same bytes.
absl::Status WriteHistogramSvg(const std::string& title, const std::vector<Histogram>& histograms,
                               const HistogramOptions& options, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_PICTURES_HISTOGRAM_SVG_H_
