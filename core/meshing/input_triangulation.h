// 3D: the triangulation of the input, which need not be small.
#ifndef DYNMESH_CORE_MESHING_INPUT_TRIANGULATION_H_
#define DYNMESH_CORE_MESHING_INPUT_TRIANGULATION_H_

#include <algorithm>
#include <bit>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_editor.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
class InputTriangulation {
 public:
  InputTriangulation(Complex<D, E>& complex, EngineOf<D, E>& engine, InputEditor<D, E>& input)
      : complex_(complex), engine_(engine), input_(input) {}

  // Inserts the points added so far, in a fast order. If there are many tetrahedra per vertex, as
  // between curves, refinement would make still more. Then neighbourhoods are found without a
  // triangulation. False if it was interrupted. 2D: does nothing, points are inserted one by one.
  bool Fill(absl::FunctionRef<bool()> interrupt);
  // With facets. Call when segment work on the input has inserted a vertex: between edges that are
  // split often there may be many tetrahedra per vertex, too.
  void LeaveIfLarge() {
    if (IsLarge()) Drop();
  }

 private:
  bool IsLarge() const {
    constexpr std::size_t kMostPerVertex = 16;
    return complex_.run.triangulation().is_full() ||
           complex_.run.triangulation().simplex_count() >
               kMostPerVertex * complex_.run.triangulation().vertex_count() + 10'000;
  }
  void Leave();
  // From now on neighbourhoods are found without a triangulation.
  void Drop();

  Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  InputEditor<D, E>& input_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool InputTriangulation<D, E>::Fill(absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    if (!complex_.run.has_triangulation() || input_.pending().empty()) return true;
    constexpr std::size_t kFirst = 512, kAtOnce = 2048;
    std::vector<VertexIndex> part;
    std::vector<geometry::Point<D>> positions;
    // Random rounds, each as large as all earlier ones together: a few points show whether there
    // are too many tetrahedra. Rounds follow a hash of the rank, as coordinates are the client's
    // choice.
    const int rounds = std::bit_width(input_.pending().size() / kFirst);
    for (int round = rounds; round >= 0; --round) {
      part.clear();
      positions.clear();
      for (std::size_t rank = 0; rank < input_.pending().size(); ++rank) {
        if (std::min(std::countl_zero(Mix(rank)), rounds) != round) continue;
        const VertexIndex v = input_.pending()[rank];
        part.push_back(v);
        positions.push_back(complex_.vertex(v).p);
      }
      for (std::size_t from = 0; from < part.size(); from += kAtOnce) {
        if (interrupt()) return false;
        const std::size_t count = std::min(kAtOnce, part.size() - from);
        complex_.run.triangulation().InsertAll(std::span(part).subspan(from, count),
                                               std::span(positions).subspan(from, count));
      }
      if (IsLarge()) {
        Leave();
        return true;
      }
    }
    input_.pending().clear();
  }
  return true;
}

template <int D, template <class> class E>
void InputTriangulation<D, E>::Leave() {
  Drop();
  input_.pending().clear();
  if constexpr (!kIsTraced<D, E>) {
    for (VertexIndex v = 0; v < complex_.elements.vertex_end(); ++v) {
      if (complex_.border_only) complex_.tree.Insert(v, complex_.vertex(v).p);
      engine_.Request(kNearest, v, NearestEpoch());
    }
  }
}

template <int D, template <class> class E>
void InputTriangulation<D, E>::Drop() {
  complex_.ResetToDomain(&complex_.run.triangulation());
  complex_.run.LeaveTriangulation();
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_INPUT_TRIANGULATION_H_
