#include "client/cleaning/clean_input.h"

#include <algorithm>
#include <iterator>
#include <tuple>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "client/cleaning/entry.h"
#include "client/cleaning/line_graph.h"
#include "client/cleaning/polygon_rings.h"
#include "client/cleaning/round.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/base/size_shapes.h"
#include "core/base/text.h"

namespace dynmesh::cleaning {
namespace {

using text::Concat;

// Half of the ids are left for new ones.
constexpr EntryLimits kLimitsIn2D = {2, 200, ~FeatureId{0} >> 1};

class Cleaner {
 public:
  Cleaner(const std::vector<Feature>& features, const CleanOptions& options)
      : features_(features), options_(options), graph_(options.tolerance) {}

  absl::StatusOr<CleanResult> Run() {
    const absl::StatusOr<FeatureId> max_id =
        CheckFeatures(features_, options_.tolerance, kLimitsIn2D);
    if (!max_id.ok()) return max_id.status();
    max_id_ = *max_id;
    EnterPoints<2>(features_, graph_, node_of_);
    for (const Feature& f : features_) {
      Visit(
          f,
          [&](const ASegment& s) {
            const Node a = node_of_[s.ends[0]], b = node_of_[s.ends[1]];
            if (a == b) Report(ChangeKind::kZeroLength, {s.id}, a, a);
            graph_.Connect(a, b, s.id);
          },
          [&](const APolygon&) {
            for (const NodePair& edge : EdgesOf(f)) {
              graph_.Connect(edge.first, edge.second, kNoFeature, {f.id});
            }
          },
          Ignore<APoint, ASize>);
    }
    graph_.Settle();
    Rounds rounds(graph_, max_id_ + 1, options_.max_crossings);
    for (;;) {
      if (graph_.round >= options_.max_rounds) return NotDone(rounds);
      const absl::StatusOr<bool> more = rounds.Run();
      if (!more.ok()) return more.status();
      if (!*more) break;
    }
    next_id_ = rounds.next_id();
    return Finish();
  }

 private:
  absl::Status NotDone(const Rounds& rounds) const {
    return absl::ResourceExhaustedError(
        Concat("after ", graph_.round, " rounds ", rounds.found(),
               " segments still touch or cross, one at (", rounds.where()[0], ", ",
               rounds.where()[1], "); choose another tolerance than ", options_.tolerance));
  }

  void Report(ChangeKind kind, std::vector<FeatureId> ids, Node from, Node to) {
    graph_.changes.push_back({kind, std::move(ids), graph_.nodes.at(from), graph_.nodes.at(to)});
  }

  std::vector<NodeRing> NodesOf(const Rings& rings) const {
    std::vector<NodeRing> nodes;
    for (const auto& ring : rings) {
      NodeRing& at = nodes.emplace_back();
      for (const FeatureId corner : ring) at.push_back(node_of_.at(corner));
    }
    return nodes;
  }

  // The edges of a polygon's rings, sorted; a repeated edge is repeated here. Reports edges of
  // length 0.
  std::vector<NodePair> EdgesOf(const Feature& polygon) {
    std::vector<NodePair> edges;
    ForEachEdgeOf(NodesOf(polygon.rings), [&](Node p, Node q) {
      if (p != q) {
        edges.push_back(std::minmax(p, q));
      } else {
        Report(ChangeKind::kZeroLength, {polygon.id}, p, p);
      }
    });
    std::sort(edges.begin(), edges.end());
    return edges;
  }

  CleanResult Finish() {
    CleanResult result;
    std::vector<Feature> others = FinishOthers();
    result.changes = std::move(graph_.changes);
    result.rounds = graph_.round;
    if (result.changes.empty()) {
      result.features = features_;
      return result;
    }
    FinishPoints(result.features);
    FinishSegments(result.features);
    std::move(others.begin(), others.end(), std::back_inserter(result.features));
    return result;
  }

  // Features that are neither points nor segments.
  std::vector<Feature> FinishOthers() {
    absl::flat_hash_map<FeatureId, std::vector<NodePair>> edges;
    for (const Edge& e : graph_.edges) {
      for (const FeatureId polygon : e.polygons) edges[polygon].emplace_back(e.a, e.b);
    }
    std::vector<Feature> others;
    for (const Feature& f : features_) {
      if (Is<APoint, ASegment>(f, Not<APolygon, ASize>)) continue;
      const bool is_size = Is<ASize>(f, Not<APoint, ASegment, APolygon>);
      const SizeShapeUse* const use = is_size ? FindUse(f.sizing.shape) : nullptr;
      if (is_size && (use == nullptr || !use->rings)) {
        others.push_back(f);
        continue;
      }
      Feature& polygon = others.emplace_back(f);
      polygon.rings = FinishRings(f, is_size ? OddEdgesOf(f) : edges[f.id]);
      if (polygon.rings.empty()) others.pop_back();
    }
    return others;
  }

  // The edges with odd count of a sizing polygon. They are not in the graph.
  std::vector<NodePair> OddEdgesOf(const Feature& size) {
    std::vector<NodePair> odd;
    for (const NodePair& edge : EdgesOf(size)) {
      if (odd.empty() || odd.back() != edge) {
        odd.push_back(edge);
      } else {
        odd.pop_back();
        Report(ChangeKind::kCancelled, {size.id}, edge.first, edge.second);
      }
    }
    return odd;
  }

  Rings FinishRings(const Feature& polygon, const std::vector<NodePair>& edges) {
    const std::vector<NodeRing> were = NodesOf(polygon.rings);
    const RemadeRings remade = RemakeRings(were, edges);
    for (const Node v : remade.cuts) {
      Report(ChangeKind::kRingCut, {polygon.id, graph_.point_ids[v]}, v, v);
    }
    if (remade.rings.empty()) {
      const bool has_corner = !were.empty() && !were.front().empty();
      const Point from = has_corner ? graph_.nodes.at(were.front().front()) : Point{};
      graph_.changes.push_back({ChangeKind::kPolygonDropped, {polygon.id}, from, from});
    }
    Rings rings;
    for (const NodeRing& ring : remade.rings) {
      std::vector<FeatureId>& ids = rings.emplace_back();
      for (const Node v : ring) ids.push_back(graph_.point_ids[v]);
    }
    return rings;
  }

  void FinishPoints(std::vector<Feature>& features) const {
    const auto add = [&](Node v) {
      const Point& p = graph_.nodes.at(v);
      features.push_back(Feature::Point(graph_.point_ids[v], p[0], p[1]));
    };
    for (const Feature& f : features_) {
      if (!IsPoint(f)) continue;
      const Node v = node_of_.at(f.id);
      if (graph_.point_ids[v] == f.id) add(v);
    }
    for (Node v = 0; v < graph_.nodes.size(); ++v) {
      if (graph_.point_ids[v] > max_id_) add(v);
    }
  }

  // The parts of each segment, from its first end to its last.
  void FinishSegments(std::vector<Feature>& features) {
    absl::flat_hash_map<FeatureId, std::vector<const Edge*>> parts;
    for (const Edge& e : graph_.edges) {
      if (e.owner != kNoFeature) parts[e.owner].push_back(&e);
    }
    for (const Feature& f : features_) {
      const auto it =
          Is<ASegment>(f, Not<APoint, APolygon, ASize>) ? parts.find(f.id) : parts.end();
      if (it == parts.end()) continue;
      const Point &from = graph_.nodes.at(node_of_[f.ends[0]]),
                  &to = graph_.nodes.at(node_of_[f.ends[1]]);
      const auto along = [&](Node v) {
        const Point& p = graph_.nodes.at(v);
        return (p[0] - from[0]) * (to[0] - from[0]) + (p[1] - from[1]) * (to[1] - from[1]);
      };
      const auto middle = [&](const Edge* e) { return along(e->a) / 2 + along(e->b) / 2; };
      std::vector<const Edge*>& own = it->second;
      std::sort(own.begin(), own.end(), [&](const Edge* s, const Edge* t) {
        return std::tuple(middle(s), s->a, s->b) < std::tuple(middle(t), t->a, t->b);
      });
      for (const Edge* e : own) {
        const bool forward = along(e->a) <= along(e->b);
        features.push_back(Feature::Segment(e == own.front() ? f.id : next_id_++,
                                            graph_.point_ids[forward ? e->a : e->b],
                                            graph_.point_ids[forward ? e->b : e->a]));
        features.back().unsplit = f.unsplit;
      }
    }
  }

  const std::vector<Feature>& features_;
  const CleanOptions& options_;
  LineGraph graph_;
  absl::flat_hash_map<FeatureId, Node> node_of_;
  FeatureId max_id_ = 0;
  FeatureId next_id_ = 0;
};

}  // namespace

const char* NameOf(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kPointMerged:
      return "point merged";
    case ChangeKind::kPointRounded:
      return "point rounded";
    case ChangeKind::kSegmentSplit:
      return "segment split";
    case ChangeKind::kSegmentsCrossed:
      return "segments crossed";
    case ChangeKind::kSmallAngle:
      return "small angle";
    case ChangeKind::kZeroLength:
      return "zero length";
    case ChangeKind::kDoubled:
      return "doubled";
    case ChangeKind::kCancelled:
      return "edge cancelled";
    case ChangeKind::kRingCut:
      return "ring cut";
    case ChangeKind::kPolygonDropped:
      return "polygon dropped";
  }
  return "";
}

absl::StatusOr<CleanResult> CleanInput(const std::vector<Feature>& features,
                                       const CleanOptions& options) {
  return Cleaner(features, options).Run();
}

}  // namespace dynmesh::cleaning
