#include "core/meshing/refinement.h"

#include <utility>

#include "core/meshing/anchors.h"
#include "core/meshing/border.h"
#include "core/meshing/complete.h"
#include "core/meshing/cure.h"
#include "core/meshing/emitter.h"
#include "core/meshing/facet_anchors.h"
#include "core/meshing/facet_membership.h"
#include "core/meshing/first_gaps.h"
#include "core/meshing/input_editor.h"
#include "core/meshing/input_triangulation.h"
#include "core/meshing/nearest.h"
#include "core/meshing/neighbours.h"
#include "core/meshing/notifier.h"
#include "core/meshing/order.h"
#include "core/meshing/plain_input.h"
#include "core/meshing/presplit.h"
#include "core/meshing/publisher.h"
#include "core/meshing/segments.h"
#include "core/meshing/sliver_base.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
struct Refinement<D, E>::Parts {
  Parts(Complex<D, E>& complex, Engine& engine, Triangulation* domain, bool refines)
      : notifier(complex, engine),
        publisher(complex, engine, notifier),
        input(complex, engine, notifier, publisher),
        input_triangulation(complex, engine, input),
        anchors(complex, input),
        facet_anchors(complex, input),
        first_gaps(complex, engine),
        sliver_base(complex, engine, domain),
        emitter(complex),
        presplit(complex, emitter),
        segments(complex, emitter),
        nearest(complex),
        complete(complex, emitter),
        cure(complex, emitter) {
    if (!refines) plain_input.emplace(complex.elements, complex.tree);
  }

  Notifier<D, E> notifier;
  Publisher<D, E> publisher;

  InputEditor<D, E> input;
  std::optional<PlainInput<D>> plain_input;  // of a mesh that is not refined, in place of `input`
  InputTriangulation<D, E> input_triangulation;
  Anchors<D, E> anchors;
  FacetAnchors<D, E> facet_anchors;
  FirstGaps<D, E> first_gaps;
  SliverBase<D, E> sliver_base;

  Emitter<D, E> emitter;
  PresplitWork<D, E> presplit;
  SegmentWork<D, E> segments;
  NearestWork<D, E> nearest;
  CompleteWork<D, E> complete;
  CureWork<D, E> cure;
};

template <int D, template <class> class E>
Refinement<D, E>::Refinement(const MeshOptions& options, Triangulation* triangulation)
    : engine_(*this),
      complex_(options, engine_, triangulation),
      parts_(std::make_unique<Parts>(complex_, engine_, triangulation,
                                     options.kind != MeshKind::kTriangulation)) {
  AddBorder(complex_, *this);
  AddMaxEdge<D>(options, *this);
}

template <int D, template <class> class E>
Refinement<D, E>::~Refinement() = default;

// --- Input ----------------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::Reserve(std::size_t points) {
  const std::size_t vertices = 2 * points;
  complex_.elements.ReserveVertices(vertices);
  if (complex_.run.has_triangulation()) complex_.run.triangulation().Reserve(vertices);
  if constexpr (kTraced) {
    complex_.tree.Reserve(vertices);
    engine_.Reserve(2 * vertices, D == 2 ? 16 : 24);
  }
}

template <int D, template <class> class E>
VertexIndex Refinement<D, E>::AddPoint(const Point& p, FeatureSlot feature) {
  if (parts_->plain_input) return parts_->plain_input->AddPoint(p, feature);
  return parts_->input.AddPoint(p, feature);
}

template <int D, template <class> class E>
void Refinement<D, E>::RemovePoint(VertexIndex v) {
  if (parts_->plain_input) return parts_->plain_input->RemovePoint(v);
  parts_->input.RemovePoint(v);
}

template <int D, template <class> class E>
SubsegmentIndex Refinement<D, E>::AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                                             const SegmentShape& shape) {
  if (parts_->plain_input) return parts_->plain_input->AddSegment(a, b, feature);
  return parts_->input.AddSegment(a, b, feature, shape);
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveSegment(SubsegmentIndex s) {
  if (parts_->plain_input) return parts_->plain_input->RemoveSegment(s);
  parts_->input.RemoveSegment(s);
}

template <int D, template <class> class E>
typename Refinement<D, E>::SizingIndex Refinement<D, E>::AddSizing(const SizingRegion<D>& region) {
  return parts_->input.AddSizing(region);
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveSizing(SizingIndex index) {
  parts_->input.RemoveSizing(index);
}

template <int D, template <class> class E>
FacetIndex Refinement<D, E>::AddFacet(std::span<const std::vector<VertexIndex>> rings,
                                      FeatureSlot feature) {
  return parts_->input.AddFacet(rings, feature);
}

template <int D, template <class> class E>
void Refinement<D, E>::RemoveFacet(FacetIndex index) {
  parts_->facet_anchors.Remove(index);
  parts_->input.RemoveFacet(index);
}

template <int D, template <class> class E>
void Refinement<D, E>::OnlyInside() {
  parts_->sliver_base.OnlyInside();
}

// --- Results ----------------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::ForSomeNeighbours(VertexIndex v,
                                         absl::FunctionRef<bool(VertexIndex)> f) const {
  if (parts_->plain_input) return parts_->plain_input->ForEachNearer(v, f);
  meshing::ForSomeNeighbours(complex_, v, f);
}

template <int D, template <class> class E>
FeatureSlot Refinement<D, E>::FacetAt(VertexIndex a, VertexIndex b, VertexIndex c,
                                      VertexIndex d) const {
  const FacetIndex facet = FacetOf(complex_, a, b, c, d);
  return facet == kNil ? kNil : complex_.facets[facet].feature();
}

// --- Propagation ------------------------------------------------------------------------

template <int D, template <class> class E>
bool Refinement<D, E>::Propagate(absl::FunctionRef<bool()> interrupt) {
  if (parts_->plain_input) return !interrupt();  // there is nothing to do
  if (!Begin(interrupt)) return false;
  const bool done = RunAll(interrupt);
  End(done);
  return done;
}

template <int D, template <class> class E>
bool Refinement<D, E>::RunAll(absl::FunctionRef<bool()> interrupt) {
  if (!complex_.slivers.is_on()) return engine_.Propagate(interrupt);
  return engine_.Propagate(interrupt, CureEpoch(0)) && BeginCures(interrupt) &&
         engine_.Propagate(interrupt);
}

template <int D, template <class> class E>
bool Refinement<D, E>::Begin(absl::FunctionRef<bool()> interrupt) {
  auto& changes = parts_->input.changes();
  // Anchors decided by an interrupted call are decided again, even if its changes were undone.
  if (!std::exchange(changes.begun, true)) KeepNetChanges(changes.features);
  changes.sizes.Begin();
  parts_->notifier.OfSizes(changes.sizes);
  if (!parts_->anchors.Update(interrupt) || !parts_->facet_anchors.Update(interrupt)) return false;
  changes.sizes.Clear();
  changes.new_facets.clear();
  if (!parts_->input_triangulation.Fill(interrupt)) return false;
  if constexpr (!kTraced) parts_->first_gaps.RequestAll();
  parts_->notifier.OfFeatures(changes.features);
  parts_->notifier.OfFacets(changes.facets);
  changes.features.clear();
  changes.facets.clear();
  changes.begun = false;
  bool numbers_by_age = complex_.run.numbers_by_age();
  if constexpr (kTraced) {
    numbers_by_age = engine_.IsFromScratch() && !complex_.elements.has_free_vertices();
  }
  complex_.run.Begin(numbers_by_age, complex_.elements.vertex_end());
  return true;
}

template <int D, template <class> class E>
bool Refinement<D, E>::BeginCures(absl::FunctionRef<bool()> interrupt) {
  if (interrupt()) return false;  // what the base does is no operation's work
  complex_.run.EndNumbersByAge();
  return parts_->sliver_base.Update(interrupt);
}

template <int D, template <class> class E>
void Refinement<D, E>::End(bool is_done) {
  complex_.run.EndNumbersByAge();
  if (is_done) {
    complex_.appeared.clear();
    if (complex_.slivers.is_on()) complex_.slivers.Forget();
  }
  parts_->nearest.Forget();
}

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::visited_cells() const {
  return parts_->notifier.visited_cells();
}

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::nearest_looked_at() const {
  return parts_->nearest.looked_at();
}

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::visited_nodes() const {
  return parts_->anchors.visited_nodes();
}

template <int D, template <class> class E>
void Refinement<D, E>::ForgetDepthLimit() {
  complex_.run.ForgetLimits();
  complex_.elements.ForgetFull();
}

template <int D, template <class> class E>
std::optional<geometry::Point<D>> Refinement<D, E>::OverflowAt() const {
  if constexpr (kTraced) {
    const sac::OpId op = engine_.overflowed();
    if (op == sac::kNoOp) return std::nullopt;
    const sac::Kind kind = engine_.kind(op);
    const sac::Item item = engine_.item(op);
    if (kind == kCure) return vertex(complex_.slivers[item].v[0]).p;
    return vertex(kind <= kComplete ? item : subsegment(item).a).p;
  }
  return std::nullopt;
}

// --- For the engine ---------------------------------------------------------------------

template <int D, template <class> class E>
std::uint64_t Refinement<D, E>::Priority(sac::Kind kind, sac::Item item) const {
  return meshing::Priority(complex_, kind, item);
}

template <int D, template <class> class E>
bool Refinement<D, E>::Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const {
  return meshing::Before(complex_, kind_a, a, kind_b, b);
}

template <int D, template <class> class E>
void Refinement<D, E>::Execute(Context& context) {
  switch (context.kind) {
    case kNearest:
      ++nearest_run_;
      if (complex_.is_global()) return parts_->first_gaps.FindAll();
      return parts_->nearest.Run(context);
    case kComplete:
      return parts_->complete.Run(context);
    case kCheck:
    case kRecheck:
    case kSplit:
      return parts_->segments.Run(context);
    case kPresplit:
      return parts_->presplit.Run(context);
    case kCure:
      return parts_->cure.Run(context);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Prefetch(sac::Kind kind, sac::Item item, int step) const {
  if (step == 0 && kind <= kComplete) __builtin_prefetch(&vertex(item));
  if (kind != kComplete) return;
  if (complex_.run.has_triangulation()) complex_.run.triangulation().PrefetchAround(item, step);
}

template <int D, template <class> class E>
void Refinement<D, E>::Publish(sac::Output output, sac::Stamp at) {
  if (complex_.is_global()) return PublishInGlobal(output, at);
  const bool is_in = parts_->publisher.Publish(output, at);
  // Until then vertices are of the input and its segments, and so in the tree. With facets each has
  // an operation of its own.
  if (is_in && !complex_.facets.empty() && vertex(IndexOf(output)).epoch < NearestEpoch()) {
    parts_->input_triangulation.LeaveIfLarge();
  }
}

// In a global run a new vertex that owns a gap requests its own Complete. What there is to know of
// the gap that the vertex fills comes from the Complete that has just made it.
template <int D, template <class> class E>
void Refinement<D, E>::PublishInGlobal(sac::Output output, sac::Stamp at) {
  const VertexIndex v = IndexOf(output);
  if (WhatOf(output) != Made::kVertex || !IsQualityEpoch(vertex(v).epoch)) {
    parts_->publisher.Publish(output, at);
    return;
  }
  const auto& filled = parts_->complete.filled();
  const std::size_t ordinal = vertex(v).ordinal;
  const std::uint32_t triangle = ordinal == 0 ? filled.triangle : Triangulation::kNone;
  if (parts_->publisher.Publish(output, at, triangle)) {
    if constexpr (!kTraced) parts_->first_gaps.FindOf(v, filled.buckets[ordinal]);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Withdraw(sac::Output output, sac::Stamp at) {
  parts_->publisher.Withdraw(output, at);
}

template <int D, template <class> class E>
void Refinement<D, E>::Release(sac::Output output) {
  parts_->publisher.Release(output);
}

// --- Memory -------------------------------------------------------------------------------

template <int D, template <class> class E>
std::size_t Refinement<D, E>::trace_bytes() const {
  if constexpr (kTraced) return engine_.bytes() + complex_.exposures.bytes();
  return 0;
}

template <int D, template <class> class E>
std::size_t Refinement<D, E>::bytes() const {
  return complex_.bytes() + parts_->anchors.bytes();
}

template class Refinement<2, sac::Engine>;
template class Refinement<2, sac::UntracedEngine>;
template class Refinement<3, sac::Engine>;
template class Refinement<3, sac::UntracedEngine>;

}  // namespace dynmesh::meshing
