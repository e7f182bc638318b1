// The star of a vertex as of an operation's time. Two ways give one result: *local*, by gap-ball
// queries in the spatial tree, seeded with any ring at hand and verified; and *global*, read off a
// triangulation of all vertices present, in a run from scratch. The reads are recorded as a region.
#ifndef DYNMESH_CORE_MESHING_STAR_FINDER_H_
#define DYNMESH_CORE_MESHING_STAR_FINDER_H_

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/corner_set.h"
#include "core/meshing/link.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// The position of a vertex or a ghost of the star at p.
template <int D, template <class> class E>
geometry::Point<D> PositionInStar(const Complex<D, E>& complex, std::uint32_t id,
                                  const geometry::Point<D>& p, double reach) {
  return Star<D>::IsGhost(id) ? Star<D>::Ghost(p, reach, static_cast<int>(id - Star<D>::kFirstGhost))
                              : complex.vertex(id).p;
}

// The greatest squared distance from v within a ball through v inside the ghosts.
template <int D>
double FarthestInView2(double reach) {
  return 4 * D * reach * reach * (1 + 1e-6);
}

// A bound of the error of a corner's computed centre. `error`: the corner's own bound.
template <int D>
double MarginOf(const RulesOf<D>& rules, double reach, double error) {
  return error + 1e-9 * reach + 2 * rules.ulp();
}

// Finds stars. The star is valid, and may be changed by the caller, until the next call.
// Thread-compatible.
template <int D, template <class> class E>
class StarFinder {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Star = meshing::Star<D>;
  using Vertex = meshing::Vertex<D>;
  using Link = LinkOf<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  explicit StarFinder(const Complex<D, E>& complex) : complex_(complex) {}

  // The link of v in the triangulation; null if there is none. Valid until the next call.
  Link* FindLink(VertexIndex v) {
    if (complex_.triangulation == nullptr) return nullptr;
    link_.Read(*complex_.triangulation, v);
    return &link_;
  }
  // The star of v with this reach, as of now, read off `link` if that is not null (it may be
  // changed). Traced, records the reads in the context: neighbours, corners and the region of their
  // balls, and subscribes.
  Star& Find(Context& context, VertexIndex v, double reach, Link* link);

 private:
  using Corner = typename CornerSet<D>::Corner;  // by its neighbours

  void ReadOff(Link& link, VertexIndex v, double reach);
  bool ReadOffLink(Link& link, VertexIndex v, double reach);
  std::uint32_t GhostBeyond(const Point& p) const;
  void RecordReads(Context& context) const;

  bool UpdateStar(Context& context, VertexIndex v, double reach);
  bool RebuildStar(Context& context, VertexIndex v, double reach,
                   std::span<const std::uint32_t> ids);
  bool RejoinStar(Context& context, VertexIndex v, double reach,
                  std::span<const std::uint32_t> words, bool* all_stay);
  static Corner Turned(Corner ids);
  void MarkOldCorners(std::span<const std::uint32_t> words);
  bool Stays(const Context& context, std::uint32_t id) const;

  void SeedStar(Context& context, VertexIndex v);
  void SortByDistance(std::vector<std::uint32_t>* ids);
  void OfferBeyondNeighbours(Context& context);
  void Offer(Context& context, std::uint32_t id);
  double DistanceInStar2(VertexIndex u) const {
    return geometry::SquaredDistance(complex_.vertex(u).p, star_.position());
  }

  void VerifyStar(Context& context);
  bool InsertAllInCorners(Context& context);
  bool VerifyCorner(Context& context, int i);

  const Complex<D, E>& complex_;
  Link link_;
  Star star_;
  // Scratch.
  CornerSet<D> old_corners_;
  std::vector<VertexIndex> far_;
  std::vector<std::uint32_t> offers_;
  std::vector<std::pair<double, std::uint32_t>> by_distance_;
  std::vector<typename SpatialTree<D>::Ball> balls_;
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
typename StarFinder<D, E>::Star& StarFinder<D, E>::Find(Context& context, VertexIndex v,
                                                        double reach, Link* link) {
  if (link != nullptr) {
    ReadOff(*link, v, reach);
  } else {
    if (context.first_time() || !UpdateStar(context, v, reach)) {
      star_.Begin(v, complex_.vertex(v).p, reach);
      SeedStar(context, v);
    }
    VerifyStar(context);
  }
  if constexpr (kTraced) RecordReads(context);
  return star_;
}

template <int D, template <class> class E>
void StarFinder<D, E>::RecordReads(Context& context) const {
  if constexpr (kTraced) {
    const double reach = star_.reach();
    const double farthest2 = FarthestInView2<D>(reach);
    WriteStar(star_, [&](std::uint32_t word) { context.Read(word); });
    StarRegion<D> region(star_.position());
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& n = star_.corner(i);
      const double margin = MarginOf<D>(complex_.rules, star_.reach(), n.error);
      if (margin < reach) {
        region.AddBall(CentreOf(star_, i), std::sqrt(n.r2), margin);
      } else {
        region.AddAll(farthest2);
      }
    }
    context.payload().SetRegion(region);
    complex_.Subscribe(context, region.box());
  }
}

template <int D, template <class> class E>
void StarFinder<D, E>::ReadOff(Link& link, VertexIndex v, double reach) {
  if constexpr (D == 2) {
    const Point& p = complex_.vertex(v).p;
    star_.BeginRing(v, p, reach);
    for (const auto corner : link.corners) {
      const VertexIndex u = complex_.triangulation->NextVertex(corner);
      if (u != TriangulationOf<D>::kInfinite) {
        star_.Append(u, complex_.triangulation->position(u));
      } else if (!kTraced) {
        // On the border: a ghost beyond it, in the outward direction.
        const Point &lo = complex_.rules.lo(), &hi = complex_.rules.hi();
        const int k = p[0] == hi[0] ? 0 : p[1] == hi[1] ? 1 : p[0] == lo[0] ? 2 : 3;
        star_.AppendGhost(Star::kFirstGhost + k);
      }
    }
    // By edges, no decision depends on corners or on the reach: untraced, the ring is enough.
    if (!kTraced && complex_.by_edge()) return;
    star_.Close();
    if (star_.IsWithinReach()) return;
    offers_.clear();
    for (int i = 0; i < star_.size(); ++i) offers_.push_back(star_[i].id);
    star_.Begin(v, p, reach);
    for (const std::uint32_t u : offers_) {
      if (!Star::IsGhost(u)) star_.Insert(u, complex_.vertex(u).p);
    }
  } else {
    if (ReadOffLink(link, v, reach)) {
      // By edges no decision depends on the reach.
      const bool needs_no_ghosts = link.is_closed && !kTraced && complex_.by_edge();
      if (!needs_no_ghosts && !star_.IsWithinReach()) star_.InsertGhosts();
      return;
    }
    star_.Begin(v, complex_.vertex(v).p, reach);
    for (const VertexIndex u : link.neighbours) {
      if (u != TriangulationOf<D>::kInfinite) star_.Insert(u, complex_.vertex(u).p);
    }
  }
}

// Makes the star of link_, the link of v. If v is on a side of the border, the link is open, and
// the ghost beyond that side replaces the infinite vertex. Two adjacent corners at the ghost
// conflict no more than their triangles on that side do, and these do not depend on points off the
// side. Returns false, and leaves no star, if the ghost conflicts with another corner or if there
// is more than one side.
template <int D, template <class> class E>
bool StarFinder<D, E>::ReadOffLink(Link& link, VertexIndex v, double reach) {
  if constexpr (D == 3) {
    const Point& p = complex_.vertex(v).p;
    const std::uint32_t beyond = link.is_closed ? Star::kNobody : GhostBeyond(p);
    if (!link.is_closed && beyond == Star::kNobody) return false;
    for (const VertexIndex u : link.neighbours) {
      if (u != TriangulationOf<D>::kInfinite) __builtin_prefetch(&complex_.vertex(u));
    }
    star_.BeginLink(v, p, reach);
    for (const VertexIndex u : link.neighbours) {
      const std::uint32_t id = u != TriangulationOf<D>::kInfinite ? u : beyond;
      star_.AddNeighbour(id, PositionInStar(complex_, id, p, reach));  // early, near the other reads of it
    }
    link.Join();
    for (std::size_t i = 0; i < link.triangles.size(); ++i) {
      star_.AddCorner(link.triangles[i], link.across[i]);
    }
    star_.Close();
    if (link.is_closed) return true;
    const Point ghost = PositionInStar(complex_, beyond, p, reach);
    for (int i = 0; i < star_.corner_count(); ++i) {
      if (std::ranges::none_of(star_.IdsOf(i), Star::IsGhost) && star_.Conflicts(i, ghost)) {
        return false;
      }
    }
    return true;
  }
  return false;
}

// 3D: the ghost beyond the side of the domain on which p is; kNobody unless p is on exactly one
// side.
template <int D, template <class> class E>
std::uint32_t StarFinder<D, E>::GhostBeyond(const Point& p) const {
  std::uint32_t ghost = SpaceStar::kNobody;
  for (std::uint32_t k = 0; k < D; ++k) {
    if (p[k] != complex_.rules.lo()[k] && p[k] != complex_.rules.hi()[k]) continue;
    if (ghost != SpaceStar::kNobody) return SpaceStar::kNobody;
    ghost = SpaceStar::kFirstGhost + 2 * k + (p[k] == complex_.rules.lo()[k] ? 1 : 0);
  }
  return ghost;
}

// Starts from the star that the previous execution read. A vertex that conflicts with one of its
// corners has appeared in this propagation; otherwise the operation would have run in an earlier
// one. So if all of its neighbours are still there, inserting the vertices that appeared makes it
// exact. Else the corners with all neighbours still there are exact. Returns false, with
// nothing done, if it is not worth trying.
template <int D, template <class> class E>
bool StarFinder<D, E>::UpdateStar(Context& context, VertexIndex v, double reach) {
  constexpr std::size_t kFew = 200;
  const auto words = context.old_reads();
  if (words.empty() || complex_.appeared.size() > kFew) return false;
  bool all_stay = true;
  const bool is_joined = RejoinStar(context, v, reach, words, &all_stay);
  if (!is_joined) all_stay = RebuildStar(context, v, reach, NeighboursIn<D>(words));
  // No vertex beyond this distance was in a ball that was read.
  const double far2 = context.payload().radius2;
  for (const VertexIndex u : complex_.appeared) {
    if (geometry::SquaredDistance(complex_.vertex(u).p, star_.position()) <= far2) Offer(context, u);
  }
  if (all_stay) {
    for (int i = 0; i < star_.corner_count(); ++i) star_.MarkVerified(i);
  } else if (!is_joined) {
    MarkOldCorners(words);
  }
  return true;
}

// Marks the corners of the former star as verified.
template <int D, template <class> class E>
void StarFinder<D, E>::MarkOldCorners(std::span<const std::uint32_t> words) {
  old_corners_.Clear();
  ForEachCornerIn<D>(words, [this](const Corner& ids) {
    old_corners_.Add(Turned(ids));
    return true;
  });
  old_corners_.Close();
  for (int i = 0; i < star_.corner_count(); ++i) {
    if (old_corners_.Has(Turned(star_.IdsOf(i)))) star_.MarkVerified(i);
  }
}

// 3D: rotates the ids so that the least is first, as a corner may be given by any rotation. 2D: as
// given.
template <int D, template <class> class E>
typename StarFinder<D, E>::Corner StarFinder<D, E>::Turned(Corner ids) {
  if constexpr (D == 3)
    std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  return ids;
}

// True if the neighbour is still there.
template <int D, template <class> class E>
bool StarFinder<D, E>::Stays(const Context& context, std::uint32_t id) const {
  return Star::IsGhost(id) || (complex_.vertex(id).present && context.Sees(complex_.vertex(id).birth));
}

// 3D: makes the star that was read without the neighbours that have gone. The corners that it had
// are marked verified. False if that is not possible.
template <int D, template <class> class E>
bool StarFinder<D, E>::RejoinStar(Context& context, VertexIndex v, double reach,
                                  std::span<const std::uint32_t> words, bool* all_stay) {
  if constexpr (D == 3) {
    constexpr std::size_t kFew = 256;
    const auto ids = NeighboursIn<D>(words), triangles = words.subspan(ids.size());
    if (ids.size() > kFew || triangles.empty()) return false;
    const Point& p = complex_.vertex(v).p;
    star_.BeginLink(v, p, reach);
    for (const std::uint32_t id : ids) star_.AddNeighbour(id, PositionInStar(complex_, id, p, reach));
    for (const std::uint32_t triangle : triangles) star_.AddCorner(PlacesIn(triangle));
    star_.JoinCorners();
    star_.Close();
    for (int i = 0; i < star_.corner_count(); ++i) star_.MarkVerified(i);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (Stays(context, ids[i])) continue;
      *all_stay = false;
      if (!star_.Remove(static_cast<int>(i))) return false;
    }
    if (!*all_stay) star_.InsertGhosts();
    return true;
  }
  return false;
}

// Makes the star of those of `ids` that are still there. Returns whether all are.
template <int D, template <class> class E>
bool StarFinder<D, E>::RebuildStar(Context& context, VertexIndex v, double reach,
                                   std::span<const std::uint32_t> ids) {
  if constexpr (D == 2) {
    star_.BeginRing(v, complex_.vertex(v).p, reach);
    for (const std::uint32_t id : ids) {
      if (Star::IsGhost(id)) {
        star_.AppendGhost(id);
      } else if (Stays(context, id)) {
        star_.Append(id, complex_.vertex(id).p);
      }
    }
    const bool all_stay = star_.size() == static_cast<int>(ids.size());
    if (star_.Close()) {
      if (!all_stay) star_.InsertGhosts();
      return all_stay;
    }
  }
  star_.Begin(v, complex_.vertex(v).p, reach);
  for (const std::uint32_t id : ids) Offer(context, id);
  return std::ranges::all_of(ids, [&](std::uint32_t id) { return Stays(context, id); });
}

// Offers vertices that are likely to be in the star, which makes verification fast. What is offered
// does not influence the result.
template <int D, template <class> class E>
void StarFinder<D, E>::SeedStar(Context& context, VertexIndex v) {
  bool newborn = false;
  offers_.clear();
  auto offer_all = [&](std::span<const std::uint32_t> ids) {
    offers_.insert(offers_.end(), ids.begin(), ids.end());
  };
  if constexpr (kTraced) {
    if (!context.first_time()) {
      offer_all(NeighboursIn<D>(context.old_reads()));
    } else {
      for (sac::OpId o = complex_.vertex(v).operations; o != sac::kNoOp; o = complex_.engine.next_of_item(o)) {
        if (complex_.engine.kind(o) == kComplete && complex_.engine.executed(o))
          offer_all(NeighboursIn<D>(complex_.engine.reads(o)));
      }
      const sac::OpId creator = complex_.vertex(v).creator;
      if (offers_.empty() && creator != sac::kNoOp && complex_.engine.kind(creator) == kComplete) {
        newborn = true;
        offer_all(NeighboursIn<D>(complex_.engine.reads(creator)));
        offers_.push_back(complex_.engine.item(creator));
        for (const sac::Output o : complex_.engine.outputs(creator)) offers_.push_back(IndexOf(o));
      }
    }
  }
  if (offers_.empty()) {
    // The nearest few within a little more than the lengths of this bucket; in 3D, within more if
    // these are too few. Where target lengths apply, there may be thousands.
    double r2 = 2.25 * LeastOfBucket(BucketOfEpoch(context.epoch) + 1);
    constexpr std::size_t kEnough = D == 2 ? 0 : 16, kMost = 32;
    const double most2 = 10 * r2;
    do {
      by_distance_.clear();
      double within2 = r2;
      complex_.tree.VisitBall(complex_.vertex(v).p, within2, [&](std::uint32_t id, const Point&, double d2) {
        if (id == v || !context.Sees(complex_.vertex(id).birth)) return;
        if (by_distance_.size() == kMost) {
          std::pop_heap(by_distance_.begin(), by_distance_.end());
          by_distance_.pop_back();
        }
        by_distance_.emplace_back(d2, id);
        std::push_heap(by_distance_.begin(), by_distance_.end());
        if (by_distance_.size() == kMost) within2 = by_distance_.front().first;
      });
      r2 *= 2;
    } while (by_distance_.size() < kEnough && r2 < most2);
    std::sort_heap(by_distance_.begin(), by_distance_.end());
    for (const auto& [d2, id] : by_distance_) offers_.push_back(id);
  } else if constexpr (D == 3) {
    SortByDistance(&offers_);
  }
  for (const std::uint32_t id : offers_) Offer(context, id);
  if (newborn) OfferBeyondNeighbours(context);
}

// The nearest first: then fewer temporary corners are made.
template <int D, template <class> class E>
void StarFinder<D, E>::SortByDistance(std::vector<std::uint32_t>* ids) {
  by_distance_.clear();
  for (const std::uint32_t id : *ids) {
    if (IsVertexWord(id)) by_distance_.emplace_back(DistanceInStar2(id), id);
  }
  std::sort(by_distance_.begin(), by_distance_.end());
  by_distance_.erase(std::unique(by_distance_.begin(), by_distance_.end()), by_distance_.end());
  ids->clear();
  for (const auto& [d2, id] : by_distance_) ids->push_back(id);
}

// The creator of a newborn has seen only one side of it. What lies on the other side is in the
// rings of its neighbours there: those that still have a large corner.
template <int D, template <class> class E>
void StarFinder<D, E>::OfferBeyondNeighbours(Context& context) {
  if constexpr (kTraced) {
    far_.clear();
    for (int i = 0; i < star_.corner_count(); ++i) {
      for (const auto id : star_.IdsOf(i)) {
        if (!Star::IsGhost(id) && star_.corner(i).r2 >= 4 * DistanceInStar2(id)) far_.push_back(id);
      }
    }
    std::sort(far_.begin(), far_.end());
    far_.erase(std::unique(far_.begin(), far_.end()), far_.end());
    offers_.clear();
    for (const VertexIndex u : far_) {
      sac::OpId o = complex_.vertex(u).operations;
      while (o != sac::kNoOp && !(complex_.engine.kind(o) == kComplete && complex_.engine.executed(o))) {
        o = complex_.engine.next_of_item(o);
      }
      if (o == sac::kNoOp) continue;
      const auto ring = NeighboursIn<D>(complex_.engine.reads(o));
      offers_.insert(offers_.end(), ring.begin(), ring.end());
    }
    for (const std::uint32_t id : offers_) Offer(context, id);
  }
}

template <int D, template <class> class E>
void StarFinder<D, E>::Offer(Context& context, std::uint32_t id) {
  if (!IsVertexWord(id) || id == star_.vertex()) return;
  const Vertex& u = complex_.vertex(id);
  if (!u.present || !context.Sees(u.birth) || star_.Has(id)) return;
  star_.Insert(id, u.p);
}

// The largest balls first, one by one, as they may be huge and full. The rest together, once that
// is worth while.
template <int D, template <class> class E>
void StarFinder<D, E>::VerifyStar(Context& context) {
  double worth_a_look = INFINITY;
  // Each vertex is inserted at most once, unless two have one position. That would be an error
  // elsewhere; it must not become an endless loop here.
  std::size_t insertions_left = complex_.elements.vertex_count();
  while (insertions_left > 0) {
    int largest = -1;
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& n = star_.corner(i);
      if (!n.verified && (largest < 0 || n.r2 > star_.corner(largest).r2)) largest = i;
    }
    if (largest < 0) return;
    const double r2 = star_.corner(largest).r2;
    if (r2 <= worth_a_look) {
      if (InsertAllInCorners(context)) return;
      worth_a_look = r2 / 8;
      continue;  // Some may have been inserted: then another corner is the largest.
    }
    if (VerifyCorner(context, largest)) --insertions_left;
  }
}

// If the unverified corners are near their final state, few vertices lie about their balls, and one
// query finds them all. Insertion makes no ball that extends beyond those it replaces and their
// neighbours', so each vertex is tested only once. Returns false if there are too many vertices to
// test: balls may be huge and full.
template <int D, template <class> class E>
bool StarFinder<D, E>::InsertAllInCorners(Context& context) {
  constexpr int kFew = D == 2 ? 96 : 400;
  Extent<D> box = Extent<D>::Nothing();
  balls_.clear();
  for (int i = 0; i < star_.corner_count(); ++i) {
    const auto& n = star_.corner(i);
    if (n.verified) continue;
    const double margin = MarginOf<D>(complex_.rules, star_.reach(), n.error);
    if (!(margin < 1e-3 * star_.reach())) return false;
    const double radius = std::sqrt(n.r2) + 2 * margin;
    balls_.push_back({CentreOf(star_, i), radius * radius});
    box.AddBall(balls_.back().centre, radius);
  }
  if (balls_.empty()) return true;
  return complex_.tree.VisitBalls(balls_, box, kFew, [&](std::uint32_t id, const Point& q) {
    if (id == star_.vertex() || star_.Has(id)) return;
    star_.InsertIf(id, q, [&] { return context.Sees(complex_.vertex(id).birth); });
  });
}

// Searches for a vertex in the ball of corner i. True if one was found and inserted.
template <int D, template <class> class E>
bool StarFinder<D, E>::VerifyCorner(Context& context, int i) {
  const auto& n = star_.corner(i);
  const Point& p = star_.position();
  std::uint32_t found = kNil;
  Point found_p = {};
  auto search = [&](const Point& centre, double radius2) {
    complex_.tree.VisitBall(centre, radius2, [&](std::uint32_t id, const Point& q, double d2) {
      if (id == star_.vertex() || star_.Has(id) || !context.Sees(complex_.vertex(id).birth) ||
          !star_.Conflicts(i, q)) {
        return;
      }
      found = id;
      found_p = q;
      radius2 = d2;
    });
    return found != kNil;
  };
  const double margin = MarginOf<D>(complex_.rules, star_.reach(), n.error);
  if (margin < 1e-3 * star_.reach()) {
    // A tentative ball may be huge and full. So first balls inside it that touch it at v, growing
    // from the scale of what is known.
    const double r = std::sqrt(n.r2);
    const double nearest = std::sqrt(star_.LeastDistance2(i));
    for (double s = nearest; 0 < s && s < r / 2; s *= 2.5) {
      Point centre = p;
      for (int k = 0; k < D; ++k) centre[k] += n.w[k] * (s / r);
      if (search(centre, s * s)) break;
    }
    if (found == kNil) search(CentreOf(star_, i), (r + 2 * margin) * (r + 2 * margin));
  } else {
    // The centre is not known.
    search(p, FarthestInView2<D>(star_.reach()));
  }
  if (found == kNil) {
    star_.MarkVerified(i);
    return false;
  }
  star_.Insert(found, found_p);
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_FINDER_H_
