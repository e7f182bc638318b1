// What a dynmeshd counts and measures, by name. The members are made with the server, so that each
// is there from the first scrape on. Thread-safe.
#ifndef DYNMESH_SERVER_METRICS_SERVER_METRICS_H_
#define DYNMESH_SERVER_METRICS_SERVER_METRICS_H_

#include <array>
#include <chrono>
#include <cstddef>

#include "absl/status/status.h"
#include "absl/strings/string_view.h"
#include "dynmesh/mesh.h"
#include "server/metrics/metrics.h"

namespace dynmesh::server {

using MetricsClock = std::chrono::steady_clock;

inline double SecondsSince(MetricsClock::time_point start) {
  return std::chrono::duration<double>(MetricsClock::now() - start).count();
}

// What brought a batch: times of loads say nothing of edits.
enum class EditSource { kEdit, kLoad, kRevert };

// Batches of edits, of all meshes.
class EditMetrics {
 public:
  explicit EditMetrics(MetricRegistry& registry);

  // Times of batches from one source.
  struct Stages {
    Stages(MetricFamily<Histogram>& stages, absl::string_view kind);
    Histogram& validate;
    Histogram& propagate;
    Histogram& diff;
    Histogram& journal;  // writing down a batch, or once a group of those that waited
    Histogram& send;     // from an answer to its last byte handed to the transport
  };
  Stages& of(EditSource source) { return stages_[static_cast<std::size_t>(source)]; }

  enum class Kind { kApplied, kReplayed, kValidated };
  // Once for each batch that was answered; `kind` counts if it went well.
  void CountAnswer(const absl::Status& status, Kind kind);
  // Of a batch that made a revision.
  void ObserveWork(const WorkCounters& work, EditSource source);

 private:
  EditMetrics(MetricFamily<Histogram>& stages, MetricFamily<Counter>& results,
              MetricRegistry& registry);

  std::array<Stages, 3> stages_;
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

  Gauge& entries;       // snapshots and batches to be applied
  Gauge& entries_done;  // the same as a gauge, as it was called first
  Counter& entries_done_total;
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
