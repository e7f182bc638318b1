// The finaliser of splitmix64: each input bit affects every output bit. Journals store its results,
// so it never changes. Pure.
#ifndef DYNMESH_SERVER_BASE_MIX_H_
#define DYNMESH_SERVER_BASE_MIX_H_

#include <cstdint>

namespace dynmesh::server {

constexpr std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_MIX_H_
