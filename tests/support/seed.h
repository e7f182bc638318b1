// The seed of a random test.
#ifndef DYNMESH_TESTS_SUPPORT_SEED_H_
#define DYNMESH_TESTS_SUPPORT_SEED_H_

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <random>

namespace dynmesh::test {

// A fresh seed below 2^32; with DYNMESH_TEST_SEED in the environment, that one. It is printed in
// the form that repeats the run.
inline std::uint64_t NewSeed() {
  const char* given = std::getenv("DYNMESH_TEST_SEED");
  const std::uint64_t seed =
      given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
  std::printf("DYNMESH_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed));
  std::fflush(stdout);
  return seed;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_SEED_H_
