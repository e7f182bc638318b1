// Cure: removes tetrahedra with a dihedral angle below the bound, the *slivers*. After refinement
// each sliver gets a Steiner point: the first of a fixed list of candidates such that
//   all tetrahedra around it would be good: they reach the bound and keep rho and sizes, and
//   facets and subsegments stay whole.
// If there is none, the sliver stays. The first candidates are tried strictly at first: no small
// angle around the point has an excuse. An exempt sliver gets no other point: it would be exchanged
// for others of its kind.
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
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/rounding.h"
#include "core/geometry/apex_bound.h"
#include "core/geometry/circumball.h"
#include "core/geometry/space_predicates.h"
#include "core/meshing/complex.h"
#include "core/meshing/cure_candidates.h"
#include "core/meshing/emitter.h"
#include "core/meshing/encroachment.h"
#include "core/meshing/facet_work.h"
#include "core/meshing/read_cover.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/refusing_facets.h"
#include "core/meshing/sliver_table.h"
#include "core/meshing/splits.h"
#include "core/meshing/star.h"

namespace dynmesh::meshing {

inline constexpr std::uint64_t kCureRounds = 3;
// No vertex may be nearer to a candidate than this, in units of e.
inline constexpr double kCureDistance = 0.4;

// The reads of a Cure are records of four words.
//   A tetrahedron that a candidate would make: the candidate's ordinal and the other corners. The
//   candidate and they, in this order, are positively oriented.
//   A sliver that another cure unmade: kUnmade and three times the vertex of that cure.
inline constexpr std::uint32_t kUnmade = kOnFacet + 1;

// The procedure kCure; 3D. Thread-compatible.
template <int D, template <class> class E>
class CureWork {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;
  using Corner = delaunay::DelaunayTetrahedralization::Corner;

  CureWork(const Complex<D, E>& complex, Emitter<D, E>& emitter)
      : complex_(complex), emitter_(emitter), search_(complex), facets_(complex) {}
  void Run(Context& context);

 private:
  struct Reads {
    Reads(Context& of, const Point& centre) : context(of), cover(centre) {}
    void Read(std::uint32_t ordinal, VertexIndex a, VertexIndex b, VertexIndex c) {
      for (const std::uint32_t word : {ordinal, a, b, c}) context.Read(word);
    }
    void AddReach(const Sliver& sliver, const Point& centre, double radius) {
      const double to_centre = std::sqrt(geometry::SquaredDistance(sliver.centre, centre));
      reach = std::max(reach, to_centre * kRootWider + radius);
      around = std::max(around, 2 * radius);  // the candidate is on the ball's surface
    }
    Context& context;
    ReadCover<D> cover;
    std::uint32_t candidate = 0;  // the one being tested
    // Untraced. How far from the candidate a cure may be that matters to its refusal; 0 if none
    // does.
    double around = 0;
    bool is_attentive = false;  // a candidate encroached on a subsegment
    // Untraced: no cure that is farther than this from the centre matters to what was found.
    double reach = 0;
  };

  // Calls f(v, position) for vertices of cures in the ball, as of now, until f returns true.
  // Returns whether it did.
  template <class F>
  bool AnyCureIn(Context& context, const Point& centre, double radius, F f) const;
  // The same for one of many balls near the sliver: f(position).
  template <class F>
  bool AnyCureNear(Context& context, const Sliver& sliver, const Point& centre, double radius, F f);
  // The vertex of another cure that unmade the sliver; kNil if there is none.
  VertexIndex UnmakerOf(Context& context, const Sliver& sliver) const;
  // True if x may become a vertex (on `facet` unless that is kNil). Most unsuitable points are
  // found by one bad tetrahedron that x would make with a facet of its cavity in the base. It
  // counts unless a vertex of a cure unmakes it. Which of several reasons is found does not matter.
  bool Suits(Context& context, const Sliver& sliver, const Point& x, FeatureSlot facet,
             Reads* reads);
  // True if the tetrahedron of x and that facet of its cavity is bad, and no vertex of a cure
  // unmakes it.
  // angles_are_good: it is known to have no angle below the bound.
  bool IsRefusedBy(Context& context, const Sliver& sliver, const Point& x, const Corner& facet,
                   Reads* reads, bool angles_are_good = false);
  // The tetrahedron of x and those three is bad. True if no vertex of a cure unmakes it.
  bool StaysBad(Context& context, const Sliver& sliver, const Point& x,
                const std::array<VertexIndex, 3>& v, const std::array<Point, 3>& p, Reads* reads);
  // Untraced: what is kept with a facet that refused a candidate.
  struct KnownFacet {
    std::array<VertexIndex, 3> v = {};
    std::array<Point, 3> p = {};
    double least2 = INFINITY;  // of its edges that count, squared
    geometry::ApexBound angles = {};
    bool is_quick = false;  // it refused as IsSurelyBad knows; then nothing else is looked at
  };
  KnownFacet Know(const std::array<VertexIndex, 3>& v, const std::array<Point, 3>& p,
                  const Point& x, const Sliver& sliver, bool is_outside) const;
  // Is the tetrahedron of x and the facet surely bad? No ball is needed for that.
  bool IsSurelyBad(const KnownFacet& facet, const Point& x, const Sliver& sliver) const;
  // The same of any three vertices.
  bool IsSurelyTooShortOrLarge(const std::array<Point, 3>& p, const Point& x,
                               const Sliver& sliver) const;
  // Untraced. True if the cavity of x in the base has a facet that refuses x, or x is cut off.
  // What is sure comes first, and what needs balls last. Fills cavity_.
  bool IsRefusedByCavity(Context& context, const Sliver& sliver, const Point& x, FeatureSlot facet,
                         Reads* reads);
  // Untraced. True if a facet would surely not stay whole. REQUIRES: cavity_ is that of x.
  bool IsCutOffByFacet(Context& context, const Sliver& sliver, const Point& x, FeatureSlot facet,
                       Reads* reads);
  // True if x, in the sliver's ball, encroaches on a subsegment.
  bool Encroaches(Context& context, const Sliver& sliver, const Point& x);
  // Finds before_ and new_cures_; untraced. Without new cures the sliver has no candidate now.
  void Recall(Context& context, const Sliver& sliver, Reads* reads);
  void Remember(double around, std::size_t number);
  // Untraced. Has every cure since an earlier round been too far away to matter to the refusal of
  // candidate x then? `number` counts the candidates tried.
  bool IsStillRefused(const Point& x, std::size_t number) const;
  // Makes the star of x among all vertices as of now. x's cell reaches no farther than the balls of
  // good tetrahedra. Returns whether vertices of cures are in it.
  bool MakeStarOf(Context& context, const Sliver& sliver, const Point& x);
  bool IsSliver(const std::array<VertexIndex, 4>& v, const std::array<Point, 4>& p) {
    return complex_.slivers.IsSliver(v, p, [this](VertexIndex a, VertexIndex b) {
      if (!complex_.IsSeditious(a, b)) return false;
      met_excuse_ = true;
      return !is_strict_;
    });
  }
  // Is the tetrahedron of x and three vertices too short or too large? `ball_of()`: its
  // circumscribed ball, seen from x.
  template <class BallOf>
  bool IsTooShortOrLarge(const std::array<VertexIndex, 3>& v, const std::array<Point, 3>& p,
                         const Point& x, const Sliver& sliver, BallOf ball_of) const;
  // True if the tetrahedron at corner i of the star is good.
  bool IsGoodCorner(int i, const Sliver& sliver);
  void AddCornerTo(Reads* reads, const Sliver& sliver, int i) const;

  const Complex<D, E>& complex_;
  Emitter<D, E>& emitter_;
  EncroachmentSearch<D, E> search_;
  FacetWork<D, E> facets_;
  // Scratch.
  Star<D> star_;
  delaunay::DelaunayTetrahedralization::Cavity cavity_;
  delaunay::NumberTable<1> rim_;
  std::vector<typename SpatialTree<D>::Ball> balls_;
  // Of the cure at work.
  RefusingFacets<KnownFacet> refusing_;
  struct Unsure {
    Corner facet;
    bool angles_are_good;
  };
  std::vector<Unsure> unsure_;  // of IsRefusedByCavity
  int asked_ = 0;               // how often Encroaches was
  int asked_near_ = 0;          // how often AnyCureNear was
  // Of AnyCureNear: all cures in a ball of that radius around the sliver. Within more than the most
  // there are too many for a list.
  double near_reach_ = 0, most_reach_ = INFINITY;
  std::vector<Point> near_cures_, more_cures_;
  bool is_strict_ = false;   // excused edges do not count as such
  bool met_excuse_ = false;  // there was one
  std::vector<SubsegmentIndex> near_segments_;
  // Untraced. Slivers without a candidate in the last round: how far what was read reached, and
  // the first vertex that was not yet there.
  struct Failed {
    double reach = 0;
    VertexIndex first_new = 0;
    bool met_excuse = false;
    // Of each candidate, by the number it was tried with: Reads::around, rounded up. Those tried
    // strictly, then the others from ordinal 0 on. Fewer than there are: of the others nothing is
    // known.
    std::vector<float> around = {};
  };
  absl::flat_hash_map<sac::Item, Failed> failed_;
  std::size_t remembered_ = 0;      // candidates in failed_
  std::vector<float> around_;       // of the cure at work
  const Failed* before_ = nullptr;  // what an earlier round found for it
  std::vector<Point> new_cures_;    // since then, in its reach
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
void CureWork<D, E>::Run(Context& context) {
  if constexpr (D == 3) {
    const Sliver& sliver = complex_.slivers[context.item];
    Reads reads(context, sliver.centre);
    reads.cover.AddDistantBall(sliver.centre,
                               sliver.radius * kBarelyWider + 4 * complex_.rules.ulp());
    const std::uint64_t round = RoundOfEpoch(context.epoch);
    refusing_.Clear();
    asked_ = asked_near_ = 0;
    near_reach_ = 0;
    most_reach_ = INFINITY;
    near_cures_.clear();
    Recall(context, sliver, &reads);
    if (const VertexIndex other = UnmakerOf(context, sliver); other != kNil) {
      reads.Read(kUnmade, other, other, other);
    } else if (!kTraced && before_ != nullptr && new_cures_.empty()) {
      if (round + 1 < kCureRounds) context.Request(kCure, context.item, CureEpoch(round + 1));
    } else {
      std::size_t number = 0;
      const auto emit_if_good = [&](std::uint32_t ordinal, const Point& x, FeatureSlot facet) {
        reads.candidate = ordinal;
        if constexpr (!kTraced) {
          if (IsStillRefused(x, number)) {
            Remember(before_->around[number], number);
            ++number;
            return false;
          }
        }
        reads.around = 0;
        if (Suits(context, sliver, x, facet, &reads)) {
          emitter_.EmitVertex(context, x, 0, facet == kNil ? 3 : 2, facet);
          return true;
        }
        if constexpr (!kTraced) Remember(reads.around, number);
        ++number;
        return false;
      };
      is_strict_ = true;
      met_excuse_ = before_ != nullptr && before_->met_excuse;
      CandidatesTried tried = {AnyFreeCandidate(sliver, 0, kFirstNotStrict, emit_if_good)};
      const bool met_excuse = met_excuse_;
      if (!tried.found && !sliver.is_exempt) {
        is_strict_ = false;
        const std::uint32_t first = met_excuse ? 0 : kFirstNotStrict;
        number = kFirstNotStrict + first;
        tried = ForEachCandidate(complex_, sliver, first, emit_if_good);
      }
      const bool goes_on = !tried.found && tried.are_all && !sliver.is_exempt;
      if (goes_on && round + 1 < kCureRounds) {
        context.Request(kCure, context.item, CureEpoch(round + 1));
        if constexpr (!kTraced) {
          Failed& failed = failed_[context.item];
          remembered_ += around_.size() - failed.around.size();
          failed = {reads.reach, complex_.elements.vertex_end(), met_excuse, around_};
        }
      }
    }
    if constexpr (kTraced) {
      context.payload().SetCover(reads.cover);
      context.payload().flag = reads.is_attentive;
      complex_.Subscribe(context, reads.cover.box());
    }
  }
}

template <int D, template <class> class E>
template <class F>
bool CureWork<D, E>::AnyCureIn(Context& context, const Point& centre, double radius, F f) const {
  bool any = false;
  double radius2 = radius * radius * kWider + 16 * complex_.rules.ulp() * complex_.rules.ulp();
  complex_.cured.VisitBall(centre, radius2, [&](std::uint32_t v, const Point& p, double) {
    if (any || !context.Sees(complex_.vertex(v).birth) || !f(v, p)) return;
    any = true;
    radius2 = -1;  // one is enough
  });
  return any;
}

template <int D, template <class> class E>
VertexIndex CureWork<D, E>::UnmakerOf(Context& context, const Sliver& sliver) const {
  VertexIndex found = kNil;
  if constexpr (D == 3) {
    AnyCureIn(context, sliver.centre, sliver.radius, [&](VertexIndex v, const Point& p) {
      if (!complex_.slivers.base().Conflicts(sliver.simplex, p)) return false;
      found = v;
      return true;
    });
  }
  return found;
}

template <int D, template <class> class E>
bool CureWork<D, E>::Suits(Context& context, const Sliver& sliver, const Point& x,
                           FeatureSlot facet, Reads* reads) {
  if constexpr (D == 3) {
    for (int k = 0; k < 3; ++k) {
      if (!(complex_.rules.lo()[k] < x[k] && x[k] < complex_.rules.hi()[k])) return false;
    }
    const TriangulationOf<D>& base = complex_.slivers.base();
    if (!base.Conflicts(sliver.simplex, x)) return false;
    const bool keeps_segments = IsOn(RefinementTerm::kCureKeepsSegments);
    // A trace tests segments last: its record of a candidate that encroaches is the whole star.
    if constexpr (!kTraced) {
      if (keeps_segments && Encroaches(context, sliver, x)) return false;
    }
    const bool keeps_facets = IsOn(RefinementTerm::kCureKeepsFacets);
    if constexpr (kTraced) {
      const auto refuses = [&](const Corner& by) {
        return IsRefusedBy(context, sliver, x, by, reads);
      };
      if (refusing_.Any([&](const Corner& by, const KnownFacet&) {
            return base.IsOnCavity(by, x) && refuses(by);
          })) {
        return false;
      }
      const bool is_kept = base.VisitCavityOf(x, sliver.simplex, &cavity_, [&](const Corner& by) {
        if (!refuses(by)) return true;
        refusing_.Add(by, {});
        return false;
      });
      if (!is_kept) return false;
    } else {
      const auto refuses = [&](const Corner& by, const KnownFacet& known) {
        if (!base.IsOnCavity(by, x)) return false;
        if (!known.is_quick) return IsRefusedBy(context, sliver, x, by, reads);
        return IsSurelyBad(known, x, sliver) &&
               StaysBad(context, sliver, x, known.v, known.p, reads);
      };
      if (refusing_.Any(refuses) || IsRefusedByCavity(context, sliver, x, facet, reads)) {
        return false;
      }
    }
    const bool has_cures = MakeStarOf(context, sliver, x);
    // Without cures it is of the tetrahedra with the cavity's facets, which are good.
    for (int i = 0; has_cures && i < star_.corner_count(); ++i) {
      if (IsGoodCorner(i, sliver)) continue;
      AddCornerTo(reads, sliver, i);
      return false;
    }
    for (int i = 0; i < star_.corner_count(); ++i) AddCornerTo(reads, sliver, i);
    if (keeps_facets && !facets_.LeavesWhole(star_, facet)) return false;
    if constexpr (kTraced) {
      const bool encroaches = !search_.EncroachedBy(context, x).empty();
      reads->is_attentive |= encroaches;
      return !encroaches || !keeps_segments;
    }
    return true;
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsRefusedBy(Context& context, const Sliver& sliver, const Point& x,
                                 const Corner& facet, Reads* reads, bool angles_are_good) {
  if constexpr (D == 3) {
    const TriangulationOf<D>& base = complex_.slivers.base();
    const std::array<VertexIndex, 3> v = base.FacetAt(facet);
    const std::array<Point, 3> p = {base.position(v[0]), base.position(v[1]), base.position(v[2])};
    const auto ball_of = [&] { return geometry::CircumballOf(x, p[0], p[2], p[1]); };
    angles_are_good |= complex_.slivers.IsOutside(facet.simplex);
    const bool is_bad = IsTooShortOrLarge(v, p, x, sliver, ball_of) ||
                        (!angles_are_good && IsOn(RefinementTerm::kCureKeepsAngles) &&
                         IsSliver({v[0], v[1], v[2], kNil}, {p[0], p[1], p[2], x}));
    return is_bad && StaysBad(context, sliver, x, v, p, reads);
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::StaysBad(Context& context, const Sliver& sliver, const Point& x,
                              const std::array<VertexIndex, 3>& v, const std::array<Point, 3>& p,
                              Reads* reads) {
  if constexpr (D == 3) {
    const geometry::Circumball ball = geometry::CircumballOf(x, p[0], p[2], p[1]);
    const double radius = std::sqrt(ball.r2) + ball.error + 4 * complex_.rules.ulp();
    Point centre = x;
    for (int k = 0; k < 3; ++k) centre[k] += ball.w[static_cast<std::size_t>(k)];
    if (AnyCureNear(context, sliver, centre, radius,
                    [&](const Point& y) { return geometry::InSphere(p[0], p[1], p[2], x, y); })) {
      return false;
    }
    if constexpr (kTraced) {
      reads->cover.AddDistantBall(centre, radius);
      reads->Read(reads->candidate, v[0], v[2], v[1]);
    } else {
      reads->AddReach(sliver, centre, radius);
    }
    return true;
  }
  return false;
}

template <int D, template <class> class E>
auto CureWork<D, E>::Know(const std::array<VertexIndex, 3>& v, const std::array<Point, 3>& p,
                          const Point& x, const Sliver& sliver, bool is_outside) const
    -> KnownFacet {
  KnownFacet known{v, p};
  if constexpr (D == 3) {
    for (std::size_t k = 0; k < 3; ++k) {
      const double d2 = geometry::SquaredDistance(p[k], p[(k + 1) % 3]);
      if (d2 < known.least2 && !complex_.IsSeditious(v[k], v[(k + 1) % 3])) known.least2 = d2;
    }
    if (!is_outside) known.angles = geometry::ApexBound(complex_.slivers.bound(), p);
    known.is_quick = IsSurelyBad(known, x, sliver);
  }
  return known;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsSurelyBad(const KnownFacet& facet, const Point& x,
                                 const Sliver& sliver) const {
  if constexpr (D == 3) {
    const double least2 = kCureDistance * kCureDistance * sliver.shortest2;
    double shortest2 = facet.least2, longest2 = 0;
    for (const Point& q : facet.p) {
      const double d2 = geometry::SquaredDistance(q, x);
      if (d2 < least2) return true;
      shortest2 = std::min(shortest2, d2);
      longest2 = std::max(longest2, d2);
    }
    if (IsOn(RefinementTerm::kCureKeepsQuality) &&
        complex_.rules.IsTooFar(0.25 * kNarrower * longest2, shortest2)) {
      return true;
    }
    return IsOn(RefinementTerm::kCureKeepsAngles) && facet.angles.IsSurelyBelow(x);
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsSurelyTooShortOrLarge(const std::array<Point, 3>& p, const Point& x,
                                             const Sliver& sliver) const {
  if constexpr (D == 3) {
    const double least2 = kCureDistance * kCureDistance * sliver.shortest2;
    double shortest2 = INFINITY, longest2 = 0;
    for (const Point& q : p) {
      const double d2 = geometry::SquaredDistance(q, x);
      if (d2 < least2) return true;
      shortest2 = std::min(shortest2, d2);
      longest2 = std::max(longest2, d2);
    }
    if (!IsOn(RefinementTerm::kCureKeepsQuality)) return false;
    // Whether or not edges between the three count.
    const double far2 = 0.25 * kNarrower * longest2;
    if (!complex_.rules.IsTooFar(far2, shortest2)) return false;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d2 = geometry::SquaredDistance(p[k], p[(k + 1) % 3]);
      if (d2 < shortest2 && !complex_.rules.IsTooFar(far2, d2)) return false;
    }
    return true;
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsRefusedByCavity(Context& context, const Sliver& sliver, const Point& x,
                                       FeatureSlot facet, Reads* reads) {
  if constexpr (D == 3) {
    const TriangulationOf<D>& base = complex_.slivers.base();
    const bool keeps_angles = IsOn(RefinementTerm::kCureKeepsAngles);
    using Certain = geometry::DihedralBound::Certain;
    unsure_.clear();
    const bool is_kept = base.VisitCavityOf(x, sliver.simplex, &cavity_, [&](const Corner& by) {
      const std::array<VertexIndex, 3>& v = cavity_.facets.back();
      const std::array<Point, 3> p = {base.position(v[0]), base.position(v[1]),
                                      base.position(v[2])};
      Certain angles = Certain::kNone;
      bool is_bad = IsSurelyTooShortOrLarge(p, x, sliver);
      const bool is_outside = complex_.slivers.IsOutside(by.simplex);
      if (!is_bad && keeps_angles && !is_outside) {
        angles = complex_.slivers.Look({p[0], p[1], p[2], x});
        is_bad = angles == Certain::kOne;
      }
      if (!is_bad) {
        unsure_.push_back({by, angles == Certain::kNone});
        return true;
      }
      if (!StaysBad(context, sliver, x, v, p, reads)) return true;
      refusing_.Add(by, Know(v, p, x, sliver, is_outside));
      return false;
    });
    if (!is_kept) return true;
    if (IsOn(RefinementTerm::kCureKeepsFacets) &&
        IsCutOffByFacet(context, sliver, x, facet, reads)) {
      return true;
    }
    for (const auto& [by, angles_are_good] : unsure_) {
      if (!IsRefusedBy(context, sliver, x, by, reads, angles_are_good)) continue;
      const std::array<VertexIndex, 3> v = base.FacetAt(by);
      refusing_.Add(by, Know(v, {base.position(v[0]), base.position(v[1]), base.position(v[2])}, x,
                             sliver, complex_.slivers.IsOutside(by.simplex)));
      return true;
    }
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsCutOffByFacet(Context& context, const Sliver& sliver, const Point& x,
                                     FeatureSlot facet, Reads* reads) {
  if constexpr (D == 3) {
    const auto room = facets_.RoomThatIsCut(x, facet);
    if (!room) return false;
    const TriangulationOf<D>& base = complex_.slivers.base();
    const double radius2 = room->radius * room->radius;
    for (const auto& v : cavity_.facets) {
      for (const VertexIndex u : v) {
        if (!(geometry::SquaredDistance(base.position(u), room->centre) > radius2)) return false;
      }
    }
    if (AnyCureNear(context, sliver, room->centre, room->radius,
                    [](const Point&) { return true; })) {
      return false;
    }
    reads->AddReach(sliver, room->centre, room->radius);
    return true;
  }
  return false;
}

// The first balls are looked up in the tree, the others in a list of all cures near the sliver. It
// grows with the balls as long as it is short: in the tree a ball that is much larger than the
// sliver meets many cells.
template <int D, template <class> class E>
template <class F>
bool CureWork<D, E>::AnyCureNear(Context& context, const Sliver& sliver, const Point& centre,
                                 double radius, F f) {
  constexpr int kFewAsked = 8;
  constexpr double kNear = 5;  // in radii of the sliver
  constexpr std::size_t kMost = 64;
  if constexpr (D == 3) {
    const double reach =
        (std::sqrt(geometry::SquaredDistance(sliver.centre, centre)) + radius) * kRootWider;
    const double first = kNear * sliver.radius;
    if (++asked_near_ > kFewAsked && !(reach < near_reach_ * kNarrower) && reach < most_reach_) {
      // Nearer than the first reach however many there are.
      const double wanted = reach < first * kNarrower ? first : 2 * reach;
      std::vector<Point>& more = more_cures_;
      more.clear();
      AnyCureIn(context, sliver.centre, wanted, [&](VertexIndex, const Point& y) {
        more.push_back(y);
        return wanted > first && more.size() > kMost;
      });
      if (wanted > first && more.size() > kMost) {
        most_reach_ = std::max(first, near_reach_);
      } else {
        near_reach_ = wanted;
        std::swap(near_cures_, more);
      }
    }
    if (!(reach < near_reach_ * kNarrower)) {
      return AnyCureIn(context, centre, radius, [&](VertexIndex, const Point& y) { return f(y); });
    }
    const double radius2 = radius * radius * kWider;
    for (std::size_t i = 0; i < near_cures_.size(); ++i) {
      if (geometry::SquaredDistance(near_cures_[i], centre) > radius2) continue;
      if (!f(near_cures_[i])) continue;
      // The one that was found most gets to the front.
      if (i > 0) std::swap(near_cures_[i - 1], near_cures_[i]);
      return true;
    }
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::Encroaches(Context& context, const Sliver& sliver, const Point& x) {
  constexpr int kFewAsked = 8;
  if (complex_.border_only || ++asked_ <= kFewAsked) {
    return !search_.EncroachedBy(context, x).empty();
  }
  if constexpr (D == 3) {
    if (asked_ == kFewAsked + 1) {
      search_.FindNear(context, sliver.centre,
                       sliver.radius * kBarelyWider + 4 * complex_.rules.ulp(), &near_segments_);
    }
    for (std::size_t i = 0; i < near_segments_.size(); ++i) {
      if (search_.SignOf(complex_.subsegment(near_segments_[i]), x) > 0) continue;
      // The one that held most candidates gets to the front.
      if (i > 0) std::swap(near_segments_[i - 1], near_segments_[i]);
      return true;
    }
  }
  return false;
}

template <int D, template <class> class E>
void CureWork<D, E>::Recall(Context& context, const Sliver& sliver, Reads* reads) {
  around_.clear();
  new_cures_.clear();
  before_ = nullptr;
  const auto tried = failed_.find(context.item);
  if (tried == failed_.end()) return;
  before_ = &tried->second;
  reads->reach = before_->reach;
  AnyCureIn(context, sliver.centre, before_->reach, [this](VertexIndex v, const Point& p) {
    if (v >= before_->first_new) new_cures_.push_back(p);
    return false;
  });
}

template <int D, template <class> class E>
void CureWork<D, E>::Remember(double around, std::size_t number) {
  constexpr std::size_t kMostRemembered = std::size_t{1} << 24;  // 64 MB
  if (remembered_ + number >= kMostRemembered) return;
  around_.resize(number + 1, std::numeric_limits<float>::infinity());
  constexpr float kLeast = std::numeric_limits<float>::min();
  around_[number] = around > 0 ? std::max(static_cast<float>(around * kWider), kLeast) : 0;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsStillRefused(const Point& x, std::size_t number) const {
  if (before_ == nullptr || number >= before_->around.size()) return false;
  const double around = before_->around[number];
  return std::ranges::all_of(new_cures_, [&](const Point& y) {
    return geometry::SquaredDistance(x, y) > around * around;
  });
}

template <int D, template <class> class E>
bool CureWork<D, E>::MakeStarOf(Context& context, const Sliver& sliver, const Point& x) {
  bool has_cures = false;
  if constexpr (D == 3) {
    star_.BeginLink(kNil, x, 4 * complex_.rules.quality() * sliver.radius);
    rim_.Clear();
    const auto slot_of = [this](VertexIndex v) {
      const std::size_t known = rim_.keys().size();
      const auto slot = static_cast<int>(rim_.Number({v}));
      if (rim_.keys().size() > known) star_.AddNeighbour(v, complex_.vertex(v).p);
      return slot;
    };
    for (const auto& [a, b, c] : cavity_.facets) {
      const int first = slot_of(a), second = slot_of(c);  // with x: positively oriented
      star_.AddCorner({first, second, slot_of(b)});
    }
    star_.JoinCorners();
    star_.Close();
    // Insertion makes no ball that extends beyond those it replaces and their neighbours'. So one
    // query is enough (StarVerifier).
    Extent<D> box = Extent<D>::Nothing();
    balls_.clear();
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& corner = star_.corner(i);
      const double radius = std::sqrt(corner.r2) + 2 * corner.error + 4 * complex_.rules.ulp();
      balls_.push_back({CentreOf(star_, i), radius * radius});
      box.AddBall(balls_.back().centre, radius);
    }
    complex_.cured.VisitBalls(
        balls_, box, std::numeric_limits<int>::max(), [&](std::uint32_t v, const Point& p) {
          has_cures |= star_.InsertIf(v, p, [&] { return context.Sees(complex_.vertex(v).birth); });
        });
  }
  return has_cures;
}

template <int D, template <class> class E>
template <class BallOf>
bool CureWork<D, E>::IsTooShortOrLarge(const std::array<VertexIndex, 3>& v,
                                       const std::array<Point, 3>& p, const Point& x,
                                       const Sliver& sliver, BallOf ball_of) const {
  if constexpr (D == 3) {
    const double least2 = kCureDistance * kCureDistance * sliver.shortest2;
    double shortest2 = INFINITY, longest2 = 0;
    for (const Point& q : p) {
      const double d2 = geometry::SquaredDistance(q, x);
      if (d2 < least2) return true;
      shortest2 = std::min(shortest2, d2);
      longest2 = std::max(longest2, d2);
    }
    // The edges between the three that are shorter, the shortest first. Those that are seditious do
    // not count. That takes long to find out, and mostly does not matter.
    struct Edge {
      double d2;
      std::size_t k;
    };
    std::array<Edge, 3> shorter;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const double d2 = geometry::SquaredDistance(p[k], p[(k + 1) % 3]);
      if (!(d2 < shortest2)) continue;
      std::size_t at = count++;
      for (; at > 0 && d2 < shorter[at - 1].d2; --at) shorter[at] = shorter[at - 1];
      shorter[at] = {d2, k};
    }
    const auto is_too_far = [&](double r2) {
      const std::span<const Edge> edges(shorter.data(), count);
      const bool with_x = complex_.rules.IsTooFar(r2, shortest2);
      if (std::ranges::all_of(edges, [&](const Edge& edge) {
            return complex_.rules.IsTooFar(r2, edge.d2) == with_x;
          })) {
        return with_x;
      }
      for (const auto& [d2, k] : edges) {
        if (!complex_.IsSeditious(v[k], v[(k + 1) % 3])) return complex_.rules.IsTooFar(r2, d2);
      }
      return with_x;
    };
    const bool keeps_quality = IsOn(RefinementTerm::kCureKeepsQuality);
    // No two points of a sphere are farther apart than its diameter.
    if (keeps_quality && is_too_far(0.25 * kNarrower * longest2)) return true;
    const geometry::Circumball ball = ball_of();
    Point centre = x;
    for (int k = 0; k < 3; ++k) centre[k] += ball.w[static_cast<std::size_t>(k)];
    return (keeps_quality && is_too_far(ball.r2)) || complex_.IsTooLarge(centre, ball.r2);
  }
  return false;
}

template <int D, template <class> class E>
bool CureWork<D, E>::IsGoodCorner(int i, const Sliver& sliver) {
  if constexpr (D == 3) {
    const auto& corner = star_.corner(i);
    const Point& x = star_.position();
    std::array<VertexIndex, 3> v;
    std::array<Point, 3> p;
    for (std::size_t k = 0; k < 3; ++k) {
      v[k] = star_[corner.n[k]].id;
      p[k] = star_[corner.n[k]].p;
    }
    const auto ball_of = [&] {
      geometry::Circumball ball;
      ball.w = corner.w;
      ball.r2 = corner.r2;
      return ball;
    };
    return !IsTooShortOrLarge(v, p, x, sliver, ball_of) &&
           !(IsOn(RefinementTerm::kCureKeepsAngles) &&
             IsSliver({v[0], v[1], v[2], kNil}, {p[0], p[1], p[2], x}));
  }
  return false;
}

template <int D, template <class> class E>
void CureWork<D, E>::AddCornerTo(Reads* reads, const Sliver& sliver, int i) const {
  if constexpr (D == 3) {
    const auto& corner = star_.corner(i);
    const double radius = std::sqrt(corner.r2) + corner.error + 4 * complex_.rules.ulp();
    if constexpr (kTraced) {
      reads->cover.AddDistantBall(CentreOf(star_, i), radius);
      const auto [a, b, c] = star_.IdsOf(i);
      reads->Read(reads->candidate, a, b, c);
    } else {
      reads->AddReach(sliver, CentreOf(star_, i), radius);
    }
  }
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_CURE_H_
