#include "core/coplanar/join_flat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/coplanar/coplanar_regions.h"
#include "core/coplanar/cut_face.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/flatten.h"
#include "core/coplanar/needles.h"
#include "core/coplanar/plane_fit.h"
#include "core/coplanar/straight_corners.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

constexpr int kMostRounds = 48;
// What a mesh allows (core/plc/facet_rules.h), less something.
constexpr double kFlatEnough = 0.9e-9;

class FlatJoiner {
 public:
  FlatJoiner(const std::vector<Feature>& features, const JoinOptions& options)
      : features_(features), options_(options) {
    for (std::size_t i = 0; i < features.size(); ++i) {
      last_ = std::max(last_, features[i].id);
      if (features[i].kind == FeatureKind::kPoint) points_.push_back(i);
    }
    std::sort(points_.begin(), points_.end(), [&](std::size_t a, std::size_t b) {
      return features[a].position < features[b].position;
    });
    for (const std::size_t i : points_) {
      corner_.emplace(features[i].id, static_cast<Corner>(positions_.size()));
      positions_.push_back({features[i].position});
      Vector3& rounding = roundings_.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) rounding[k] = options.rounding(features[i].position[k]);
    }
    named_before_.assign(positions_.size(), false);
    for (const Feature& f : features) {
      if (f.kind != FeatureKind::kPolygon) continue;
      CornerRing& ring = faces_.emplace_back();
      for (const FeatureId id : f.rings.front()) {
        ring.push_back(corner_.at(id));
        named_before_[ring.back()] = true;
      }
      ids_.push_back(f.id);
      kept_faces_.push_back(false);
    }
    kept_.corners.assign(positions_.size(), false);
    for (const Feature& f : features) {
      if (f.kind != FeatureKind::kSegment) continue;
      const Corner p = corner_.at(f.ends[0]), q = corner_.at(f.ends[1]);
      kept_.corners[p] = kept_.corners[q] = true;
      kept_.edges.push_back(std::minmax(p, q));
    }
    std::sort(kept_.edges.begin(), kept_.edges.end());
  }

  JoinedFaces Run() {
    if (options_.join) {
      result_.needles = DropNeedles(positions_, Within(), kept_.edges, faces_);
    }
    for (std::size_t f = 0, n = faces_.size(); f < n; ++f) {
      if (faces_[f].size() > 3 && !IsFlat(faces_[f])) Cut(f);
    }
    for (int round = 0;; ++round) {
      const bool is_last = !options_.join || round == kMostRounds;
      if (is_last) kept_faces_.assign(faces_.size(), true);
      MakePatches();
      moved_ = positions_;
      if (!is_last) {
        if (const auto bad = Flatten(patches_, roundings_, moved_); !bad.empty()) {
          for (const std::size_t p : bad) Keep(p);
          continue;
        }
      }
      WriteFeatures();
      if (is_last || !options_.refused || !KeepRefused()) break;
    }
    Count();
    return std::move(result_);
  }

 private:
  std::function<double(Corner)> Within() const {
    return [this](Corner c) {
      return 2 * std::max({roundings_[c][0], roundings_[c][1], roundings_[c][2]});
    };
  }

  PointRing PositionsOf(const CornerRing& ring) const {
    PointRing points;
    for (const Corner c : ring) points.push_back(positions_[c]);
    return points;
  }

  // Is a face of four corners and more within its rounding, or flat enough for a mesh?
  bool IsFlat(const CornerRing& ring) const {
    const std::array<PointRing, 1> rings = {PositionsOf(ring)};
    const Vector3 area = AreaVector(rings[0]);
    if (!(geometry::Dot(area, area) > 0)) return true;  // refused by a mesh
    const geometry::FacetBounds bounds = geometry::BoundsOf(rings, geometry::PlaneOf(rings));
    double extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, bounds.hi[k] - bounds.lo[k]);
    return bounds.deviation <= kFlatEnough * extent || IsRounded(ring);
  }

  bool IsRounded(const CornerRing& ring) const {
    if (!options_.join) return false;
    CornerRing sorted = ring;
    std::sort(sorted.begin(), sorted.end());
    const Vector3 area = AreaVector(PositionsOf(ring));
    const PlaneFit fit(PositionsOf(sorted), area);
    return std::all_of(sorted.begin(), sorted.end(), [&](Corner c) {
      return std::abs(fit.Height(positions_[c])) <=
             kBand * RoundingAlong(fit.normal(), roundings_[c]);
    });
  }

  // Its triangles are kept faces.
  void Cut(std::size_t f) {
    const std::vector<CornerRing> triangles = CutFace(positions_, faces_[f]);
    if (triangles.empty()) {
      kept_faces_[f] = true;
      return;
    }
    ++result_.cut;
    for (const CornerRing& triangle : triangles) {
      if (&triangle == triangles.data()) {
        faces_[f] = triangle;
        kept_faces_[f] = options_.join ? was_patch_ : true;
        continue;
      }
      faces_.push_back(triangle);
      ids_.push_back(++last_);
      result_.parts.emplace_back(last_, ids_[f]);
      kept_faces_.push_back(kept_faces_[f]);
    }
  }

  // Joins what is flat, of the faces that are not kept.
  void MakePatches() {
    std::vector<FaceRings> faces;
    std::vector<bool> stay = kept_faces_;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      faces.push_back(faces_[f].empty() ? FaceRings{} : Canonical({faces_[f]}));
      if (faces_[f].empty()) stay[f] = true;
    }
    std::vector<FlatRegion> regions;
    if (options_.join) {
      regions = FindRoundedRegions(positions_, roundings_, faces, kept_, stay);
    }
    out_.clear();
    members_.clear();
    std::vector<bool> used(faces_.size(), false);
    for (FlatRegion& region : regions) {
      if (!options_.holes && region.rings.size() > 1) continue;
      for (const std::size_t f : region.faces) used[f] = true;
      out_.push_back(std::move(region.rings));
      members_.push_back(std::move(region.faces));
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (used[f] || faces_[f].empty()) continue;
      out_.push_back({faces_[f]});
      members_.push_back({f});
    }
    if (options_.join) DropStraightCorners(positions_, kept_.corners, out_, Within());
    // What is to be flat, by coordinates.
    std::map<FaceRings, std::size_t> order;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      std::size_t corners = 0;
      for (const CornerRing& ring : out_[i]) corners += ring.size();
      const bool is_kept = members_[i].size() == 1 && kept_faces_[members_[i].front()];
      if (corners > 3 && !is_kept) order.emplace(Canonical(out_[i]), i);
    }
    patches_.clear();
    of_patch_.clear();
    for (auto& [rings, i] : order) {
      patches_.push_back(rings);
      of_patch_.push_back(i);
    }
  }

  void Keep(std::size_t patch) { KeepOutput(of_patch_[patch]); }

  // The faces of a polygon stay as they were; a lone one is cut.
  void KeepOutput(std::size_t i) {
    for (const std::size_t f : members_[i]) {
      kept_faces_[f] = true;
      if (faces_[f].size() > 3) {
        was_patch_ = true;
        Cut(f);
      }
    }
  }

  FeatureId IdOf(Corner c) const { return features_[points_[c]].id; }

  void WriteFeatures() {
    std::vector<bool> named(positions_.size(), false);
    for (const FaceRings& rings : out_) {
      for (const CornerRing& ring : rings) {
        for (const Corner c : ring) named[c] = true;
      }
    }
    result_.features.clear();
    for (const Feature& f : features_) {
      if (f.kind == FeatureKind::kPolygon) continue;
      if (f.kind != FeatureKind::kPoint) {
        result_.features.push_back(f);
        continue;
      }
      const Corner c = corner_.at(f.id);
      if (named_before_[c] && !named[c] && !kept_.corners[c]) continue;
      result_.features.push_back(f);
      result_.features.back().position = moved_[c].c;
    }
    std::map<FeatureId, std::size_t> by_id;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      FeatureId id = ids_[members_[i].front()];
      for (const std::size_t f : members_[i]) id = std::min(id, ids_[f]);
      by_id.emplace(id, i);
    }
    for (const auto& [id, i] : by_id) {
      Rings rings;
      for (const CornerRing& ring : out_[i]) {
        std::vector<FeatureId>& corners = rings.emplace_back();
        for (const Corner c : ring) corners.push_back(IdOf(c));
      }
      result_.features.push_back(Feature::Polygon(id, std::move(rings)));
    }
  }

  // With numbers by coordinates as ids, so that the order of the file does not decide what is told
  // first. True if a polygon is kept as its faces now.
  bool KeepRefused() {
    if (patches_.empty()) return false;
    std::vector<Feature> canonical;
    for (const std::size_t i : points_) {
      const auto c = corner_.at(features_[i].id);
      canonical.push_back(
          Feature::Point(FeatureId{c} + 1, moved_[c][0], moved_[c][1], moved_[c][2]));
    }
    absl::flat_hash_set<FeatureId> present;
    for (const Feature& f : result_.features) present.insert(f.id);
    std::erase_if(canonical, [&](const Feature& f) {
      return !present.contains(IdOf(static_cast<Corner>(f.id - 1)));
    });
    FeatureId id = positions_.size();
    for (const auto& [p, q] : kept_.edges) {
      canonical.push_back(Feature::Segment(++id, FeatureId{p} + 1, FeatureId{q} + 1));
    }
    std::vector<std::size_t> order(out_.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::vector<FaceRings> keys;
    for (const FaceRings& rings : out_) keys.push_back(Canonical(rings));
    std::sort(order.begin(), order.end(),
              [&](std::size_t i, std::size_t j) { return keys[i] < keys[j]; });
    const FeatureId first = id + 1;
    for (const std::size_t i : order) {
      Rings rings;
      for (const CornerRing& ring : keys[i]) {
        std::vector<FeatureId>& corners = rings.emplace_back();
        for (const Corner c : ring) corners.push_back(FeatureId{c} + 1);
      }
      canonical.push_back(Feature::Polygon(++id, std::move(rings)));
    }
    std::vector<bool> blamed(out_.size(), false);
    for (const FeatureId of : options_.refused(canonical)) {
      if (of >= first && of <= id) blamed[order[of - first]] = true;
    }
    bool any = false;
    for (const std::size_t i : of_patch_) {
      if (!blamed[i]) continue;
      const bool is_joined = members_[i].size() > 1;
      const bool is_moved =
          std::any_of(out_[i].begin(), out_[i].end(), [&](const CornerRing& ring) {
            return std::any_of(ring.begin(), ring.end(),
                               [&](Corner c) { return !(moved_[c] == positions_[c]); });
          });
      if (!is_joined && !is_moved) continue;
      KeepOutput(i);
      any = true;
    }
    return any;
  }

  void Count() {
    for (const std::vector<std::size_t>& faces : members_) {
      if (faces.size() < 2) continue;
      result_.joined += faces.size();
      ++result_.polygons;
    }
    for (const Feature& f : result_.features) {
      if (f.kind != FeatureKind::kPoint) continue;
      const Corner c = corner_.at(f.id);
      const double distance2 = geometry::SquaredDistance(moved_[c], positions_[c]);
      if (distance2 == 0) continue;
      ++result_.moved;
      result_.most_moved = std::max(result_.most_moved, std::sqrt(distance2));
    }
  }

  const std::vector<Feature>& features_;
  const JoinOptions& options_;
  JoinedFaces result_;
  FeatureId last_ = 0;
  std::vector<std::size_t> points_;  // in the order of coordinates
  std::vector<Point3> positions_, moved_;
  std::vector<Vector3> roundings_;
  absl::flat_hash_map<FeatureId, Corner> corner_;
  std::vector<bool> named_before_;
  Kept kept_;
  std::vector<CornerRing> faces_;  // empty: it is gone
  std::vector<FeatureId> ids_;     // of faces
  std::vector<bool> kept_faces_;   // those that stay as they are
  bool was_patch_ = false;         // faces that are cut were to be flat
  // Of a round: polygons, and their faces; of them those that are to be flat.
  std::vector<FaceRings> out_;
  std::vector<std::vector<std::size_t>> members_;
  std::vector<FaceRings> patches_;
  std::vector<std::size_t> of_patch_;
};

}  // namespace

JoinedFaces JoinFlat(const std::vector<Feature>& features, const JoinOptions& options) {
  return FlatJoiner(features, options).Run();
}

}  // namespace dynmesh::coplanar
