// Memory for the few large arrays that are read at random: vertices, triangles.
//
// With pages of 4 KiB nearly each such read misses the processor's address cache too;
// with pages of 2 MiB, where the system grants them, a fifth of the time of a whole
// build is saved. Such a block grows without a copy: its pages move. Thread-safe.
#ifndef DYNMESH_CORE_BASE_HUGE_PAGES_H_
#define DYNMESH_CORE_BASE_HUGE_PAGES_H_

#include <cstddef>
#include <cstdint>
#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace dynmesh::huge_pages {

inline constexpr std::size_t kPage = std::size_t{2} << 20;

#ifdef __linux__

// Is a block of that size made of such pages? Smaller ones are ordinary ones.
inline bool AreFor(std::size_t bytes) { return bytes >= 2 * kPage; }
inline std::size_t RoundedUp(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

// Addresses from a multiple of kPage on, `bytes` of them, another such multiple. A page more than
// needed is mapped, for what is not aligned at both ends to go again.
inline void* MapAligned(std::size_t bytes, int protection) {
  void* const all =
      mmap(nullptr, bytes + kPage, protection, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (all == MAP_FAILED) throw std::bad_alloc();
  char* const begin = static_cast<char*>(all);
  const std::size_t before = (kPage - reinterpret_cast<std::uintptr_t>(begin) % kPage) % kPage;
  if (before > 0) munmap(begin, before);
  if (before < kPage) munmap(begin + before + bytes, kPage - before);
  return begin + before;
}

// At least `bytes`, AreFor(bytes). Costs memory where it is written to only.
inline void* Map(std::size_t bytes) {
  void* const block = MapAligned(RoundedUp(bytes), PROT_READ | PROT_WRITE);
  madvise(block, RoundedUp(bytes), MADV_HUGEPAGE);  // refused is as good
  return block;
}

inline void Unmap(void* block, std::size_t bytes) { munmap(block, RoundedUp(bytes)); }

// The block with its content, at least `more` bytes now, where it was or elsewhere: then its pages
// are entered there, 2 MiB at a time. Null, and nothing changed, where the system cannot do that.
inline void* Grow(void* block, std::size_t bytes, std::size_t more) {
  const std::size_t from = RoundedUp(bytes), to = RoundedUp(more);
  if (from == to || mremap(block, from, to, 0) != MAP_FAILED) return block;
  // Elsewhere, aligned as well: or the pages would be broken up on the way.
  void* const place = MapAligned(to, PROT_NONE);
  if (mremap(block, from, to, MREMAP_MAYMOVE | MREMAP_FIXED, place) == place) return place;
  munmap(place, to);
  return nullptr;
}

#else

inline bool AreFor(std::size_t) { return false; }
inline void* Map(std::size_t) { throw std::bad_alloc(); }
inline void Unmap(void*, std::size_t) {}
inline void* Grow(void*, std::size_t, std::size_t) { return nullptr; }

#endif

}  // namespace dynmesh::huge_pages

#endif  // DYNMESH_CORE_BASE_HUGE_PAGES_H_
