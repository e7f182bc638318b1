// The soak's measurements: latencies, memory over time, the disk's own sync.
#ifndef DYNMESH_TESTS_E2E_SOAK_FIGURES_H_
#define DYNMESH_TESTS_E2E_SOAK_FIGURES_H_

#include <sys/types.h>

#include <mutex>
#include <string>
#include <vector>

#include "absl/synchronization/notification.h"
#include "client/cli/json.h"
#include "dynmesh/client/mesh_client.h"

namespace dynmesh::soak {

// {"n": 3, "p50": 1, "p99": 2, "max": 2}
cli::JsonObject Spread(const std::vector<double>& samples);

// Milliseconds: all of them, and those since the last report. Thread-safe.
class Latencies {
 public:
  void Add(double milliseconds) {
    const std::lock_guard lock(mutex_);
    all_.push_back(milliseconds);
  }
  std::vector<double> TakeRecent() {
    const std::lock_guard lock(mutex_);
    const auto begin = all_.begin() + static_cast<std::ptrdiff_t>(reported_);
    reported_ = all_.size();
    return {begin, all_.end()};
  }
  std::vector<double> All() const {
    const std::lock_guard lock(mutex_);
    return all_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<double> all_;
  std::size_t reported_ = 0;
};

struct MemorySample {
  double seconds = 0;
  double megabytes = 0;
};

// The course of memory after a warm-up of a fifth of the time.
struct Growth {
  double warm = 0;      // MB: median of the tenth after the warm-up
  double last = 0;      // MB: median of the last tenth; last - warm is checked
  double highest = 0;   // MB after the warm-up, including short peaks
  double per_hour = 0;  // MB: slope of the line through all after the warm-up
};
// Samples in order of time. All 0 if there are less than ten.
Growth JudgeGrowth(const std::vector<MemorySample>& samples);

// Resident memory of a process in MB; 0 if it is gone.
double ResidentMegabytes(pid_t process);
// Of all files under a folder.
double FolderMegabytes(const std::string& folder);

// Every `pause_seconds` writes 4 kB in the middle of a file and waits until they are on the disk,
// until `stop`; milliseconds go to `times`. This is the file system's cost without the server.
void ProbeDisk(const std::string& file, double pause_seconds, const absl::Notification& stop,
               Latencies& times);

// Every `pause_seconds` queries a missing mesh, until `stop`; milliseconds go to `times`. This is
// the cost of a call that does nothing: thread switches, TLS, and the wait for a core.
void ProbeCalls(client::MeshClient& client, double pause_seconds, const absl::Notification& stop,
                Latencies& times);

}  // namespace dynmesh::soak

#endif  // DYNMESH_TESTS_E2E_SOAK_FIGURES_H_
