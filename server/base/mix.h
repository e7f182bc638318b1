// The finaliser of splitmix64: every bit of the input moves every bit of the output. Files keep
// what is made with it, so it never changes. Pure.
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
