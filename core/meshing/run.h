// The mode of a run and what it has met. The mode is chosen when the run starts; a few named steps
// change it, none of them an operation's.
#ifndef DYNMESH_CORE_MESHING_RUN_H_
#define DYNMESH_CORE_MESHING_RUN_H_

#include <cstdint>

#include "core/delaunay/triangulation_of.h"
#include "core/meshing/elements.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

// How operations find the vertices around a vertex. All ways give the same bits.
enum class Neighbourhoods : std::uint8_t {
  // They search in the spatial tree, in which all vertices are. The way of all propagations but the
  // first.
  kLocal,
  // They read off a triangulation of all vertices present, and record what a local search would.
  // All vertices are in the tree, too, for the propagations that follow.
  kRecorded,
  // Untraced. They read off such a triangulation. The tree is only as fine as subsegments need it.
  kReadOff,
  // The same, and only vertices that own a gap have operations at all (first_gaps.h). By edges, and
  // without facets, which may reach into any cell.
  kGlobal,
};

// Thread-compatible.
template <int D>
class Run {
 public:
  using Triangulation = delaunay::TriangulationOf<D>;

  // Local if there is no triangulation.
  Run(Triangulation* triangulation, bool is_traced, Criterion criterion)
      : triangulation_(triangulation),
        neighbourhoods_(triangulation == nullptr        ? Neighbourhoods::kLocal
                        : is_traced                     ? Neighbourhoods::kRecorded
                        : criterion == Criterion::kEdge ? Neighbourhoods::kGlobal
                                                        : Neighbourhoods::kReadOff),
        numbers_by_age_(!is_traced) {}

  // --- Neighbourhoods -----------------------------------------------------------------------

  Neighbourhoods neighbourhoods() const { return neighbourhoods_; }
  bool has_triangulation() const { return triangulation_ != nullptr; }
  // Of all vertices present. REQUIRES: has_triangulation(), that is, they are not kLocal.
  const Triangulation& triangulation() const { return *triangulation_; }
  Triangulation& triangulation() { return *triangulation_; }
  // The input has a facet.
  void MeetFacet() {
    if (neighbourhoods_ == Neighbourhoods::kGlobal) neighbourhoods_ = Neighbourhoods::kReadOff;
  }
  // From now on neighbourhoods are found locally.
  void LeaveTriangulation() {
    triangulation_ = nullptr;
    neighbourhoods_ = Neighbourhoods::kLocal;
  }
  // From now on they are read off `triangulation`, and recorded.
  void Record(Triangulation* triangulation) {
    triangulation_ = triangulation;
    neighbourhoods_ = Neighbourhoods::kRecorded;
  }

  // --- Ages -----------------------------------------------------------------------------------

  // True if vertices made later have greater indices, as in a run from scratch: operations come in
  // the order of time, and no index is used twice.
  bool numbers_by_age() const { return numbers_by_age_; }
  // Vertices of the input have lower indices.
  VertexIndex first_made() const { return first_made_; }
  void Begin(bool numbers_by_age, VertexIndex first_made) {
    numbers_by_age_ = numbers_by_age;
    first_made_ = first_made;
  }
  void EndNumbersByAge() { numbers_by_age_ = false; }

  // --- Limits that it has met -------------------------------------------------------------------

  // An insertion or a split was refused because it would be finer than limits allow.
  bool hit_depth_limit() const { return hit_depth_limit_; }
  bool filled_triangulation() const { return filled_triangulation_; }
  void NoteDepthLimit() { hit_depth_limit_ = true; }
  void NoteFullTriangulation() { filled_triangulation_ = true; }
  void ForgetLimits() { hit_depth_limit_ = filled_triangulation_ = false; }

 private:
  Triangulation* triangulation_;
  Neighbourhoods neighbourhoods_;
  bool numbers_by_age_;
  bool hit_depth_limit_ = false, filled_triangulation_ = false;
  VertexIndex first_made_ = 0;
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_RUN_H_
