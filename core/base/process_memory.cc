#include "core/base/process_memory.h"

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>

#include "core/base/huge_pages.h"

#ifdef __GLIBC__
#include <malloc.h>
#include <unistd.h>
#endif

namespace dynmesh {
namespace {

#ifdef __GLIBC__

constexpr std::size_t kMiB = std::size_t{1} << 20;

// A heap up to this size, and from there to the next huge page, has ordinary pages: what needs no
// more is small.
constexpr std::size_t kSmallHeap = 256 << 10;

// So much of it is used by the smallest mesh. It is asked for at once: that takes half as long as
// to touch each page.
constexpr std::size_t kSurelyUsed = 512 << 10;

// How far the heap grows at first. Large blocks that fit in there are part of the heap, too.
constexpr std::size_t kFirstStep = 6 * kMiB;

// No larger block is ever allocated in the heap: the most that glibc takes as its threshold.
constexpr std::size_t kMostInHeap = 32 * kMiB;

// No heap reaches from here on: growth is not noticed.
constexpr std::uintptr_t kNowhere = ~std::uintptr_t{0} >> 1;

// Addresses of the heap are at most so far beyond what it was; all other memory is farther away.
constexpr std::uintptr_t kHeapReach = std::uintptr_t{1} << 36;

// Up to here the heap is known. Read by each allocation, changed when the heap has grown.
std::atomic<std::uintptr_t> known_end{kNowhere};
// From here on its huge pages are requested.
std::uintptr_t huge_begin = 0;

std::uintptr_t HeapEnd() { return reinterpret_cast<std::uintptr_t>(sbrk(0)); }

// Only of whole huge pages within the range: its ends stay as they are.
void RequestHugePages(std::uintptr_t from, std::uintptr_t to) {
  from = (from + huge_pages::kPage - 1) / huge_pages::kPage * huge_pages::kPage;
  to = to / huge_pages::kPage * huge_pages::kPage;
  // A refusal is harmless.
  if (from < to) madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
}

// Ordinary pages that will be written to. Without effect before Linux 5.14.
void TouchPages(std::uintptr_t from, std::uintptr_t to) {
#ifdef MADV_POPULATE_WRITE
  constexpr std::uintptr_t kOrdinary = 4096;
  from = (from + kOrdinary - 1) / kOrdinary * kOrdinary;
  to = to / kOrdinary * kOrdinary;
  if (from < to) madvise(reinterpret_cast<void*>(from), to - from, MADV_POPULATE_WRITE);
#endif
}

// Looks at the heap after a block at the end of it.
void NoticeHeap(std::uintptr_t end_of_block) {
  const std::uintptr_t end = HeapEnd();
  if (end_of_block > end) return;  // not of the heap
  RequestHugePages(huge_begin, end);
  known_end.store(end, std::memory_order_relaxed);
  // Blocks that are small beside the heap come from it, too: freed, they are used again without a
  // fault. What the heap keeps unused by them is at most a part of it.
  const std::uintptr_t heap = end - huge_begin;
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(std::clamp(heap / 8, 2 * kMiB, kMostInHeap)));
  // Large steps, since of each the first and the last huge page remain ordinary ones: malloc writes
  // beyond the former end before it is noticed. Not too large: the process may have a limit.
  mallopt(M_TOP_PAD, static_cast<int>(std::clamp(heap / 4, 16 * kMiB, 64 * kMiB)));
}

// Null if there is no memory.
[[maybe_unused]] void* Allocate(std::size_t bytes, std::size_t alignment) {
  void* const block = alignment <= alignof(std::max_align_t) ? std::malloc(bytes)
                                                             : std::aligned_alloc(alignment, bytes);
  const auto begin = reinterpret_cast<std::uintptr_t>(block), end = begin + bytes;
  if (bytes >= huge_pages::kPage) {
    if (block != nullptr) RequestHugePages(begin, end);
  } else if (end - known_end.load(std::memory_order_relaxed) < kHeapReach) {
    NoticeHeap(end);
  }
  return block;
}

void SetUpHeap(MemoryUse use) {
  mallopt(M_MMAP_THRESHOLD, static_cast<int>(use == MemoryUse::kCommand ? 2 * kMiB : kMiB));
  if (use == MemoryUse::kServer) {
    mallopt(M_TRIM_THRESHOLD, static_cast<int>(2 * kMiB));
    return;
  }
  mallopt(M_TRIM_THRESHOLD, -1);  // never
  mallopt(M_ARENA_MAX, 1);        // threads use what is free of it, too
  mallopt(M_TOP_PAD, static_cast<int>(kFirstStep));
  // Grown before it is used: a huge page of which malloc has written a part would stay ordinary.
  const std::uintptr_t before = HeapEnd();
  void* volatile small = std::malloc(kSmallHeap);
  const std::uintptr_t end = HeapEnd();
  const auto begin = reinterpret_cast<std::uintptr_t>(static_cast<void*>(small));
  huge_begin = begin + kSmallHeap + 1;
  std::free(small);
  // Another heap than that of sbrk: as it is.
  if (end == before || huge_begin > end) return;
  RequestHugePages(huge_begin, end);
  known_end.store(end, std::memory_order_relaxed);
  // Up to the first huge page.
  const std::uintptr_t ordinary =
      (huge_begin + huge_pages::kPage - 1) / huge_pages::kPage * huge_pages::kPage;
  TouchPages(begin, std::min(begin + kSurelyUsed, ordinary));
}

#else

void* Allocate(std::size_t bytes, std::size_t alignment) {
  return alignment <= alignof(std::max_align_t) ? std::malloc(bytes)
                                                : std::aligned_alloc(alignment, bytes);
}
void SetUpHeap(MemoryUse) {}

#endif

// As the standard says of operator new.
[[maybe_unused]] void* AllocateOrThrow(std::size_t bytes, std::size_t alignment) {
  while (true) {
    if (void* const block = Allocate(bytes, alignment)) return block;
    const std::new_handler handler = std::get_new_handler();
    if (handler == nullptr) throw std::bad_alloc();
    handler();
  }
}

}  // namespace

void SetUpMemory(MemoryUse use) { SetUpHeap(use); }

}  // namespace dynmesh

// The standard library's other forms (of arrays, nothrow) call these. Sanitizers have their own.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

void* operator new(std::size_t bytes) {
  return dynmesh::AllocateOrThrow(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return dynmesh::AllocateOrThrow(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { std::free(block); }
void operator delete(void* block, std::size_t) noexcept { std::free(block); }
void operator delete(void* block, std::align_val_t) noexcept { std::free(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { std::free(block); }

#endif
