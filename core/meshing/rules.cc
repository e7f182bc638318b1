#include "core/meshing/rules.h"

#include <algorithm>
#include <cmath>

#include "core/base/rounding.h"
#include "core/geometry/constructions.h"
#include "core/meshing/planar_rules.h"
#include "core/meshing/refinement_terms.h"

namespace dynmesh::meshing {

template <int D>
CommonRules<D>::CommonRules(const MeshOptions& options, double farthest)
    : quality_(options.quality),
      criterion_(options.criterion),
      grid_cells_(BorderVertices(options) - 1) {
  const Box domain = DomainBox(options);
  for (int i = 0; i < D; ++i) lo_[i] = domain.lo[i], hi_[i] = domain.hi[i];
  ulp_ = UlpOf(domain, D);
  least_squared_length_ = std::ldexp(ulp_ * ulp_, 12);  // 64 ulps
  // If the square of a length is not a normal double, it keeps the nearest legal bucket.
  constexpr int kLeast = 1 << kBucketFractionBits;
  constexpr int kGreatest = (2047 << kBucketFractionBits) - 1;
  too_far_.resize(kBuckets);
  reach_.resize(kBuckets);
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    const int k = std::ilogb(LeastOfBucket(std::clamp(bucket, kLeast, kGreatest)));
    const double slack = 1 + (IsOn(RefinementTerm::kSlackIsTiny) ? QualitySlackAt(k, ulp_) : 0.01);
    too_far_[bucket] = quality_ * quality_ * slack * slack;
    const int beyond = std::clamp(bucket + kReachBuckets + 1, kLeast, kGreatest);
    reach_[bucket] = 1.001 * farthest * std::sqrt(LeastOfBucket(beyond));
  }
}

template class CommonRules<2>;
template class CommonRules<3>;

PlanarRules::PlanarRules(const MeshOptions& options)
    : CommonRules(options, std::sqrt(geometry::OffCenterB(options.quality))),
      off_center_(4 * geometry::OffCenterB(quality_)),
      kappa_(geometry::OffCenterHeight(quality_)) {
  skinny_.resize(kBuckets);
  for (int bucket = 0; bucket < kBuckets; ++bucket) skinny_[bucket] = 4 * too_far_[bucket];
}

}  // namespace dynmesh::meshing
