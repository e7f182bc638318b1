// Decides whether a batch is propagated or the mesh rebuilt. Only time depends on it.
//
// Measured: processor time of propagating / of rebuilding. 8,000 to 50,000 points, 20,000 segments.
// "stale" is the share of all operations that are stale once the change is applied, "executed" the
// share executed in the end. Removing and adding are nearly alike.
//
//                   2D points, scattered     3D points, scattered     2D segments, scattered
//   share of them   1 %    2 %    4 %        1 %    2 %    4 %        1 %    3 %    5 %
//   stale           0.03   0.07   0.13       0.07   0.13   0.17       0.00   0.06   0.09
//   executed        0.06   0.10   0.20       0.17   0.28   0.40       0.03   0.08   0.12
//   time            0.20   0.41   0.80       0.80   1.2    1.8        0.08   0.25   0.38
//
// Concentrated in one place, 5 % cost 0.1 (2D) and 0.45 (3D). So an operation that runs again takes
// 3 to 4.5 times as long as in a build. The number of features predicts little. The number stale at
// the beginning predicts more: two to three times as many are executed. Some edits make the trace
// stale step by step. Only the executed operations reveal these: stopped at 0.12 of the operations,
// they have cost half a build. The limit is higher if more was stale at the beginning.
//
// One sizing feature may need any number of vertices: about its area over the square of its target.
// Adding (removing) features of 0.2, 0.7, 2.4 and 8 times the vertices present cost 0.5 (0.5), 1.5
// (2), 2.8 (3.5), 3.5 (5 to 10) builds. A region that moves keeps its anchors except near its
// border, and a few features may belong to a mesh of very many vertices. In these cases, too, the
// stale operations decide.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/dynamic_mesh/live_mesh_tuning.h"
#include "core/plc/delta.h"
#include "core/plc/size_rules.h"
#include "core/sac/engine.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh {

enum class Plan {
  kPropagate,
  kProbe,  // propagate, unless too much is stale once the change is known
  kRebuild,
};

// The cost of a propagation so far, evaluated before each of its operations.
template <class Engine>
class PropagationCost {
 public:
  // Both must outlive this. REQUIRES: the engine's counters are reset.
  PropagationCost(const RebuildThresholds& thresholds, int dimension, const Engine& engine)
      : thresholds_(thresholds), looks_(thresholds.looks[dimension - 2]), engine_(engine) {}

  // At the beginning: is so much stale that a rebuild is cheaper?
  bool IsMostlyStale() const {
    return engine_.counters().executed == 0 &&
           static_cast<double>(engine_.waiting()) >
               thresholds_.stale * static_cast<double>(engine_.operation_count());
  }
  bool IsTooDear() {
    const sac::Counters& counters = engine_.counters();
    const std::size_t operations = engine_.operation_count();
    if (counters.executed == 0) {
      operations_ = operations;
      waiting_ = engine_.waiting();
    }
    const std::uint64_t all_done = counters.executed + counters.notified / looks_;
    const std::uint64_t grown = std::max(operations, operations_) - operations_;
    const std::uint64_t done = all_done - std::min(all_done, grown);
    if (done <= thresholds_.at_least_work) return false;
    const auto all = static_cast<double>(operations);
    const double of_stale = std::min(thresholds_.work_of_stale * static_cast<double>(waiting_),
                                     thresholds_.most_work * all);
    return static_cast<double>(done) > std::max(thresholds_.work * all, of_stale);
  }

 private:
  const RebuildThresholds& thresholds_;
  const std::uint64_t looks_;
  const Engine& engine_;
  std::size_t operations_ = 0, waiting_ = 0;  // at the beginning
};

// An upper estimate of the vertices that sizing features may need, but for those for which
// is_idle(feature) is true.
template <int D, class IsIdle>
double VerticesCarried(const std::vector<plc::SizeFeature<D>>& sizes, const Box& box,
                       IsIdle is_idle) {
  double whole = 1;
  for (int k = 0; k < D; ++k) whole *= box.hi[k] - box.lo[k];
  double sum = 0;
  for (const plc::SizeFeature<D>& f : sizes) {
    if (is_idle(f)) continue;
    double cell = 1;
    for (int k = 0; k < D; ++k) cell *= f.sizing.target;
    sum += std::min(plc::RulesOf(f).Measure(f), whole) / cell;
  }
  return sum;
}

struct NeverIdle {
  template <class SizeFeature>
  bool operator()(const SizeFeature&) const {
    return false;
  }
};

// is_idle(f): will it change nothing that sizing feature f comes or goes?
template <int D, class IsIdle = NeverIdle>
Plan PlanFor(const plc::Delta<D>& delta, std::size_t features, std::size_t vertices, const Box& box,
             const RebuildThresholds& thresholds, IsIdle is_idle = {}) {
  const auto changes = static_cast<double>(delta.size());
  const double added = VerticesCarried(delta.added_sizes, box, is_idle);
  const double removed = VerticesCarried(delta.removed_sizes, box, is_idle);
  const double carried = std::max(added, removed);
  if (changes + carried < static_cast<double>(thresholds.at_least)) return Plan::kPropagate;
  const auto n = static_cast<double>(features), v = static_cast<double>(vertices);
  if (changes > thresholds.features * std::max(n, 0.25 * v)) return Plan::kRebuild;
  if (carried > thresholds.carried * v) {
    const bool may_be_a_move = 2 * std::min(added, removed) > carried;
    return may_be_a_move ? Plan::kProbe : Plan::kRebuild;
  }
  return changes > thresholds.probe_features * n ? Plan::kProbe : Plan::kPropagate;
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_
