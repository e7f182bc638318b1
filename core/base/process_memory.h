// Malloc settings for a process that builds meshes. Call it first in main().
#ifndef DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
#define DYNMESH_CORE_BASE_PROCESS_MEMORY_H_

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace dynmesh {

// Large arrays grow by doubling. By default glibc soon keeps the smaller former blocks, of tens of
// megabytes, unused in its heap: a fifth of the process. After this call blocks of 1 MiB and more
// return to the system when freed.
inline void ReturnLargeBlocks() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
#endif
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
