// How a process that builds meshes should keep its memory. For the first line of main().
#ifndef DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
#define DYNMESH_CORE_BASE_PROCESS_MEMORY_H_

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace dynmesh {

// Large arrays grow by doubling. By default glibc soon keeps the former, smaller
// blocks of tens of megabytes in its heap, where nothing else needs them: a fifth of
// the process. From here on blocks of 1 MiB and more go back to the system when freed.
inline void ReturnLargeBlocks() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
