// Processor time of this thread. Other processes on its core do not count, except for their effect
// on the caches.
#ifndef DYNMESH_TESTS_BENCH_THREAD_CLOCK_H_
#define DYNMESH_TESTS_BENCH_THREAD_CLOCK_H_

#include <time.h>

namespace dynmesh {

inline double ThreadSeconds() {
  timespec t = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace dynmesh

#endif  // DYNMESH_TESTS_BENCH_THREAD_CLOCK_H_
