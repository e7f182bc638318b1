// How a process that builds meshes gets memory from the system. It is the process's choice, so it
// is no part of the library: main programs link dynmesh_process_memory and call SetUpMemory.
//
// On a virtual machine the first touch of a page of 4 KiB costs microseconds, and random reads of
// such pages miss the TLB.
// 1. Blocks of 2 MiB and more that C++ code allocates request huge pages, for what is whole huge
//    pages in them. They return to the system when freed. (Large arrays grow by doubling. By
//    default glibc soon keeps the smaller former blocks, of tens of megabytes, unused in its heap:
//    a fifth of the process.)
// 2. The heap of a command requests huge pages but for its beginning, of 256 KiB and up to the next
//    huge page. The first 512 KiB of that are touched by one call, in half the time. It grows in
//    large steps and does not shrink: what is free is used again. That holds also for blocks of up
//    to an eighth of the heap, at most 32 MiB: they are part of the heap and do not return. All
//    threads share it.
// 3. The heap of a server has ordinary pages, as it gives back what is free page by page. The
//    system may make a huge page whole again of which a part was given back.
//
// glibc 2.36 has no option for huge pages but an environment variable that is read before main. So
// `operator new` is replaced by one that calls malloc. It notices a large block by its size, and
// growth of the heap by the address that it gets: two comparisons. It and the standard library may
// free what the other allocated. Where the system grants no huge pages ("never" in
// /sys/kernel/mm/transparent_hugepage/enabled), only the settings of malloc remain. With sanitizers
// operator new is theirs.
//
// A Python module links dynmesh_process_memory without a call of SetUpMemory: then its own large
// blocks request huge pages, and the settings of malloc stay those of the host.
#ifndef DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
#define DYNMESH_CORE_BASE_PROCESS_MEMORY_H_

namespace dynmesh {

enum class MemoryUse {
  kCommand,  // builds what was asked for, and ends
  kServer    // stays, while meshes come and go on many threads
};

// Call first in main(), before there are threads.
void SetUpMemory(MemoryUse use);

}  // namespace dynmesh

#endif  // DYNMESH_CORE_BASE_PROCESS_MEMORY_H_
