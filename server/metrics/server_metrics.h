// The counters and histograms of a dynmeshd, by name. The members are made with the server, so that
// each is present from the first scrape on. Thread-safe.
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

// The source of a batch: times of loads say nothing about edits.
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
    Histogram& journal;  // writing a batch, or a group of waiting ones at once, to the journal
    Histogram& send;     // from an answer to its last byte handed to the transport
  };
  Stages& of(EditSource source) { return stages_[static_cast<std::size_t>(source)]; }

  enum class Kind { kApplied, kReplayed, kValidated };
  // To be called once per answered batch; `kind` counts if it succeeded.
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

// Builds of meshes that the server does not keep.
class BuildMetrics {
 public:
  explicit BuildMetrics(MetricRegistry& registry);

  // To be called once per build that began, with its result and time.
  void Count(const absl::Status& status, double seconds);

  Gauge& running;

 private:
  explicit BuildMetrics(MetricFamily<Counter>& results, MetricRegistry& registry);

  Counter& built_;
  Counter& refused_;
  Counter& cancelled_;
  Counter& failed_;
  Histogram& seconds_;  // of those that made a mesh
};

// Snapshots of meshes, for the journal.
class SnapshotMetrics {
 public:
  explicit SnapshotMetrics(MetricRegistry& registry);

  // To be called once per snapshot that was made, with the time of each of its parts.
  void Observe(double take_seconds, double encode_seconds, double write_seconds);

 private:
  explicit SnapshotMetrics(MetricFamily<Histogram>& seconds);

  Histogram& take_;
  Histogram& encode_;
  Histogram& write_;
};

// Meshes recovered from the journal.
struct RecoveryMetrics {
  explicit RecoveryMetrics(MetricRegistry& registry);

  Gauge& entries;       // snapshots and batches to be applied
  Gauge& entries_done;  // the same as a gauge, under its first name
  Counter& entries_done_total;
  Gauge& damaged;  // meshes that could not be recovered
  Gauge& seconds;  // duration of the recovery
};

// Meshes that are followed: another server has them.
struct FollowerMetrics {
  explicit FollowerMetrics(MetricRegistry& registry);

  Counter& mismatches;  // replicas that were dropped, as they differed from the journal
  Counter& takeovers;   // meshes that were taken over while they were followed
};

// All metrics of a server. Its other figures are added to the registry as sources.
struct ServerMetrics {
  MetricRegistry registry;
  EditMetrics edits{registry};
  BuildMetrics builds{registry};
  SnapshotMetrics snapshots{registry};
  RecoveryMetrics recovery{registry};
  FollowerMetrics followers{registry};
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_METRICS_SERVER_METRICS_H_
