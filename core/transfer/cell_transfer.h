// Transfer of fields with values in simplices: means (P0), means made linear, and linear functions
// of their own in each (DG1). One component at a time, on arrays in the order of the overlay.
//
// Sums are over differences to a reference value, an old one of the group, so that a constant comes
// out as it was whatever rounding makes of measures, and so does one for each region. Then the
// group's balance is drawn up from the measures themselves, and what is missing, which is rounding,
// is spread over the group.
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

// Of each new simplex, the old one that takes its place where no piece counts: the one that holds
// its centroid. Such simplices are as flat as rounding.
template <std::size_t D>
std::vector<std::uint32_t> HomesOf(const Overlay<D>& overlay, const Exchange<D>& exchange);

// Of each new simplex the old one with which it shares most; the first of several.
template <std::size_t D>
std::vector<std::uint32_t> DonorsOf(const Overlay<D>& overlay, const Exchange<D>& exchange);

template <std::size_t D>
class CellTransfer {
 public:
  CellTransfer(const Overlay<D>& overlay, const Exchange<D>& exchange);

  // `old` has a mean for each old simplex; the result for each new one.
  std::vector<double> Means(std::span<const double> old, bool bounded) const;
  // `old` has behind those the means of the stencil's kept simplices. `at_corners` gets the old
  // ones' linear functions at their corners.
  std::vector<double> LinearMeans(const Stencil<D>& stencil, std::span<const double> old,
                                  bool bounded, std::vector<double>& at_corners) const;
  // D + 1 values a simplex.
  std::vector<double> Functions(std::span<const double> old, bool bounded) const;

 private:
  // `old` of the overlay's simplices less the reference of its group, `width` values each.
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
