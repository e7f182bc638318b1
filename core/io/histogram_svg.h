// Histograms as a picture, one under the other.
#ifndef DYNMESH_CORE_IO_HISTOGRAM_SVG_H_
#define DYNMESH_CORE_IO_HISTOGRAM_SVG_H_

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
  std::string unit;                   // below the axis
  double hi = 1;                      // the axis runs from 0 to here
  double tick = 1;                    // a number every so far, at most 1000 of them
  std::vector<std::uint64_t> counts;  // of equal parts of the axis
  std::vector<Mark> marks;            // upright lines; those off the axis are left out
};

struct HistogramOptions {
  double width = 1000;     // pixels
  bool log_scale = false;  // bars by the logarithm of their count
};

// INVALID_ARGUMENT for bad options, UNAVAILABLE, naming the path, if it cannot be written. The
// same histograms and options make the same bytes.
absl::Status WriteHistogramSvg(const std::string& title, const std::vector<Histogram>& histograms,
                               const HistogramOptions& options, const std::string& path);

}  // namespace dynmesh::io

#endif  // DYNMESH_CORE_IO_HISTOGRAM_SVG_H_
