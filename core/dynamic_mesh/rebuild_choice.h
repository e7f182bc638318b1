// Whether a batch is propagated or the mesh built anew. Only time depends on it.
//
// Measured (dynmesh_edit_tables rebuild), time of propagating / time of building anew, on
// uniform points, rho sqrt 2, 1 k to 100 k of them, removing (adding):
//
//   part of the points     3 %          10 %         20 %         30 %        50 %        80 %
//   scattered              0.4 (0.5)    1.2 (1.4)    2.7 (2.6)    3.2 (3.0)   4.1 (3.3)   6 (4)
//   in one place           0.1 (0.1)    0.2 (0.4)    0.4 (0.9)    0.8 (1.4)   1.9 (2.0)   6 (3.5)
//
// So a count of features tells neither way between 3 % and 50 %. What is stale once the
// change is made known does: an operation costs about twice as much to run again as to run
// from scratch, and those stale at the beginning make others stale. Scattered changes are at
// par at 13 % stale (3 % of the points moved: 0.12 stale, 0.8; 10 % removed: 0.29, 2.2), those
// in one place at 35 % (removing) and 10 % (adding). Looking costs a snapshot. One sizing feature
// may be worth any number of vertices: about its area over the square of its target, of which
// adding (dropping) 0.2, 0.7, 2.4 and 8 times the vertices present came to 0.5 (0.5), 1.5 (2), 2.8
// (3.5), 3.5 (5 to 10). A region that moves keeps its anchors but at the rim, and a few features may
// stand in a mesh of very many vertices: there, too, what is stale decides.
#ifndef DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_
#define DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <vector>

#include "core/base/rings.h"
#include "core/plc/delta.h"
#include "core/sac/engine.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh {

enum class Plan {
  kPropagate,
  kLook,  // propagate, unless too much is stale once the change is known
  kRebuild,
};

// Parts of what there is, above which a batch is built anew.
struct RebuildThresholds {
  std::size_t at_least = 64;       // changes of features; fewer are propagated
  double look_at_features = 0.03;  // from so many on it is worth a look
  double features = 0.5;           // changed, of those there are or of a fourth of the vertices
  double stale = 0.22;             // operations, of those there are
  double carried = 0.3;            // vertices that sizing features carry
  // A propagation that has cost so much of a build, and is not at its end, is given up.
  double work = 0.5;
  std::uint64_t at_least_work = 1'000;  // operations

  bool IsMostlyStale(std::size_t waiting, std::size_t operations) const {
    return static_cast<double>(waiting) > stale * static_cast<double>(operations);
  }
  bool IsTooDear(const sac::Counters& counters, std::size_t operations) const {
    // To ask a subscriber costs a small part of running an operation.
    const std::uint64_t done = counters.executed + counters.notified / 64;
    return done > at_least_work &&
           static_cast<double>(done) > work * static_cast<double>(operations);
  }
};

// The area or volume of a sizing feature.
template <int D>
double MeasureOf(const plc::SizeFeature<D>& f) {
  double measure = 0;
  if (f.sizing.shape == SizeShape::kDisc) {
    const double r = f.sizing.radius;
    measure = std::numbers::pi * r * r * (D == 2 ? 1 : 4 * r / 3);
  } else if (f.sizing.shape == SizeShape::kBox) {
    measure = 1;
    for (int k = 0; k < D; ++k) measure *= f.sizing.hi[k] - f.at[k];
  } else if (f.sizing.shape == SizeShape::kPolygon) {  // in the plane
    const auto& o = f.places.front().front();          // near all: little is lost to rounding
    ForEachEdgeOf(f.places, [&](const auto& p, const auto& q) {
      measure += 0.5 * ((p[0] - o[0]) * (q[1] - o[1]) - (q[0] - o[0]) * (p[1] - o[1]));
    });
  }
  return std::abs(measure);
}

// How many vertices sizing features may carry: an upper estimate.
template <int D>
double VerticesCarried(const std::vector<plc::SizeFeature<D>>& sizes, const Box& box) {
  double whole = 1;
  for (int k = 0; k < D; ++k) whole *= box.hi[k] - box.lo[k];
  double sum = 0;
  for (const plc::SizeFeature<D>& f : sizes) {
    double cell = 1;
    for (int k = 0; k < D; ++k) cell *= f.sizing.target;
    sum += std::min(MeasureOf(f), whole) / cell;
  }
  return sum;
}

template <int D>
Plan PlanFor(const plc::Delta<D>& delta, std::size_t features, std::size_t vertices, const Box& box,
             const RebuildThresholds& thresholds) {
  const auto changes = static_cast<double>(delta.size());
  const double added = VerticesCarried(delta.added_sizes, box);
  const double removed = VerticesCarried(delta.removed_sizes, box);
  const double carried = std::max(added, removed);
  if (changes + carried < static_cast<double>(thresholds.at_least)) return Plan::kPropagate;
  const auto n = static_cast<double>(features), v = static_cast<double>(vertices);
  if (changes > thresholds.features * std::max(n, 0.25 * v)) return Plan::kRebuild;
  if (carried > thresholds.carried * v) {
    const bool may_be_a_move = 2 * std::min(added, removed) > carried;
    return may_be_a_move ? Plan::kLook : Plan::kRebuild;
  }
  return changes > thresholds.look_at_features * n ? Plan::kLook : Plan::kPropagate;
}

}  // namespace dynmesh

#endif  // DYNMESH_CORE_DYNAMIC_MESH_REBUILD_CHOICE_H_
