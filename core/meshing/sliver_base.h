// Between refinement and cures: which slivers there are, and so which cures.
#ifndef DYNMESH_CORE_MESHING_SLIVER_BASE_H_
#define DYNMESH_CORE_MESHING_SLIVER_BASE_H_

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/meshing/complex.h"
#include "core/meshing/facet_membership.h"
#include "core/meshing/neighbours.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/sliver_table.h"

namespace dynmesh::meshing {

// Brings the base up to date: the triangulation of refinement's vertices, of which the slivers are.
template <int D, template <class> class E>
class SliverBase {
 public:
  using Triangulation = TriangulationOf<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  // `domain`: a triangulation that may be used; null if there is none.
  SliverBase(Complex<D, E>& complex, EngineOf<D, E>& engine, Triangulation* domain)
      : complex_(complex), engine_(engine), domain_(domain) {}

  // From now on tetrahedra outside of what facets enclose are no slivers, if anything is enclosed:
  // for a mesh from scratch of which the inside alone is kept. What is outside is no local
  // question.
  void OnlyInside() { only_inside_ = true; }
  // Brings the base up to date and requests the cures that are due. From scratch the base is the
  // triangulation that refinement read neighbourhoods from, if it has all vertices. False if it
  // was interrupted.
  bool Update(absl::FunctionRef<bool()> interrupt);

 private:
  bool Fill(Triangulation* base, absl::FunctionRef<bool()> interrupt) const;
  void Follow();
  bool FindOutside(const TriangulationOf<D>& base, absl::FunctionRef<bool()> interrupt);
  auto IsSeditious() const {
    return [this](VertexIndex v, VertexIndex u) { return complex_.IsSeditious(v, u); };
  }
  auto IsFlat() const {
    return [this](const std::array<VertexIndex, 4>& v) { return complex_.IsFlatByCounterparts(v); };
  }

  Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  Triangulation* const domain_;
  bool only_inside_ = false;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool SliverBase<D, E>::Update(absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    if (complex_.slivers.has_base()) {
      Follow();
    } else {
      TriangulationOf<D> whole;
      TriangulationOf<D>* base = &whole;
      if (complex_.run.has_triangulation()) {
        base = &complex_.run.triangulation();
      } else {
        if (domain_ != nullptr) base = domain_;
        if (!Fill(base, interrupt)) return false;
      }
      if (base->is_full()) {
        complex_.run.NoteFullTriangulation();
        return true;
      }
      if (only_inside_ && !FindOutside(*base, interrupt)) return false;
      const bool is_to_change = kTraced || base == &whole;
      if (!complex_.slivers.Begin(*base, is_to_change, IsSeditious(), IsFlat(), interrupt)) {
        return false;
      }
      complex_.run.LeaveTriangulation();
    }
    complex_.changed_base.clear();
    const sac::Epoch first = CureEpoch(0);
    complex_.slivers.TakeChanges([&](SliverIndex i) { engine_.Request(kCure, i, first); },
                                 [&]([[maybe_unused]] SliverIndex i) {
                                   if constexpr (kTraced) engine_.Unrequest(kCure, i, first);
                                 });
  }
  return true;
}

// Inserts all vertices that refinement made, in a fast order.
template <int D, template <class> class E>
bool SliverBase<D, E>::Fill(TriangulationOf<D>* base, absl::FunctionRef<bool()> interrupt) const {
  if constexpr (D == 3) {
    constexpr std::size_t kAtOnce = 2048;
    complex_.ResetToDomain(base);
    base->Reserve(complex_.elements.vertex_count());
    // Steiner points of long edges first, the input last (DiffBuilder::FillTriangulation).
    std::vector<VertexIndex> all;
    complex_.elements.ForEachVertex([&](VertexIndex v, const Vertex<D>&) {
      if (!base->Contains(v)) all.push_back(v);
    });
    std::stable_sort(all.begin(), all.end(), [this](VertexIndex v, VertexIndex u) {
      return BucketOfEpoch(complex_.vertex(v).epoch) > BucketOfEpoch(complex_.vertex(u).epoch);
    });
    std::vector<geometry::Point<D>> positions;
    for (std::size_t from = 0; from < all.size(); from += kAtOnce) {
      if (interrupt()) return false;
      const auto part = std::span(all).subspan(from, std::min(kAtOnce, all.size() - from));
      positions.clear();
      for (const VertexIndex v : part) positions.push_back(complex_.vertex(v).p);
      base->InsertAll(part, positions);
    }
  }
  return true;
}

// From the hull on, through all faces that are on no facet. That leaves out what the selection of a
// mesh's inside leaves out (mesh_data/chambers.h). False if it was interrupted.
template <int D, template <class> class E>
bool SliverBase<D, E>::FindOutside(const TriangulationOf<D>& base,
                                   absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    constexpr std::uint32_t kAtOnce = 4096;
    std::vector<bool> outside(base.simplex_limit());
    std::vector<std::uint32_t> stack;
    std::size_t reached = 0;
    const auto reach = [&](std::uint32_t t) {
      if (outside[t]) return;
      outside[t] = true;
      ++reached;
      stack.push_back(t);
    };
    const auto is_wall = [&](std::uint32_t t, int i) {
      const auto [a, b, c] = base.FacetAt({t, i});
      const auto beyond = base.Opposite({t, i});
      const VertexIndex d = base.vertices(t)[static_cast<std::size_t>(i)],
                        e = base.vertices(beyond.simplex)[static_cast<std::size_t>(beyond.index)];
      return FacetOf(complex_, a, b, c, d) != kNil ||
             (e != TriangulationOf<D>::kInfinite && FacetOf(complex_, a, b, c, e) != kNil);
    };
    for (std::uint32_t t = 0; t < base.simplex_limit(); ++t) {
      if (t % kAtOnce == 0 && interrupt()) return false;
      if (base.IsInfinite(t)) continue;
      for (int i = 0; i < 4; ++i) {
        if (base.IsInfinite(base.Opposite({t, i}).simplex) && !is_wall(t, i)) reach(t);
      }
    }
    for (std::uint32_t step = 0; !stack.empty(); ++step) {
      if (step % kAtOnce == 0 && interrupt()) return false;
      const std::uint32_t t = stack.back();
      stack.pop_back();
      for (int i = 0; i < 4; ++i) {
        const std::uint32_t next = base.Opposite({t, i}).simplex;
        if (base.IsInfinite(next) || outside[next]) continue;
        if (!is_wall(t, i) || !IsOn(RefinementTerm::kFacetsEnclose)) reach(next);
      }
    }
    if (reached < base.simplex_count()) complex_.slivers.SetOutside(std::move(outside));
  }
  return true;
}

// Removes before it inserts: a new vertex may have the position of an old one.
template <int D, template <class> class E>
void SliverBase<D, E>::Follow() {
  if constexpr (D == 3) {
    const auto is_wanted = [this](VertexIndex v) {
      return complex_.vertex(v).present && !IsOfCure(complex_.vertex(v));
    };
    for (const VertexIndex v : complex_.changed_base) {
      if (complex_.slivers.base().Contains(v) && !is_wanted(v)) complex_.slivers.Remove(v);
    }
    for (const VertexIndex v : complex_.changed_base) {
      if (complex_.slivers.base().Contains(v) || !is_wanted(v)) continue;
      VertexIndex near = 0;
      ForSomeNeighbours(complex_, v, [&](VertexIndex u) {
        if (!complex_.slivers.base().Contains(u)) return false;
        near = u;
        return true;
      });
      complex_.slivers.Insert(v, complex_.vertex(v).p, near);
    }
    if (complex_.slivers.base().is_full()) complex_.run.NoteFullTriangulation();
    if (!complex_.is_full()) complex_.slivers.FindSlivers(IsSeditious(), IsFlat());
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_SLIVER_BASE_H_
