// The gap of an edge in 2D, and its Steiner point.
//
//   B       the off-center's triangle has longer sides of squared length B e^2
// Immutable once made; thread-safe.
#ifndef DYNMESH_CORE_MESHING_PLANAR_RULES_H_
#define DYNMESH_CORE_MESHING_PLANAR_RULES_H_

#include <cstdint>
#include <vector>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement_terms.h"
#include "core/meshing/rules.h"

namespace dynmesh::meshing {

enum class Gap : std::uint8_t { kNone, kCircumcenter, kOffCenter };

class PlanarRules : public CommonRules<2> {
 public:
  explicit PlanarRules(const MeshOptions& options);

  // The gap of edge pq on the side of c, (p, q, c) counter-clockwise. There is one if r > rho (1+h)
  // e (edge criterion). Its kind says whether the circumcenter is nearer than the off-center.
  // Symmetric in p and q to the bit.
  [[gnu::always_inline]] inline Gap GapAt(const geometry::Point2& p, const geometry::Point2& q,
                                          const geometry::Point2& c, int bucket) const {
    const double px = p[0] - c[0], py = p[1] - c[1], qx = q[0] - c[0], qy = q[1] - c[1];
    const double cross = px * qy - py * qx;
    const double product = (px * px + py * py) * (qx * qx + qy * qy);
    if (!(product > skinny_[bucket] * cross * cross)) return Gap::kNone;
    if (!(px * qx + py * qy > 0)) return Gap::kNone;  // the centre lies beyond pq
    if (!IsOn(RefinementTerm::kNearerCenter)) return Gap::kOffCenter;
    if (!IsOn(RefinementTerm::kOffCenter)) return Gap::kCircumcenter;
    return product > off_center_ * cross * cross ? Gap::kOffCenter : Gap::kCircumcenter;
  }

  // True if the Voronoi edge of pq begins on the *other* side of the edge, seen from d, and so far
  // out that the gap's Steiner point would not lie on it. (q, p, d) is counter-clockwise. Then
  // shorter edges, to d, have the same gap, and pq is left alone for good, as Voronoi edges only
  // shrink.
  bool BeginsBeyond(const geometry::Point2& p, const geometry::Point2& q,
                    const geometry::Point2& d) const {
    const double px = p[0] - d[0], py = p[1] - d[1], qx = q[0] - d[0], qy = q[1] - d[1];
    if (!(px * qx + py * qy < 0) || !IsOn(RefinementTerm::kPointFits)) return false;
    const double cross = px * qy - py * qx;
    return (px * px + py * py) * (qx * qx + qy * qy) > off_center_ * cross * cross;
  }

  // The gap of edge pq, of squared length e2, with room for a point on the side of c. (p, q, c) is
  // counter-clockwise. c = null: the view ends there, and the off-center fits. d: the apex on the
  // other side, or null.
  [[gnu::always_inline]] inline Gap GapOfEdge(const geometry::Point2& p, const geometry::Point2& q,
                                              double e2, const geometry::Point2* c,
                                              const geometry::Point2* d) const {
    if (e2 < least_squared_length_) return Gap::kNone;
    const Gap gap = c == nullptr ? Gap::kOffCenter : GapAt(p, q, *c, BucketOf(e2));
    return gap != Gap::kNone && d != nullptr && BeginsBeyond(p, q, *d) ? Gap::kNone : gap;
  }

  // The off-center of pq to its left.
  geometry::Point2 OffCenter(const geometry::Point2& p, const geometry::Point2& q) const {
    return geometry::OffCenter(p, q, kappa_);
  }

 private:
  double off_center_;           // 4 B
  double kappa_;                // height of the off-center over the edge, in units of e
  std::vector<double> skinny_;  // 4 rho^2 (1+h)^2 by bucket
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_PLANAR_RULES_H_
