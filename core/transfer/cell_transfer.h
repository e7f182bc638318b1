// Transfer of fields with values in simplices: means (P0), means made linear, and separate linear
// functions in each simplex (DG1). One component at a time, on arrays in the order of the overlay.
//
// Sums are over differences to a reference value, an old value of the group. So a constant is
// preserved exactly, whatever the rounding of measures, also a separate constant per region. Then
// the group's balance is computed from the measures themselves. What is missing is rounding, and is
// distributed over the group.
#ifndef DYNMESH_CORE_TRANSFER_CELL_TRANSFER_H_
#define DYNMESH_CORE_TRANSFER_CELL_TRANSFER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/exchange.h"
#include "core/transfer/overlay.h"
#include "core/transfer/stencil.h"

namespace dynmesh::transfer {

// For each new simplex, the old one to use if no piece counts: the one that contains its centroid.
// Such simplices are flat up to rounding.
template <std::size_t D>
std::vector<std::uint32_t> HomesOf(const Overlay<D>& overlay, const Exchange<D>& exchange);

// For each new simplex the old one with the largest overlap; the first of several.
template <std::size_t D>
std::vector<std::uint32_t> DonorsOf(const Overlay<D>& overlay, const Exchange<D>& exchange);

template <std::size_t D>
class CellTransfer {
 public:
  CellTransfer(const Overlay<D>& overlay, const Exchange<D>& exchange);

  // `old` has a mean for each old simplex; the result has one for each new one.
  std::vector<double> Means(std::span<const double> old, bool bounded) const;
  // `old` also has, at its end, the means of the stencil's kept simplices. Writes to `at_corners`
  // the old simplices' linear functions at their corners.
  std::vector<double> LinearMeans(const Stencil<D>& stencil, std::span<const double> old,
                                  bool bounded, std::vector<double>& at_corners) const;
  // D + 1 values per simplex.
  std::vector<double> Functions(std::span<const double> old, bool bounded) const;

 private:
  // The values `old` of the overlay's simplices minus the reference of their group, `width` values
  // each.
  std::vector<double> Relative(std::span<const double> old, std::size_t width,
                               std::vector<double>& references) const;
  double Offset(const std::vector<double>& references, std::size_t i, std::size_t j) const;
  void Balance(std::span<const double> old_means, std::span<const double> all_old, bool bounded,
               std::span<double> means) const;

  const Overlay<D>& overlay_;
  const Exchange<D>& exchange_;
  std::vector<std::uint32_t> homes_;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_CELL_TRANSFER_H_
