#include "core/coplanar/merge_coplanar.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "core/base/feature_kinds.h"
#include "core/base/rings.h"
#include "core/base/text.h"
#include "core/coplanar/coplanar_regions.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/straight_corners.h"
#include "core/geometry/point.h"
#include "dynmesh/error.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using text::Concat;

namespace {

absl::Status Refuse(FeatureId polygon, const std::string& why,
                    const char* reason = reason::kBadPolygon, std::vector<FeatureId> blamed = {}) {
  blamed.push_back(polygon);
  return MakeError(absl::StatusCode::kInvalidArgument, Concat("polygon ", polygon, " ", why),
                   {reason, std::move(blamed), std::nullopt});
}

class Merger {
 public:
  explicit Merger(const std::vector<Feature>& features) : features_(features) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (IsPoint(features[i])) points_.push_back(i);
    }
    std::sort(points_.begin(), points_.end(), [&](std::size_t a, std::size_t b) {
      const Point3 p = {features[a].position}, q = {features[b].position};
      return p == q ? features[a].id < features[b].id : p < q;
    });
    for (const std::size_t i : points_) {
      corner_.emplace(features[i].id, static_cast<Corner>(positions_.size()));
      positions_.push_back({features[i].position});
    }
  }

  absl::Status ReadFaces() {
    for (std::size_t i = 0; i < features_.size(); ++i) {
      if (!Is<APolygon>(features_[i], Not<APoint, ASegment, ASize>)) continue;
      absl::StatusOr<FaceRings> rings = RingsOf(features_[i]);
      if (!rings.ok()) return rings.status();
      polygons_.push_back(i);
      faces_.push_back(*std::move(rings));
    }
    named_before_ = NamedByFaces();
    return absl::OkStatus();
  }

  // Returns the number of regions that were too thick.
  std::size_t Merge(double tolerance, const Thickness& most) {
    std::vector<FaceRings> canonical;
    for (const FaceRings& face : faces_) canonical.push_back(Canonical(face));
    const Kept kept = KeptElsewhere();
    FlatRegions found = FindFlatRegions(positions_, canonical, kept, tolerance, most);
    for (FlatRegion& region : found.regions) {
      const auto by_id = [&](std::size_t f, std::size_t g) {
        return features_[polygons_[f]].id < features_[polygons_[g]].id;
      };
      const std::size_t first = *std::min_element(region.faces.begin(), region.faces.end(), by_id);
      for (const std::size_t f : region.faces) faces_[f].clear();
      faces_[first] = std::move(region.rings);
    }
    named_else_ = kept.corners;
    DropStraightCorners(positions_, named_else_, faces_);
    return found.too_thick;
  }

  std::vector<Feature> Write() const {
    const std::vector<bool> named = NamedByFaces();
    std::vector<Feature> result;
    std::size_t face = 0;
    for (const Feature& f : features_) {
      Visit(
          f,
          [&](const APoint& p) {
            const Corner c = corner_.at(p.id);
            if (!named_before_[c] || named[c] || named_else_[c]) result.push_back(f);
          },
          [&](const APolygon& p) {
            const FaceRings& rings = faces_[face++];
            if (!rings.empty()) result.push_back(Feature::Polygon(p.id, IdsOf(rings)));
          },
          [&](const ASegment&) { result.push_back(f); },
          [&](const ASize&) { result.push_back(f); });
    }
    return result;
  }

 private:
  absl::StatusOr<FaceRings> RingsOf(const Feature& polygon) const {
    FaceRings rings;
    for (const std::vector<FeatureId>& ids : polygon.rings) {
      if (ids.size() < 3) return Refuse(polygon.id, "has a ring of fewer than 3 corners");
      CornerRing& ring = rings.emplace_back();
      for (const FeatureId id : ids) {
        const auto it = corner_.find(id);
        if (it == corner_.end()) {
          return Refuse(polygon.id, Concat("has the corner ", id, ", which is no point; add it"),
                        reason::kUnknownEnd);
        }
        if (!IsInDomain(positions_[it->second].c)) {
          return Refuse(polygon.id,
                        Concat("has the corner ", id, ", which has a coordinate above 2^200 or ",
                               "nearer to 0 than 2^-200; scale the input"),
                        reason::kTooClose, {id});
        }
        ring.push_back(it->second);
      }
    }
    if (rings.empty()) return Refuse(polygon.id, "has no ring");
    return rings;
  }

  template <class F>
  void ForEachEdge(F f) const {
    for (const FaceRings& face : faces_) {
      ForEachEdgeOf(face, [&](Corner p, Corner q) { f(CornerPair(std::minmax(p, q))); });
    }
  }

  std::vector<bool> NamedByFaces() const {
    std::vector<bool> named(positions_.size(), false);
    ForEachEdge([&](const CornerPair& edge) { named[edge.first] = named[edge.second] = true; });
    return named;
  }

  // Kept by segments and by sizing polygons.
  Kept KeptElsewhere() const {
    Kept kept = {{}, std::vector<bool>(positions_.size(), false)};
    const auto name = [&](FeatureId id) {
      const auto it = corner_.find(id);
      if (it != corner_.end()) kept.corners[it->second] = true;
      return it;
    };
    for (const Feature& f : features_) {
      Visit(
          f,
          [&](const ASegment& s) {
            const auto p = name(s.ends[0]), q = name(s.ends[1]);
            if (p != corner_.end() && q != corner_.end()) {
              kept.edges.push_back(std::minmax(p->second, q->second));
            }
          },
          [&](const ASize& s) {
            for (const std::vector<FeatureId>& ring : s.rings) {
              for (const FeatureId id : ring) name(id);
            }
          },
          Ignore<APoint, APolygon>);
    }
    std::sort(kept.edges.begin(), kept.edges.end());
    return kept;
  }

  FeatureId IdOf(Corner c) const { return features_[points_[c]].id; }

  Rings IdsOf(const FaceRings& rings) const {
    Rings ids;
    for (const CornerRing& ring : rings) {
      std::vector<FeatureId>& out = ids.emplace_back();
      for (const Corner c : ring) out.push_back(IdOf(c));
    }
    return ids;
  }

  const std::vector<Feature>& features_;
  std::vector<std::size_t> points_;  // by coordinates; indices into features_
  std::vector<Point3> positions_;    // of points_
  absl::flat_hash_map<FeatureId, Corner> corner_;
  std::vector<std::size_t> polygons_;  // indices into features_
  std::vector<FaceRings> faces_;       // of polygons_; empty if joined to another
  std::vector<bool> named_before_;     // by faces
  std::vector<bool> named_else_;
};

}  // namespace

absl::StatusOr<MergedFaces> MergeCoplanar(const std::vector<Feature>& features, double tolerance,
                                          const Thickness& most) {
  if (!(tolerance >= 0)) {
    return absl::InvalidArgumentError("the tolerance of coplanar faces must be 0 or more");
  }
  Merger merger(features);
  if (auto s = merger.ReadFaces(); !s.ok()) return s;
  MergedFaces merged;
  merged.too_thick = merger.Merge(tolerance, most);
  merged.features = merger.Write();
  return merged;
}

absl::StatusOr<std::vector<Feature>> MergeCoplanar(const std::vector<Feature>& features,
                                                   double tolerance) {
  absl::StatusOr<MergedFaces> merged = MergeCoplanar(features, tolerance, nullptr);
  if (!merged.ok()) return merged.status();
  return std::move(merged->features);
}

}  // namespace dynmesh::coplanar
