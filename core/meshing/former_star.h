// The star that an operation read in its previous execution.
#ifndef DYNMESH_CORE_MESHING_FORMER_STAR_H_
#define DYNMESH_CORE_MESHING_FORMER_STAR_H_

#include <algorithm>
#include <span>

#include "core/meshing/complex.h"
#include "core/meshing/corner_set.h"
#include "core/meshing/star.h"
#include "core/meshing/star_reads.h"
#include "core/meshing/star_view.h"

namespace dynmesh::meshing {

// Thread-compatible.
template <int D, template <class> class E>
class FormerStar {
 public:
  using Context = ContextOf<D, E>;
  using Point = geometry::Point<D>;
  using Star = meshing::Star<D>;

  explicit FormerStar(const Complex<D, E>& complex) : complex_(complex) {}

  // Starts from the star that the previous execution read. A vertex that conflicts with one of its
  // corners has appeared in this propagation; otherwise the operation would have run in an earlier
  // one. So if all of its neighbours are still there, inserting the vertices that appeared makes it
  // exact. Else the corners with all neighbours still there are exact. Returns false, with nothing
  // done, if it is not worth trying.
  bool Update(Context& context, VertexIndex v, double reach, Star& star);

 private:
  using Corner = typename CornerSet<D>::Corner;  // by its neighbours

  bool Rejoin(const Context& context, VertexIndex v, double reach,
              std::span<const std::uint32_t> words, Star& star, bool* all_stay);
  bool Rebuild(const Context& context, VertexIndex v, double reach,
               std::span<const std::uint32_t> ids, Star& star);
  static Corner Turned(Corner ids);
  void MarkOldCorners(std::span<const std::uint32_t> words, Star& star);
  bool Stays(const Context& context, std::uint32_t id) const;

  const Complex<D, E>& complex_;
  CornerSet<D> old_corners_;  // scratch
};

// --- Implementation -------------------------------------------------------------------------

template <int D, template <class> class E>
bool FormerStar<D, E>::Update(Context& context, VertexIndex v, double reach, Star& star) {
  constexpr std::size_t kFew = 200;
  const auto words = context.old_reads();
  if (words.empty() || complex_.appeared.size() > kFew) return false;
  bool all_stay = true;
  const bool is_joined = Rejoin(context, v, reach, words, star, &all_stay);
  if (!is_joined) all_stay = Rebuild(context, v, reach, NeighboursIn<D>(words), star);
  // No vertex beyond this distance was in a ball that was read.
  const double far2 = context.payload().radius2;
  for (const VertexIndex u : complex_.appeared) {
    if (geometry::SquaredDistance(complex_.vertex(u).p, star.position()) <= far2)
      Offer(complex_, context, u, star);
  }
  if (all_stay) {
    for (int i = 0; i < star.corner_count(); ++i) star.MarkVerified(i);
  } else if (!is_joined) {
    MarkOldCorners(words, star);
  }
  return true;
}

// Marks the corners of the former star as verified.
template <int D, template <class> class E>
void FormerStar<D, E>::MarkOldCorners(std::span<const std::uint32_t> words, Star& star) {
  old_corners_.Clear();
  ForEachCornerIn<D>(words, [this](const Corner& ids) {
    old_corners_.Add(Turned(ids));
    return true;
  });
  old_corners_.Close();
  for (int i = 0; i < star.corner_count(); ++i) {
    if (old_corners_.Has(Turned(star.IdsOf(i)))) star.MarkVerified(i);
  }
}

// 3D: rotates the ids so that the least is first, as a corner may be given by any rotation. 2D: as
// given.
template <int D, template <class> class E>
typename FormerStar<D, E>::Corner FormerStar<D, E>::Turned(Corner ids) {
  if constexpr (D == 3)
    std::rotate(ids.begin(), std::min_element(ids.begin(), ids.end()), ids.end());
  return ids;
}

// True if the neighbour is still there.
template <int D, template <class> class E>
bool FormerStar<D, E>::Stays(const Context& context, std::uint32_t id) const {
  return Star::IsGhost(id) ||
         (complex_.vertex(id).present && context.Sees(complex_.vertex(id).birth));
}

// 3D: makes the star that was read without the neighbours that have gone. The corners that it had
// are marked verified. False if that is not possible.
template <int D, template <class> class E>
bool FormerStar<D, E>::Rejoin(const Context& context, VertexIndex v, double reach,
                              std::span<const std::uint32_t> words, Star& star, bool* all_stay) {
  if constexpr (D == 3) {
    constexpr std::size_t kFew = 256;
    const auto ids = NeighboursIn<D>(words), triangles = words.subspan(ids.size());
    if (ids.size() > kFew || triangles.empty()) return false;
    const Point& p = complex_.vertex(v).p;
    star.BeginLink(v, p, reach);
    for (const std::uint32_t id : ids)
      star.AddNeighbour(id, PositionInStar(complex_, id, p, reach));
    for (const std::uint32_t triangle : triangles) star.AddCorner(IndicesIn(triangle));
    star.JoinCorners();
    star.Close();
    for (int i = 0; i < star.corner_count(); ++i) star.MarkVerified(i);
    for (std::size_t i = 0; i < ids.size(); ++i) {
      if (Stays(context, ids[i])) continue;
      *all_stay = false;
      if (!star.Remove(static_cast<int>(i))) return false;
    }
    if (!*all_stay) star.InsertGhosts();
    return true;
  }
  return false;
}

// Makes the star of those of `ids` that are still there. Returns whether all are.
template <int D, template <class> class E>
bool FormerStar<D, E>::Rebuild(const Context& context, VertexIndex v, double reach,
                               std::span<const std::uint32_t> ids, Star& star) {
  if constexpr (D == 2) {
    star.BeginRing(v, complex_.vertex(v).p, reach);
    for (const std::uint32_t id : ids) {
      if (Star::IsGhost(id)) {
        star.AppendGhost(id);
      } else if (Stays(context, id)) {
        star.Append(id, complex_.vertex(id).p);
      }
    }
    const bool all_stay = star.size() == static_cast<int>(ids.size());
    if (star.Close()) {
      if (!all_stay) star.InsertGhosts();
      return all_stay;
    }
  }
  star.Begin(v, complex_.vertex(v).p, reach);
  for (const std::uint32_t id : ids) Offer(complex_, context, id, star);
  return std::ranges::all_of(ids, [&](std::uint32_t id) { return Stays(context, id); });
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_FORMER_STAR_H_
