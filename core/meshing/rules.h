// The numbers of refinement in the plane: buckets, the quality test, the Steiner
// point of a gap. Everything here is a function of coordinates to the bit, so that
// whoever computes it, from whichever view of the neighbourhood, gets the same.
//
//   rho     quality asked for: circumradius / shortest edge
//   e       length of the edge in question
//   B       the off-center's triangle has longer sides of squared length B e^2
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

enum class Gap : std::uint8_t { kNone, kCircumcenter, kOffCenter };

class Rules {
 public:
  explicit Rules(const MeshOptions& options);

  // What is beyond edge pq on the side of c, (p, q, c) counter-clockwise: no gap,
  // or one too large for the edge, r > rho (1+h) e (edge criterion), and whether
  // its circumcenter is nearer than the off-center. Symmetric in p and q to the bit.
  Gap GapAt(const geometry::Point2& p, const geometry::Point2& q, const geometry::Point2& c,
            int bucket) const {
    const double px = p[0] - c[0], py = p[1] - c[1], qx = q[0] - c[0], qy = q[1] - c[1];
    const double cross = px * qy - py * qx;
    const double product = (px * px + py * py) * (qx * qx + qy * qy);
    if (!(product > skinny_[bucket] * cross * cross)) return Gap::kNone;
    if (!(px * qx + py * qy > 0)) return Gap::kNone;  // the centre lies beyond pq
    return product > off_center_ * cross * cross ? Gap::kOffCenter : Gap::kCircumcenter;
  }

  // Does the Voronoi edge of pq begin so far out on the *other* side of the edge,
  // seen from d, (q, p, d) counter-clockwise, that the gap's Steiner point would not
  // lie on it? Then shorter edges, to d, have the same gap, and pq is left alone for
  // good: Voronoi edges only shrink.
  bool BeginsBeyond(const geometry::Point2& p, const geometry::Point2& q,
                    const geometry::Point2& d) const {
    const double px = p[0] - d[0], py = p[1] - d[1], qx = q[0] - d[0], qy = q[1] - d[1];
    if (!(px * qx + py * qy < 0)) return false;
    const double cross = px * qy - py * qx;
    return (px * px + py * py) * (qx * qx + qy * qy) > off_center_ * cross * cross;
  }

  // The gap of edge pq, of squared length e2, that a point may be put into on the side of
  // c, (p, q, c) counter-clockwise; without a c the view ends there, and the off-center
  // fits. d, if there is one, is the apex on the other side.
  Gap GapOfEdge(const geometry::Point2& p, const geometry::Point2& q, double e2,
                const geometry::Point2* c, const geometry::Point2* d) const {
    if (e2 < least_squared_length_) return Gap::kNone;
    const Gap gap = c == nullptr ? Gap::kOffCenter : GapAt(p, q, *c, BucketOf(e2));
    return gap != Gap::kNone && d != nullptr && BeginsBeyond(p, q, *d) ? Gap::kNone : gap;
  }

  // The off-center of pq to its left: on the bisector, at sqrt(B) e from both ends.
  geometry::Point2 OffCenter(const geometry::Point2& p, const geometry::Point2& q) const {
    return {{0.5 * (p[0] + q[0]) - kappa_ * (q[1] - p[1]),
             0.5 * (p[1] + q[1]) + kappa_ * (q[0] - p[0])}};
  }

  // Thesis criterion: is a corner of v's Voronoi cell at squared distance r2 too far for
  // a vertex whose nearest neighbour is at squared distance nn2 (Def. 4.2.3)?
  bool IsTooFar(double r2, double nn2) const { return r2 > too_far_[BucketOf(nn2)] * nn2; }
  // gamma / NN: from how far out a Steiner point is taken at most.
  double gamma() const { return 1.5 * quality_; }

  // H for work in `bucket`: more than sqrt(B) times any length in the bucket, so that
  // no decision about an edge of that bucket depends on what lies farther away.
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
  const geometry::Point2& lo() const { return lo_; }
  const geometry::Point2& hi() const { return hi_; }
  double grid_spacing() const { return spacing_; }  // of the domain's border vertices

 private:
  static constexpr int kReachBuckets = 2 << kBucketFractionBits;

  double quality_;
  Criterion criterion_;
  double off_center_;  // 4 B
  double kappa_;       // height of the off-center over the edge, in units of e
  double least_squared_length_;
  geometry::Point2 lo_, hi_;
  double spacing_;
  double ulp_;
  std::vector<double> skinny_;   // 4 rho^2 (1+h)^2 by bucket
  std::vector<double> too_far_;  // rho^2 (1+h)^2 by bucket
  std::vector<double> reach_;    // H by bucket
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
