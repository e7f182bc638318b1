// One round of cleaning: finds all faults of one kind and repairs them.
//
// First contacts: a point nearer than half the tolerance to a segment, or the end of a segment at a
// small angle to a longer one. The segment is split there. If there are no contacts: crossings. The
// two segments get a common point; an existing one if it is within the tolerance of the crossing.
//
// Why rounds end. Nodes are a tolerance T apart, so only finitely many fit into the input's box,
// and only finitely many rounds add one. Between these rounds the nodes are a fixed set. Order all
// pairs of nodes strictly by length. Every change replaces an edge pq by edges that precede it in
// this order. So the list of edges, sorted downwards, decreases lexicographically in a finite set
// of such lists; where edges cancel, it gets shorter. For a split of pq at v:
//  * contact: v is at least T from both ends and less than T/2 from the segment, hence the apex of
//    a triangle with base pq and two shorter sides;
//  * small angle: v is the far end of a segment pv at a small angle to the longer pq: pv precedes
//    pq in the order, and vq is shorter still;
//  * crossing: v is the node nearest to a crossing x, no farther from x than p and q are. With
//    |xv| <= |xq|, |pv|^2 = |px|^2 + |xv|^2 + 2 px.xv <= (|px| + |xq|)^2, with equality only for
//    v = q. There are no contacts then, so x is T/2 or more from p and q, and the difference is
//    far above rounding errors.
// If several splits of one edge would leave a part that is no shorter, one is made, and the next
// round finds the rest again.
//
// All decisions are functions of coordinates: crossings are decided by exact predicates and
// constructed exactly, rounded once.
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
  // Points made at crossings get ids from `next_id` on. The graph must be settled. `max_crossings`
  // is per round.
  Rounds(LineGraph& graph, FeatureId next_id, std::size_t max_crossings)
      : graph_(graph), next_id_(next_id), max_crossings_(max_crossings) {}

  // False if there was nothing left to do. RESOURCE_EXHAUSTED above max_crossings.
  absl::StatusOr<bool> Run();

  // Number of splits found by the last round, and the position of one.
  std::size_t found() const { return found_; }
  const Point& where() const { return where_; }
  FeatureId next_id() const { return next_id_; }

 private:
  // Edge `edge` is to be split at `at`.
  struct Split {
    EdgeIndex edge = 0;
    Node at = 0;
    ChangeKind kind = ChangeKind::kSegmentSplit;
    FeatureId other = kNoFeature;  // kSmallAngle: owner of the edge that ends at `at`
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
  int crossings_seen_ = 0;  // all crossings of edges born before this round are repaired
  std::size_t found_ = 0;
  Point where_{};
};

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_ROUND_H_
