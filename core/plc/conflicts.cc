#include "core/plc/conflicts.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "core/base/box_tree.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/plc/delta.h"
#include "core/plc/facet.h"
#include "core/plc/facet_rules.h"
#include "core/plc/feature_index.h"
#include "core/plc/messages.h"
#include "core/plc/rules.h"

namespace dynmesh::plc {
namespace {

using geometry::Point3;

constexpr double kGrown = 1e-4;  // of the mesh's box

class ConflictFinder {
 public:
  ConflictFinder(const MeshOptions& options, const std::vector<Feature>& features,
                 absl::FunctionRef<bool(FeatureId)> is_looked_at,
                 absl::FunctionRef<void(FeatureId, FeatureId)> found)
      : options_(options),
        limit_(CloseLimit(options)),
        is_looked_at_(is_looked_at),
        found_(found),
        index_(CellGrid<3>(options.box, limit_)) {
    for (const Feature& f : features) {
      if (!IsPoint(f)) continue;
      std::copy_n(f.position.begin(), 3, position_[f.id].c.begin());
    }
    // What is far from all that is looked at does not matter.
    std::vector<Box3> looked_at;
    for (const Feature& f : features) {
      if (IsShape(f) && is_looked_at(f.id)) looked_at.push_back(BoxOf(f));
    }
    const boxes::BoxTree<3> near(std::move(looked_at));
    for (const Feature& f : features) {
      if (!IsShape(f) || !near.Meets(BoxOf(f))) continue;
      Visit(
          f,
          [&](const APoint& p) {
            points_.push_back({p.id, position_.at(p.id)});
          },
          [&](const ASegment&) { AddSegment(f); }, [&](const APolygon&) { AddPolygon(f); },
          Ignore<ASize>);
    }
  }

  void Run() {
    for (const auto& p : points_) index_.Insert(p);
    for (const auto& s : segments_) index_.Insert(s);
    for (const Facet& f : facets_) index_.Insert(f);
    for (const auto& p : points_) {
      if (!is_looked_at_(p.id)) continue;
      if (!CheckPosition(p, options_.box, 0).ok()) found_(p.id, p.id);
      index_.QueryNear(
          p.p, [&](const PointFeature<3>& q) { Judge(p, q, p.id != q.id); },
          [&](const SegmentFeature<3>& s) { Judge(p, s); }, [&](const Facet& f) { Judge(p, f); },
          &cost_);
    }
    for (const auto& s : segments_) {
      if (!IsLookedAt(s)) continue;
      index_.QueryNear(
          s, [&](const PointFeature<3>& p) { Judge(p, s); },
          [&](const SegmentFeature<3>& t) { Judge(s, t, KeyOf(s) != KeyOf(t)); },
          [&](const Facet& f) { Judge(s, f); }, &cost_);
    }
    for (const Facet& f : facets_) {
      if (!is_looked_at_(f.id())) continue;
      if (!CheckFacet(f, limit_, 0).ok()) found_(f.id(), f.id());
      // Facets may be near in as many visited cells as they have corners.
      absl::flat_hash_map<FeatureId, bool> judged;
      index_.QueryNear(
          f, [&](const PointFeature<3>& p) { Judge(p, f); },
          [&](const SegmentFeature<3>& s) { Judge(s, f); },
          [&](const Facet& g) {
            if (judged.try_emplace(g.id(), true).second) Judge(f, g, f.id() != g.id());
          },
          &cost_);
    }
  }

 private:
  using Box3 = boxes::Box<3>;
  // Has it a place? Sizes have none.
  static bool IsShape(const Feature& f) { return !Is<ASize>(f, Not<APoint, ASegment, APolygon>); }

  // Grown by far more than what is too close, or not flat.
  Box3 BoxOf(const Feature& f) const {
    Box3 box{};
    bool is_first = true;
    const auto add = [&](FeatureId id) {
      const Box3::Corner& corner = position_.at(id).c;
      if (is_first) box = {corner, corner};
      is_first = false;
      box.Hold(corner);
    };
    Visit(
        f, [&](const APoint& p) { add(p.id); },
        [&](const ASegment& s) {
          for (const FeatureId id : s.ends) add(id);
        },
        [&](const APolygon& p) {
          for (const auto& ring : p.rings) {
            for (const FeatureId id : ring) add(id);
          }
        },
        Ignore<ASize>);
    for (std::size_t k = 0; k < 3; ++k) {
      const double more = kGrown * (options_.box.hi[k] - options_.box.lo[k]);
      box.low[k] -= more, box.high[k] += more;
    }
    return box;
  }

  void AddSegment(const Feature& f) {
    SegmentFeature<3>& edge = segments_[EdgeBetween(f.ends[0], f.ends[1])];
    const bool is_twice = edge.id != kNoFeature && !edge.IsOfPolygon();
    if (is_twice && (is_looked_at_(f.id) || is_looked_at_(edge.id))) found_(edge.id, f.id);
    if (!is_twice) edge.id = f.id;
  }

  // The index of the segment or edge between two points.
  std::size_t EdgeBetween(FeatureId p, FeatureId q) {
    const EdgeKey key = KeyOf(p, q);
    const auto [it, is_new] = edge_.emplace(key, segments_.size());
    if (is_new) {
      segments_.push_back({kNoFeature,
                           key.first,
                           key.second,
                           position_.at(key.first),
                           position_.at(key.second),
                           {}});
    }
    return it->second;
  }

  void AddPolygon(const Feature& f) {
    if (!CheckRings(f.id, f.rings, 0).ok()) {
      found_(f.id, f.id);
      return;
    }
    FacetFeature facet = {f.id, f.rings, {}};
    for (const std::vector<FeatureId>& ring : f.rings) {
      std::vector<Point3>& positions = facet.positions.emplace_back();
      for (const FeatureId id : ring) positions.push_back(position_.at(id));
    }
    facets_.emplace_back(std::move(facet));
    ForEachEdgeOf(f.rings, [&](FeatureId p, FeatureId q) {
      SegmentFeature<3>& edge = segments_[EdgeBetween(p, q)];
      edge.polygons.insert(std::lower_bound(edge.polygons.begin(), edge.polygons.end(), f.id),
                           f.id);
      // As the complex has it: a segment feature stands for the edge.
      if (edge.id == kNoFeature || edge.IsOfPolygon()) edge.id = edge.polygons.front();
    });
  }

  bool IsLookedAt(const SegmentFeature<3>& s) const {
    return is_looked_at_(s.id) || std::any_of(s.polygons.begin(), s.polygons.end(), is_looked_at_);
  }

  static std::vector<FeatureId> IdsOf(const PointFeature<3>& p) { return {p.id}; }
  static std::vector<FeatureId> IdsOf(const Facet& f) { return {f.id()}; }
  static std::vector<FeatureId> IdsOf(const SegmentFeature<3>& s) {
    std::vector<FeatureId> ids = s.polygons;
    if (!s.IsOfPolygon()) ids.push_back(s.id);
    return ids;
  }

  template <class F, class G>
  void Judge(const F& f, const G& g, bool are_two = true) {
    if (!are_two || Between(f, g, limit_) == Conflict::kNone) return;
    for (const FeatureId a : IdsOf(f)) {
      for (const FeatureId b : IdsOf(g)) found_(a, b);
    }
  }

  const MeshOptions& options_;
  const double limit_;
  const absl::FunctionRef<bool(FeatureId)> is_looked_at_;
  const absl::FunctionRef<void(FeatureId, FeatureId)> found_;
  FeatureIndex<3> index_;
  absl::flat_hash_map<FeatureId, Point3> position_;
  absl::flat_hash_map<EdgeKey, std::size_t> edge_;
  std::vector<PointFeature<3>> points_;
  std::vector<SegmentFeature<3>> segments_;
  std::vector<Facet> facets_;
  std::uint64_t cost_ = 0;
};

}  // namespace

void FindConflicts(const MeshOptions& options, const std::vector<Feature>& features,
                   absl::FunctionRef<bool(FeatureId)> is_looked_at,
                   absl::FunctionRef<void(FeatureId, FeatureId)> found) {
  ConflictFinder(options, features, is_looked_at, found).Run();
}

}  // namespace dynmesh::plc
