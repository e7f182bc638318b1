#include "server/metrics/server_metrics.h"

#include <algorithm>

namespace dynmesh::server {
namespace {

constexpr double kLongestStage = 1e4;  // seconds

enum class Result { kOk, kCancelled, kFailed, kRefused };

Result ResultOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return Result::kOk;
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kDeadlineExceeded:
      return Result::kCancelled;
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
    case absl::StatusCode::kDataLoss:
    case absl::StatusCode::kUnavailable:
      return Result::kFailed;
    default:
      return Result::kRefused;  // an error that the client can fix
  }
}

}  // namespace

EditMetrics::Stages::Stages(MetricFamily<Histogram>& stages, absl::string_view kind)
    : validate(stages.With({{"stage", "validate"}, {"kind", kind}})),
      propagate(stages.With({{"stage", "propagate"}, {"kind", kind}})),
      diff(stages.With({{"stage", "diff"}, {"kind", kind}})),
      journal(stages.With({{"stage", "journal"}, {"kind", kind}})),
      send(stages.With({{"stage", "send"}, {"kind", kind}})) {}

EditMetrics::EditMetrics(MetricRegistry& registry)
    : EditMetrics(
          registry.AddHistograms("dynmesh_edit_seconds",
                                 "Time of a batch in each stage, by what brought it: edit, load "
                                 "or revert.",
                                 SecondsBounds(kLongestStage)),
          registry.AddCounters("dynmesh_edits_total",
                               "Batches of edits that were answered, by result."),
          registry) {}

EditMetrics::EditMetrics(MetricFamily<Histogram>& stages, MetricFamily<Counter>& results,
                         MetricRegistry& registry)
    : stages_{Stages(stages, "edit"), Stages(stages, "load"), Stages(stages, "revert")},
      applied_(results.With({{"result", "applied"}})),
      replayed_(results.With({{"result", "replayed"}})),
      validated_(results.With({{"result", "validated"}})),
      refused_(results.With({{"result", "refused"}})),
      cancelled_(results.With({{"result", "cancelled"}})),
      failed_(results.With({{"result", "failed"}})),
      operations_(registry
                      .AddCounters("dynmesh_operations_executed_total",
                                   "Operations of the mesher that edits ran or ran again.")
                      .With()) {}

void EditMetrics::CountAnswer(const absl::Status& status, Kind kind) {
  switch (ResultOf(status)) {
    case Result::kOk:
      if (kind == Kind::kApplied) return applied_.Add();
      if (kind == Kind::kReplayed) return replayed_.Add();
      return validated_.Add();
    case Result::kCancelled:
      return cancelled_.Add();
    case Result::kFailed:
      return failed_.Add();
    case Result::kRefused:
      return refused_.Add();
  }
}

void EditMetrics::ObserveWork(const WorkCounters& work, EditSource source) {
  constexpr double kMicrosecond = 1e-6;
  const double known = work.validate_microseconds + work.diff_microseconds;
  Stages& stages = of(source);
  stages.validate.Observe(work.validate_microseconds * kMicrosecond);
  stages.propagate.Observe(std::max(0.0, work.microseconds - known) * kMicrosecond);
  stages.diff.Observe(work.diff_microseconds * kMicrosecond);
  operations_.Add(work.executed);
}

BuildMetrics::BuildMetrics(MetricRegistry& registry)
    : BuildMetrics(registry.AddCounters("dynmesh_builds_total",
                                        "Builds of meshes that are not kept, by result."),
                   registry) {}

BuildMetrics::BuildMetrics(MetricFamily<Counter>& results, MetricRegistry& registry)
    : running(registry.AddGauges("dynmesh_builds_running", "Builds that compute.").With()),
      built_(results.With({{"result", "built"}})),
      refused_(results.With({{"result", "refused"}})),
      cancelled_(results.With({{"result", "cancelled"}})),
      failed_(results.With({{"result", "failed"}})),
      seconds_(registry
                   .AddHistograms("dynmesh_build_seconds", "Time of a build that made a mesh.",
                                  SecondsBounds(kLongestStage))
                   .With()) {}

void BuildMetrics::Count(const absl::Status& status, double seconds) {
  switch (ResultOf(status)) {
    case Result::kOk:
      seconds_.Observe(seconds);
      return built_.Add();
    case Result::kCancelled:
      return cancelled_.Add();
    case Result::kFailed:
      return failed_.Add();
    case Result::kRefused:
      return refused_.Add();
  }
}

SnapshotMetrics::SnapshotMetrics(MetricRegistry& registry)
    : SnapshotMetrics(registry.AddHistograms(
          "dynmesh_snapshot_seconds",
          "Time of a mesh's snapshot for the journal, by part: take (reading "
          "its features back), encode or write. Edits go on meanwhile.",
          SecondsBounds(kLongestStage))) {}

SnapshotMetrics::SnapshotMetrics(MetricFamily<Histogram>& seconds)
    : take_(seconds.With({{"part", "take"}})),
      encode_(seconds.With({{"part", "encode"}})),
      write_(seconds.With({{"part", "write"}})) {}

void SnapshotMetrics::Observe(double take_seconds, double encode_seconds, double write_seconds) {
  take_.Observe(take_seconds);
  encode_.Observe(encode_seconds);
  write_.Observe(write_seconds);
}

RecoveryMetrics::RecoveryMetrics(MetricRegistry& registry)
    : entries(registry
                  .AddGauges("dynmesh_recovery_entries",
                             "Snapshots and batches that the journal had when the server started.")
                  .With()),
      entries_done(
          registry
              .AddGauges("dynmesh_recovery_entries_done", "As dynmesh_recovery_entries_done_total.")
              .With()),
      entries_done_total(registry
                             .AddCounters("dynmesh_recovery_entries_done_total",
                                          "Snapshots and batches of these that are meshes again.")
                             .With()),
      damaged(registry
                  .AddGauges("dynmesh_recovery_meshes_damaged",
                             "Meshes that could not be recovered from the journal, or lack "
                             "acknowledged changes.")
                  .With()),
      seconds(registry
                  .AddGauges("dynmesh_recovery_seconds",
                             "Seconds that the recovery of the meshes took.")
                  .With()) {}

FollowerMetrics::FollowerMetrics(MetricRegistry& registry)
    : mismatches(
          registry
              .AddCounters("dynmesh_follower_mismatches_total",
                           "Followed meshes that were dropped, as a revision was another one "
                           "here than in the journal.")
              .With()),
      takeovers(registry
                    .AddCounters("dynmesh_follower_takeovers_total",
                                 "Meshes that this server took over while it followed them.")
                    .With()) {}

}  // namespace dynmesh::server
