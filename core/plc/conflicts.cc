#include "core/plc/conflicts.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
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
                 absl::FunctionRef<bool(FeatureId)> is_new,
                 absl::FunctionRef<void(FeatureId)> found)
      : options_(options),
        limit_(CloseLimit(options)),
        is_new_(is_new),
        found_(found),
        index_(CellGrid<3>(options.box, limit_)) {
    for (const Feature& f : features) {
      if (is_looked_at(f.id)) open_.insert(f.id);
      if (!IsPoint(f)) continue;
      std::copy_n(f.position.begin(), 3, position_[f.id].c.begin());
    }
    // What is far from all that is new does not matter.
    std::vector<Box3> fresh;
    for (const Feature& f : features) {
      if (IsShape(f) && is_new_(f.id)) fresh.push_back(BoxOf(f));
    }
    const boxes::BoxTree<3> near(std::move(fresh));
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

  // Each pair is judged once: when the later one comes. What is new comes first. The rest need not
  // be in the index: of two that are not new nothing is asked. It takes long to enter thousands of
  // needles at one corner.
  void Run() {
    for (const auto& p : points_) {
      if (!is_new_(p.id)) continue;
      if (!CheckPosition(p, options_.box, 0).ok()) Tell(p);
      JudgeNear(p);
      index_.Insert(p);
    }
    for (const auto& s : segments_) {
      if (!IsNew(s)) continue;
      JudgeNear(s);
      index_.Insert(s);
    }
    for (const Facet& f : facets_) {
      if (!is_new_(f.id())) continue;
      if (!CheckFacet(f, limit_, 0).ok()) Tell(f);
      JudgeNear(f);
      index_.Insert(f);
    }
    for (const auto& p : points_) {
      if (!is_new_(p.id)) JudgeNear(p);
    }
    for (const auto& s : segments_) {
      if (!IsNew(s)) JudgeNear(s);
    }
    for (const Facet& f : facets_) {
      if (!is_new_(f.id())) JudgeNear(f);
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
    if (is_twice && (is_new_(f.id) || is_new_(edge.id))) {
      Tell(f.id);
      Tell(edge.id);
    }
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
      if (is_new_(f.id)) Tell(f.id);
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

  bool IsNew(const SegmentFeature<3>& s) const {
    return is_new_(s.id) || std::any_of(s.polygons.begin(), s.polygons.end(), is_new_);
  }

  // What is in conflict with the feature is so with all of these.
  template <class Do>
  static bool AnyOf(const PointFeature<3>& p, Do is) {
    return is(p.id);
  }
  template <class Do>
  static bool AnyOf(const Facet& f, Do is) {
    return is(f.id());
  }
  template <class Do>
  static bool AnyOf(const SegmentFeature<3>& s, Do is) {
    return std::any_of(s.polygons.begin(), s.polygons.end(), is) || (!s.IsOfPolygon() && is(s.id));
  }

  void Tell(FeatureId id) {
    if (open_.erase(id) != 0) found_(id);
  }
  template <class F>
  void Tell(const F& f) {
    AnyOf(f, [&](FeatureId id) {
      Tell(id);
      return false;
    });
  }

  // Of many at one corner that are in conflict with each other, most are told after a few pairs.
  template <class F>
  bool IsTold(const F& f) const {
    return !AnyOf(f, [&](FeatureId id) { return open_.contains(id); });
  }

  // Each with what is in the index.
  void JudgeNear(const PointFeature<3>& p) {
    index_.QueryNear(
        p.p, [&](const PointFeature<3>& q) { Judge(p, q, p.id != q.id); },
        [&](const SegmentFeature<3>& s) { Judge(p, s); }, [&](const Facet& f) { Judge(p, f); },
        &cost_);
  }
  void JudgeNear(const SegmentFeature<3>& s) {
    index_.QueryNear(
        s, [&](const PointFeature<3>& p) { Judge(p, s); },
        [&](const SegmentFeature<3>& t) { Judge(s, t, KeyOf(s) != KeyOf(t)); },
        [&](const Facet& f) { Judge(s, f); }, &cost_);
  }
  void JudgeNear(const Facet& f) {
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
  template <class F, class G>
  void Judge(const F& f, const G& g, bool are_two = true) {
    if (!are_two || (IsTold(f) && IsTold(g)) || Between(f, g, limit_) == Conflict::kNone) return;
    Tell(f);
    Tell(g);
  }

  const MeshOptions& options_;
  const double limit_;
  const absl::FunctionRef<bool(FeatureId)> is_new_;
  const absl::FunctionRef<void(FeatureId)> found_;
  absl::flat_hash_set<FeatureId> open_;  // looked at, and not told yet
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
                   absl::FunctionRef<bool(FeatureId)> is_new,
                   absl::FunctionRef<void(FeatureId)> found) {
  ConflictFinder(options, features, is_looked_at, is_new, found).Run();
}

}  // namespace dynmesh::plc
