// Which vertices encroach on a subsegment, and on which subsegments a point encroaches: as of an
// operation.
#ifndef DYNMESH_CORE_MESHING_ENCROACHMENT_H_
#define DYNMESH_CORE_MESHING_ENCROACHMENT_H_

#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/constructions.h"
#include "core/meshing/complex.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

using geometry::DiametralBallSign;

// Thread-compatible. A result holds until the next call.
template <int D, template <class> class E>
class EncroachmentSearch {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;
  using Subsegment = meshing::Subsegment<D>;

  explicit EncroachmentSearch(const Complex<D, E>& complex) : complex_(complex) {}

  // The vertices that encroach on s as of now: one vertex in the open ball, or vertices on its
  // surface that keep s out of the triangulation (segments.h). Nothing if none does. In 2D, read
  // off a triangulation, they are not listed.
  std::optional<std::span<const VertexIndex>> WitnessesOf(const Context& context,
                                                          SubsegmentIndex s);

  struct Encroached {
    SubsegmentIndex s;
    bool strictly;  // x is inside the ball, not on its surface
  };
  // The visible subsegments that have x in their closed diametral balls.
  std::span<const Encroached> EncroachedBy(const Context& context, const Point& x);
  // Negative if x is in the subsegment's open diametral ball, 0 if it encroaches from the surface,
  // else positive.
  int SignOf(const Subsegment& sub, const Point& x) const;
  // The visible subsegments that may have points of the ball in their diametral balls.
  void FindNear(const Context& context, const Point& centre, double radius,
                std::vector<SubsegmentIndex>* near) const;

 private:
  bool FindHiding(const Subsegment& sub);
  bool IsEncroachedInTriangulation(const Subsegment& sub) const;

  const Complex<D, E>& complex_;
  std::vector<VertexIndex> witnesses_, on_surface_;
  std::vector<Encroached> encroached_;
  Star<D> star_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
std::optional<std::span<const VertexIndex>> EncroachmentSearch<D, E>::WitnessesOf(
    const Context& context, SubsegmentIndex s) {
  const Subsegment& sub = complex_.subsegment(s);
  const Point &a = complex_.vertex(sub.a).p, &b = complex_.vertex(sub.b).p;
  witnesses_.clear();
  on_surface_.clear();
  if (D == 2 && !complex_.needs_tree()) {
    if (!IsEncroachedInTriangulation(sub)) return std::nullopt;
    return witnesses_;
  }
  const double radius = complex_.RadiusOf(sub);
  double r2 = radius * radius;
  complex_.tree.VisitBall(
      geometry::Midpoint(a, b), r2, [&](std::uint32_t id, const Point& q, double) {
        if (id == sub.a || id == sub.b || !context.Sees(complex_.vertex(id).birth)) return;
        const int sign = DiametralBallSign(a, b, q);
        if (sign < 0) {
          if (!IsOn(RefinementTerm::kInsideSplits)) return;
          witnesses_.assign(1, id);
          r2 = -1;  // one is enough
        } else if (sign == 0) {
          on_surface_.push_back(id);
        }
      });
  if (witnesses_.empty() && !FindHiding(sub)) return std::nullopt;
  return witnesses_;
}

// True if vertices on the surface of the subsegment's ball keep it out of the triangulation.
template <int D, template <class> class E>
bool EncroachmentSearch<D, E>::FindHiding(const Subsegment& sub) {
  if (on_surface_.size() < 2 || !IsOn(RefinementTerm::kHidingSplits)) return false;
  const Point &a = complex_.vertex(sub.a).p, &b = complex_.vertex(sub.b).p;
  if constexpr (D == 2) {
    for (const VertexIndex c : on_surface_) {
      if (geometry::Orientation(a, b, complex_.vertex(c).p) <= 0) continue;
      for (const VertexIndex d : on_surface_) {
        if (geometry::Orientation(a, b, complex_.vertex(d).p) >= 0) continue;
        if (geometry::InCircle(a, b, complex_.vertex(c).p, complex_.vertex(d).p)) {
          witnesses_ = {c, d};
          return true;
        }
      }
    }
    return false;
  } else {
    // Take the star of a among these vertices alone. The ghosts are too far to matter. The
    // subsegment is an edge iff b is a neighbour in it.
    star_.Begin(sub.a, a, 4 * complex_.RadiusOf(sub));
    star_.Insert(sub.b, b);
    for (const VertexIndex c : on_surface_) star_.Insert(c, complex_.vertex(c).p);
    if (star_.Has(sub.b)) return false;
    witnesses_ = on_surface_;
    return true;
  }
}

template <int D, template <class> class E>
bool EncroachmentSearch<D, E>::IsEncroachedInTriangulation(const Subsegment& sub) const {
  if constexpr (D == 2) {
    const Point &a = complex_.vertex(sub.a).p, &b = complex_.vertex(sub.b).p;
    const auto first = complex_.run.triangulation().Around(sub.a);
    auto corner = first;
    bool is_edge = false;
    auto in_ball = [&](VertexIndex c) {
      return c != TriangulationOf<D>::kInfinite && IsOn(RefinementTerm::kInsideSplits) &&
             geometry::InDiametralBall(a, b, complex_.vertex(c).p);
    };
    do {
      const auto& tri = complex_.run.triangulation().vertices(corner.simplex);
      const VertexIndex right = tri[corner.index == 2 ? 0 : corner.index + 1];
      const VertexIndex left = tri[corner.index == 0 ? 2 : corner.index - 1];
      if (right == sub.b) is_edge = true;
      if ((right == sub.b && in_ball(left)) || (left == sub.b && in_ball(right))) return true;
      corner = complex_.run.triangulation().NextAround(corner);
    } while (corner.simplex != first.simplex);
    return !is_edge && IsOn(RefinementTerm::kHidingSplits);
  }
  return false;
}

template <int D, template <class> class E>
std::span<const typename EncroachmentSearch<D, E>::Encroached>
EncroachmentSearch<D, E>::EncroachedBy(const Context& context, const Point& x) {
  encroached_.clear();
  if (complex_.border_only) {
    // The balls of the domain's sides reach half a grid spacing inwards.
    const double margin = 0.501 * complex_.rules.grid_spacing();
    bool inside = true;
    for (int k = 0; k < D; ++k) {
      inside = inside && complex_.rules.lo()[k] + margin < x[k] &&
               x[k] < complex_.rules.hi()[k] - margin;
    }
    if (inside) return encroached_;
  }
  complex_.tree.VisitPath(x, [&](sac::Place place, sac::Parts part) {
    for (const auto& [s, parts] : complex_.exposures.at(place)) {
      if ((parts & part) != part) continue;  // there may be thousands in a cell without points
      const Subsegment& sub = complex_.subsegment(s);
      if (!complex_.IsVisible(context, sub)) continue;
      const int sign = SignOf(sub, x);
      if (sign > 0) continue;
      encroached_.push_back({s, sign < 0 || !IsOn(RefinementTerm::kSurfaceRechecks)});
    }
  });
  return encroached_;
}

template <int D, template <class> class E>
int EncroachmentSearch<D, E>::SignOf(const Subsegment& sub, const Point& x) const {
  const int sign = DiametralBallSign(complex_.vertex(sub.a).p, complex_.vertex(sub.b).p, x);
  return sign == 0 && !IsOn(RefinementTerm::kSurfaceCounts) ? 1 : sign;
}

template <int D, template <class> class E>
void EncroachmentSearch<D, E>::FindNear(const Context& context, const Point& centre, double radius,
                                        std::vector<SubsegmentIndex>* near) const {
  near->clear();
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(centre, radius);
  complex_.tree.VisitBoxIf(
      box, [](const Point&, double) { return true; },
      [&](sac::Place place) {
        for (const auto& [s, parts] : complex_.exposures.at(place)) {
          const Subsegment& sub = complex_.subsegment(s);
          if (!complex_.IsVisible(context, sub)) continue;
          const double far = complex_.RadiusOf(sub) + radius;
          if (geometry::SquaredDistance(
                  geometry::Midpoint(complex_.vertex(sub.a).p, complex_.vertex(sub.b).p), centre) <=
              far * far) {
            near->push_back(s);
          }
        }
      });
  std::sort(near->begin(), near->end());
  near->erase(std::unique(near->begin(), near->end()), near->end());
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_ENCROACHMENT_H_
