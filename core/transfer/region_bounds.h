// Values at vertices within bounds that keep the integral over each of several regions.
//
// A vertex on a wall has one value and a share in each region beside the wall, so regions cannot be
// bounded one by one. Finds the least change, in the lumped norm, that restores all integrals
// within the bounds. Where no values in the bounds do so, mass flows between regions beside each
// other: as little as possible, in the sum of squares. The sum over all regions is kept in any case
// if the bounds have room for it.
//
// A pure function. Time: some ten passes over the shares; some hundred if mass flows.
#ifndef DYNMESH_CORE_TRANSFER_REGION_BOUNDS_H_
#define DYNMESH_CORE_TRANSFER_REGION_BOUNDS_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/bounds.h"

namespace dynmesh::transfer {

// The share of a vertex's hat function in a part of the mesh: a region, or several.
struct PartShare {
  std::uint32_t vertex, part;
  double amount;  // >= 0
};

// What bounds moved from one part to another.
struct PartFlow {
  std::uint32_t from, to;
  double amount;
};

// Brings `values` into `range` and keeps, of each part, the sum of shares times values. `shares`
// are sorted by vertex. `weights` are their sums by vertex; vertices without weight are clamped
// only. Returns the flows, by `from` and `to`; none if all sums are kept up to rounding.
std::vector<PartFlow> ClampInParts(const Range& range, std::span<const PartShare> shares,
                                   std::size_t part_count, std::span<const double> weights,
                                   std::span<double> values);

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_REGION_BOUNDS_H_
