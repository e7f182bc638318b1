// Facets of the base that refused candidates of one cure, to be tried first with the next ones.
//
// Most candidates are refused by one bad tetrahedron that they would make with a facet of their
// cavity, and those of one sliver mostly with the same few facets. Whether a facet is on a cavity
// takes two tests of conflict, the whole cavity takes many. A cure that fails tries more than a
// thousand candidates.
//
// Thread-compatible. No allocation once warm.
#ifndef DYNMESH_CORE_MESHING_REFUSING_FACETS_H_
#define DYNMESH_CORE_MESHING_REFUSING_FACETS_H_

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/delaunay/delaunay_tetrahedralization.h"

namespace dynmesh::meshing {

// `Note`: what is kept with a facet.
template <class Note>
class RefusingFacets {
 public:
  // By the corner of the tetrahedron inside.
  using Facet = delaunay::DelaunayTetrahedralization::Corner;

  void Clear() { entries_.clear(); }
  // Calls refuses(facet, note) for each, those first that have refused most, until it returns true.
  // Returns whether it did.
  template <class Refuses>
  bool Any(Refuses refuses) {
    for (std::size_t i = 0; i < entries_.size(); ++i) {
      if (!refuses(entries_[i].facet, entries_[i].note)) continue;
      ++entries_[i].count;
      for (; i > 0 && entries_[i - 1].count < entries_[i].count; --i) {
        std::swap(entries_[i - 1], entries_[i]);
      }
      return true;
    }
    return false;
  }
  // Of the most that are kept, the one that has refused least gives way.
  void Add(const Facet& facet, const Note& note) {
    if (entries_.size() == kMost) entries_.pop_back();
    entries_.push_back({facet, 1, note});
  }

 private:
  static constexpr std::size_t kMost = 32;
  struct Entry {
    Facet facet;
    std::uint32_t count;
    Note note;
  };
  std::vector<Entry> entries_;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_REFUSING_FACETS_H_
