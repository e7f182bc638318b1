// The star of a vertex as of an operation's time. Two ways give one result: *local*, by gap-ball
// queries in the spatial tree, seeded with any ring at hand and verified; and *global*, read off a
// triangulation of all vertices present, in a run from scratch. The reads are recorded as a cover.
#ifndef DYNMESH_CORE_MESHING_STAR_FINDER_H_
#define DYNMESH_CORE_MESHING_STAR_FINDER_H_

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/meshing/complex.h"
#include "core/meshing/former_star.h"
#include "core/meshing/link.h"
#include "core/meshing/read_cover.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"
#include "core/meshing/star_seeder.h"
#include "core/meshing/star_verifier.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

// Finds stars. The star is valid, and may be changed by the caller, until the next call.
// Thread-compatible.
template <int D, template <class> class E>
class StarFinder {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Star = meshing::Star<D>;
  using Link = LinkOf<D>;
  static constexpr bool kTraced = kIsTraced<D, E>;

  explicit StarFinder(const Complex<D, E>& complex)
      : complex_(complex), former_star_(complex), seeder_(complex), verifier_(complex) {}

  // The link of v in the triangulation; null if there is none. Valid until the next call.
  Link* FindLink(VertexIndex v) {
    if (!complex_.run.has_triangulation()) return nullptr;
    link_.Read(complex_.run.triangulation(), v);
    return &link_;
  }
  // The star of v with this reach, as of now, read off `link` if that is not null (it may be
  // changed). Traced, records the reads in the context: neighbours, corners and the cover of their
  // balls, and subscribes.
  Star& Find(Context& context, VertexIndex v, double reach, Link* link);

 private:
  void ReadOff(Link& link, VertexIndex v, double reach);
  bool ReadOffLink(Link& link, VertexIndex v, double reach);
  std::uint32_t GhostBeyond(const Point& p) const;
  void RecordReads(Context& context) const;
  double MostJudged() const;

  const Complex<D, E>& complex_;
  FormerStar<D, E> former_star_;
  StarSeeder<D, E> seeder_;
  StarVerifier<D, E> verifier_;
  Link link_;
  Star star_;
  std::vector<std::uint32_t> ring_;  // scratch
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
typename StarFinder<D, E>::Star& StarFinder<D, E>::Find(Context& context, VertexIndex v,
                                                        double reach, Link* link) {
  if (link != nullptr) {
    ReadOff(*link, v, reach);
  } else {
    if (context.first_time() || !former_star_.Update(context, v, reach, star_)) {
      star_.Begin(v, complex_.vertex(v).p, reach);
      seeder_.Run(context, star_);
    }
    verifier_.Run(context, star_);
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
    ReadCover<D> cover(star_.position());
    for (int i = 0; i < star_.corner_count(); ++i) {
      const auto& n = star_.corner(i);
      const double margin = MarginOf<D>(complex_.rules, star_.reach(), n.error);
      if (margin < reach) {
        cover.AddBall(CentreOf(star_, i), std::sqrt(n.r2), margin);
      } else {
        cover.AddAll(farthest2);
      }
    }
    context.payload().SetCover(cover);
    context.payload().most_judged = RoundedUp(MostJudged());
    complex_.Subscribe(context, cover.box());
  }
}

// The radius of the largest ball that may be judged by target lengths, rounded up. INFINITY if it
// is not known, as while there are no sizes. By edges the balls are those of corners of which the
// vertex is the youngest.
template <int D, template <class> class E>
double StarFinder<D, E>::MostJudged() const {
  if (complex_.sizing.empty() || !complex_.by_edge()) return INFINITY;
  double most = 0;
  for (int i = 0; i < star_.corner_count(); ++i) {
    const auto& n = star_.corner(i);
    const double margin = MarginOf<D>(complex_.rules, star_.reach(), n.error);
    const bool is_known = margin < star_.reach() && n.r2 < 1e6 * star_.LeastDistance2(i);
    const double room = most - margin;
    if (is_known && room > 0 && n.r2 * kWider * kWider <= room * room) continue;
    const auto ids = star_.IdsOf(i);
    const bool is_judged = std::ranges::all_of(ids, [&](std::uint32_t id) {
      return !Star::IsGhost(id) && complex_.IsOlder(id, star_.vertex());
    });
    if (!is_judged) continue;
    if (!is_known) return INFINITY;
    // In a lattice most balls are as large, but for the last digits.
    most = (std::sqrt(n.r2) * kWider + margin) * kWider;
  }
  return most;
}

template <int D, template <class> class E>
void StarFinder<D, E>::ReadOff(Link& link, VertexIndex v, double reach) {
  if constexpr (D == 2) {
    const Point& p = complex_.vertex(v).p;
    star_.BeginRing(v, p, reach);
    for (const auto corner : link.corners) {
      const VertexIndex u = complex_.run.triangulation().NextVertex(corner);
      if (u != TriangulationOf<D>::kInfinite) {
        star_.Append(u, complex_.run.triangulation().position(u));
      } else if (!kTraced) {
        // On the border: a ghost beyond it, in the outward direction.
        const Point &lo = complex_.rules.lo(), &hi = complex_.rules.hi();
        const int k = p[0] == hi[0] ? 0 : p[1] == hi[1] ? 1 : p[0] == lo[0] ? 2 : 3;
        star_.AppendGhost(Star::kFirstGhost + k);
      }
    }
    // By edges, no decision depends on corners or on the reach: without a record, the ring is
    // enough.
    if (complex_.is_global()) return;
    star_.Close();
    if (star_.IsWithinReach()) return;
    ring_.clear();
    for (int i = 0; i < star_.size(); ++i) ring_.push_back(star_[i].id);
    star_.Begin(v, p, reach);
    for (const std::uint32_t u : ring_) {
      if (!Star::IsGhost(u)) star_.Insert(u, complex_.vertex(u).p);
    }
  } else {
    if (ReadOffLink(link, v, reach)) {
      // By edges no decision depends on the reach, but those about facets do.
      const bool needs_no_ghosts = link.is_closed && complex_.is_global();
      if (!needs_no_ghosts && !star_.IsWithinReach()) star_.InsertGhosts();
      return;
    }
    star_.Begin(v, complex_.vertex(v).p, reach);
    for (const VertexIndex u : link.neighbours) {
      if (u != TriangulationOf<D>::kInfinite) star_.Insert(u, complex_.vertex(u).p);
    }
  }
}

// Makes the star of `link`, the link of v. If v is on a side of the border, the link is open, and
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
      star_.AddNeighbour(
          id, PositionInStar(complex_, id, p, reach));  // early, near the other reads of it
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

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_STAR_FINDER_H_
