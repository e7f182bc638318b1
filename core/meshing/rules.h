// The numbers of refinement in any dimension: buckets, slack, how far is looked. What a gap of
// an edge is, and the Steiner point for it, planar_rules.h and space_rules.h say. Everything
// there and here is a function of coordinates to the bit, so that whoever computes it, from
// whichever view of the neighbourhood, gets the same.
//
//   rho     quality asked for: circumradius / shortest edge
//   e       length of the edge in question
//   h       slack of the quality test: coordinates are rounded
//   H       reach: how far a neighbourhood is looked at
// Immutable once made; thread-safe.
#ifndef DYNMESH_CORE_MESHING_RULES_H_
#define DYNMESH_CORE_MESHING_RULES_H_

#include <bit>
#include <cstdint>
#include <vector>

#include "core/geometry/point.h"
#include "dynmesh/options.h"

namespace dynmesh::meshing {

// Bucket of a squared length: its binary exponent and the first bits of its mantissa,
// so four buckets to a binade, each a factor of at most sqrt(1.25) in length, and no
// logarithm, hence no libm, has a say. Finer than the thesis asks (beta = rho / 2^(d-1))
// because shorter edges first makes smaller meshes (ARCHITECTURE.md).
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

// What belongs to any dimension.
template <int D>
class CommonRules {
 public:
  using Point = geometry::Point<D>;

  // Thesis criterion: is a corner of v's Voronoi cell at squared distance r2 too far for
  // a vertex whose nearest neighbour is at squared distance nn2 (Def. 4.2.3)?
  bool IsTooFar(double r2, double nn2) const { return r2 > MostNear2(nn2); }
  // The largest squared distance that is not.
  double MostNear2(double nn2) const { return too_far_[BucketOf(nn2)] * nn2; }
  // gamma / NN: from how far out a Steiner point is taken at most.
  double gamma() const { return 1.5 * quality_; }

  // H for work in `bucket`: more than any length in the bucket times what its Steiner points
  // are away in units of that length, so that no decision about an edge of that bucket depends
  // on what lies farther away.
  double Reach(int bucket) const { return reach_[bucket]; }
  // Every edge of a bucket up to this one is judged rightly by a view of Reach(bucket).
  int LastKnownBucket(int bucket) const { return bucket + kReachBuckets; }

  // Shortest squared length at which anything is inserted or split: below, rounding
  // of coordinates would decide. A fuse; valid input stays far above.
  double least_squared_length() const { return least_squared_length_; }

  // Termination guard: is a subsegment of squared length s2 too short to be split for the
  // sake of a gap in `bucket`? Work of a bucket of edges of length l makes nothing much
  // shorter than l (Lemmas 4.3.1, 5.3.4); where segments meet at angles that rho is too near
  // to 1 for, each split can ask for a shorter one, round after round of one bucket. Halves
  // shorter than l/64 end that. A function of the place in time, which is one of the input.
  static bool IsGuarded(double s2, int bucket) { return s2 < 0x1p-10 * LeastOfBucket(bucket); }

  // Spacing of doubles at the largest coordinates: what a centre may be off by rounding.
  double ulp() const { return ulp_; }
  double quality() const { return quality_; }
  Criterion criterion() const { return criterion_; }
  const Point& lo() const { return lo_; }
  const Point& hi() const { return hi_; }
  // Cells of the grid of vertices on the domain's border, along each axis, and their side.
  int grid_cells() const { return grid_cells_; }
  double grid_spacing() const { return (hi_[0] - lo_[0]) / grid_cells_; }

 protected:
  // Steiner points are at most `farthest` lengths of their edge away from its ends.
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

// The relative slack h of the quality test for edges of squared length `e2`:
// 2e-9 + 8 u / e', u the ulp of the largest coordinate in the domain, e'^2 the
// largest power of two <= e2. A coordinate is rounded by u/2 and R/e changes by at
// most (1/2 + small) |dx| / e; 8 leaves room for the roundings of constructions.
double QualitySlack(double e2, double u);

// The spacing of doubles at the largest coordinate of the domain box.
double UlpOfDomain(const Box& domain, int dimension);

}  // namespace dynmesh::meshing

#endif  // DYNMESH_CORE_MESHING_RULES_H_
