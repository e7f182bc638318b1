#include "core/meshing/rules.h"

#include <algorithm>
#include <cmath>

#include "core/meshing/planar_rules.h"

namespace dynmesh::meshing {

double UlpOfDomain(const Box& domain, int dimension) {
  double largest = 0;
  for (int i = 0; i < dimension; ++i) {
    largest = std::max({largest, std::fabs(domain.lo[i]), std::fabs(domain.hi[i])});
  }
  return std::ldexp(1.0, std::ilogb(largest) - 52);
}

double QualitySlack(double e2, double u) {
  const double e = std::sqrt(std::ldexp(1.0, std::ilogb(e2)));
  return 2e-9 + 8 * u / e;
}

template <int D>
CommonRules<D>::CommonRules(const MeshOptions& options, double farthest)
    : quality_(options.quality),
      criterion_(options.criterion),
      grid_cells_(BorderVertices(options) - 1) {
  const Box domain = DomainBox(options);
  for (int i = 0; i < D; ++i) lo_[i] = domain.lo[i], hi_[i] = domain.hi[i];
  ulp_ = UlpOfDomain(domain, D);
  least_squared_length_ = std::ldexp(ulp_ * ulp_, 12);  // 64 ulps
  // If the square of a length is not a normal double, it keeps the nearest legal bucket.
  constexpr int kLeast = 1 << kBucketFractionBits;
  constexpr int kGreatest = (2047 << kBucketFractionBits) - 1;
  too_far_.resize(kBuckets);
  reach_.resize(kBuckets);
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    const double slack =
        1 + QualitySlack(LeastOfBucket(std::clamp(bucket, kLeast, kGreatest)), ulp_);
    too_far_[bucket] = quality_ * quality_ * slack * slack;
    const int beyond = std::clamp(bucket + kReachBuckets + 1, kLeast, kGreatest);
    reach_[bucket] = 1.001 * farthest * std::sqrt(LeastOfBucket(beyond));
  }
}

template class CommonRules<2>;
template class CommonRules<3>;

namespace {

double OffCenterB(double rho) {
  const double rho2 = rho * rho;
  return 2 * rho2 + std::sqrt(4 * rho2 * rho2 - rho2);
}

}  // namespace

PlanarRules::PlanarRules(const MeshOptions& options)
    : CommonRules(options, std::sqrt(OffCenterB(options.quality))) {
  const double b = OffCenterB(quality_);
  off_center_ = 4 * b;
  kappa_ = std::sqrt(b - 0.25);
  skinny_.resize(kBuckets);
  for (int bucket = 0; bucket < kBuckets; ++bucket) skinny_[bucket] = 4 * too_far_[bucket];
}

}  // namespace dynmesh::meshing
