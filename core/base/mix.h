// SplitMix64: a bijection of 64-bit words after which each input bit affects every output bit. Ids
// of vertices, hashes of meshes, priorities and the checksums of journals are made of it. So it
// never changes. Not cryptographic: the inverse is public. Pure, O(1).
//
// Hash tables that only need the leading bits of short keys spread multiply by 2^64 / phi instead:
// one operation (mesh/number_table.h, data/face_links.cc, transfer/slot_index.h).
#ifndef DYNMESH_CORE_BASE_MIX_H_
#define DYNMESH_CORE_BASE_MIX_H_

#include <cstdint>

namespace dynmesh {

// The finalizer. It maps 0 to 0.
constexpr std::uint64_t MixBits(std::uint64_t z) {
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

// One step: the increment, then the finalizer.
constexpr std::uint64_t Mix(std::uint64_t z) { return MixBits(z + 0x9e3779b97f4a7c15ULL); }

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_MIX_H_
