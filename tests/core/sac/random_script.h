// Shared by the random tests of this folder: the seed, which is printed. Set DYNMESH_TEST_SEED to
// repeat a run.
#ifndef DYNMESH_TESTS_CORE_SAC_RANDOM_SCRIPT_H_
#define DYNMESH_TESTS_CORE_SAC_RANDOM_SCRIPT_H_

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

#include "tests/support/seed.h"

namespace dynmesh::sac::testing {

using test::NewSeed;

class Random {
 public:
  explicit Random(std::uint64_t seed) : generator_(seed) {}

  std::uint64_t Word() { return generator_(); }
  // Uniform enough in [0, n). REQUIRES: n > 0.
  std::uint32_t Below(std::uint64_t n) { return static_cast<std::uint32_t>(generator_() % n); }
  bool OneIn(std::uint64_t n) { return Below(n) == 0; }

 private:
  std::mt19937_64 generator_;
};

}  // namespace dynmesh::sac::testing

#endif  // DYNMESH_TESTS_CORE_SAC_RANDOM_SCRIPT_H_
