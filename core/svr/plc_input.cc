#include "core/svr/plc_input.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"
#include "core/geometry/predicates.h"
#include "core/meshing/border.h"
#include "core/meshing/facet_membership.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/splits.h"
#include "core/svr/hilbert_order.h"

namespace dynmesh::svr {

template <int D>
PlcInput<D>::PlcInput(const MeshOptions& options)
    : complex_(options, engine_, nullptr), balls_(complex_.rules.lo(), complex_.rules.hi()) {
  // The sides of the square need no protection: nothing is inserted outside of them.
  meshing::AddBorder(complex_, *this);
  border_count_ = complex_.elements.vertex_end();
  for (VertexIndex v = 0; v < border_count_; ++v) SetPresent(v);
  meshing::AddMaxEdge<D>(options, *this);
}

template <int D>
Options<D> PlcInput<D>::options() const {
  return {.lo = complex_.rules.lo(),
          .hi = complex_.rules.hi(),
          .border_cells = complex_.rules.grid_cells(),
          .quality = complex_.rules.quality()};
}

template <int D>
VertexIndex PlcInput<D>::NewVertex(const Point& p, int dimension, meshing::FeatureSlot feature) {
  const VertexIndex v = complex_.elements.NewVertex();
  Vertex& vertex = complex_.vertex(v);
  vertex.p = p;
  vertex.dimension = static_cast<std::uint8_t>(dimension);
  vertex.feature = feature;
  return v;
}

template <int D>
VertexIndex PlcInput<D>::AddPoint(const Point& p, meshing::FeatureSlot feature) {
  return NewVertex(p, 0, feature);
}

template <int D>
SubsegmentIndex PlcInput<D>::AddSegment(VertexIndex a, VertexIndex b, meshing::FeatureSlot feature,
                                        const meshing::SegmentShape& shape) {
  const SubsegmentIndex s = complex_.elements.NewSegment(a, b, feature);
  Subsegment& sub = complex_.subsegment(s);
  sub.split_rule = meshing::SplitRule::Whole(shape, meshing::LengthOf(position(a), position(b)));
  if (sub.split_rule.kind != meshing::SplitRule::Kind::kHalve) has_wedges_ = true;
  sub.exposed = 0;
  complex_.elements.MarkSubsegmentChanged(s);
  if (feature != 0) wholes_.push_back(s);
  return s;
}

template <int D>
FacetIndex PlcInput<D>::AddFacet(std::span<const std::vector<VertexIndex>> rings,
                                 meshing::FeatureSlot feature) {
  if constexpr (D == 3) {
    return complex_.facets.Add(
        meshing::Facet(rings, feature, [this](VertexIndex v) { return position(v); }));
  }
  return kNone;
}

template <int D>
std::vector<typename PlcInput<D>::Point> PlcInput<D>::positions() const {
  std::vector<Point> all(complex_.elements.vertex_end());
  for (VertexIndex v = 0; v < all.size(); ++v) all[v] = position(v);
  return all;
}

// Also protects the segments, in an order that depends on positions alone.
template <int D>
std::vector<VertexIndex> PlcInput<D>::Waiting() {
  std::sort(wholes_.begin(), wholes_.end(), [&](SubsegmentIndex s, SubsegmentIndex t) {
    const Subsegment &of_s = subsegment(s), &of_t = subsegment(t);
    return std::pair(position(of_s.a), position(of_s.b)) <
           std::pair(position(of_t.a), position(of_t.b));
  });
  for (const SubsegmentIndex s : wholes_) AddBall(s);
  std::vector<Point> points;
  for (VertexIndex v = border_count_; v < complex_.elements.vertex_end(); ++v) {
    points.push_back(position(v));
  }
  std::vector<VertexIndex> order = HilbertOrder(points, options());
  for (VertexIndex& v : order) v += border_count_;
  return order;
}

template <int D>
VertexIndex PlcInput<D>::AddSteiner(const SteinerPoint<D>& steiner) {
  if (steiner.facet == kNone) return NewVertex(steiner.p, D, meshing::kNil);
  const VertexIndex v = NewVertex(steiner.p, 2, complex_.facets[steiner.facet].feature());
  if (steiner.of != kNone) {
    complex_.elements.SetOrigin(v, {steiner.of, steiner.axis});
    has_wedges_ = true;
  }
  return v;
}

template <int D>
double PlcInput<D>::SquaredShortestEdge(const Kernel<D>& mesh, SimplexIndex s) const {
  if (!has_wedges_) return svr::SquaredShortestEdge<D>(mesh, s);
  const auto& v = mesh.vertices(s);
  double least = INFINITY;
  for (int i = 0; i < D; ++i) {
    for (int j = i + 1; j <= D; ++j) {
      const double e2 = geometry::SquaredDistance(mesh.position(v[i]), mesh.position(v[j]));
      if (e2 < least && !complex_.IsSeditious(v[i], v[j])) least = e2;
    }
  }
  return least;
}

// --- Subsegments ----------------------------------------------------------------------------

template <int D>
void PlcInput<D>::AddBall(SubsegmentIndex s) {
  const Subsegment& of = complex_.subsegment(s);
  const Point middle = geometry::Midpoint(position(of.a), position(of.b));
  if (s >= balls_of_.size()) balls_of_.resize(s + 1 + s / 2, kNone);
  balls_of_[s] = balls_.Add({s, middle, middle, complex_.RadiusOf(of)});
}

template <int D>
bool PlcInput<D>::CanSplit(SubsegmentIndex s) {
  if (meshing::CanSplit(complex_, complex_.subsegment(s))) return true;
  complex_.run.NoteDepthLimit();
  return false;
}

template <int D>
bool PlcInput<D>::IsGuarded(SubsegmentIndex s, double e2) const {
  return e2 > 0 && meshing::IsGuarded(complex_, complex_.subsegment(s), meshing::BucketOf(e2));
}

template <int D>
VertexIndex PlcInput<D>::Split(SubsegmentIndex s) {
  const Subsegment whole = complex_.subsegment(s);
  const auto [p, rules] = meshing::SplitOf(complex_, whole);
  const VertexIndex v = NewVertex(p, 1, whole.feature);
  complex_.vertex(v).creator = s;
  complex_.subsegment(s).death = kDead;
  balls_.Remove(balls_of_[s]);
  if (s >= parts_.size()) parts_.resize(s + 1 + s / 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const SubsegmentIndex part = parts_[s][i] = complex_.elements.NewSubsegment();
    Subsegment& of = complex_.subsegment(part);
    of = whole;
    (i == 0 ? of.b : of.a) = v;
    of.split_rule = rules[i];
    ++of.depth;
    of.changed = false;
    complex_.elements.MarkSubsegmentChanged(part);
    AddBall(part);
  }
  return v;
}

// --- Facets ---------------------------------------------------------------------------------

template <int D>
void PlcInput<D>::FindNeighbours(const Kernel<D>& mesh, VertexIndex v) {
  if constexpr (D == 3) {
    neighbours_.clear();
    svr::FindNeighbours<D>(mesh, v, &star_, &found_);
    for (const VertexIndex u : found_) {
      const auto d = geometry::Difference(position(u).c, position(v).c);
      neighbours_.push_back({u, position(u), d, geometry::Dot(d, d), 1});
    }
  }
}

template <int D>
std::optional<SteinerPoint<D>> PlcInput<D>::FindFacetPoint(const Kernel<D>& mesh, VertexIndex v) {
  std::optional<SteinerPoint<D>> best;
  if constexpr (D == 3) {
    const Point& p = position(v);
    double far2 = 0;
    star_.ForEach(mesh, v, [&](SimplexIndex s) {
      if (!mesh.IsInfinite(s)) far2 = std::max(far2, BallOf(mesh, s).r2);
    });
    const double far = std::sqrt(far2) * kWider;
    double most2 = 0;
    bool begun = false;
    Point nearest;
    complex_.facets.ForEachNear(p, far, [&](const meshing::Facet& facet) {
      if (complex_.IsOnFacet(v, facet)) return;
      if (!std::exchange(begun, true)) {
        FindNeighbours(mesh, v);
        cut_.Begin(p, far, neighbours_);
      }
      const auto cut = cut_.Of(facet);
      if (!cut) return;
      if (cut->touches && std::ranges::none_of(neighbours_, [&](const auto& u) {
            return !complex_.IsOnFacet(u.id, facet) && meshing::CellCut::GoesThrough(p, u, facet);
          })) {
        return;
      }
      const Point at = cut_.Farthest(facet).value_or(cut->nearest);
      const double d2 = geometry::SquaredDistance(at, p);
      if (d2 < most2 || (d2 == most2 && best && best->p < at)) return;
      most2 = d2;
      best = SteinerPoint<D>{at, complex_.facets.OfFeature(facet.feature())};
      nearest = cut->nearest;
    });
    if (best) {
      const auto other = meshing::CounterpartOn(complex_.facets[best->facet], complex_, v, nearest);
      if (other) best = SteinerPoint<D>{other->p, best->facet, v, other->axis};
    }
  }
  return best;
}

template <int D>
SteinerPoint<D> PlcInput<D>::MoveToFacet(const Ball<D>& ball) const {
  if constexpr (D == 3) {
    if (has_facets()) {
      const auto foot = meshing::FootNear(complex_.facets, ball.centre, std::sqrt(ball.r2));
      if (foot.facet != nullptr) return {foot.p, complex_.facets.OfFeature(foot.facet->feature())};
    }
  }
  return {ball.centre};
}

template <int D>
meshing::FeatureSlot PlcInput<D>::FacetAt(VertexIndex a, VertexIndex b, VertexIndex c,
                                          VertexIndex d) const {
  const FacetIndex facet = meshing::FacetOf(complex_, a, b, c, d);
  return facet == meshing::kNil ? meshing::kNil : complex_.facets[facet].feature();
}

template class PlcInput<2>;
template class PlcInput<3>;

}  // namespace dynmesh::svr
