// Cure: removes tetrahedra with a dihedral angle below the bound, the *slivers*. After refinement
// each sliver gets a Steiner point: the first of a fixed list of candidates such that
//   all tetrahedra around it would be good: they reach the bound and keep rho and sizes, and
//   facets and subsegments stay whole.
// If there is none, the sliver stays.
//
// A point makes no sliver and unmakes at least one, so cures end, whatever the input. The slivers
// are those of the triangulation of refinement's vertices (sliver_table.h). Each is an item, in the
// order of a hash of its corners. A sliver without a candidate is tried again in the next rounds,
// after other slivers around it got their points.
//
//   T       the sliver     c, R    centre and radius of its circumscribed ball
//   e       length of its shortest edge
//   x       a candidate
#ifndef DYNMESH_CORE_MESHING_CURE_H_
#define DYNMESH_CORE_MESHING_CURE_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/space_predicates.h"
#include "core/meshing/directions.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/refinement.h"
#include "core/meshing/sliver_table.h"

namespace dynmesh::meshing {

inline constexpr std::uint64_t kCureRounds = 3;
// Candidates have ordinals. They are tried in this order:
//   the centre;
//   points on the sliver's normal through the centre, at +-kCureHeights R;
//   shells of grid directions, at kCureShells R;
//   points on facets, which all have the last ordinal;
//   points all over the ball, which cost the most.
// Points on the normal succeed most often, as they are far from the sliver's plane: half of them
// do, of the nearest grid directions a fifth. A sliver without success in the shells mostly has two
// corners on a facet. Then one point in 100 to 1000 may succeed.
inline constexpr std::array<double, 4> kCureHeights = {0.3, 0.45, 0.6, 0.15};
inline constexpr std::array<double, 5> kCureShells = {0.15, 0.3, 0.45, 0.6, 0.75};
// On a facet: this part of the radius of the circle that the ball cuts out of its plane.
inline constexpr std::array<double, 10> kCircleParts = {0,   0.2, 0.4, 0.6, 0.8,
                                                        0.1, 0.3, 0.5, 0.7, 0.9};
inline constexpr std::uint32_t kFirstInShell = 1 + 2 * kCureHeights.size();
inline constexpr std::uint32_t kFirstInBall =
    kFirstInShell + kCureShells.size() * kGridDirections.size();
inline constexpr std::uint32_t kOnFacet = kFirstInBall + kBallPlaces.size();
// The reads of a Cure are records of four words.
//   A tetrahedron that a candidate would make: the candidate's ordinal and the other corners. The
//   candidate and they, in this order, are positively oriented.
//   A sliver that another cure unmade: kUnmade and three times the vertex of that cure.
inline constexpr std::uint32_t kUnmade = kOnFacet + 1;
// No vertex may be nearer to a candidate than this, in units of e.
inline constexpr double kCureDistance = 0.4;

// --- Between refinement and cures -----------------------------------------------------------

// Brings the base up to date and requests the cures that are due. From scratch the base is the
// triangulation that refinement read neighbourhoods from, if it has all vertices.
template <int D, template <class> class E>
bool Refinement<D, E>::UpdateSlivers(absl::FunctionRef<bool()> interrupt) {
  if constexpr (D == 3) {
    if (slivers_.has_base()) {
      UpdateBase();
    } else {
      Triangulation whole;
      Triangulation* base = triangulation_;
      if (base == nullptr) {
        base = domain_ != nullptr ? domain_ : &whole;
        if (!FillBase(base, interrupt)) return false;
      }
      if (base->is_full()) return is_full_ = true;
      const bool is_to_change = kTraced || base == &whole;
      if (!slivers_.Begin(*base, is_to_change, interrupt)) return false;
      triangulation_ = nullptr;
    }
    changed_base_.clear();
    const sac::Epoch first = CureEpoch(0);
    slivers_.TakeChanges([&](SliverIndex i) { engine_.Request(kCure, i, first); },
                         [&]([[maybe_unused]] SliverIndex i) {
                           if constexpr (kTraced) engine_.Unrequest(kCure, i, first);
                         });
  }
  return true;
}

// Inserts all vertices that refinement made, in a fast order.
template <int D, template <class> class E>
bool Refinement<D, E>::FillBase(Triangulation* base, absl::FunctionRef<bool()> interrupt) const {
  if constexpr (D == 3) {
    constexpr std::size_t kAtOnce = 2048;
    ResetToDomain(base);
    base->Reserve(vertex_count_);
    // Steiner points of long edges first, the input last (DiffBuilder::FillTriangulation).
    std::vector<VertexIndex> all;
    ForEachVertex([&](VertexIndex v, const Vertex&) {
      if (!base->Contains(v)) all.push_back(v);
    });
    std::stable_sort(all.begin(), all.end(), [this](VertexIndex v, VertexIndex u) {
      return BucketOfEpoch(vertices_[v].epoch) > BucketOfEpoch(vertices_[u].epoch);
    });
    std::vector<Point> places;
    for (std::size_t from = 0; from < all.size(); from += kAtOnce) {
      if (interrupt()) return false;
      const auto part = std::span(all).subspan(from, std::min(kAtOnce, all.size() - from));
      places.clear();
      for (const VertexIndex v : part) places.push_back(vertices_[v].p);
      base->InsertAll(part, places);
    }
  }
  return true;
}

// Removes before it inserts: a new vertex may have the position of an old one.
template <int D, template <class> class E>
void Refinement<D, E>::UpdateBase() {
  if constexpr (D == 3) {
    const auto is_wanted = [this](VertexIndex v) {
      return vertices_[v].present && !IsOfCure(vertices_[v]);
    };
    for (const VertexIndex v : changed_base_) {
      if (slivers_.base().Contains(v) && !is_wanted(v)) slivers_.Remove(v);
    }
    for (const VertexIndex v : changed_base_) {
      if (slivers_.base().Contains(v) || !is_wanted(v)) continue;
      VertexIndex near = 0;
      ForSomeNeighbours(v, [&](VertexIndex u) {
        if (!slivers_.base().Contains(u)) return false;
        near = u;
        return true;
      });
      slivers_.Insert(v, vertices_[v].p, near);
    }
    if (slivers_.base().is_full()) is_full_ = true;
    if (!is_full_) slivers_.FindSlivers();
  }
}

// --- The procedure --------------------------------------------------------------------------

template <int D, template <class> class E>
void Refinement<D, E>::Cure(Context& context) {
  if constexpr (D == 3) {
    const Sliver& sliver = slivers_[context.item];
    CureReads reads(context, sliver.centre);
    reads.region.AddDistantBall(sliver.centre, sliver.radius * (1 + 1e-9) + 4 * rules_.ulp());
    const std::uint64_t round = RoundOfEpoch(context.epoch);
    if (const VertexIndex other = UnmakerOf(context, sliver); other != kNil) {
      reads.Read(kUnmade, other, other, other);
    } else {
      const auto emit_if_good = [&](std::uint32_t ordinal, const Point& x, FeatureSlot facet) {
        reads.candidate = ordinal;
        if (!Suits(context, sliver, x, facet, &reads)) return false;
        EmitVertex(context, x, 0, facet == kNil ? 3 : 2, facet);
        return true;
      };
      const bool found = ForEachCandidate(sliver, emit_if_good);
      if (!found && round + 1 < kCureRounds) {
        context.Request(kCure, context.item, CureEpoch(round + 1));
      }
    }
    if constexpr (kTraced) {
      context.payload().SetRegion(reads.region);
      context.payload().flag = reads.is_attentive;
      SubscribeBox(context, reads.region.box());
    }
  }
}

// Calls f(v, position) for vertices of cures in the ball, as of now, until f returns true. Returns
// whether it did.
template <int D, template <class> class E>
template <class F>
bool Refinement<D, E>::AnyCureIn(Context& context, const Point& centre, double radius, F f) const {
  bool any = false;
  double radius2 = radius * radius * (1 + 1e-6) + 16 * rules_.ulp() * rules_.ulp();
  cured_.VisitBall(centre, radius2, [&](std::uint32_t v, const Point& p, double) {
    any = any || (context.Sees(vertices_[v].birth) && f(v, p));
  });
  return any;
}

// The vertex of another cure that unmade the sliver; kNil if there is none.
template <int D, template <class> class E>
VertexIndex Refinement<D, E>::UnmakerOf(Context& context, const Sliver& sliver) const {
  VertexIndex found = kNil;
  if constexpr (D == 3) {
    AnyCureIn(context, sliver.centre, sliver.radius, [&](VertexIndex v, const Point& p) {
      if (!slivers_.base().Conflicts(sliver.simplex, p)) return false;
      found = v;
      return true;
    });
  }
  return found;
}

// The candidate of that ordinal, for ordinals below kOnFacet.
template <int D, template <class> class E>
geometry::Point<D> Refinement<D, E>::CandidateAt(const Sliver& sliver, std::uint32_t ordinal) {
  Point x = {};
  if constexpr (D == 3) {
    x = sliver.centre;
    if (ordinal == 0) return x;
    const geometry::Vector3* direction = &sliver.normal;
    double part = 1;
    if (ordinal < kFirstInShell) {
      const std::size_t i = ordinal - 1;
      part = (i % 2 == 0 ? 1 : -1) * kCureHeights[i / 2];
    } else if (ordinal < kFirstInBall) {
      const std::size_t i = ordinal - kFirstInShell;
      direction = &kGridDirections[i % kGridDirections.size()];
      part = kCureShells[i / kGridDirections.size()];
    } else {
      direction = &kBallPlaces[ordinal - kFirstInBall];
    }
    const double out = part * sliver.radius;
    for (std::size_t k = 0; k < 3; ++k) x.c[k] += out * (*direction)[k];
  }
  return x;
}

// Calls f(ordinal, x, facet) for the candidates in their order until f returns true. Returns
// whether it did. facet = kNil: x is on no facet. The order is that of kCureHeights
// and what follows it.
template <int D, template <class> class E>
template <class F>
bool Refinement<D, E>::ForEachCandidate(const Sliver& sliver, F f) const {
  if constexpr (D == 3) {
    const auto any_of = [&](std::uint32_t first, std::uint32_t end) {
      for (std::uint32_t ordinal = first; ordinal < end; ++ordinal) {
        if (f(ordinal, CandidateAt(sliver, ordinal), kNil)) return true;
      }
      return false;
    };
    if (any_of(0, kFirstInBall)) return true;
    const Point& c = sliver.centre;
    for (const Facet* facet : FacetsNear(c, sliver.radius)) {
      const geometry::FacetPlane& plane = facet->plane();
      const double h = plane.Height(c), wide2 = sliver.radius * sliver.radius - h * h;
      if (!(wide2 > 0)) continue;
      const auto [x, y] = geometry::AxesOf(plane);
      for (const double part : kCircleParts) {
        const double out = part * std::sqrt(wide2);
        for (int k = 0; k < (part == 0 ? 1 : kDirections); ++k) {
          Point p = c;
          for (int i = 0; i < 3; ++i) {
            const auto j = static_cast<std::size_t>(i);
            p[i] += out * (CosineOf(k) * x[j] + SineOf(k) * y[j]);
          }
          p = plane.Foot(p);
          if (facet->IsInside(p) && f(kOnFacet, p, facet->feature())) return true;
        }
      }
    }
    return any_of(kFirstInBall, kOnFacet);
  }
  return false;
}

// The facets that the ball may meet, sorted by the distance of their planes from its centre.
template <int D, template <class> class E>
std::vector<const Facet*> Refinement<D, E>::FacetsNear(const Point& c, double radius) const {
  std::vector<const Facet*> near;
  if constexpr (D == 3) {
    if (facets_.empty()) return near;
    facets_.ForEachNear(c, radius, [&](const Facet& facet) { near.push_back(&facet); });
    const auto key = [&](const Facet* facet) {
      std::uint64_t corners = 0;
      for (const VertexIndex v : facet->corners()) corners += geometry::HashOf(vertices_[v].p);
      return std::pair(std::fabs(facet->plane().Height(c)), corners);
    };
    std::sort(near.begin(), near.end(),
              [&](const Facet* a, const Facet* b) { return key(a) < key(b); });
  }
  return near;
}

// True if x may become a vertex (on `facet` unless that is kNil). Most unsuitable points are found
// by one bad tetrahedron that x would make with a facet of its cavity in the base. It counts unless
// a vertex of a cure unmakes it.
template <int D, template <class> class E>
bool Refinement<D, E>::Suits(Context& context, const Sliver& sliver, const Point& x,
                             FeatureSlot facet, CureReads* reads) {
  if constexpr (D == 3) {
    for (int k = 0; k < 3; ++k) {
      if (!(rules_.lo()[k] < x[k] && x[k] < rules_.hi()[k])) return false;
    }
    const Triangulation& base = slivers_.base();
    if (!base.Conflicts(sliver.simplex, x)) return false;
    base.CavityOf(x, sliver.simplex, &cavity_);
    for (const auto& [a, b, c] : cavity_.facets) {
      const Point &p = base.position(a), &q = base.position(b), &r = base.position(c);
      if (!slivers_.bound().IsBelow({p, q, r, x})) continue;
      const geometry::Circumball ball = geometry::CircumballOf(x, p, r, q);
      const double radius = std::sqrt(ball.r2) + ball.error + 4 * rules_.ulp();
      Point centre = x;
      for (int k = 0; k < 3; ++k) centre[k] += ball.w[static_cast<std::size_t>(k)];
      const bool is_unmade = AnyCureIn(context, centre, radius, [&](VertexIndex, const Point& y) {
        return geometry::InSphere(p, q, r, x, y);
      });
      if (is_unmade) continue;
      reads->region.AddDistantBall(centre, radius);
      reads->Read(reads->candidate, a, c, b);
      return false;
    }
    MakeStarOf(context, sliver, x);
    for (int i = 0; i < star_.corner_count(); ++i) {
      if (IsGoodCorner(i, sliver)) continue;
      AddCornerTo(reads, i);
      return false;
    }
    for (int i = 0; i < star_.corner_count(); ++i) AddCornerTo(reads, i);
    if (!LeavesFacetsWhole(facet)) return false;
    FindEncroached(context, x);
    reads->is_attentive |= !encroached_.empty();
    return encroached_.empty();
  }
  return false;
}

// Makes the star of x among all vertices as of now. x's cell reaches no farther than the balls of
// good tetrahedra.
template <int D, template <class> class E>
void Refinement<D, E>::MakeStarOf(Context& context, const Sliver& sliver, const Point& x) {
  if constexpr (D == 3) {
    star_.BeginLink(kNil, x, 4 * rules_.quality() * sliver.radius);
    rim_.Clear();
    const auto slot_of = [this](VertexIndex v) {
      const std::size_t known = rim_.keys().size();
      const auto slot = static_cast<int>(rim_.Number({v}));
      if (rim_.keys().size() > known) star_.AddNeighbour(v, vertices_[v].p);
      return slot;
    };
    for (const auto& [a, b, c] : cavity_.facets) {
      const int first = slot_of(a), second = slot_of(c);  // with x: positively oriented
      star_.AddCorner({first, second, slot_of(b)});
    }
    star_.JoinCorners();
    star_.Close();
    // Insertion makes no ball that extends beyond those it replaces and their neighbours'. So one
    // query is enough (InsertAllInCorners).
    Extent<D> box = Extent<D>::Nothing();
    balls_.clear();
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& corner = star_.corner(i);
      const double radius = std::sqrt(corner.r2) + 2 * corner.error + 4 * rules_.ulp();
      balls_.push_back({CentreOf(i), radius * radius});
      box.AddBall(balls_.back().centre, radius);
    }
    cured_.VisitBalls(balls_, box, std::numeric_limits<int>::max(),
                      [&](std::uint32_t v, const Point& p) {
                        star_.InsertIf(v, p, [&] { return context.Sees(vertices_[v].birth); });
                      });
  }
}

// True if the tetrahedron at corner i of the star is good.
template <int D, template <class> class E>
bool Refinement<D, E>::IsGoodCorner(int i, const Sliver& sliver) const {
  if constexpr (D == 3) {
    const auto& corner = star_.corner(i);
    std::array<Point, 4> p;
    p[3] = star_.position();
    const double least2 = kCureDistance * kCureDistance * sliver.shortest2;
    double shortest2 = INFINITY;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& u = star_[corner.n[k]];
      p[k] = u.p;
      if (u.d2 < least2) return false;
      shortest2 = std::min(shortest2, u.d2);
    }
    for (std::size_t k = 0; k < 3; ++k) {
      shortest2 = std::min(shortest2, geometry::SquaredDistance(p[k], p[(k + 1) % 3]));
    }
    return !rules_.IsTooFar(corner.r2, shortest2) && !IsTooLargeCorner(i) &&
           !slivers_.bound().IsBelow(p);
  }
  return false;
}

// True if the cell of the star's vertex, which is to lie on facet `on`, meets no other facet.
template <int D, template <class> class E>
bool Refinement<D, E>::LeavesFacetsWhole(FeatureSlot on) {
  bool found = false;
  if constexpr (D == 3) {
    if (facets_.empty()) return true;
    double far2 = 0;
    for (const auto& corner : star_.corners()) far2 = std::max(far2, corner.r2);
    cut_.Begin(star_);
    facets_.ForEachNear(star_.position(), std::sqrt(far2) * (1 + 1e-6), [&](const Facet& facet) {
      if (found || facet.feature() == on) return;
      const auto cut = cut_.Of(facet);
      found = cut && !(cut->touches && !IsJoinedThrough(facet));
    });
  }
  return !found;
}

template <int D, template <class> class E>
void Refinement<D, E>::AddCornerTo(CureReads* reads, int i) const {
  if constexpr (D == 3) {
    const auto& corner = star_.corner(i);
    reads->region.AddDistantBall(CentreOf(i),
                                 std::sqrt(corner.r2) + corner.error + 4 * rules_.ulp());
    const auto [a, b, c] = star_.IdsOf(i);
    reads->Read(reads->candidate, a, b, c);
  }
}

// --- Changes ----------------------------------------------------------------------------------

// True if v, in the region that `op` read, may change the operation's result. A vertex of
// refinement in the sliver's ball is not tested: then the sliver is gone. Reads of candidates on
// facets are not examined: the answer is true.
template <int D, template <class> class E>
bool Refinement<D, E>::CureMatters(sac::OpId op, VertexIndex v, bool appears) const {
  if constexpr (kTraced && D == 3) {
    const Sliver& sliver = slivers_[engine_.item(op)];
    if (!sliver.is_there) return false;  // the operation will be dropped
    const auto words = engine_.reads(op);
    const Point& y = vertices_[v].p;
    if (!words.empty() && words[0] == kUnmade) return !appears && words[1] == v;
    if (appears && IsOfCure(vertices_[v]) && slivers_.base().Conflicts(sliver.simplex, y))
      return true;
    for (std::size_t i = 0; i < words.size(); i += 4) {
      const VertexIndex a = words[i + 1], b = words[i + 2], c = words[i + 3];
      if (words[i] == kOnFacet || a == v || b == v || c == v) return true;
      if (appears && geometry::InSphere(CandidateAt(sliver, words[i]), vertices_[a].p,
                                        vertices_[b].p, vertices_[c].p, y)) {
        return true;
      }
    }
    return false;
  }
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CURE_H_
