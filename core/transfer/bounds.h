// Puts values back into a range and what they lose or gain into the others, by weight.
// Pure functions.
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

// Clamps `values` to `range`; the sum of weight times value stays, as far as there is room. With
// slack for it in the range, which holds if the sum is that of values in it, it stays but for
// rounding. `extra` is added to the sum beforehand. Weights are not negative.
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
