// The subfacets of a 3D mesh: faces of its tetrahedra that lie on facets. Follows the
// triangulation, and lists changes.
//
// `facet_of(a, b, c, d)` is the slot of the facet that contains face abc, as seen from the side of
// the fourth corner d; kNil on the other side, and if there is none. So of the two tetrahedra at a
// subfacet only one reports it: the face is kept and removed with that one. Evaluated for new
// tetrahedra, and for those near the corners of a new facet. From its corners all subfacets of a
// facet are reached over common vertices, since every part of a polygon has corners.
//
// Thread-compatible. Expected O(1) for each tetrahedron; for each subfacet of a facet that is added
// or removed, O(tetrahedra at its corners).
#ifndef DYNMESH_CORE_DYNAMIC_MESH_SUBFACET_TABLE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_SUBFACET_TABLE_H_

#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/meshing/elements.h"
#include "core/regions/sides.h"

namespace dynmesh {

class SubfacetTable {
 public:
  using Triangulation = delaunay::DelaunayTetrahedralization;
  using Vertex = meshing::VertexIndex;
  using Slot = meshing::FeatureSlot;
  using Face = std::array<Vertex, 3>;  // ascending
  using Tetrahedron = std::array<Vertex, 4>;
  struct Row {
    Face face;
    Slot slot;
    friend bool operator==(const Row&, const Row&) = default;
  };

  std::size_t size() const { return kept_.size(); }
  // Calls f(face, slot) for each, in no particular order.
  template <class F>
  void ForEach(F f) const {
    for (const auto& [face, kept] : kept_) f(face, kept.slot);
  }

  // Calls f(face) for the subfacets of the facet in that slot, in no particular order.
  template <class F>
  void ForEachOf(Slot slot, F f) const {
    const auto it = faces_.find(slot);
    if (it == faces_.end()) return;
    for (const Face& face : it->second) f(face);
  }

  // Subfacets removed and added since the last ClearChanges; some may be in both lists.
  const std::vector<Row>& gone() const { return gone_; }
  const std::vector<Row>& come() const { return come_; }
  void ClearChanges() {
    gone_.clear();
    come_.clear();
  }

  // A change, in this order: removed facets, removed tetrahedra, added tetrahedra, added facets.
  // `facet_of` describes the state after all of them.
  void RemoveFacet(Slot slot) {
    const auto it = faces_.find(slot);
    if (it == faces_.end()) return;
    for (const Face& face : it->second) {
      kept_.erase(face);
      gone_.push_back({face, slot});
    }
    faces_.erase(it);
  }
  void Remove(const Tetrahedron& t) {
    if (kept_.empty()) return;
    for (const auto& [face, apex] : SidesOf(t)) {
      const auto it = kept_.find(face);
      if (it == kept_.end() || it->second.apex != apex) continue;
      const Slot slot = it->second.slot;
      gone_.push_back({face, slot});
      const auto of_facet = faces_.find(slot);
      of_facet->second.erase(face);
      if (of_facet->second.empty()) faces_.erase(of_facet);
      kept_.erase(it);
    }
  }
  template <class FacetOf>
  void Add(const Tetrahedron& t, FacetOf facet_of) {
    for (const Side& side : SidesOf(t)) {
      const Slot slot = SlotOf(side, facet_of);
      if (slot != meshing::kNil) Keep(side, slot);
    }
  }
  // `corners` of the facet.
  template <class FacetOf>
  void AddFacet(Slot slot, std::span<const Vertex> corners, const Triangulation& triangulation,
                FacetOf facet_of) {
    absl::flat_hash_set<Vertex> reached(corners.begin(), corners.end());
    std::vector<Vertex> queue(reached.begin(), reached.end());
    while (!queue.empty()) {
      const Vertex v = queue.back();
      queue.pop_back();
      triangulation.ForEachSimplexAround(v, [&](Triangulation::SimplexIndex t) {
        if (triangulation.IsInfinite(t)) return;
        for (const Side& side : SidesOf(triangulation.vertices(t))) {
          if (side.apex == v || SlotOf(side, facet_of) != slot) continue;
          Keep(side, slot);
          for (const Vertex u : side.face) {
            if (reached.insert(u).second) queue.push_back(u);
          }
        }
      });
    }
  }

  std::size_t bytes() const {
    return kept_.capacity() * (sizeof(Face) + sizeof(Kept) + 1) +
           kept_.size() * 2 * (sizeof(Face) + 1);  // as sets by facet
  }

 private:
  struct Side {
    Face face;
    Vertex apex;  // the tetrahedron's fourth corner
  };
  struct Kept {
    Slot slot;
    Vertex apex;
  };

  static std::array<Side, 4> SidesOf(const Tetrahedron& t) {
    std::array<Side, 4> sides;
    for (std::size_t i = 0; i < 4; ++i) sides[i] = {SideOpposite(t, static_cast<int>(i)), t[i]};
    return sides;
  }
  template <class FacetOf>
  static Slot SlotOf(const Side& side, FacetOf facet_of) {
    return facet_of(side.face[0], side.face[1], side.face[2], side.apex);
  }
  void Keep(const Side& side, Slot slot) {
    if (!kept_.try_emplace(side.face, Kept{slot, side.apex}).second) return;
    faces_[slot].insert(side.face);
    come_.push_back({side.face, slot});
  }

  absl::flat_hash_map<Face, Kept> kept_;
  absl::flat_hash_map<Slot, absl::flat_hash_set<Face>> faces_;
  std::vector<Row> gone_, come_;
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_SUBFACET_TABLE_H_
