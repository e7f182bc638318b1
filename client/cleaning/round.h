// One round of cleaning: finds all that is not clean of one kind and mends it.
//
// First what touches: a point nearer than half the tolerance to a segment, or a segment's
// end across a small angle from a longer one. The segment is split there. Only where
// nothing touches: what crosses. The two segments get a common point, an old one if one is
// within the tolerance of the crossing.
//
// Why rounds end. Places are a tolerance T apart: only finitely many fit into the input's
// box, so only finitely many rounds make one. Between these the places are a fixed set, and
// every change replaces an edge pq by edges that come before it in one strict order of all
// pairs of places, by length: the list of edges, sorted downwards, comes down
// lexicographically, in a finite set of such lists; where edges cancel, it gets shorter. For a
// split of pq at v:
//  * v touches: it is at least T from both ends and less than T/2 off the segment, hence the
//    top of a triangle whose other sides are shorter than its base;
//  * v is the far end of a segment pv at a small angle to the longer pq: pv comes before pq
//    by the order itself, and vq is shorter still;
//  * v is the place nearest to a crossing x, no farther from x than p and q are. With
//    |xv| <= |xq| is |pv|^2 = |px|^2 + |xv|^2 + 2 px.xv at most (|px| + |xq|)^2, and equal
//    only for v = q. Nothing touches by then, so x is T/2 or more from p and q, and
//    the difference is far above what rounding does.
// Where several splits of one edge would leave a piece that is no shorter, one is made, and
// the rest is found again in the next round.
//
// All decisions are functions of coordinates: crossings are decided by exact predicates and
// made by exact arithmetic, rounded once.
#ifndef DYNMESH_CLIENT_CLEANING_ROUND_H_
#define DYNMESH_CLIENT_CLEANING_ROUND_H_

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cleaning/line_graph.h"
#include "client/cleaning/meeting_search.h"

namespace dynmesh::cleaning {

class Rounds {
 public:
  // Points that crossings make get ids from `next_id` on. The graph must be settled.
  Rounds(LineGraph& graph, FeatureId next_id, std::size_t max_crossings)
      : graph_(graph), next_id_(next_id), max_crossings_(max_crossings) {}

  // False if there was nothing left to do. RESOURCE_EXHAUSTED if more crosses than allowed.
  absl::StatusOr<bool> Run();

  // What the last round found: segments to split, and a place where.
  std::size_t found() const { return found_; }
  const Point& where() const { return where_; }
  FeatureId next_id() const { return next_id_; }

 private:
  // Edge `edge` is to go through `at`.
  struct Split {
    EdgeIndex edge = 0;
    Place at = 0;
    ChangeKind kind = ChangeKind::kSegmentSplit;
    FeatureId other = kNoFeature;  // kSmallAngle: whose edge ends at `at`
  };
  struct Crossing {
    EdgeIndex e = 0;
    EdgeIndex f = 0;
    Point at{};
  };

  std::vector<Split> FindTouching() const;
  void FindSmallAngles(std::vector<Split>& splits) const;
  absl::StatusOr<std::vector<Crossing>> FindCrossings() const;
  std::vector<Split> JoinCrossings(const std::vector<Crossing>& crossings);
  void Apply(std::vector<Split> splits);
  void ApplyToEdge(EdgeIndex edge, std::vector<Split> splits);
  bool TryChain(EdgeIndex edge, const std::vector<Split>& splits);
  void Report(const Edge& e, const Split& split);
  void Found(std::size_t count, const Point& where);

  LineGraph& graph_;
  FeatureId next_id_;
  const std::size_t max_crossings_;
  int crossings_seen_ = 0;  // all crossings of edges born before this round are mended
  std::size_t found_ = 0;
  Point where_{};
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_ROUND_H_
