// What a dynmeshd counts and measures, by name. The members are made with the server, so that each
// is there from the first scrape on. Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_SERVER_METRICS_H_
#define DYNMESH_SERVER_METRICS_SERVER_METRICS_H_

#include <chrono>

#include "absl/status/status.h"
#include "dynmesh/mesh.h"
#include "server/metrics/metrics.h"

namespace dynmesh::server {

using MetricsClock = std::chrono::steady_clock;

inline double SecondsSince(MetricsClock::time_point start) {
  return std::chrono::duration<double>(MetricsClock::now() - start).count();
}

// Batches of edits, of all meshes.
class EditMetrics {
 public:
  explicit EditMetrics(MetricRegistry& registry);

  enum class Kind { kApplied, kReplayed, kValidated };
  // Once for each batch that was answered; `kind` counts if it went well.
  void CountAnswer(const absl::Status& status, Kind kind);
  // Of a batch that made a revision.
  void ObserveWork(const WorkCounters& work);

  Histogram& journal_seconds;  // from a batch that is ready to one that is on the disk
  Histogram& send_seconds;     // from an answer to its last byte handed to the transport

 private:
  EditMetrics(MetricFamily<Histogram>& stages, MetricFamily<Counter>& results,
              MetricRegistry& registry);

  Histogram& validate_seconds_;
  Histogram& propagate_seconds_;
  Histogram& diff_seconds_;
  Counter& applied_;
  Counter& replayed_;
  Counter& validated_;
  Counter& refused_;
  Counter& cancelled_;
  Counter& failed_;
  Counter& operations_;
};

// Meshes made again from the journal.
struct RecoveryMetrics {
  explicit RecoveryMetrics(MetricRegistry& registry);

  Gauge& entries;  // snapshots and batches to be applied
  Gauge& entries_done;
  Gauge& damaged;  // meshes that could not be made again
  Gauge& seconds;  // that it took
};

// All of a server's. What else a server tells it adds to the registry as sources.
struct ServerMetrics {
  MetricRegistry registry;
  EditMetrics edits{registry};
  RecoveryMetrics recovery{registry};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_SERVER_METRICS_H_
