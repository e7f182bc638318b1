// Clamps values to a range and distributes the excess to the others, by weight. Pure functions.
#ifndef DYNMESH_CORE_TRANSFER_BOUNDS_H_
#define DYNMESH_CORE_TRANSFER_BOUNDS_H_

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>

#include "core/transfer/compensated_sum.h"

namespace dynmesh::transfer {

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void Hold(double value) { low = std::min(low, value), high = std::max(high, value); }
};

// Clamps `values` to `range` and keeps the sum of weight times value, plus `extra`, as far as the
// range has room. It has room, up to rounding, if that sum is one of values in the range. REQUIRES:
// weights >= 0.
inline void Clamp(const Range& range, std::span<const double> weights, double extra,
                  std::span<double> values) {
  Sum owed;
  owed.Add(extra);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double clamped = std::clamp(values[i], range.low, range.high);
    owed.Add(weights[i] * (values[i] - clamped));
    values[i] = clamped;
  }
  const double amount = owed.value();
  if (amount == 0) return;
  const double end = amount > 0 ? range.high : range.low;
  Sum slack;
  for (std::size_t i = 0; i < values.size(); ++i) slack.Add(weights[i] * (end - values[i]));
  if (slack.value() == 0) return;
  const double part = std::clamp(amount / slack.value(), 0.0, 1.0);
  for (double& value : values) {
    value = std::clamp(value + part * (end - value), range.low, range.high);
  }
}

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_BOUNDS_H_
