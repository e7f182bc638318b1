// Most stars of a load in space have no gap, and the triangulation knows as much: with each
// tetrahedron it keeps its sphere. So what such an operation has read can be told without making
// the star (star_search.h), whose corners would be computed one by one.
//
// To the bit what it would be: what depends on roundings is kept so coarsely that it is nearly
// always certain in spite of them; where it is not, the star is made.
#ifndef DYNMESH_CORE_MESHING_IDLE_STAR_H_
#define DYNMESH_CORE_MESHING_IDLE_STAR_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/meshing/refinement.h"
#include "core/meshing/star_reads.h"

namespace dynmesh::meshing {

// Records what v's Complete reads, if that has certainly nothing to do; else false, and nothing is
// recorded. REQUIRES: with a triangulation, link_ is v's.
template <int D, template <class> class E>
bool Refinement<D, E>::ReadIdleStar(Context& context, VertexIndex v, double reach) {
  if constexpr (D == 3 && kTraced) {
    const bool by_edge_alone = by_edge() && sizing_.empty() && facets_.empty();
    if (triangulation_ == nullptr || !by_edge_alone || !link_.is_closed || MayHaveGap(v))
      return false;
    star_.BeginLink(v, vertices_[v].p, reach);
    const double margin = MarginOf(0);
    StarRegion<D> region(vertices_[v].p);
    double doubt = 0;
    for (const auto t : link_.simplices) {
      const auto sphere = triangulation_->SphereOf(t);
      const double radius = std::sqrt(sphere.high);
      if (!(radius < 0.9 * reach)) return false;
      doubt = std::max(doubt, (sphere.high - sphere.low) / radius);
      region.AddBall(sphere.center, radius, margin);
    }
    // Centre and radius of a corner differ by less than `doubt` from the sphere's, its margin,
    // which counts four times at most, by less than 2e-9 of the radius; what is kept are distances
    // from v, twice the length of what of the centre points into an orthant at most. With floats
    // for low and high, doubt is more than 4e-7 of the largest radius.
    doubt = 8 * doubt + 8 * rules_.ulp();
    if (!context.payload().SetRegion(region, doubt)) return false;
    context.payload().flag = 0;
    WriteStar(link_, [&](std::uint32_t word) { context.Read(word); });
    Extent<D> box = region.box();
    for (int k = 0; k < D; ++k) box.lo[k] -= doubt, box.hi[k] += doubt;
    SubscribeBox(context, box);
    return true;
  }
  return false;
}

// Rather yes than no. REQUIRES: link_ is v's, and closed.
template <int D, template <class> class E>
bool Refinement<D, E>::MayHaveGap(VertexIndex v) const {
  if constexpr (D == 3) {
    constexpr std::size_t kMost = mesh::SmallLinkTables::kMost;
    const auto& neighbours = link_.neighbours;
    if (neighbours.size() > kMost) return true;
    std::array<double, kMost> most_near2;  // by neighbour
    for (std::size_t i = 0; i < neighbours.size(); ++i) {
      const double d2 = geometry::SquaredDistance(triangulation_->position(neighbours[i]),
                                                  triangulation_->position(v));
      most_near2[i] = rules_.MostNear2(d2) * (1 - 1e-6);
    }
    for (std::size_t i = 0; i < link_.triangles.size(); ++i) {
      const auto t = link_.simplices[i];
      if (!triangulation_->HasSphere(t)) return true;
      const double r2 = triangulation_->SphereOf(t).high;
      for (const int u : link_.triangles[i]) {
        if (r2 > most_near2[u] && IsOlder(vertices_[neighbours[u]], vertices_[v])) return true;
      }
    }
    return false;
  }
  return true;
}

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_IDLE_STAR_H_
