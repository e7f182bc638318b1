// Changes of state. A vertex appears or vanishes at its creator's time; a subsegment is visible
// between its exposure and its death. Later operations that have read it become stale
// (notifier.h).
#ifndef DYNMESH_CORE_MESHING_PUBLISHER_H_
#define DYNMESH_CORE_MESHING_PUBLISHER_H_

#include <algorithm>
#include <utility>

#include "core/meshing/complex.h"
#include "core/meshing/filter_terms.h"
#include "core/meshing/notifier.h"

namespace dynmesh::meshing {

// Makes what operations emit visible: during a propagation vertices and exposures of subsegments
// come and go here only. complex.h lists what else changes the complex. Thread-compatible.
template <int D, template <class> class E>
class Publisher {
 public:
  using Point = geometry::Point<D>;
  using Subsegment = meshing::Subsegment<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  Publisher(Complex<D, E>& complex, EngineOf<D, E>& engine, Notifier<D, E>& notifier)
      : complex_(complex), engine_(engine), notifier_(notifier) {}

  // Makes the output visible from time `at` on. Returns true for a vertex that was inserted into
  // the triangulation. `triangle`: the one that holds the vertex, if it is known.
  bool Publish(sac::Output output, sac::Stamp at,
               std::uint32_t triangle = TriangulationOf<D>::kNone);
  void Withdraw(sac::Output output, sac::Stamp at);
  // The output's index becomes free when changes are taken.
  void Release(sac::Output output);
  void WithdrawVertex(VertexIndex v, sac::Stamp at);

 private:
  bool PublishVertex(VertexIndex v, sac::Stamp at, std::uint32_t triangle);
  bool InsertIntoTriangulation(VertexIndex v, std::uint32_t triangle);
  bool AreFewSubscribers(std::uint32_t first_child, std::uint32_t parent) const;
  // Leaves merge into their parent: their subscribers now subscribe at the parent.
  void MoveSubscribers(std::uint32_t first_child, std::uint32_t parent);
  void SetExposed(SubsegmentIndex s, sac::Stamp at);
  void HideSubsegment(SubsegmentIndex s);
  sac::Stamp NextDeath(const Subsegment& s, sac::Stamp except) const;

  Complex<D, E>& complex_;
  EngineOf<D, E>& engine_;
  Notifier<D, E>& notifier_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool Publisher<D, E>::Publish(sac::Output output, sac::Stamp at, std::uint32_t triangle) {
  const std::uint32_t i = IndexOf(output);
  switch (WhatOf(output)) {
    case Made::kVertex:
      return PublishVertex(i, at, triangle);
    case Made::kSubsegment:
      break;  // visible when its Check exposes it
    case Made::kExposure:
      SetExposed(i, at);
      break;
    case Made::kDeath: {
      Subsegment& s = complex_.subsegment(i);
      const sac::Stamp old = s.death;
      if (old != sac::kNoStamp && !engine_.Precedes(at, old)) break;
      s.death = at;
      complex_.elements.MarkSubsegmentChanged(i);
      notifier_.OfSubsegment(i, at, old);
      if constexpr (!kTraced) HideSubsegment(i);  // no later operation reads it
      if constexpr (kTraced) {
        if (IsOn(FilterTerm::kDeathOfSubsegment)) engine_.NotifyChain(s.operations, at);
      }
      break;
    }
  }
  return false;
}

template <int D, template <class> class E>
void Publisher<D, E>::Withdraw(sac::Output output, sac::Stamp at) {
  const std::uint32_t i = IndexOf(output);
  switch (WhatOf(output)) {
    case Made::kVertex:
      WithdrawVertex(i, at);
      break;
    case Made::kSubsegment:
      break;
    case Made::kExposure: {
      Subsegment& s = complex_.subsegment(i);
      notifier_.OfSubsegment(i, at, s.death);
      HideSubsegment(i);
      s.exposed = sac::kNoStamp;
      complex_.elements.MarkSubsegmentChanged(i);
      break;
    }
    case Made::kDeath: {
      Subsegment& s = complex_.subsegment(i);
      if (s.death != at) break;  // an earlier split is in force
      // A later split may exist, if a propagation was abandoned between the two.
      s.death = NextDeath(s, at);
      complex_.elements.MarkSubsegmentChanged(i);
      notifier_.OfSubsegment(i, at, s.death);
      if constexpr (kTraced) {
        if (IsOn(FilterTerm::kDeathOfSubsegment)) engine_.NotifyChain(s.operations, at);
      }
      break;
    }
  }
}

// The earliest split of s other than that at time `except`.
template <int D, template <class> class E>
sac::Stamp Publisher<D, E>::NextDeath(const Subsegment& s, sac::Stamp except) const {
  sac::Stamp earliest = sac::kNoStamp;
  if constexpr (kTraced) {
    for (sac::OpId o = s.operations; o != sac::kNoOp; o = engine_.next_of_item(o)) {
      if (!engine_.executed(o) || engine_.stamp(o) == except) continue;
      const auto made = engine_.outputs(o);
      const bool split = std::any_of(made.begin(), made.end(),
                                     [](sac::Output m) { return WhatOf(m) == Made::kDeath; });
      if (split && (earliest == sac::kNoStamp || engine_.Precedes(engine_.stamp(o), earliest))) {
        earliest = engine_.stamp(o);
      }
    }
  }
  return earliest;
}

template <int D, template <class> class E>
void Publisher<D, E>::Release(sac::Output output) {
  if (WhatOf(output) == Made::kVertex) complex_.elements.ReleaseVertex(IndexOf(output));
  if (WhatOf(output) == Made::kSubsegment) complex_.elements.ReleaseSubsegment(IndexOf(output));
}

template <int D, template <class> class E>
bool Publisher<D, E>::PublishVertex(VertexIndex v, sac::Stamp at, std::uint32_t triangle) {
  const Vertex<D>& vertex = complex_.vertex(v);
  const bool is_of_cure = IsOfCure(vertex);
  if (is_of_cure) {
    complex_.cured.Insert(v, vertex.p);
  } else if (complex_.needs_tree() || (vertex.dimension < D && !complex_.border_only)) {
    complex_.tree.Insert(v, vertex.p);
  }
  const bool is_in = InsertIntoTriangulation(v, triangle);
  complex_.SetPresent(v, true);
  if (kTraced && !complex_.run.has_triangulation() && !is_of_cure) complex_.appeared.push_back(v);
  notifier_.OfVertex(v, true, at);
  return is_in;
}

// False if there is no triangulation, or if it is full.
template <int D, template <class> class E>
bool Publisher<D, E>::InsertIntoTriangulation(VertexIndex v, std::uint32_t triangle) {
  if (!complex_.run.has_triangulation()) return false;
  const Point& p = complex_.vertex(v).p;
  auto& triangulation = complex_.run.triangulation();
  const bool is_known = triangle != TriangulationOf<D>::kNone;
  triangulation.InsertAt(v, p, is_known ? triangle : triangulation.Locate(p, complex_.MakerOf(v)));
  if (triangulation.is_full()) complex_.run.NoteFullTriangulation();
  return !complex_.is_full();
}

template <int D, template <class> class E>
void Publisher<D, E>::WithdrawVertex(VertexIndex v, sac::Stamp at) {
  const Vertex<D>& vertex = complex_.vertex(v);
  complex_.SetPresent(v, false);
  notifier_.OfVertex(v, false, at);
  if (IsOfCure(vertex)) {
    complex_.cured.Remove(v, vertex.p);
  } else if constexpr (kTraced) {
    complex_.tree.Remove(
        v, vertex.p,
        [this](std::uint32_t first_child, std::uint32_t parent) {
          return AreFewSubscribers(first_child, parent);
        },
        [this](std::uint32_t first_child, std::uint32_t parent) {
          MoveSubscribers(first_child, parent);
        });
  }
}

// May the children's subscribers be the parent's, too, without making it crowded?
template <int D, template <class> class E>
bool Publisher<D, E>::AreFewSubscribers(std::uint32_t first_child, std::uint32_t parent) const {
  if constexpr (kTraced) {
    std::size_t operations = engine_.subscriptions().CountAt(parent),
                balls = complex_.exposures.CountAt(parent);
    for (std::uint32_t child = first_child; child < first_child + (1u << D); ++child) {
      operations += engine_.subscriptions().CountAt(child);
      balls += complex_.exposures.CountAt(child);
    }
    return 2 * operations <= kCrowd && 2 * balls <= kCrowd;
  }
  return true;
}

template <int D, template <class> class E>
void Publisher<D, E>::MoveSubscribers(std::uint32_t first_child, std::uint32_t parent) {
  if constexpr (kTraced) {
    for (std::uint32_t child = first_child; child < first_child + (1u << D); ++child) {
      for (const sac::OpId op : engine_.subscriptions().Take(child)) {
        engine_.ReplacePlace(op, child, parent);
      }
      for (const SubsegmentIndex i : complex_.exposures.Take(child)) {
        Subsegment& s = complex_.subsegment(i);
        auto* const end = s.places.begin() + s.place_count;
        auto* const at = std::find(s.places.begin(), end, child);
        if (std::find(s.places.begin(), end, parent) == end) {
          *at = parent;
          complex_.exposures.Add(parent, i);
        } else {
          *at = *(end - 1);
          --s.place_count;
        }
      }
    }
  }
}

template <int D, template <class> class E>
void Publisher<D, E>::SetExposed(SubsegmentIndex i, sac::Stamp at) {
  Subsegment& s = complex_.subsegment(i);
  s.exposed = at;
  s.place_count = 0;
  const auto is_crowded = [&](sac::Place place) {
    return complex_.exposures.CountAt(place) >= kCrowd;
  };
  complex_.tree.CoverToKeep(
      complex_.BallOf(s), is_crowded, [&](sac::Place place, sac::Parts parts) {
        complex_.subsegment(i).places[complex_.subsegment(i).place_count++] = place;
        complex_.exposures.Add(place, i, parts);
      });
  complex_.elements.MarkSubsegmentChanged(i);
  notifier_.OfSubsegment(i, at, s.death);
}

template <int D, template <class> class E>
void Publisher<D, E>::HideSubsegment(SubsegmentIndex i) {
  Subsegment& s = complex_.subsegment(i);
  for (int k = 0; k < s.place_count; ++k) complex_.exposures.Remove(s.places[k], i);
  s.place_count = 0;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PUBLISHER_H_
