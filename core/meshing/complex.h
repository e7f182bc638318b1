// The complex that refinement makes: its elements, the indices over them, the input beside which
// they are made, and the run that makes them. Procedures see it const. These change it:
//   emitter.h              new elements, not yet visible
//   publisher.h            what becomes visible, and stops being so
//   input_editor.h         the input, between runs
//   input_triangulation.h, sliver_base.h   triangulations as a whole; which slivers there are
// Nothing here notifies an operation.
#ifndef DYNMESH_CORE_MESHING_COMPLEX_H_
#define DYNMESH_CORE_MESHING_COMPLEX_H_

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/rounding.h"
#include "core/geometry/angles.h"
#include "core/geometry/constructions.h"
#include "core/meshing/element_store.h"
#include "core/meshing/facet_field.h"
#include "core/meshing/input_features.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/run.h"
#include "core/meshing/sharp_facets.h"
#include "core/meshing/sizing_field.h"
#include "core/meshing/sliver_table.h"
#include "core/meshing/spatial_tree.h"
#include "core/meshing/types.h"
#include "core/meshing/unsplit_balls.h"
#include "core/sac/subscriptions.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

// So many subscribe to a leaf of the vertex tree, or so many balls of subsegments are kept there,
// before it is split for the next ones. Leaves merge if half as many remain.
inline constexpr std::size_t kCrowd = 48;

// What is part of the trace's time, and so is read as of an operation: vertices from their birth
// on, subsegments from their exposure to their death. The rest stands outside of time: input
// features, facets and sizes change between propagations only; tree, exposures and triangulation
// are found through, and hold what is there now.
template <int D, template <class> class E>
struct Complex {
  using Engine = EngineOf<D, E>;
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Vertex = meshing::Vertex<D>;
  using Subsegment = meshing::Subsegment<D>;
  using Rules = RulesOf<D>;
  using Triangulation = TriangulationOf<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  Complex(const MeshOptions& options, const Engine& engine, Triangulation* triangulation);

  // --- Elements ---------------------------------------------------------------------------

  Vertex& vertex(VertexIndex v) { return elements.vertex(v); }
  const Vertex& vertex(VertexIndex v) const { return elements.vertex(v); }
  Subsegment& subsegment(SubsegmentIndex s) { return elements.subsegment(s); }
  const Subsegment& subsegment(SubsegmentIndex s) const { return elements.subsegment(s); }
  // The vertex appears or vanishes. REQUIRES: this is a change.
  void SetPresent(VertexIndex v, bool is) {
    if (slivers.is_on() && !IsOfCure(vertex(v))) changed_base.push_back(v);
    elements.SetPresent(v, is);
  }

  // True if u was born before v: in an earlier epoch or by an earlier operation. Of two vertices
  // born together in segment work or with the input, the one of lesser hash is older.
  [[gnu::always_inline]] inline bool IsOlder(VertexIndex u, VertexIndex v) const;

  bool IsVisible(const Context& context, const Subsegment& s) const {
    return s.exposed != sac::kNoStamp && context.Sees(s.exposed) &&
           !(s.death != sac::kNoStamp && context.Sees(s.death));
  }
  double SquaredLength(const Subsegment& s) const {
    return geometry::SquaredDistance(vertex(s.a).p, vertex(s.b).p);
  }
  // A little more than the radius of the diametral ball: its centre is rounded.
  double RadiusOf(const Subsegment& s) const;
  // The box of that ball.
  Extent<D> BallOf(const Subsegment& s) const;
  std::uint64_t HashOf(const Subsegment& s) const {
    return geometry::HashOf(vertex(s.a).p) + 3 * geometry::HashOf(vertex(s.b).p);
  }

  // --- What a vertex lies on ----------------------------------------------------------------

  // The vertex whose Complete made v, or an end of the subsegment that was split at v. REQUIRES: a
  // procedure but kCure made v.
  VertexIndex MakerOf(VertexIndex v) const {
    const sac::Item item = ItemOfCreator(v);
    return vertex(v).dimension == 1 ? subsegment(item).a : item;
  }
  // The subsegment that was split at v. REQUIRES: v has containing dimension 1.
  const Subsegment& SplitAt(VertexIndex v) const;
  // The ends of the input segment that v, of containing dimension 1, lies on.
  Facet::Edge SegmentOf(VertexIndex v) const;
  bool IsOnFacet(VertexIndex v, const Facet& facet) const;
  // Calls f(facet) for the facets with v inside, on an edge or at a corner.
  template <class F>
  void ForEachFacetOf(VertexIndex v, F f) const;
  // 3D. What owns v, which is inside a facet or a segment.
  OwnedVertex OwnedVertexOf(VertexIndex v) const;
  // True if both lie on one shell, on segments that meet at a small angle; or on facets that do, as
  // sharp_facets.h says.
  bool IsSeditious(VertexIndex v, VertexIndex u) const;
  // 3D. True if two opposite edges are seditious and a corner is a counterpart. Then the
  // tetrahedron is flat within rounding if it has a common axis: its corners are those of a
  // trapezoid across it.
  bool IsFlatByCounterparts(const std::array<VertexIndex, 4>& v) const;

  // --- Input ------------------------------------------------------------------------------

  // The point a (b = a) or the segment ab.
  InputFeature<D> FeatureOf(VertexIndex a, VertexIndex b) const {
    return {a, b, vertex(a).p, vertex(b).p};
  }
  bool InDomain(const Point& p) const;
  // True if the ball is too large for a sizing region.
  bool IsTooLarge(const Point& centre, double r2) const {
    return !sizing.empty() && IsOn(RefinementTerm::kSizesCount) &&
           r2 > rules.least_squared_length() && sizing.IsTooLarge(centre, std::sqrt(r2));
  }

  // --- How neighbourhoods are found -----------------------------------------------------------

  bool by_edge() const { return rules.criterion() == Criterion::kEdge; }
  // What follows from the neighbourhoods of the run (run.h). Constants, if it is traced.
  bool is_global() const { return !kTraced && run.neighbourhoods() == Neighbourhoods::kGlobal; }
  // True if all vertices are in the tree. Else a triangulation answers everything except what a
  // point encroaches on: the tree need only be as fine as the subsegments.
  bool needs_tree() const { return kTraced || !run.has_triangulation(); }
  // Records that the operation reads what is in the box.
  void Subscribe(Context& context, const Extent<D>& box) const {
    if constexpr (kTraced) {
      const auto subscribe = [&](sac::Place place, sac::Parts parts) {
        context.Subscribe(place, parts);
      };
      if (box.lo == box.hi) return tree.Cover(box, subscribe);  // no cell is too large for a point
      const auto is_crowded = [&](sac::Place place) {
        return engine.subscriptions().CountAt(place) >= kCrowd;
      };
      tree.CoverToKeep(box, is_crowded, subscribe);
    }
  }
  // Resets the triangulation to the domain's corners, which are the first vertices.
  void ResetToDomain(Triangulation* to) const;
  // True if the greatest number of vertices, subsegments or simplices is reached.
  bool is_full() const { return run.filled_triangulation() || elements.is_full(); }
  std::size_t bytes() const;

  Rules rules;
  Limits limits;
  const Engine& engine;  // tells times apart
  ElementStore<D> elements;

  // Vertices, but those of cures. What subscribes may split leaves, which no result depends on.
  mutable SpatialTree<D> tree;
  SpatialTree<D> cured;          // the vertices of cures
  sac::Subscriptions exposures;  // by place: subsegments with balls that meet the cell
  // Vertices published since the last completed propagation.
  std::vector<VertexIndex> appeared;

  SizingField<D> sizing;
  InputFeatures<D> features;  // empty while there are only points
  UnsplitBalls<D> unsplit;    // of segments that stay whole
  FacetField facets;          // empty in 2D
  SliverTable slivers;        // empty in 2D
  // Vertices but those of cures that came or went since cures ran.
  std::vector<VertexIndex> changed_base;

  bool border_only = true;  // no client segment has ever been added

  meshing::Run<D> run;

 private:
  bool IsOlder(const Vertex& u, const Vertex& v) const;
  bool AreOnOneShell(VertexIndex v, VertexIndex u) const;
  // What v is the counterpart of, and that of, and so on. v if it is no counterpart.
  VertexIndex OriginOf(VertexIndex v) const;
  // The subsegment that was split on a shell at v or its origin; null if there is none. ApexOf: of
  // the shell. TowardsOf: the segment's other end, or v.
  const Subsegment* SplitOnShell(VertexIndex v) const;
  VertexIndex ApexOf(const Subsegment& split) const {
    return split.split_rule.from_b ? split.whole_b : split.whole_a;
  }
  const Point& TowardsOf(VertexIndex v, const Subsegment& split) const;
  bool HaveOneOrigin(VertexIndex v, VertexIndex u) const;
  bool IsCounterpart(VertexIndex v) const { return elements.origin(v).of != kNil; }
  bool HasAxis(VertexIndex v) const { return elements.origin(v).axis != kNoAxis; }
  // What v's creator worked on: a vertex, or the subsegment that it split.
  sac::Item ItemOfCreator(VertexIndex v) const;
};

// --- Implementation -------------------------------------------------------------------------

namespace internal {
inline geometry::Point3 FacetBox(const geometry::Point3& p) { return p; }
inline geometry::Point3 FacetBox(const geometry::Point2&) { return {}; }
}  // namespace internal

template <int D, template <class> class E>
Complex<D, E>::Complex(const MeshOptions& options, const Engine& times, Triangulation* given)
    : rules(options),
      limits(options.limits),
      engine(times),
      tree(rules.lo(), rules.hi()),
      cured(rules.lo(), rules.hi()),
      sizing(rules.lo(), rules.hi()),
      features(rules.lo(), rules.hi()),
      unsplit(rules.lo(), rules.hi()),
      facets(internal::FacetBox(rules.lo()), internal::FacetBox(rules.hi())),
      slivers(D == 3 ? std::max(options.min_dihedral, kFlat) : 0),
      run(given, kTraced, rules.criterion()) {}

// In a run from scratch the indices decide, unless both vertices are of the input or of the same
// segment work. Then u's record, which is anywhere in memory, is not read.
template <int D, template <class> class E>
inline bool Complex<D, E>::IsOlder(VertexIndex u, VertexIndex v) const {
  if (!kTraced || run.numbers_by_age()) {
    const sac::Epoch birth = vertex(v).epoch;
    if (IsQualityEpoch(birth) || (birth == kBirthOfInput && u >= run.first_made())) {
      assert((u < v) == IsOlder(vertex(u), vertex(v)));
      return u < v;
    }
  }
  return IsOlder(vertex(u), vertex(v));
}

template <int D, template <class> class E>
bool Complex<D, E>::IsOlder(const Vertex& u, const Vertex& v) const {
  if (u.epoch != v.epoch) return u.epoch < v.epoch;
  if (IsQualityEpoch(u.epoch)) {
    if (u.birth != v.birth) return engine.Precedes(u.birth, v.birth);
    return u.ordinal < v.ordinal;
  }
  const std::uint64_t hu = geometry::HashOf(u.p), hv = geometry::HashOf(v.p);
  return hu != hv ? hu < hv : u.p < v.p;
}

template <int D, template <class> class E>
double Complex<D, E>::RadiusOf(const Subsegment& s) const {
  return std::sqrt(SquaredLength(s)) / 2 * kWider + 2 * rules.ulp();
}

template <int D, template <class> class E>
Extent<D> Complex<D, E>::BallOf(const Subsegment& s) const {
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(geometry::Midpoint(vertex(s.a).p, vertex(s.b).p), RadiusOf(s));
  return box;
}

template <int D, template <class> class E>
const Subsegment<D>& Complex<D, E>::SplitAt(VertexIndex v) const {
  return subsegment(ItemOfCreator(v));
}

template <int D, template <class> class E>
Facet::Edge Complex<D, E>::SegmentOf(VertexIndex v) const {
  const Subsegment& split = SplitAt(v);
  return std::minmax(split.whole_a, split.whole_b);
}

template <int D, template <class> class E>
bool Complex<D, E>::IsOnFacet(VertexIndex v, const Facet& facet) const {
  const Vertex& on = vertex(v);
  if (on.dimension == 0) return facet.HasCorner(v);
  if (on.dimension == 2) return on.feature == facet.feature();
  if (on.dimension == D) return false;
  const auto [a, b] = SegmentOf(v);
  return facet.HasEdge(a, b);
}

template <int D, template <class> class E>
const Subsegment<D>* Complex<D, E>::SplitOnShell(VertexIndex v) const {
  const VertexIndex origin = OriginOf(v);
  if (vertex(origin).dimension != 1) return nullptr;
  const Subsegment& s = SplitAt(origin);
  if (s.split_rule.kind != SplitRule::Kind::kShells) return nullptr;
  const VertexIndex apex = ApexOf(s);
  for (VertexIndex of = v; IsCounterpart(of); of = elements.origin(of).of) {
    if (!std::ranges::count(elements.origin(of).axis, apex)) return nullptr;
  }
  return &s;
}

template <int D, template <class> class E>
const geometry::Point<D>& Complex<D, E>::TowardsOf(VertexIndex v, const Subsegment& split) const {
  return vertex(IsCounterpart(v) ? v : split.split_rule.from_b ? split.whole_a : split.whole_b).p;
}

template <int D, template <class> class E>
VertexIndex Complex<D, E>::OriginOf(VertexIndex v) const {
  while (IsCounterpart(v)) v = elements.origin(v).of;
  return v;
}

template <int D, template <class> class E>
sac::Item Complex<D, E>::ItemOfCreator(VertexIndex v) const {
  if constexpr (kTraced) {
    return engine.item(vertex(v).creator);
  } else {
    return vertex(v).creator;
  }
}

template <int D, template <class> class E>
template <class F>
void Complex<D, E>::ForEachFacetOf(VertexIndex v, F f) const {
  const Vertex& on = vertex(v);
  if (on.dimension == D) return;
  if (on.dimension == 2) return f(facets[facets.OfFeature(on.feature)]);
  const auto [a, b] = on.dimension == 0 ? Facet::Edge(v, v) : SegmentOf(v);
  for (const FacetIndex i : facets.AtCorner(a)) {
    if (on.dimension == 0 || facets[i].HasEdge(a, b)) f(facets[i]);
  }
}

template <int D, template <class> class E>
OwnedVertex Complex<D, E>::OwnedVertexOf(VertexIndex v) const {
  OwnedVertex owned;
  if constexpr (D == 3) {
    owned.p = vertex(v).p;
    if (vertex(v).dimension == 2) {
      owned.facet = &facets[facets.OfFeature(vertex(v).feature)];
    } else {
      const auto [a, b] = SegmentOf(v);
      owned.ends = {a, b};
      owned.positions = {vertex(a).p, vertex(b).p};
    }
    owned.is_counterpart = IsCounterpart(v);
    if (const Subsegment* split = SplitOnShell(v)) {
      owned.apex = ApexOf(*split);
      owned.origin = vertex(OriginOf(v)).p;
    }
  }
  return owned;
}

template <int D, template <class> class E>
bool Complex<D, E>::IsSeditious(VertexIndex v, VertexIndex u) const {
  if (!IsOn(RefinementTerm::kSeditiousIsExempt)) return false;
  return HaveOneOrigin(v, u) || AreOnOneShell(v, u);
}

template <int D, template <class> class E>
bool Complex<D, E>::HaveOneOrigin(VertexIndex v, VertexIndex u) const {
  if (!IsCounterpart(v) && !IsCounterpart(u) && !(HasAxis(v) && HasAxis(u))) return false;
  // The corners that all counterparts from the origin on have their distance from in common.
  Axis common = kNoAxis;
  bool is_first = true;
  const auto narrow = [&](const Axis& axis) {
    for (VertexIndex& c : common) {
      if (!is_first && !std::ranges::count(axis, c)) c = kNil;
    }
    if (is_first) common = axis;
    is_first = false;
  };
  const auto origin = [&](VertexIndex of) {
    for (; IsCounterpart(of); of = elements.origin(of).of) narrow(elements.origin(of).axis);
    return of;
  };
  const VertexIndex of_v = origin(v), of_u = origin(u);
  if (of_v != of_u) {  // then they must be the same point of one lattice
    if (!HasAxis(of_v) || elements.origin(of_v) != elements.origin(of_u)) return false;
    narrow(elements.origin(of_v).axis);
  }
  const double chord2 = geometry::SquaredDistance(vertex(v).p, vertex(u).p);
  return std::ranges::any_of(common, [&](VertexIndex c) {
    return c != kNil && chord2 < geometry::SquaredDistance(vertex(v).p, vertex(c).p);
  });
}

template <int D, template <class> class E>
bool Complex<D, E>::IsFlatByCounterparts(const std::array<VertexIndex, 4>& v) const {
  if (std::ranges::none_of(v, [this](VertexIndex a) { return HasAxis(a); })) return false;
  const auto is_pair = [this](VertexIndex a, VertexIndex b) { return IsSeditious(a, b); };
  return (is_pair(v[0], v[1]) && is_pair(v[2], v[3])) ||
         (is_pair(v[0], v[2]) && is_pair(v[1], v[3])) ||
         (is_pair(v[0], v[3]) && is_pair(v[1], v[2]));
}

template <int D, template <class> class E>
bool Complex<D, E>::AreOnOneShell(VertexIndex v, VertexIndex u) const {
  const auto may_be = [this](VertexIndex w) {
    return vertex(w).dimension == 1 || IsCounterpart(w);
  };
  if (!may_be(v) || !may_be(u)) return false;
  const Subsegment *of_v = SplitOnShell(v), *of_u = SplitOnShell(u);
  if (of_v == nullptr || of_u == nullptr || ApexOf(*of_v) != ApexOf(*of_u)) return false;
  const Point &to_v = TowardsOf(v, *of_v), &to_u = TowardsOf(u, *of_u);
  return to_v != to_u && geometry::IsSmallAngle(vertex(ApexOf(*of_v)).p, to_v, to_u) &&
         SplitDistance(of_v->split_rule) == SplitDistance(of_u->split_rule);
}

template <int D, template <class> class E>
bool Complex<D, E>::InDomain(const Point& p) const {
  const Point &lo = rules.lo(), &hi = rules.hi();
  for (int k = 0; k < D; ++k) {
    if (!(lo[k] <= p[k] && p[k] <= hi[k])) return false;
  }
  return true;
}

template <int D, template <class> class E>
void Complex<D, E>::ResetToDomain(Triangulation* to) const {
  std::array<VertexIndex, 1 << D> corners;
  for (VertexIndex v = 0; v < corners.size(); ++v) corners[v] = v;
  to->Reset(rules.lo(), rules.hi(), corners);
}

template <int D, template <class> class E>
std::size_t Complex<D, E>::bytes() const {
  return elements.bytes() + tree.bytes() + cured.bytes() + slivers.bytes() + sizing.bytes() +
         features.bytes() + unsplit.bytes() + facets.bytes();
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_COMPLEX_H_
