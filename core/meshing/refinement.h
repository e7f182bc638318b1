// Refinement: the program that the self-adjusting engine runs. From input points and segments it
// makes the vertices and subsegments of a quality mesh, bottom up (ChooseSteiners, Figs. 4.10, 5.6,
// 6.2), and keeps them when the input changes. core/sac/engine.h draws the calls between the two.
//
//   complex.h        what there is: elements, the indices over them, the input
//   run.h            the mode of a run: how neighbourhoods are found
//   input_editor.h   changes of input; border.h, anchors.h and facet_anchors.h add vertices to it
//   order.h          the order of operations within an epoch
//
// Procedures, one class each, without state between runs:
//   presplit.h       kPresplit: no subsegment has a feature too near
//   segments.h       kCheck, kSplit, kRecheck: no subsegment is encroached (rule b)
//   nearest.h        kNearest: when does a vertex begin?
//   complete.h       kComplete: no edge has a gap (rule a), yielding (c); no vertex has a part of a
//                    facet that it is not on (facet_work.h, rule b)
//   cure.h           kCure: no tetrahedron has a small dihedral angle, if requested
// What they read:
//   star_finder.h    the star of a vertex, found locally or read off a triangulation
//   idle_star.h      the reads of stars without a gap, which most are, read off at a glance
//   edge_criterion.h, thesis_criterion.h, planar_gaps.h, space_gaps.h   which gap an edge has
//   encroachment.h   which vertices encroach on a subsegment, and on which ones a point does
// What they make:
//   splits.h         where a subsegment is split
//   emitter.h        emits elements
//   publisher.h      makes them visible
//   notifier.h, read_filter.h   which operations a change affects
//
// Invariants at every operation of quality work: no subsegment is encroached, hence each is an edge
// of the Delaunay triangulation. A gap's Steiner point that would encroach is not inserted; the
// subsegments are split in the next round.
//
// The same code runs traced (sac::Engine) and untraced (sac::UntracedEngine). Neighbourhoods are
// found locally, in the spatial tree, or, in a run from scratch, read off a triangulation of all
// vertices present. All four combinations give the same bits.
//
// Thread-compatible.
#ifndef DYNMESH_CORE_MESHING_REFINEMENT_H_
#define DYNMESH_CORE_MESHING_REFINEMENT_H_

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "absl/functional/function_ref.h"
#include "core/meshing/complex.h"
#include "core/meshing/input_sink.h"
#include "core/meshing/mesh_source.h"
#include "core/meshing/types.h"
#include "core/sac/engine.h"
#include "core/sac/untraced_engine.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

template <int D, template <class> class E>
class Refinement final : public EditableSink<D>, public MeshSource<D> {
 public:
  using Engine = E<Refinement>;
  using Context = typename Engine::Context;
  static constexpr bool kTraced = Engine::kTraced;
  static constexpr int kDimension = D;
  using Point = geometry::Point<D>;
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  using Payload = meshing::Payload<D>;
  using Rules = RulesOf<D>;
  using Triangulation = TriangulationOf<D>;
  using SizingIndex = typename SizingField<D>::Index;
  using OnChange = typename MeshSource<D>::OnChange;

  // Chooses the mode of the run (run.h). If `triangulation` is given, neighbourhoods are read off
  // it, and every published vertex is inserted into it: for runs from scratch only, until
  // DetachTriangulation. It must be empty.
  Refinement(const MeshOptions& options, Triangulation* triangulation);
  ~Refinement();

  // --- Input: call between propagations (input_editor.h). ------------------------------------

  // Reserves room for so many input points and as many Steiner points. This saves copying; a guess
  // that is too high costs no memory.
  void Reserve(std::size_t points);
  VertexIndex AddPoint(const Point& p, FeatureSlot feature) override;
  void RemovePoint(VertexIndex v) override;
  SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                             const SegmentShape& shape = {}) override;
  void RemoveSegment(SubsegmentIndex s) override;
  SizingIndex AddSizing(const SizingRegion<D>& region) override;
  void RemoveSizing(SizingIndex index) override;
  FacetIndex AddFacet(std::span<const std::vector<VertexIndex>> rings,
                      FeatureSlot feature) override;
  void RemoveFacet(FacetIndex index) override;

  // 3D. Slivers outside of what facets enclose are left (SliverBase::OnlyInside). Call before the
  // only propagation.
  void OnlyInside();

  // Runs what is due, for the first time or again. `interrupt()` is called before each operation,
  // and before the base of cures follows the mesh; if it returns true, Propagate returns false. See
  // sac::Engine::Propagate.
  bool Propagate(absl::FunctionRef<bool()> interrupt);

  // From now on neighbourhoods are found in the spatial tree.
  void DetachTriangulation() { complex_.run.LeaveTriangulation(); }

  // --- Results ---------------------------------------------------------------------

  const Complex<D, E>& complex() const { return complex_; }
  const ElementStore<D>& elements() const override { return complex_.elements; }
  const FacetField& facets() const override { return complex_.facets; }
  const Vertex& vertex(VertexIndex v) const { return complex_.vertex(v); }
  const Subsegment& subsegment(SubsegmentIndex s) const { return complex_.subsegment(s); }
  std::size_t vertex_count() const { return complex_.elements.vertex_count(); }
  void TakeChanges(OnChange on_vertex, OnChange on_subsegment) override {
    complex_.elements.TakeChanges(on_vertex, on_subsegment);
  }
  void ForSomeNeighbours(VertexIndex v, absl::FunctionRef<bool(VertexIndex)> f) const override;
  FeatureSlot FacetAt(VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) const override;

  // Because of sizes so far: cells of the vertex tree, and lattice points or balls of them.
  std::uint64_t visited_cells() const;
  std::uint64_t visited_nodes() const;
  // How many operations of kNearest have run so far.
  std::uint64_t nearest_run() const { return nearest_run_; }
  // How many vertices these have looked at, other than in a load.
  std::uint64_t nearest_looked_at() const;
  std::size_t tree_nodes() const { return complex_.tree.node_count(); }
  // True if an insertion or a split was refused because it would be finer than limits allow.
  bool hit_depth_limit() const { return complex_.run.hit_depth_limit(); }
  // True if the greatest number of vertices, subsegments or simplices is reached. Then what was
  // made must be undone, which may take as many more vertices and subsegments as there were before.
  bool is_full() const { return complex_.is_full(); }
  // Forgets both.
  void ForgetDepthLimit();
  // The position of the operation at which limits stopped the propagation (sac::EngineLimits).
  std::optional<Point> OverflowAt() const;

  Engine& engine() { return engine_; }
  const Engine& engine() const { return engine_; }
  std::size_t trace_bytes() const;
  std::size_t bytes() const;

  // --- For the engine (engine.h says what these are) --------------------------------

  std::uint64_t Priority(sac::Kind kind, sac::Item item) const;
  bool Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const;
  sac::OpId& OperationsOf(sac::Kind kind, sac::Item item) {
    if (kind == kCure) return complex_.slivers.operations(item);
    return kind <= kComplete ? complex_.vertex(item).operations
                             : complex_.subsegment(item).operations;
  }
  const sac::OpId& OperationsOf(sac::Kind kind, sac::Item item) const {
    return const_cast<Refinement*>(this)->OperationsOf(kind, item);
  }
  void Execute(Context& context);
  // True if further visible subsegments matter to the operation, beside those with what it made in
  // their balls. Then its candidates yielded or were kept out; their positions are not kept.
  static bool IsAttentive(sac::Kind kind, const Payload& payload) {
    return (kind == kComplete || kind == kCure) && payload.flag;
  }
  static constexpr int kPrefetchSteps = Triangulation::kPrefetchSteps;
  void Prefetch(sac::Kind kind, sac::Item item, int step) const;
  void Publish(sac::Output output, sac::Stamp at);
  void Withdraw(sac::Output output, sac::Stamp at);
  void Release(sac::Output output);

 private:
  struct Parts;  // the procedures and what serves them

  void PublishInGlobal(sac::Output output, sac::Stamp at);

  // What comes before and after the engine's own propagation. Begin is false if it was interrupted.
  bool Begin(absl::FunctionRef<bool()> interrupt);
  void End(bool is_done);
  // Refinement, then cures.
  bool RunAll(absl::FunctionRef<bool()> interrupt);
  bool BeginCures(absl::FunctionRef<bool()> interrupt);

  Engine engine_;
  Complex<D, E> complex_;
  std::unique_ptr<Parts> parts_;
  std::uint64_t nearest_run_ = 0;
};

extern template class Refinement<2, sac::Engine>;
extern template class Refinement<2, sac::UntracedEngine>;
extern template class Refinement<3, sac::Engine>;
extern template class Refinement<3, sac::UntracedEngine>;

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_REFINEMENT_H_
