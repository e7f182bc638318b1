#include "client/cleaning/clean_surfaces.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <set>
#include <string>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cleaning/effort.h"
#include "client/cleaning/entry.h"
#include "client/cleaning/surface.h"
#include "client/cleaning/surface_polygons.h"
#include "client/cleaning/surface_round.h"
#include "client/cleaning/tolerance_field.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"

namespace dynmesh::cleaning {
namespace {

using text::Concat;

// Three quarters of the ids are left for new ones.
constexpr EntryLimits kLimitsIn3D = {3, 140, ~FeatureId{0} >> 2};
// How flat a polygon must be to stay one, in tolerances.
constexpr double kFlat = 1.0 / 16;
// Rounds that find no fewer faults than the best one before them.
constexpr int kMostStalled = 3;
// Faults of a round, in units of the first two.
constexpr std::size_t kMostGrowth = 2;
// With the tolerance doubled near some places.
constexpr int kMostRestarts = 40;

class SurfaceCleaner {
 public:
  SurfaceCleaner(const std::vector<Feature>& features, const SurfaceCleanOptions& options,
                 const ToleranceField& field, Effort& effort)
      : features_(features), options_(options), effort_(effort), surface_(field) {
    surface_.least_sine = std::sin(options.least_angle * std::numbers::pi / 180);
    surface_.most_contraction = options.most_contraction;
  }

  // ABORTED if repairs undo each other, at places that `stuck` becomes.
  absl::StatusOr<SurfaceCleanResult> Run(std::vector<StuckPlace>& stuck) {
    const absl::StatusOr<FeatureId> max_id =
        CheckFeatures(features_, options_.tolerance, kLimitsIn3D);
    if (!max_id.ok()) return max_id.status();
    surface_.next_id = *max_id + 1;
    EnterPoints<3>(features_, surface_, node_of_);
    const absl::flat_hash_set<FeatureId> named = Named();
    for (const Feature& f : features_) {
      Visit(
          f, [&](const ASegment&) { AddSegment(f); }, [&](const APolygon&) { AddPolygon(f); },
          Ignore<APoint, ASize>);
    }
    for (const Feature& f : features_) {
      if (!IsPoint(f) || named.contains(f.id)) continue;
      surface_.Add(std::array{node_of_.at(f.id)}, {f.id});
    }
    surface_.Settle();
    SurfaceRounds rounds(surface_, options_.max_crossings, effort_);
    std::size_t least = ~std::size_t{0}, first = 0;
    int last_gain = 0;
    for (;;) {
      if (surface_.round >= options_.max_rounds) return NotDone(rounds, stuck);
      const absl::StatusOr<bool> more = rounds.Run();
      if (!more.ok()) return more.status();
      if (!*more) break;
      if (rounds.found() < least) {
        least = rounds.found();
        last_gain = surface_.round;
      }
      if (surface_.round <= 2) first = std::max(first, rounds.found());
      if (surface_.round - last_gain > kMostStalled || rounds.found() > kMostGrowth * first) {
        return NotDone(rounds, stuck);
      }
    }
    return Finish();
  }

 private:
  struct Polygon {
    std::size_t pieces = 0;
    std::vector<NodeRing> rings;
    bool may_stay = false;  // a polygon, if nothing changes its pieces
  };

  // The ends and corners.
  absl::flat_hash_set<FeatureId> Named() const {
    absl::flat_hash_set<FeatureId> named;
    for (const Feature& f : features_) {
      ForEachPointOf(f, [&](FeatureId id) { named.insert(id); });
    }
    return named;
  }

  void AddSegment(const Feature& f) {
    surface_.Add(std::array{node_of_.at(f.ends[0]), node_of_.at(f.ends[1])}, {f.id});
  }

  void AddPolygon(const Feature& f) {
    Polygon& polygon = polygons_[f.id];
    std::set<Node> corners;
    std::size_t count = 0;
    for (const auto& ring : f.rings) {
      NodeRing& nodes = polygon.rings.emplace_back();
      for (const FeatureId corner : ring) {
        const Node v = node_of_.at(corner);
        if (nodes.empty() || nodes.back() != v) nodes.push_back(v);
      }
      while (nodes.size() > 1 && nodes.back() == nodes.front()) nodes.pop_back();
      const std::set<Node> own(nodes.begin(), nodes.end());
      count += own.size() == nodes.size() ? 0 : 1;  // a ring through a corner twice
      if (nodes.size() < 3) polygon.rings.pop_back();
    }
    const PolygonPieces pieces = PiecesOf(surface_, polygon.rings, kFlat * options_.tolerance);
    polygon.pieces = pieces.triangles.size();
    polygon.may_stay = pieces.is_regular && pieces.is_flat && count == 0 &&
                       (options_.holes || polygon.rings.size() == 1);
    if (!polygon.may_stay && !pieces.triangles.empty()) {
      const Point3& at = surface_.at(polygon.rings.front().front());
      surface_.changes.push_back({SurfaceChangeKind::kFaceTriangulated, {f.id}, at, at});
    }
    for (const auto& t : pieces.triangles) surface_.Add(t, {f.id});
  }

  absl::Status NotDone(const SurfaceRounds& rounds, std::vector<StuckPlace>& stuck) const {
    stuck = rounds.places();
    return absl::AbortedError(Concat(
        "after ", surface_.round, " rounds faces or edges still touch or cross in ", rounds.found(),
        " places, one at (", rounds.where()[0], ", ", rounds.where()[1], ", ", rounds.where()[2],
        "); choose another tolerance than ", surface_.field.least()));
  }

  // The polygons that no change has reached.
  absl::flat_hash_set<FeatureId> Whole() const {
    struct Left {
      std::size_t pieces = 0;
      Sources sources;  // of all pieces
      bool differ = false;
    };
    absl::flat_hash_map<FeatureId, Left> left;
    for (const Simplex& s : surface_.simplices) {
      if (s.size != 3) continue;
      for (const FeatureId source : s.sources) {
        Left& of = left[source];
        if (of.pieces++ == 0) of.sources = s.sources;
        of.differ = of.differ || of.sources != s.sources || s.born != 0;
      }
    }
    absl::flat_hash_set<FeatureId> whole;
    for (const auto& [id, polygon] : polygons_) {
      const auto it = left.find(id);
      if (!polygon.may_stay || it == left.end() || it->second.differ) continue;
      if (it->second.sources.front() != id) continue;  // the same as another one
      if (std::all_of(it->second.sources.begin(), it->second.sources.end(), [&](FeatureId source) {
            return polygons_.at(source).pieces == it->second.pieces;
          })) {
        whole.insert(id);
      }
    }
    // Its diagonals must be of no other feature.
    absl::flat_hash_set<NodePair> sides;
    for (const FeatureId id : whole) {
      if (polygons_.at(id).pieces < 2) continue;
      for (const NodeRing& ring : polygons_.at(id).rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
          sides.insert(Ordered(ring[i], ring[(i + 1) % ring.size()]));
        }
      }
    }
    for (const auto& [edge, simplices] : surface_.EdgesOf()) {
      std::set<FeatureId> owners;
      for (const std::uint32_t s : simplices) owners.insert(surface_.simplices[s].sources.front());
      if (owners.size() < 2) continue;
      for (const FeatureId owner : owners) {
        if (!whole.contains(owner) || polygons_.at(owner).pieces < 2) continue;
        const std::size_t own = static_cast<std::size_t>(std::count_if(
            simplices.begin(), simplices.end(),
            [&](std::uint32_t s) { return surface_.simplices[s].sources.front() == owner; }));
        if (own > 1) whole.erase(owner);
      }
    }
    return whole;
  }

  SurfaceCleanResult Finish() {
    const absl::flat_hash_set<FeatureId> whole = Whole();
    absl::flat_hash_map<FeatureId, std::vector<const Simplex*>> parts;
    std::vector<bool> used(surface_.nodes.size(), false);
    for (const Simplex& s : surface_.simplices) {
      if (s.size > 1) parts[s.sources.front()].push_back(&s);
      for (int k = 0; k < s.size; ++k) used[s.v[static_cast<std::size_t>(k)]] = true;
    }
    SurfaceCleanResult result;
    AddPoints(used, result.features);
    FeatureId next_id = surface_.next_id;
    for (const bool is_of_faces : {false, true}) {
      for (const Feature& f : features_) {
        if (!Is<ASegment, APolygon>(f, Not<APoint, ASize>)) continue;
        const bool is_face = Is<APolygon>(f, Not<APoint, ASegment, ASize>);
        if (is_face != is_of_faces) continue;
        const auto it = parts.find(f.id);
        if (it == parts.end()) {
          ReportDropped(f);
        } else if (is_face && whole.contains(f.id)) {
          result.features.push_back(Feature::Polygon(f.id, IdsOf(polygons_.at(f.id).rings)));
          if (IsDoubled(*it->second.front())) result.doubled.push_back(f.id);
        } else {
          for (const Simplex* s : it->second) {
            const FeatureId id = s == it->second.front() ? f.id : next_id++;
            if (id != f.id) result.parts.emplace_back(id, f.id);
            if (IsDoubled(*s)) result.doubled.push_back(id);
            result.features.push_back(
                is_face ? Feature::Polygon(id, IdsOf({{s->v[0], s->v[1], s->v[2]}}))
                        : SegmentOf(f, id, *s));
          }
        }
      }
    }
    for (const Feature& f : features_) {
      if (Is<ASize>(f, Not<APoint, ASegment, APolygon>)) result.features.push_back(f);
    }
    result.changes = std::move(surface_.changes);
    result.rounds = surface_.round;
    result.tolerance = surface_.field.most();
    return result;
  }

  static bool IsDoubled(const Simplex& s) { return s.size == 3 && s.sources.size() % 2 == 0; }

  // Of the input first, in its order.
  void AddPoints(const std::vector<bool>& used, std::vector<Feature>& features) const {
    absl::flat_hash_set<FeatureId> of_input;
    const auto add = [&](Node v) {
      const Point3& p = surface_.at(v);
      features.push_back(Feature::Point(surface_.point_ids[v], p[0], p[1], p[2]));
    };
    for (const Feature& f : features_) {
      if (!IsPoint(f)) continue;
      of_input.insert(f.id);
      const Node v = node_of_.at(f.id);
      if (used[v] && surface_.point_ids[v] == f.id) add(v);
    }
    for (Node v = 0; v < surface_.nodes.size(); ++v) {
      if (used[v] && !of_input.contains(surface_.point_ids[v])) add(v);
    }
  }

  // From the end that was nearer to the segment's first one.
  Feature SegmentOf(const Feature& f, FeatureId id, const Simplex& s) const {
    const Point3 &from = surface_.at(node_of_.at(f.ends[0])), &to = surface_.at(s.v[0]);
    const bool forward =
        SquaredDistance<3>(from, to) <= SquaredDistance<3>(from, surface_.at(s.v[1]));
    return Feature::Segment(id, surface_.point_ids[s.v[forward ? 0 : 1]],
                            surface_.point_ids[s.v[forward ? 1 : 0]]);
  }

  Rings IdsOf(const std::vector<NodeRing>& rings) const {
    Rings ids;
    for (const NodeRing& ring : rings) {
      std::vector<FeatureId>& corners = ids.emplace_back();
      for (const Node v : ring) corners.push_back(surface_.point_ids[v]);
    }
    return ids;
  }

  void ReportDropped(const Feature& f) {
    const bool is_face = Is<APolygon>(f, Not<APoint, ASegment, ASize>);
    Point3 at{};
    if (!is_face || (!f.rings.empty() && !f.rings.front().empty())) {
      at = surface_.at(node_of_.at(is_face ? f.rings.front().front() : f.ends[0]));
    }
    surface_.changes.push_back(
        {is_face ? SurfaceChangeKind::kFaceDropped : SurfaceChangeKind::kSegmentDropped,
         {f.id},
         at,
         at});
  }

  const std::vector<Feature>& features_;
  const SurfaceCleanOptions& options_;
  Effort& effort_;
  Surface surface_;
  absl::flat_hash_map<FeatureId, Node> node_of_;
  absl::flat_hash_map<FeatureId, Polygon> polygons_;
};

}  // namespace

const char* NameOf(SurfaceChangeKind kind) {
  switch (kind) {
    case SurfaceChangeKind::kPointMerged:
      return "point merged";
    case SurfaceChangeKind::kPointRounded:
      return "point rounded";
    case SurfaceChangeKind::kFaceTriangulated:
      return "face triangulated";
    case SurfaceChangeKind::kEdgeSplit:
      return "edge split";
    case SurfaceChangeKind::kFaceSplit:
      return "face split";
    case SurfaceChangeKind::kEdgesCrossed:
      return "edges crossed";
    case SurfaceChangeKind::kFaceCrossed:
      return "face crossed";
    case SurfaceChangeKind::kFaceDoubled:
      return "face doubled";
    case SurfaceChangeKind::kFaceDropped:
      return "face dropped";
    case SurfaceChangeKind::kSegmentDoubled:
      return "segment doubled";
    case SurfaceChangeKind::kSegmentDropped:
      return "segment dropped";
    case SurfaceChangeKind::kPointDropped:
      return "point dropped";
  }
  return "";
}

std::uint64_t DefaultSteps(std::size_t features) {
  return std::max(kLeastSteps, kStepsForFeature * features);
}

absl::StatusOr<SurfaceCleanResult> CleanSurfaces(const std::vector<Feature>& features,
                                                 const SurfaceCleanOptions& options) {
  Effort effort(options.max_steps != 0 ? options.max_steps : DefaultSteps(features.size()));
  absl::Status last;
  double most = 0;
  std::vector<StuckPlace> stuck;
  // Nothing if repairs undo each other.
  const auto clean = [&](const ToleranceField& field) {
    absl::StatusOr<SurfaceCleanResult> result =
        SurfaceCleaner(features, options, field, effort).Run(stuck);
    std::optional<absl::StatusOr<SurfaceCleanResult>> done;
    last = result.status();
    most = std::max(most, field.most());
    if (!absl::IsAborted(last)) done = std::move(result);
    return done;
  };
  const auto doubled = [&](int times) {
    return clean(ToleranceField(std::ldexp(options.tolerance, times)));
  };
  ToleranceField field(options.tolerance);
  if (auto done = clean(field)) return *std::move(done);
  std::vector<StuckPlace> places = std::move(stuck);
  const int first = std::min(options.first_doublings, options.max_doublings);
  for (int i = 1; i <= first; ++i) {
    if (auto done = doubled(i)) return *std::move(done);
  }
  // Doubled everywhere it would spoil what needs no more than that.
  for (int i = 0; i < kMostRestarts && field.most_level() < options.max_doublings; ++i) {
    field.RaiseAt(std::move(places), options.max_doublings);
    if (auto done = clean(field)) return *std::move(done);
    places = std::move(stuck);
  }
  for (int i = first + 1; i <= options.max_doublings; ++i) {
    if (auto done = doubled(i)) return *std::move(done);
  }
  return absl::ResourceExhaustedError(
      Concat("up to the tolerance ", most, ": ", text::View(last.message())));
}

}  // namespace dynmesh::cleaning
