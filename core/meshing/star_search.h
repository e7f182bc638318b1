// The star of a vertex as of an operation's time. Two ways give one result: *local*, by gap-ball
// queries in the spatial tree, seeded with any ring at hand and verified; and *global*, read off a
// triangulation of all vertices present, in a run from scratch. The reads are recorded as a region.
#ifndef DYNMESH_CORE_MESHING_STAR_SEARCH_H_
#define DYNMESH_CORE_MESHING_STAR_SEARCH_H_

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/meshing/refinement.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// Reads all simplices around v off the triangulation, if there is one.
template <int D, template <class> class E>
void Refinement<D, E>::FindLink(VertexIndex v) {
  if (triangulation_ == nullptr) return;
  if constexpr (D == 2) {
    triangulation_->CornersAround(v, &corners_);
  } else {
    triangulation_->LinkOf(v, &link_);
  }
}

// REQUIRES: FindLink(v) was called.
template <int D, template <class> class E>
void Refinement<D, E>::FindStar(Context& context, VertexIndex v, double reach) {
  if (triangulation_ != nullptr) {
    StarFromTriangulation(v, reach);
  } else {
    if (context.first_time() || !UpdateStar(context, v, reach)) {
      star_.Begin(v, vertices_[v].p, reach);
      SeedStar(context, v);
    }
    VerifyStar(context);
  }
  if constexpr (kTraced) {
    const double farthest2 = FarthestInView2(reach);
    WriteStar(star_, [&](std::uint32_t word) { context.Read(word); });
    StarRegion<D> region(star_.position());
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& n = star_.corner(i);
      const double margin = MarginOf(n.error);
      if (margin < reach) {
        region.AddBall(CentreOf(i), std::sqrt(n.r2), margin);
      } else {
        region.AddAll(farthest2);
      }
    }
    context.payload().SetRegion(region);
    SubscribeBox(context, region.box());
  }
}

// The greatest squared distance from v within a ball through v inside the ghosts.
template <int D, template <class> class E>
double Refinement<D, E>::FarthestInView2(double reach) const {
  return 4 * D * reach * reach * (1 + 1e-6);
}

// A bound of the error of a corner's computed centre.
template <int D, template <class> class E>
double Refinement<D, E>::MarginOf(double error) const {
  return error + 1e-9 * star_.reach() + 2 * rules_.ulp();
}

template <int D, template <class> class E>
void Refinement<D, E>::StarFromTriangulation(VertexIndex v, double reach) {
  if constexpr (D == 2) {
    const Point& p = vertices_[v].p;
    star_.BeginRing(v, p, reach);
    for (const auto corner : corners_) {
      const VertexIndex u = triangulation_->NextVertex(corner);
      if (u != Triangulation::kInfinite) {
        star_.Append(u, triangulation_->position(u));
      } else if (!kTraced) {
        // On the border: a ghost beyond it, in the outward direction.
        const Point &lo = rules_.lo(), &hi = rules_.hi();
        const int k = p[0] == hi[0] ? 0 : p[1] == hi[1] ? 1 : p[0] == lo[0] ? 2 : 3;
        star_.AppendGhost(Star::kFirstGhost + k);
      }
    }
    // By edges, no decision depends on corners or on the reach: untraced, the ring is enough.
    if (!kTraced && by_edge()) return;
    star_.Close();
    if (star_.IsWithinReach()) return;
    offers_.clear();
    for (int i = 0; i < star_.size(); ++i) offers_.push_back(star_[i].id);
    star_.Begin(v, p, reach);
    for (const std::uint32_t u : offers_) {
      if (!Star::IsGhost(u)) star_.Insert(u, vertices_[u].p);
    }
  } else {
    if (LinkFromTriangulation(v, reach)) {
      // By edges no decision depends on the reach.
      const bool needs_no_ghosts = link_.is_closed && !kTraced && by_edge();
      if (!needs_no_ghosts && !star_.IsWithinReach()) star_.InsertGhosts();
      return;
    }
    star_.Begin(v, vertices_[v].p, reach);
    for (const VertexIndex u : link_.neighbours) {
      if (u != Triangulation::kInfinite) star_.Insert(u, vertices_[u].p);
    }
  }
}

// Makes the star of link_, the link of v. If v is on a side of the border, the link is open, and
// the ghost beyond that side replaces the infinite vertex. Two adjacent corners at the ghost
// conflict no more than their triangles on that side do, and these do not depend on points off the
// side. Returns false, and leaves no star, if the ghost conflicts with another corner or if there
// is more than one side.
template <int D, template <class> class E>
bool Refinement<D, E>::LinkFromTriangulation(VertexIndex v, double reach) {
  if constexpr (D == 3) {
    const Point& p = vertices_[v].p;
    const std::uint32_t beyond = link_.is_closed ? Star::kNobody : GhostBeyond(p);
    if (!link_.is_closed && beyond == Star::kNobody) return false;
    for (const VertexIndex u : link_.neighbours) {
      if (u != Triangulation::kInfinite) __builtin_prefetch(&vertices_[u]);
    }
    star_.BeginLink(v, p, reach);
    for (const VertexIndex u : link_.neighbours) {
      const std::uint32_t id = u != Triangulation::kInfinite ? u : beyond;
      star_.AddNeighbour(id, PlaceOf(id, p, reach));  // early, near the other reads of it
    }
    link_.Join();
    for (std::size_t i = 0; i < link_.triangles.size(); ++i) {
      star_.AddCorner(link_.triangles[i], link_.across[i]);
    }
    star_.Close();
    if (link_.is_closed) return true;
    const Point ghost = PlaceOf(beyond, p, reach);
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
std::uint32_t Refinement<D, E>::GhostBeyond(const Point& p) const {
  std::uint32_t ghost = SpaceStar::kNobody;
  for (std::uint32_t k = 0; k < D; ++k) {
    if (p[k] != rules_.lo()[k] && p[k] != rules_.hi()[k]) continue;
    if (ghost != SpaceStar::kNobody) return SpaceStar::kNobody;
    ghost = SpaceStar::kFirstGhost + 2 * k + (p[k] == rules_.lo()[k] ? 1 : 0);
  }
  return ghost;
}

// Starts from the star that the previous execution read. A vertex that conflicts with one of its
// corners has appeared in this propagation; otherwise the operation would have run in an earlier
// one. So if all of its neighbours are still there, inserting the vertices that appeared makes it
// exact. Else the corners with all neighbours still there are exact. Returns false, with
// nothing done, if it is not worth trying.
template <int D, template <class> class E>
bool Refinement<D, E>::UpdateStar(Context& context, VertexIndex v, double reach) {
  constexpr std::size_t kFew = 200;
  const auto words = context.old_reads();
  if (words.empty() || appeared_.size() > kFew) return false;
  bool all_stay = true;
  const bool is_joined = RejoinStar(context, v, reach, words, &all_stay);
  if (!is_joined) all_stay = RebuildStar(context, v, reach, NeighboursIn<D>(words));
  // No vertex beyond this distance was in a ball that was read.
  const double far2 = context.payload().radius2;
  for (const VertexIndex u : appeared_) {
    if (geometry::SquaredDistance(vertices_[u].p, star_.position()) <= far2) Offer(context, u);
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
void Refinement<D, E>::MarkOldCorners(std::span<const std::uint32_t> words) {
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
typename Refinement<D, E>::Corner Refinement<D, E>::Turned(Corner ids) {
  if constexpr (D == 3)
    std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  return ids;
}

// True if the neighbour is still there.
template <int D, template <class> class E>
bool Refinement<D, E>::Stays(const Context& context, std::uint32_t id) const {
  return Star::IsGhost(id) || (vertices_[id].present && context.Sees(vertices_[id].birth));
}

// 3D: makes the star that was read without the neighbours that have gone. The corners that it had
// are marked verified. False if that is not possible.
template <int D, template <class> class E>
bool Refinement<D, E>::RejoinStar(Context& context, VertexIndex v, double reach,
                                  std::span<const std::uint32_t> words, bool* all_stay) {
  if constexpr (D == 3) {
    constexpr std::size_t kFew = 256;
    const auto ids = NeighboursIn<D>(words), triangles = words.subspan(ids.size());
    if (ids.size() > kFew || triangles.empty()) return false;
    const Point& p = vertices_[v].p;
    star_.BeginLink(v, p, reach);
    for (const std::uint32_t id : ids) star_.AddNeighbour(id, PlaceOf(id, p, reach));
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
bool Refinement<D, E>::RebuildStar(Context& context, VertexIndex v, double reach,
                                   std::span<const std::uint32_t> ids) {
  if constexpr (D == 2) {
    star_.BeginRing(v, vertices_[v].p, reach);
    for (const std::uint32_t id : ids) {
      if (Star::IsGhost(id)) {
        star_.AppendGhost(id);
      } else if (Stays(context, id)) {
        star_.Append(id, vertices_[id].p);
      }
    }
    const bool all_stay = star_.size() == static_cast<int>(ids.size());
    if (star_.Close()) {
      if (!all_stay) star_.InsertGhosts();
      return all_stay;
    }
  }
  star_.Begin(v, vertices_[v].p, reach);
  for (const std::uint32_t id : ids) Offer(context, id);
  return std::ranges::all_of(ids, [&](std::uint32_t id) { return Stays(context, id); });
}

// Offers vertices that are likely to be in the star, which makes verification fast. What is offered
// does not influence the result.
template <int D, template <class> class E>
void Refinement<D, E>::SeedStar(Context& context, VertexIndex v) {
  bool newborn = false;
  offers_.clear();
  auto offer_all = [&](std::span<const std::uint32_t> ids) {
    offers_.insert(offers_.end(), ids.begin(), ids.end());
  };
  if constexpr (kTraced) {
    if (!context.first_time()) {
      offer_all(NeighboursIn<D>(context.old_reads()));
    } else {
      for (sac::OpId o = vertices_[v].operations; o != sac::kNoOp; o = engine_.next_of_item(o)) {
        if (engine_.kind(o) == kComplete && engine_.executed(o))
          offer_all(NeighboursIn<D>(engine_.reads(o)));
      }
      const sac::OpId creator = vertices_[v].creator;
      if (offers_.empty() && creator != sac::kNoOp && engine_.kind(creator) == kComplete) {
        newborn = true;
        offer_all(NeighboursIn<D>(engine_.reads(creator)));
        offers_.push_back(engine_.item(creator));
        for (const sac::Output o : engine_.outputs(creator)) offers_.push_back(IndexOf(o));
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
      tree_.VisitBall(vertices_[v].p, within2, [&](std::uint32_t id, const Point&, double d2) {
        if (id == v || !context.Sees(vertices_[id].birth)) return;
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
void Refinement<D, E>::SortByDistance(std::vector<std::uint32_t>* ids) {
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
void Refinement<D, E>::OfferBeyondNeighbours(Context& context) {
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
      sac::OpId o = vertices_[u].operations;
      while (o != sac::kNoOp && !(engine_.kind(o) == kComplete && engine_.executed(o))) {
        o = engine_.next_of_item(o);
      }
      if (o == sac::kNoOp) continue;
      const auto ring = NeighboursIn<D>(engine_.reads(o));
      offers_.insert(offers_.end(), ring.begin(), ring.end());
    }
    for (const std::uint32_t id : offers_) Offer(context, id);
  }
}

template <int D, template <class> class E>
void Refinement<D, E>::Offer(Context& context, std::uint32_t id) {
  if (!IsVertexWord(id) || id == star_.vertex()) return;
  const Vertex& u = vertices_[id];
  if (!u.present || !context.Sees(u.birth) || star_.Has(id)) return;
  star_.Insert(id, u.p);
}

// The largest balls first, one by one, as they may be huge and full. The rest together, once that
// is worth while.
template <int D, template <class> class E>
void Refinement<D, E>::VerifyStar(Context& context) {
  double worth_a_look = INFINITY;
  // Each vertex is inserted at most once, unless two have one position. That would be an error
  // elsewhere; it must not become an endless loop here.
  std::size_t insertions_left = vertex_count_;
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
bool Refinement<D, E>::InsertAllInCorners(Context& context) {
  constexpr int kFew = D == 2 ? 96 : 400;
  Extent<D> box = Extent<D>::Nothing();
  balls_.clear();
  for (int i = 0; i < star_.corner_count(); ++i) {
    const auto& n = star_.corner(i);
    if (n.verified) continue;
    const double margin = MarginOf(n.error);
    if (!(margin < 1e-3 * star_.reach())) return false;
    const double radius = std::sqrt(n.r2) + 2 * margin;
    balls_.push_back({CentreOf(i), radius * radius});
    box.AddBall(balls_.back().centre, radius);
  }
  if (balls_.empty()) return true;
  return tree_.VisitBalls(balls_, box, kFew, [&](std::uint32_t id, const Point& q) {
    if (id == star_.vertex() || star_.Has(id)) return;
    star_.InsertIf(id, q, [&] { return context.Sees(vertices_[id].birth); });
  });
}

// Searches for a vertex in the ball of corner i. True if one was found and inserted.
template <int D, template <class> class E>
bool Refinement<D, E>::VerifyCorner(Context& context, int i) {
  const auto& n = star_.corner(i);
  const Point& p = star_.position();
  std::uint32_t found = kNil;
  Point found_p = {};
  auto search = [&](const Point& centre, double radius2) {
    tree_.VisitBall(centre, radius2, [&](std::uint32_t id, const Point& q, double d2) {
      if (id == star_.vertex() || star_.Has(id) || !context.Sees(vertices_[id].birth) ||
          !star_.Conflicts(i, q)) {
        return;
      }
      found = id;
      found_p = q;
      radius2 = d2;
    });
    return found != kNil;
  };
  const double margin = MarginOf(n.error);
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
    if (found == kNil) search(CentreOf(i), (r + 2 * margin) * (r + 2 * margin));
  } else {
    // The centre is not known.
    search(p, FarthestInView2(star_.reach()));
  }
  if (found == kNil) {
    star_.MarkVerified(i);
    return false;
  }
  star_.Insert(found, found_p);
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_SEARCH_H_
