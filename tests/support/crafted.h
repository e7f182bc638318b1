// Input that a client can make with knowledge of the hashes: they are fixed, public and invertible.
// Ids of vertices and of sets of polygons: core/mesh_data/hash.cc; priorities: geometry::HashOf.
#ifndef DYNMESH_TESTS_SUPPORT_CRAFTED_H_
#define DYNMESH_TESTS_SUPPORT_CRAFTED_H_

#include <array>
#include <bit>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

#include "core/base/mix.h"
#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::test {

// All of them fold words by h = Mix(h ^ word), from a key.

// Mix(Unmix(h)) == h.
inline std::uint64_t Unmix(std::uint64_t h) {
  const auto unshift = [](std::uint64_t z, int by) {
    std::uint64_t x = z;
    for (int known = by; known < 64; known += by) x = z ^ (x >> by);
    return x;
  };
  const auto inverse = [](std::uint64_t odd) {  // modulo 2^64
    std::uint64_t x = odd;
    for (int i = 0; i < 6; ++i) x *= 2 - odd * x;
    return x;
  };
  h = unshift(h, 31) * inverse(0x94d049bb133111ebULL);
  h = unshift(h, 27) * inverse(0xbf58476d1ce4e5b9ULL);
  return unshift(h, 30) - 0x9e3779b97f4a7c15ULL;
}
inline std::uint64_t Fold(std::uint64_t key, const std::vector<std::uint64_t>& words) {
  for (const std::uint64_t word : words) key = Mix(key ^ word);
  return key;
}

inline constexpr std::uint64_t kPriorityKey = 0x2545f4914f6cdd1dULL;
inline std::uint64_t KeyOfVertexIds(std::uint64_t salt) {
  return Mix(0xa0761d6478bd642fULL ^ salt);
}

// A point in the middle half of the unit square or cube with folded coordinates, from `key`, that
// equal the result of `wanted`, which is called repeatedly.
template <int D>
std::array<double, D> PlaceOfHash(std::uint64_t key, const std::function<std::uint64_t()>& wanted,
                                  std::mt19937_64& random) {
  while (true) {
    std::array<double, D> p;
    std::uint64_t h = key;
    for (int k = 0; k + 1 < D; ++k) {
      p[k] = 0.25 + 0.5 * static_cast<double>(random() >> 11) * 0x1p-53;
      h = Mix(h ^ std::bit_cast<std::uint64_t>(p[k]));
    }
    p[D - 1] = std::bit_cast<double>(Unmix(wanted()) ^ h);
    if (0.25 < p[D - 1] && p[D - 1] < 0.75) return p;
  }
}

// Polygons b < 2^63 and greater than a, so that {a, b} has that region id, whatever its top bit.
// Nothing if there is none.
inline std::vector<FeatureId> PairOfRegionId(RegionId id, FeatureId a) {
  for (const RegionId top : {RegionId{0}, RegionId{1} << 63}) {
    const FeatureId b = Unmix(id ^ top) ^ Mix(Mix(0xe7037ed1a0b428dbULL) ^ a);
    if (a < b && b <= kLastPolygonId) return {a, b};
  }
  return {};
}
// The same, with the least a from `from` on for which there is one.
inline std::vector<FeatureId> AnyPairOfRegionId(RegionId id, FeatureId from) {
  while (true) {
    if (const auto pair = PairOfRegionId(id, from++); !pair.empty()) return pair;
  }
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_CRAFTED_H_
