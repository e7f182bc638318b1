#include "core/meshing/rules.h"

#include <algorithm>
#include <cmath>

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

Rules::Rules(const MeshOptions& options)
    : quality_(options.quality), criterion_(options.criterion) {
  const Box domain = DomainBox(options);
  lo_ = {{domain.lo[0], domain.lo[1]}};
  hi_ = {{domain.hi[0], domain.hi[1]}};
  spacing_ = (hi_[0] - lo_[0]) / 6;
  const double u = UlpOfDomain(domain, 2);
  ulp_ = u;
  const double rho2 = quality_ * quality_;
  const double b = 2 * rho2 + std::sqrt(4 * rho2 * rho2 - rho2);
  off_center_ = 4 * b;
  kappa_ = std::sqrt(b - 0.25);
  least_squared_length_ = std::ldexp(u * u, 12);  // 64 ulps
  // Lengths whose squares are no normal doubles keep the nearest legal bucket.
  constexpr int kLeast = 1 << kBucketFractionBits;
  constexpr int kGreatest = (2047 << kBucketFractionBits) - 1;
  skinny_.resize(kBuckets);
  too_far_.resize(kBuckets);
  reach_.resize(kBuckets);
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    const double slack = 1 + QualitySlack(LeastOfBucket(std::clamp(bucket, kLeast, kGreatest)), u);
    skinny_[bucket] = 4 * rho2 * slack * slack;
    too_far_[bucket] = rho2 * slack * slack;
    const int beyond = std::clamp(bucket + kReachBuckets + 1, kLeast, kGreatest);
    reach_[bucket] = 1.001 * std::sqrt(b) * std::sqrt(LeastOfBucket(beyond));
  }
}

}  // namespace dynmesh::meshing
