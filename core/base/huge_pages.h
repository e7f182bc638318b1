// An allocator for the few large arrays that are read at random: vertices, triangles.
//
// With pages of 4 KiB nearly each such read misses the processor's address cache too;
// with pages of 2 MiB, where the system grants them, a fifth of the time of a whole
// build is saved. Blocks below 4 MiB are ordinary ones. Stateless, thread-safe.
#ifndef DYNMESH_CORE_BASE_HUGE_PAGES_H_
#define DYNMESH_CORE_BASE_HUGE_PAGES_H_

#include <cstddef>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace dynmesh {

template <class T>
class HugePageAllocator {
 public:
  using value_type = T;
  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (!IsLarge(bytes))
      return static_cast<T*>(::operator new(bytes, std::align_val_t(alignof(T))));
    return static_cast<T*>(Map(RoundedUp(bytes)));
  }
  void deallocate(T* block, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (!IsLarge(bytes)) {
      ::operator delete(block, std::align_val_t(alignof(T)));
    } else {
      Unmap(block, RoundedUp(bytes));
    }
  }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }

 private:
  static constexpr std::size_t kPage = std::size_t{2} << 20;
  static std::size_t RoundedUp(std::size_t bytes) { return (bytes + kPage - 1) / kPage * kPage; }

#ifdef __linux__
  static bool IsLarge(std::size_t bytes) { return bytes >= 2 * kPage; }
  // A page more than needed is mapped, for what is not aligned at both ends to go again.
  static void* Map(std::size_t bytes) {
    void* const all =
        mmap(nullptr, bytes + kPage, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (all == MAP_FAILED) throw std::bad_alloc();
    char* const begin = static_cast<char*>(all);
    const std::size_t before = (kPage - reinterpret_cast<std::size_t>(begin) % kPage) % kPage;
    if (before > 0) munmap(begin, before);
    if (before < kPage) munmap(begin + before + bytes, kPage - before);
    madvise(begin + before, bytes, MADV_HUGEPAGE);  // refused is as good
    return begin + before;
  }
  static void Unmap(void* block, std::size_t bytes) { munmap(block, bytes); }
#else
  static bool IsLarge(std::size_t) { return false; }
  static void* Map(std::size_t) { throw std::bad_alloc(); }
  static void Unmap(void*, std::size_t) {}
#endif
};

template <class T>
using LargeVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_HUGE_PAGES_H_
