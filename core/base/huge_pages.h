// Memory for the few large arrays with random reads: vertices, triangles.
//
// With pages of 4 KiB nearly each such read also misses the TLB. Pages of 2 MiB, if the system
// grants them, save a fifth of the time of a whole build. Such a block grows without a copy: its
// pages are remapped. Thread-safe.
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

// Does a block of that size get huge pages? Smaller blocks get ordinary ones.
inline bool AreFor(std::size_t bytes) { return bytes >= 2 * kPage; }
inline std::size_t RoundedUp(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

// Maps `bytes` (a multiple of kPage) at an address that is a multiple of kPage: maps a page more,
// then unmaps what is not aligned at both ends.
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

// At least `bytes`; REQUIRES: AreFor(bytes). Uses physical memory only where it is written to.
inline void* Map(std::size_t bytes) {
  void* const block = MapAligned(RoundedUp(bytes), PROT_READ | PROT_WRITE);
  madvise(block, RoundedUp(bytes), MADV_HUGEPAGE);  // a refusal is harmless
  return block;
}

inline void Unmap(void* block, std::size_t bytes) { munmap(block, RoundedUp(bytes)); }

// Grows the block to at least `more` bytes with its content, in place or elsewhere. Moving remaps
// the pages, 2 MiB at a time. Returns null, with nothing changed, if the system cannot do it.
inline void* Grow(void* block, std::size_t bytes, std::size_t more) {
  const std::size_t from = RoundedUp(bytes), to = RoundedUp(more);
  if (from == to || mremap(block, from, to, 0) != MAP_FAILED) return block;
  // Elsewhere the address must be aligned too: otherwise the huge pages would be split.
  void* const at = MapAligned(to, PROT_NONE);
  if (mremap(block, from, to, MREMAP_MAYMOVE | MREMAP_FIXED, at) == at) return at;
  munmap(at, to);
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
