// Percentiles of measured times.
#ifndef DYNMESH_CLIENT_CLI_PERCENTILE_H_
#define DYNMESH_CLIENT_CLI_PERCENTILE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace dynmesh::cli {

// The least sample with at least `part` (0 to 1) of all samples <= it; NaN if there is none. O(n).
inline double Percentile(std::vector<double> samples, double part) {
  if (samples.empty()) return std::nan("");
  const auto rank = static_cast<std::size_t>(
      std::max(1.0, std::ceil(part * static_cast<double>(samples.size()))));
  const auto at = samples.begin() + static_cast<std::ptrdiff_t>(rank - 1);
  std::nth_element(samples.begin(), at, samples.end());
  return *at;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_PERCENTILE_H_
