#include <bit>
#include <cmath>

#include "dynmesh/quadtree.h"

namespace dynmesh {

// In units of the root's side a centre is an odd multiple of 2^-(level + 1), along every axis.
std::optional<QuadtreeCell> QuadtreeCellAt(const MeshOptions& options, const double* centre) {
  constexpr int kBits = 53;
  const Box root = DomainBox(options);
  QuadtreeCell cell;
  const double side = root.hi[0] - root.lo[0];
  for (int k = 0; k < options.dimension; ++k) {
    const double part = std::ldexp((centre[k] - root.lo[k]) / side, kBits);
    if (!(part > 0 && part < std::ldexp(1.0, kBits)) || part != std::floor(part)) {
      return std::nullopt;
    }
    const auto number = static_cast<std::uint64_t>(part);
    const int zeros = std::countr_zero(number);
    const int level = kBits - 1 - zeros;
    if (k > 0 && level != cell.level) return std::nullopt;
    cell.level = level;
    cell.at[static_cast<std::size_t>(k)] = number >> (zeros + 1);
  }
  cell.side = std::ldexp(side, -cell.level);
  for (std::size_t k = 0; k < static_cast<std::size_t>(options.dimension); ++k) {
    cell.box.lo[k] = root.lo[k] + static_cast<double>(cell.at[k]) * cell.side;
    cell.box.hi[k] = root.lo[k] + static_cast<double>(cell.at[k] + 1) * cell.side;
  }
  return cell;
}

FeatureSizeBounds FeatureSizeIn(const QuadtreeCell& leaf, int dimension) {
  return {leaf.side / 4, 4.5 * std::sqrt(dimension) * leaf.side};
}

}  // namespace dynmesh
