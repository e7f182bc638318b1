// Transfer of a field with values at vertices (P1): interpolation at new vertices, then the
// Galerkin projection of the error.
//
// The difference e of the old field and the interpolant is zero outside the cavity. r_i is the
// integral of e times the hat function of vertex i, over the pieces. Solves M d = r on the free
// vertices of a NodalPatch, to a few digits. In M, couplings to vertices that are not free are
// added to the diagonal: so the columns of M add up to the lumped masses. The residual is added
// lumped: then the integral of d is the sum of r up to rounding, at any accuracy of the solution.
// The eigenvalues of D^-1 M are in [1/2, 1 + d/2], whatever the shape of the simplices, so d
// decreases by a factor of about three from ring to ring.
#ifndef DYNMESH_CORE_TRANSFER_NODAL_TRANSFER_H_
#define DYNMESH_CORE_TRANSFER_NODAL_TRANSFER_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/exchange.h"
#include "core/transfer/nodal_patch.h"
#include "core/transfer/overlay.h"
#include "core/transfer/region_bounds.h"

namespace dynmesh::transfer {

template <std::size_t D>
class NodalTransfer {
 public:
  NodalTransfer(const SlotMesh& mesh, const Overlay<D>& overlay, const Exchange<D>& exchange,
                int rings);

  // The vertices that the transfer reads: those of the patch (added ones have none), then the
  // removed ones.
  std::span<const Slot> sources() const { return sources_; }
  bool is_added(std::size_t source) const { return is_added_[source]; }
  // The slots of the results.
  std::span<const Slot> results() const {
    return std::span<const Slot>(patch_.vertices).first(patch_.free_count);
  }

  // `old` is in the order of sources(); values of added vertices are overwritten. Adds to `flows`
  // what bounds moved between regions, by their ids. Regions with changed shapes are one, by the
  // least id.
  struct Flow {
    RegionId from, to;
    double amount;
  };
  std::vector<double> Values(std::span<double> old, bool bounded, std::vector<Flow>& flows) const;

  // The corners of old simplex i as sources.
  const std::array<std::uint32_t, D + 1>& corners(std::size_t i) const { return old_corners_[i]; }

 private:
  struct Birth {  // of an added vertex
    std::uint32_t vertex;
    std::uint32_t from;
    std::array<double, D + 1> lambda;
  };

  // Two corners of a cell are coupled by `unit`. A corner that is not free has index free_count.
  struct Coupling {
    std::array<std::uint32_t, D + 1> corners;
    double unit;
  };

  void FindParts();
  std::vector<double> Residual(std::span<const double> from) const;
  void Multiply(std::span<const double> x, std::span<double> y) const;
  std::vector<double> Project(std::vector<double> residual) const;
  void KeepRegions(std::span<const double> from, std::span<double> change) const;

  const Overlay<D>& overlay_;
  const Exchange<D>& exchange_;
  int rings_;
  NodalPatch<D> patch_;
  std::vector<Slot> sources_;
  std::vector<bool> is_added_;
  std::vector<std::array<std::uint32_t, D + 1>> old_corners_;
  std::vector<Birth> births_;
  std::vector<double> diagonal_;     // of free vertices
  std::vector<Coupling> couplings_;  // of cells with two free corners or more
  std::uint32_t part_count_ = 0;
  std::vector<std::uint32_t> parts_from_, parts_to_;  // of the overlay's simplices
  std::vector<PartShare> shares_;                     // empty if there is one part only
  std::vector<RegionId> part_regions_;                // the least of each part
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_NODAL_TRANSFER_H_
