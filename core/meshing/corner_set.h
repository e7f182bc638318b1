// A small set of corners of stars, by their neighbours' ids. It answers which corners of a former
// star a star still has.
//
// Corners are added in any order; equal corners must be given alike. O(1) to add, no allocation
// once warm. A query is O(n) for few corners, O(log n) for many. Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_CORNER_SET_H_
#define DYNMESH_CORE_MESHING_CORNER_SET_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace dynmesh::meshing {

template <int D>
class CornerSet {
 public:
  using Corner = std::array<std::uint32_t, D>;

  void Clear() { corners_.clear(); }
  void Add(const Corner& corner) { corners_.push_back(corner); }
  // Call after the last Add and before the first Has.
  void Close() {
    if (!AreFew()) std::sort(corners_.begin(), corners_.end());
  }
  bool Has(const Corner& corner) const {
    if (!AreFew()) return std::binary_search(corners_.begin(), corners_.end(), corner);
    // Nearly all sets are small: compares with every corner, without branches, which would be
    // mispredicted.
    bool has = false;
    for (const Corner& other : corners_) {
      std::uint32_t differ = 0;
      for (std::size_t k = 0; k < D; ++k) differ |= other[k] ^ corner[k];
      has |= differ == 0;
    }
    return has;
  }

 private:
  static constexpr std::size_t kFew = 32;
  bool AreFew() const { return corners_.size() <= kFew; }

  std::vector<Corner> corners_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CORNER_SET_H_
