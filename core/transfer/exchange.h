// Which pieces of an overlay exchange mass, and within which groups of simplices mass stays.
//
// A region that the edit leaves in its shape is a group of its own: what its old simplices share
// with new ones of other regions is rounding, and is left out. All other regions are one group
// together. Pure functions of an overlay.
#ifndef DYNMESH_CORE_TRANSFER_EXCHANGE_H_
#define DYNMESH_CORE_TRANSFER_EXCHANGE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/transfer/overlay.h"

namespace dynmesh::transfer {

template <std::size_t D>
class Exchange {
 public:
  explicit Exchange(const Overlay<D>& overlay);

  std::size_t group_count() const { return group_count_; }
  std::uint32_t group_from(std::size_t i) const { return groups_from_[i]; }
  std::uint32_t group_to(std::size_t j) const { return groups_to_[j]; }
  bool Counts(const Piece<D>& piece) const {
    return groups_from_[piece.from] == groups_to_[piece.to];
  }
  // The own matrix of a new simplex over the pieces that count, and their measure.
  const typename Overlay<D>::Mass& own(std::size_t j) const {
    return groups_to_[j] == 0 ? overlay_.own[j] : overlay_.own_of_region[j];
  }
  double MeasureOf(std::size_t j) const;
  // Those of pieces that count and lie in another region than before.
  bool ChangesRegion(const Piece<D>& piece) const {
    return overlay_.from[piece.from].region != overlay_.to[piece.to].region && Counts(piece);
  }

 private:
  const Overlay<D>& overlay_;
  std::size_t group_count_ = 1;
  std::vector<std::uint32_t> groups_from_, groups_to_;  // 0: regions whose shape changed
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_EXCHANGE_H_
