// Refinement: the program that the self-adjusting engine runs. From input points and segments it
// makes the vertices and subsegments of a quality mesh, bottom up (ChooseSteiners, Figs. 4.10, 5.6,
// 6.2), and keeps them when the input changes. core/sac/engine.h draws the calls between the two.
//
//   segments.h    Presplit, Check, Split: no subsegment is encroached (rule b)
//   anchors.h     vertices of areas with a target length that are there from the beginning
//   complete.h    Complete: no edge has a gap (rule a, either criterion), yielding (c)
//   facet_work.h  3D: no vertex has a part of a facet that it is not on (rule b)
//   cure.h        3D: no tetrahedron has a small dihedral angle, if requested
//   planar_gaps.h, space_gaps.h   which gap an edge has
//   star_search.h  the star of a vertex, found locally or read off a triangulation
//   idle_star.h   the reads of stars without a gap, which most are, read off at a glance
//   neighbourhood.h  what is in a ball, what a point encroaches on
//   changes.h     publishing, withdrawing and notifying
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

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "absl/functional/function_ref.h"
#include "core/base/large_vector.h"
#include "core/mesh/delaunay_tetrahedralization.h"
#include "core/mesh/delaunay_triangulation.h"
#include "core/meshing/anchor_lattice.h"
#include "core/meshing/cell_cut.h"
#include "core/meshing/corner_set.h"
#include "core/meshing/elements.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/facet_lattice.h"
#include "core/meshing/input_features.h"
#include "core/meshing/planar_rules.h"
#include "core/meshing/sizing_field.h"
#include "core/meshing/sliver_table.h"
#include "core/meshing/space_rules.h"
#include "core/meshing/spatial_tree.h"
#include "core/meshing/star.h"
#include "core/sac/engine.h"
#include "core/sac/subscriptions.h"
#include "core/sac/untraced_engine.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {
// D: the dimension. E: the engine, traced or not.
template <int D, template <class> class E>
class Refinement;
template <class R>
class PlanarGaps;
template <class R>
class SpaceGaps;
template <class R>
class TetrahedronGaps;
}  // namespace dynmesh::meshing

template <int D, template <class> class E>
struct dynmesh::sac::PayloadOf<dynmesh::meshing::Refinement<D, E>> {
  using Type = meshing::Payload<D>;
};

namespace dynmesh::meshing {

template <int D, template <class> class E>
class Refinement {
 public:
  using Engine = E<Refinement>;
  using Context = typename Engine::Context;
  static constexpr bool kTraced = Engine::kTraced;
  static constexpr int kDimension = D;
  using Point = geometry::Point<D>;
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  using Payload = meshing::Payload<D>;
  using Star = meshing::Star<D>;
  using Rules = std::conditional_t<D == 2, PlanarRules, SpaceRules>;
  using Triangulation =
      std::conditional_t<D == 2, mesh::DelaunayTriangulation, mesh::DelaunayTetrahedralization>;

  // If `triangulation` is given, neighbourhoods are read off it, and every published vertex is
  // inserted into it: for runs from scratch only, until DetachTriangulation. It must be empty.
  Refinement(const MeshOptions& options, Triangulation* triangulation);

  // --- Input: call between propagations. --------------------------------------------

  // Reserves room for so many input points and as many Steiner points. This saves copying; a guess
  // that is too high costs no memory.
  void Reserve(std::size_t points);
  VertexIndex AddPoint(const Point& p, FeatureSlot feature);
  void RemovePoint(VertexIndex v);
  // `shape`: of the segment from the lesser end to the greater.
  SubsegmentIndex AddSegment(VertexIndex a, VertexIndex b, FeatureSlot feature,
                             const SegmentShape& shape = {});
  void RemoveSegment(SubsegmentIndex s);
  typename SizingField<D>::Index AddSizing(const SizingRegion<D>& region);
  void RemoveSizing(typename SizingField<D>::Index index);
  // 3D: a polygon. The corners of its rings are input points. Its edges are input segments that are
  // present before it is added and are removed after it.
  FacetIndex AddFacet(std::span<const std::vector<VertexIndex>> rings, FeatureSlot feature);
  void RemoveFacet(FacetIndex index);

  // Runs what is due, for the first time or again. `interrupt()` is called before each operation;
  // if it returns true, Propagate returns false. See sac::Engine::Propagate.
  template <class Interrupt>
  bool Propagate(Interrupt interrupt) {
    KeepNetChanges();
    if (!UpdateAnchors(interrupt)) return false;
    if constexpr (D == 3) {
      if (!FillTriangulation(interrupt)) return false;
    }
    if constexpr (!kTraced) BeginUntraced();
    NotifyOfFeatures();
    NotifyOfFacets();
    if constexpr (kTraced) numbers_by_age_ = engine_.IsFromScratch() && free_vertices_.empty();
    first_made_ = static_cast<VertexIndex>(vertices_.size());
    const bool done = RunAll(interrupt);
    numbers_by_age_ = false;
    if (done) appeared_.clear();
    nearest_ = std::vector<Near>();
    return done;
  }

  // Refinement, then cures.
  template <class Interrupt>
  bool RunAll(Interrupt interrupt) {
    if (!slivers_.is_on()) return engine_.Propagate(interrupt);
    if (!engine_.Propagate(interrupt, CureEpoch(0))) return false;
    numbers_by_age_ = false;
    if (!UpdateSlivers(interrupt) || !engine_.Propagate(interrupt)) return false;
    slivers_.Forget();
    return true;
  }

  // From now on neighbourhoods are found in the spatial tree.
  void DetachTriangulation() { triangulation_ = nullptr; }

  // Resets the triangulation to the domain's corners, which are the first vertices.
  void ResetToDomain(Triangulation* triangulation) const;

  // --- Results ---------------------------------------------------------------------

  const Vertex& vertex(VertexIndex v) const { return vertices_[v]; }
  const Subsegment& subsegment(SubsegmentIndex s) const { return subsegments_[s]; }
  std::size_t vertex_count() const { return vertex_count_; }
  bool InMesh(const Subsegment& s) const {
    return s.exposed != sac::kNoStamp && s.death == sac::kNoStamp;
  }

  // Calls on_vertex(index, is, was) and on_subsegment(index, is, was) for those that came or went
  // since the last call. Then forgets those that are gone.
  template <class OnVertex, class OnSubsegment>
  void TakeChanges(OnVertex on_vertex, OnSubsegment on_subsegment);

  // Calls f(vertex index, vertex) / f(subsegment) for those in the mesh.
  template <class F>
  void ForEachVertex(F f) const {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) {
      if (vertices_[v].present) f(v, vertices_[v]);
    }
  }
  template <class F>
  void ForEachSubsegment(F f) const {
    for (const Subsegment& s : subsegments_) {
      if (InMesh(s)) f(s);
    }
  }
  // The same for those that were in the mesh when changes were last taken. May be called at any
  // time.
  template <class F>
  void ForEachTakenVertex(F f) const {
    for (VertexIndex v = 0; v < vertices_.size(); ++v) {
      if (vertices_[v].in_mesh) f(v, vertices_[v]);
    }
  }
  template <class F>
  void ForEachTakenSubsegment(F f) const {
    for (const Subsegment& s : subsegments_) {
      if (s.in_mesh) f(s);
    }
  }
  // Calls f(u) for vertices u near v until f returns true.
  template <class F>
  void ForSomeNeighbours(VertexIndex v, F f) const {
    if constexpr (kTraced) {
      if (IsOfCure(vertices_[v])) {
        for (const VertexIndex u : slivers_[engine_.item(vertices_[v].creator)].v) {
          if (f(u)) return;
        }
      }
      for (sac::OpId o = vertices_[v].operations; o != sac::kNoOp; o = engine_.next_of_item(o)) {
        for (const std::uint32_t u : engine_.reads(o)) {
          if (!Star::IsGhost(u) && f(u)) return;
        }
      }
    }
  }

  // How many operations of kNearest have run so far.
  std::uint64_t nearest_run() const { return nearest_run_; }

  // True if an insertion or a split was refused because it would be finer than limits allow.
  bool hit_depth_limit() const { return hit_depth_limit_; }
  void ForgetDepthLimit() { hit_depth_limit_ = is_full_ = false; }
  // True if the greatest number of vertices, subsegments or simplices is reached. Then what was
  // made must be undone, which may take as many more vertices and subsegments as there were before:
  // outputs have 30 bits for an index.
  bool is_full() const { return is_full_; }
  static constexpr std::size_t kMostElements = std::size_t{1} << 29;
  // The position of the operation at which limits stopped the propagation (sac::EngineLimits).
  std::optional<Point> OverflowAt() const {
    if constexpr (kTraced) {
      const sac::OpId op = engine_.overflowed();
      if (op == sac::kNoOp) return std::nullopt;
      const sac::Item item = engine_.item(op);
      return vertices_[VertexOf(engine_.kind(op), item)].p;
    }
    return std::nullopt;
  }

  // 3D: which vertices are on which facet (facet_work.h).
  const FacetField& facets() const { return facets_; }
  bool IsOnFacet(VertexIndex v, const Facet& facet) const;
  FacetIndex FacetOf(VertexIndex a, VertexIndex b, VertexIndex c, VertexIndex d) const;

  const Rules& rules() const { return rules_; }
  Engine& engine() { return engine_; }
  const Engine& engine() const { return engine_; }
  std::size_t trace_bytes() const;
  std::size_t bytes() const;

  // An operation, to compare traces: hashes of its kind, item and time; and of these and all that
  // it made, requested and read.
  struct OperationHash {
    std::uint64_t identity = 0, whole = 0;
    sac::OpId op = sac::kNoOp;
  };
  // Checks the invariants of engine and program; returns the hash of the whole trace. `operations`,
  // if given, gets all operations in the order of time.
  std::uint64_t Audit(std::vector<std::string>* problems,
                      std::vector<OperationHash>* operations = nullptr) const;
  // For people: kind, item and time of an operation, what it made and what it read.
  std::string Describe(sac::OpId op) const;

  // --- For the engine (engine.h says what these are) --------------------------------

  std::uint64_t Priority(sac::Kind kind, sac::Item item) const;
  bool Before(sac::Kind kind_a, sac::Item a, sac::Kind kind_b, sac::Item b) const;
  sac::OpId& OperationsOf(sac::Kind kind, sac::Item item) {
    if (kind == kCure) return slivers_.operations(item);
    return kind <= kComplete ? vertices_[item].operations : subsegments_[item].operations;
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
  using Gaps = std::conditional_t<D == 2, PlanarGaps<Refinement>, SpaceGaps<Refinement>>;
  friend Gaps;
  friend class TetrahedronGaps<Refinement>;
  // An edge with a gap, or a facet with a missing part, and the point to insert there.
  struct Candidate {
    double e2 = 0;  // squared; at most the distance from the point to its nearest neighbour
    Point neighbour = {};
    bool left = false;  // 2D: the side of the gap, seen from the lesser end of the edge
    int corner = 0;     // 2D: the star's corner in the gap
    Point x = {};
    FeatureSlot facet = kNil;  // the facet on which x lies
    bool required = false;     // a facet needs it: it cannot be left out
  };
  struct Skipped {
    Point neighbour;
    bool left;
  };

  // The border of the domain: a grid of points and, in 2D, the segments between them.
  void AddBox();
  void AddSquare();
  void AddCube();

  // segments.h
  void Presplit(Context& context);
  void Check(Context& context);
  void Split(Context& context);
  void SplitInto(Context& context, SubsegmentIndex s);
  std::pair<VertexIndex, std::array<SubsegmentIndex, 2>> EmitHalves(Context& context,
                                                                    SubsegmentIndex s);
  bool IsTooLong(const Subsegment& s) const;
  bool IsTooLong(const Subsegment& s, const SizingRegion<D>& region) const;
  bool IsTooNear(const Subsegment& s, const InputFeature<D>& feature, double d2) const;
  std::optional<InputFeature<D>> NearestTooNear(const Subsegment& s, double* d2) const;
  double FacetReach2(const Subsegment& s) const;
  bool IsFacetTooNear(const Subsegment& s, bool is_near, double* d2) const;
  bool CanSplit(const Subsegment& s) const;
  bool IsGuarded(const Subsegment& s, int bucket) const;
  VertexIndex EmitVertex(Context& context, const Point& p, int ordinal, int dimension,
                         FeatureSlot feature);
  SubsegmentIndex EmitSubsegment(Context& context, const Subsegment& subsegment);
  struct Shell {
    VertexIndex apex, other;  // of the segment that it is on
    double distance;          // from the apex
  };
  std::pair<Point, std::array<Piece, 2>> SplitOf(const Subsegment& s) const;
  const Subsegment& SplitAt(VertexIndex v) const;
  std::optional<Shell> ShellOf(VertexIndex v) const;
  bool IsSeditious(VertexIndex v, VertexIndex u) const;

  // complete.h
  void Nearest(Context& context);
  void Complete(Context& context);
  bool FindGap(int bucket, Candidate* candidate) const {
    return by_edge() ? ShortestGap(bucket, candidate) : FarthestCorner(bucket, candidate);
  }
  bool FindNext(int bucket, Candidate* next);
  bool by_edge() const { return rules_.criterion() == Criterion::kEdge; }
  // True if whole stars are read off a triangulation, untraced.
  bool is_global() const { return !kTraced && triangulation_ != nullptr; }
  bool ShortestGap(int bucket, Candidate* candidate) const;
  bool FarthestCorner(int bucket, Candidate* candidate) const;
  double NearestInStar() const;
  bool IsTooLargeCorner(int i) const;
  bool IsBeyondBorder(int i) const;
  bool IsInView(const typename Star::Neighbour& u) const {
    return Star::IsUsed(u) && !Star::IsGhost(u.id);
  }
  void RequestNeighbours(Context& context);
  bool IsSkipped(const Point& neighbour, bool left) const;
  bool Owns(VertexIndex u) const;
  [[gnu::always_inline]] inline bool IsOlder(VertexIndex u, VertexIndex v) const;
  bool IsOlder(const Vertex& u, const Vertex& v) const;
  // True if vertices made later have greater indices, as in a run from scratch: operations come in
  // the order of time, and no index is used twice.
  bool NumbersByAge() const { return !kTraced || numbers_by_age_; }
  void PrefetchBeyond(int i) const;
  int NextBucket(int bucket) const;
  void RequestFirstComplete(Context& context, VertexIndex x, double d2);
  sac::Epoch NoEarlierThan(sac::Epoch now, VertexIndex v, VertexIndex x, int own) const;
  void RequestNoEarlierThanNow(Context& context, VertexIndex x, int bucket);
  bool IsOpen() const;
  bool InDomain(const Point& p) const;
  Point CentreOf(int i) const;

  // facet_work.h
  Facet::Edge SegmentOf(VertexIndex v) const;
  bool IsOnNormalsSide(const Facet& facet, VertexIndex a, VertexIndex b, VertexIndex c,
                       VertexIndex d) const;
  double FacetDistance2(VertexIndex v, double d2) const;
  bool FindFacetPoint(Candidate* best);
  bool IsJoinedThrough(const Facet& facet) const;
  void MoveToFacet(Candidate* gap) const;
  void NotifyOfFacets();
  void NotifyOfFacets(const Extent<3>& box, std::span<const Facet> facets);
  bool BoxMatters(sac::OpId op, const Extent<3>& box) const;
  double PresplitReach(sac::OpId op) const;
  bool FacetMatters(sac::OpId op, const Facet& changed) const;

  // cure.h
  struct CureReads {
    CureReads(Context& of, const Point& centre) : context(of), region(centre) {}
    void Read(std::uint32_t ordinal, VertexIndex a, VertexIndex b, VertexIndex c) {
      for (const std::uint32_t word : {ordinal, a, b, c}) context.Read(word);
    }
    Context& context;
    StarRegion<D> region;
    std::uint32_t candidate = 0;  // the one being tested
    bool is_attentive = false;    // a candidate encroached on a subsegment
  };
  bool UpdateSlivers(absl::FunctionRef<bool()> interrupt);
  bool FillBase(Triangulation* base, absl::FunctionRef<bool()> interrupt) const;
  void UpdateBase();
  void Cure(Context& context);
  template <class F>
  bool AnyCureIn(Context& context, const Point& centre, double radius, F f) const;
  VertexIndex UnmakerOf(Context& context, const Sliver& sliver) const;
  static Point CandidateAt(const Sliver& sliver, std::uint32_t ordinal);
  template <class F>
  bool ForEachCandidate(const Sliver& sliver, F f) const;
  std::vector<const Facet*> FacetsNear(const Point& c, double radius) const;
  bool Suits(Context& context, const Sliver& sliver, const Point& x, FeatureSlot facet,
             CureReads* reads);
  void MakeStarOf(Context& context, const Sliver& sliver, const Point& x);
  bool IsGoodCorner(int i, const Sliver& sliver) const;
  bool LeavesFacetsWhole(FeatureSlot on);
  void AddCornerTo(CureReads* reads, int i) const;
  bool CureMatters(sac::OpId op, VertexIndex v, bool appears) const;

  // idle_star.h
  bool ReadIdleStar(Context& context, VertexIndex v, double reach);
  bool AddBallsOfLink(StarRegion<D>* region, double* doubt) const;
  bool MayHaveGap(VertexIndex v) const;

  // star_search.h
  void FindLink(VertexIndex v);
  void FindStar(Context& context, VertexIndex v, double reach);
  void StarFromTriangulation(VertexIndex v, double reach);
  bool LinkFromTriangulation(VertexIndex v, double reach);
  std::uint32_t GhostBeyond(const Point& p) const;
  void SeedStar(Context& context, VertexIndex v);
  void SortByDistance(std::vector<std::uint32_t>* ids);
  void OfferBeyondNeighbours(Context& context);
  double FarthestInView2(double reach) const;
  double MarginOf(double error) const;
  double DistanceInStar2(VertexIndex u) const {
    return geometry::SquaredDistance(vertices_[u].p, star_.position());
  }
  bool UpdateStar(Context& context, VertexIndex v, double reach);
  using Corner = typename CornerSet<D>::Corner;  // by its neighbours
  static Corner Turned(Corner ids);
  bool RebuildStar(Context& context, VertexIndex v, double reach,
                   std::span<const std::uint32_t> ids);
  bool RejoinStar(Context& context, VertexIndex v, double reach,
                  std::span<const std::uint32_t> words, bool* all_stay);
  void MarkOldCorners(std::span<const std::uint32_t> words);
  bool Stays(const Context& context, std::uint32_t id) const;
  void Offer(Context& context, std::uint32_t id);
  void VerifyStar(Context& context);
  bool InsertAllInCorners(Context& context);
  bool VerifyCorner(Context& context, int i);

  // neighbourhood.h
  struct Near {
    double d2 = INFINITY;  // squared distance
    VertexIndex v = kNil;  // any vertex at that distance
  };
  Near NearestTo(Context& context, VertexIndex v);
  void FindAllNearest();
  bool FindEncroaching(Context& context, SubsegmentIndex s);
  bool FindHiding(const Subsegment& sub);
  bool FindEncroachingInTriangulation(SubsegmentIndex s) const;
  void FindEncroached(Context& context, const Point& x);
  bool IsVisible(const Context& context, const Subsegment& s) const;
  void SubscribeBox(Context& context, const Extent<D>& box);
  void SubscribePoint(Context& context, const Point& p);
  Extent<D> BallOf(const Subsegment& s) const;
  double RadiusOf(const Subsegment& s) const;

  // changes.h
  VertexIndex VertexOf(sac::Kind kind, sac::Item item) const;
  Point CentreOfReads(sac::OpId op) const;
  VertexIndex NewVertex();
  SubsegmentIndex NewSubsegment();
  void PublishVertex(VertexIndex v, sac::Stamp at);
  bool InsertIntoTriangulation(VertexIndex v);
  void WithdrawVertex(VertexIndex v, sac::Stamp at);
  void MovePlaces(std::uint32_t first_child, std::uint32_t parent);
  void NotifyOfVertex(VertexIndex v, bool appears, sac::Stamp at);
  bool VertexMatters(sac::OpId op, VertexIndex v, bool appears) const;
  bool NearestMatters(sac::OpId op, VertexIndex v, bool appears) const;
  bool ConflictsWithStar(sac::OpId op, const Point& y) const;
  Point PlaceOf(std::uint32_t id, const Point& p, double reach) const;
  bool ConflictsWithRing(std::span<const std::uint32_t> ring, const Point& p, double reach,
                         const Point& y) const;
  std::optional<Corner> CornerTowards(std::span<const std::uint32_t> words, const Point& p,
                                      double reach, const std::array<double, D>& direction) const;
  std::optional<typename SpatialTree<D>::Ball> BallOfCorner(sac::OpId op, const Corner& ids) const;
  bool ConflictsWithLink(std::span<const std::uint32_t> words, const Point& p, double reach,
                         const Point& y) const;
  void NotifyOfSubsegment(SubsegmentIndex s, sac::Stamp after, sac::Stamp until);
  template <class Keep, class Matters>
  void NotifyFromBeginning(const Extent<D>& box, Keep keep, Matters matters);
  // anchors.h
  using Lattice = AnchorLattice<D>;
  int WidestLevel() const;
  bool IsInUse(int level) const;
  template <class F>
  bool ForEachLevel(int own, F f) const;
  int LevelAt(const Point& x) const;
  std::set<int> LevelsInUse() const;
  bool IsAnchor(int level, const Point& x) const;
  bool MayHaveLevel(int level, const Point& centre, double radius) const;
  void AddSize(const SizingRegion<D>& region);
  void RemoveSize(const SizingRegion<D>& region);
  bool UpdateAnchors(absl::FunctionRef<bool()> interrupt);
  void DecideAnchor(const typename Lattice::Place& place, const Point& x);
  VertexIndex AddAnchor(const Point& p);
  void RemoveAnchor(VertexIndex v);

  // facet_anchors.h
  struct FacetSurroundings {
    double feature, edge;  // distances
  };
  double FacetSpacing() const;
  FacetSurroundings Around(const Facet& facet, const Point& x, double radius, double margin) const;
  bool MayHaveAnchors(const Facet& facet) const;
  static bool IsWithinReach(const Facet& facet, const InputFeature<D>& f);
  static bool HasCornerOver(const Facet& facet, const Facet& other);
  static bool IsWithinReach(const Facet& facet, const Facet& other);
  bool HasEdgeWithin(const Facet& facet, const Point& x, double radius) const;
  bool IsFacetAnchor(const Facet& facet, const FacetLattice& lattice, int level,
                     const Point& x) const;
  template <class FeatureChanged, class SizeChanged, class Decide>
  bool VisitLattice(const Facet& facet, const FacetLattice& lattice, const FacetLattice::Cell& cell,
                    const FeatureChanged& feature_changed, const SizeChanged& size_changed,
                    Decide decide) const;
  template <class FeatureChanged, class SizeChanged>
  bool UpdateFacetAnchors(FacetIndex i, const FeatureChanged& feature_changed,
                          const SizeChanged& size_changed, absl::FunctionRef<bool()> interrupt);
  void DecideFacetAnchor(FacetIndex facet, const FacetLattice::Index& index, const Point& x,
                         bool is);
  bool UpdateFacetAnchors(absl::FunctionRef<bool()> interrupt);

  void IndexFeatures();
  void KeepNetChanges();
  static Extent<D> BoxOf(const InputFeature<D>& feature);
  InputFeature<D> FeatureOf(VertexIndex a, VertexIndex b) const;
  void AddFeature(const InputFeature<D>& feature);
  void RemoveFeature(const InputFeature<D>& feature);
  void NotifyOfFeatures();
  bool FeatureMatters(sac::OpId op, const InputFeature<D>& feature, bool appears) const;
  void NotifyOfSizing(const SizingRegion<D>& region);
  bool SizingMatters(sac::OpId op, const SizingRegion<D>& region) const;
  void SetExposed(SubsegmentIndex s, sac::Stamp at);
  void HideSubsegment(SubsegmentIndex s);
  sac::Stamp NextDeath(const Subsegment& s, sac::Stamp except) const;
  void MarkChanged(VertexIndex v);
  void MarkSubsegmentChanged(SubsegmentIndex s);
  void BeginUntraced();
  bool FillTriangulation(absl::FunctionRef<bool()> interrupt);
  void LeaveTriangulation();
  void RequestFirstGaps();
  void RequestFirstGap(VertexIndex v);
  std::uint64_t HashOfSubsegment(const Subsegment& s) const;

  Rules rules_;
  Limits limits_;
  Triangulation* triangulation_;
  Triangulation* const domain_;  // the one given
  SpatialTree<D> tree_;
  SizingField<D> sizing_;
  InputFeatures<D> features_;  // of the input; empty while there are only points
  bool indexes_features_ = false;
  std::map<int, int> levels_;  // of sizing regions: their own levels, with counts
  absl::flat_hash_map<typename AnchorLattice<D>::Place, VertexIndex> anchors_;
  bool had_sizes_ = false;                      // at the last Propagate
  std::vector<SizingRegion<D>> changed_sizes_;  // came or went since the last Propagate
  std::vector<std::pair<InputFeature<D>, bool>> changed_features_;  // since the last Propagate
  FacetField facets_;                                               // empty in 2D
  SliverTable slivers_;                                             // empty in 2D
  SpatialTree<D> cured_;                   // the vertices of cures; these are not in tree_
  std::vector<VertexIndex> changed_base_;  // other vertices that came or went since cures ran
  std::vector<Facet> changed_facets_;      // came or went since the last Propagate
  std::vector<FacetIndex> new_facets_;     // came since then and are present
  absl::flat_hash_map<FacetIndex, absl::flat_hash_map<FacetLattice::Index, VertexIndex>>
      facet_anchors_;
  LargeVector<Vertex> vertices_;
  LargeVector<Subsegment> subsegments_;
  std::vector<VertexIndex> free_vertices_;
  std::vector<SubsegmentIndex> free_subsegments_;
  std::size_t vertex_count_ = 0;
  bool box_only_ = true;  // no client segment has ever been added
  bool hit_depth_limit_ = false;
  bool is_full_ = false;
  bool looked_for_gaps_ = false;
  bool numbers_by_age_ = false;
  VertexIndex first_made_ = 0;  // vertices of the input have lower indices
  VertexIndex near_ = 0;        // a vertex near the next published one
  // The triangle with the gap that the next published vertex fills, if known.
  std::uint32_t gap_triangle_ = Triangulation::kNone;
  // The bucket of the gap that a vertex last filled, by the vertex's ordinal in its operation.
  std::array<std::uint16_t, kMostOutputs> gap_buckets_ = {};
  sac::Subscriptions exposures_;  // by place: subsegments with balls that meet the cell

  std::uint64_t nearest_run_ = 0;
  std::vector<Near> nearest_;  // from scratch: by vertex; computed at the first query

  // Vertices published since the last completed propagation.
  std::vector<VertexIndex> appeared_;
  std::vector<VertexIndex> changed_vertices_, released_vertices_;
  std::vector<SubsegmentIndex> changed_subsegments_, released_subsegments_;

  // Scratch of the operation being executed.
  Star star_;
  CellCut cut_;
  std::vector<Skipped> skipped_;
  std::vector<SubsegmentIndex> encroached_;
  std::vector<bool> encroached_strictly_;
  std::vector<VertexIndex> witnesses_, on_surface_, far_;
  CornerSet<D> old_corners_;
  std::vector<std::uint32_t> offers_;
  std::vector<std::pair<double, std::uint32_t>> by_distance_;
  std::vector<typename SpatialTree<D>::Ball> balls_;
  std::vector<typename Triangulation::Corner> corners_;
  std::vector<VertexIndex> pending_;  // 3D: not yet in the triangulation
  mesh::DelaunayTetrahedralization::Cavity cavity_;
  mesh::NumberTable<1> rim_;
  mesh::DelaunayTetrahedralization::VertexLink link_;

  Engine engine_;
};

extern template class Refinement<2, sac::Engine>;
extern template class Refinement<2, sac::UntracedEngine>;
extern template class Refinement<3, sac::Engine>;
extern template class Refinement<3, sac::UntracedEngine>;

template <int D, template <class> class E>
template <class OnVertex, class OnSubsegment>
void Refinement<D, E>::TakeChanges(OnVertex on_vertex, OnSubsegment on_subsegment) {
  for (const VertexIndex v : changed_vertices_) {
    Vertex& vertex = vertices_[v];
    vertex.changed = false;
    on_vertex(v, vertex.present, vertex.in_mesh);
    vertex.in_mesh = vertex.present;
  }
  for (const SubsegmentIndex s : changed_subsegments_) {
    Subsegment& sub = subsegments_[s];
    sub.changed = false;
    const bool is = InMesh(sub);
    on_subsegment(s, is, sub.in_mesh);
    sub.in_mesh = is;
  }
  changed_vertices_.clear();
  changed_subsegments_.clear();
  free_vertices_.insert(free_vertices_.end(), released_vertices_.begin(), released_vertices_.end());
  free_subsegments_.insert(free_subsegments_.end(), released_subsegments_.begin(),
                           released_subsegments_.end());
  released_vertices_.clear();
  released_subsegments_.clear();
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_REFINEMENT_H_
