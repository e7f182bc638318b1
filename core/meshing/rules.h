// The numbers of refinement in any dimension: buckets, slack, reach. The gap of an edge and its
// Steiner point are in planar_rules.h and space_rules.h. Everything there and here is a function of
// coordinates to the bit. So it does not depend on the view of the neighbourhood from which it is
// computed.
//
//   rho     quality bound: circumradius / shortest edge
//   e       length of the edge in question
//   h       slack of the quality test: coordinates are rounded (base/rounding.h)
//   H       reach: the radius of the neighbourhood that is read
// Immutable once made; thread-safe.
#ifndef DYNMESH_CORE_MESHING_RULES_H_
#define DYNMESH_CORE_MESHING_RULES_H_

#include <bit>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

// Bucket of a squared length: its binary exponent and the first bits of its mantissa. So there are
// four buckets to a binade, each a factor of at most sqrt(1.25) in length. Uses no logarithm, hence
// no libm. Finer than the thesis's beta = rho / 2^(d-1): shorter edges first makes smaller meshes
// (docs/refinement.md).
inline constexpr int kBucketFractionBits = 2;
inline constexpr int kBuckets = 2048 << kBucketFractionBits;
inline int BucketOf(double squared_length) {
  return static_cast<int>(std::bit_cast<std::uint64_t>(squared_length) >>
                          (52 - kBucketFractionBits));
}
// The least squared length of a bucket.
inline double LeastOfBucket(int bucket) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(bucket) << (52 - kBucketFractionBits));
}
// No squared length of the bucket is greater.
inline double EndOfBucket(int bucket) {
  return bucket < BucketOf(INFINITY) ? LeastOfBucket(bucket + 1) : INFINITY;
}

// The rules common to all dimensions.
template <int D>
class CommonRules {
 public:
  using Point = geometry::Point<D>;

  // Thesis criterion: true if a corner of v's Voronoi cell at squared distance r2 is too far, for a
  // vertex with its nearest neighbour at squared distance nn2 (Def. 4.2.3).
  bool IsTooFar(double r2, double nn2) const { return r2 > MostNear2(nn2); }
  // The largest squared distance that is not too far.
  double MostNear2(double nn2) const { return too_far_[BucketOf(nn2)] * nn2; }
  // gamma / NN: the greatest distance at which a Steiner point is inserted.
  double gamma() const { return 1.5 * quality_; }

  // H for work in `bucket`. A Steiner point is at most f e away from the ends of its edge, e the
  // edge's length. H > f e for every e of the bucket. So no decision about an edge of the bucket
  // depends on anything farther away.
  double Reach(int bucket) const { return reach_[bucket]; }
  // A view of Reach(bucket) judges every edge of a bucket up to this one rightly.
  int LastKnownBucket(int bucket) const { return bucket + kReachBuckets; }

  // The shortest squared length at which anything is inserted or split. Below it rounding of
  // coordinates would decide. A safety limit; valid input stays far above.
  double least_squared_length() const { return least_squared_length_; }

  // Termination guard: true if a subsegment of squared length s2 is too short to be split for a gap
  // in `bucket`.
  // 1. Work of a bucket of edges of length l makes nothing much shorter than l (Lemmas 4.3.1 and
  //    5.3.4). These are for rho > 1 without target lengths. Otherwise lengths need not grow from
  //    one round to the next, and the number of rounds of a bucket has no bound.
  // 2. Exception: where segments meet at angles for which rho is too near to 1, each split can
  //    require a shorter one, round after round of one bucket.
  // 3. The guard ends that once halves are shorter than l / 64. It is a function of the place in
  //    time, which is a function of the input.
  static bool IsGuarded(double s2, int bucket) { return s2 < 0x1p-10 * LeastOfBucket(bucket); }

  // Spacing of doubles at the largest coordinates: the rounding error of a centre.
  double ulp() const { return ulp_; }
  double quality() const { return quality_; }
  Criterion criterion() const { return criterion_; }
  const Point& lo() const { return lo_; }
  const Point& hi() const { return hi_; }
  // Number and side of the cells of the grid of vertices on the domain's border, along each axis.
  int grid_cells() const { return grid_cells_; }
  double grid_spacing() const { return (hi_[0] - lo_[0]) / grid_cells_; }

 protected:
  // `farthest`: Steiner points are at most so many lengths of their edge away from its ends.
  CommonRules(const MeshOptions& options, double farthest);
  static constexpr int kReachBuckets = 2 << kBucketFractionBits;

  double quality_;
  double least_squared_length_;
  std::vector<double> too_far_;  // rho^2 (1+h)^2 by bucket

 private:
  Criterion criterion_;
  Point lo_, hi_;
  int grid_cells_;
  double ulp_;
  std::vector<double> reach_;  // H by bucket
};

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_RULES_H_
