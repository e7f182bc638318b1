// Transfer of means over median-dual cells. Such a cell of a vertex is made of a part of each
// simplex around it: where its barycentric coordinate is the greatest. So each of the D + 1 corners
// of a simplex has an equal part.
//
// First order, exact overlaps: a part of a new simplex gets the mean over the parts of old ones
// that it meets. Values stay within those of the old ones, and the mass of each group of simplices
// (exchange.h) is kept up to rounding. Sums are over differences to a reference, as in
// cell_transfer.h. One component at a time, on arrays in the order of the overlay.
#ifndef DYNMESH_CORE_TRANSFER_DUAL_TRANSFER_H_
#define DYNMESH_CORE_TRANSFER_DUAL_TRANSFER_H_

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/transfer/exchange.h"
#include "core/transfer/nodal_patch.h"
#include "core/transfer/overlay.h"

namespace dynmesh::transfer {

template <std::size_t D>
class DualTransfer {
 public:
  // Expected O(pieces); a piece has some ten overlaps of parts in 2D, some hundred in 3D.
  DualTransfer(const Overlay<D>& overlay, const Exchange<D>& exchange);

  // Of parts: D + 1 means a simplex, by corner.
  std::vector<double> OfCorners(std::span<const double> old) const;

  // Calls add(from, to, mass) for what old parts with these means leave in other regions.
  template <class Add>
  void ForEachChangeOfRegion(std::span<const double> old, const Add& add) const {
    for (const Overlap& overlap : overlaps_) {
      const auto& from = overlay_.from[overlap.from / (D + 1)];
      const auto& to = overlay_.to[overlap.to / (D + 1)];
      if (from.region != to.region)
        add(from.region, to.region, overlap.measure * old[overlap.from]);
    }
  }

 private:
  struct Overlap {
    std::uint32_t from, to;  // parts: D + 1 times the simplex, plus the corner
    double measure;
  };

  void FindOverlaps();
  void Balance(std::span<const double> from, std::span<double> to) const;

  const Overlay<D>& overlay_;
  const Exchange<D>& exchange_;
  std::vector<Overlap> overlaps_;  // that exchange mass, by `to`
};

// The same for values at vertices: means over whole cells. A cell that lies partly outside of the
// cavity keeps that part.
template <std::size_t D>
class DualNodes {
 public:
  DualNodes(const SlotMesh& mesh, const Overlay<D>& overlay);

  // As of NodalTransfer.
  std::span<const Slot> sources() const { return sources_; }
  bool is_added(std::size_t source) const { return is_added_[source]; }
  std::span<const Slot> results() const {
    return std::span<const Slot>(patch_.vertices).first(patch_.cavity_count);
  }

  // The means of old parts, from those of their vertices, in the order of sources().
  std::vector<double> AtCorners(std::span<const double> old) const;
  // The means of results(), from those of new parts.
  std::vector<double> Values(std::span<const double> old, std::span<const double> parts) const;

 private:
  NodalPatch<D> patch_;
  std::vector<Slot> sources_;
  std::vector<bool> is_added_;
  std::vector<std::uint32_t> old_corners_;  // as sources, D + 1 an old simplex
  std::size_t new_count_;                   // of new simplices: the patch's first cells
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_DUAL_TRANSFER_H_
