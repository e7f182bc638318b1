// The pieces of an overlay that exchange mass, and the groups of simplices within which mass stays.
//
// A region that keeps its shape is a separate group: its old simplices' overlap with new ones of
// other regions is rounding, and is omitted. All other regions form one group. Pure functions of an
// overlay.
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
  // The own matrix of a new simplex over the pieces that count.
  const typename Overlay<D>::Mass& own(std::size_t j) const {
    return groups_to_[j] == 0 ? overlay_.own[j] : overlay_.own_of_region[j];
  }
  double MeasureOf(std::size_t j) const;
  // True for pieces that count and lie in another region than before.
  bool ChangesRegion(const Piece<D>& piece) const {
    return overlay_.from[piece.from].region != overlay_.to[piece.to].region && Counts(piece);
  }

 private:
  const Overlay<D>& overlay_;
  std::size_t group_count_ = 1;
  std::vector<std::uint32_t> groups_from_, groups_to_;  // 0: regions with changed shapes
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_EXCHANGE_H_
