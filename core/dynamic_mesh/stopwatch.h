// Time that work reports of itself. No decision depends on it.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_STOPWATCH_H_
#define DYNMESH_CORE_DYNAMIC_MESH_STOPWATCH_H_

#include <chrono>

namespace dynmesh {

// Runs from its making on.
class Stopwatch {
 public:
  double microseconds() const {
    return std::chrono::duration<double, std::micro>(Clock::now() - start_).count();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_STOPWATCH_H_
