#include "core/coplanar/join_flat.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "core/base/feature_kinds.h"
#include "core/coplanar/coplanar_regions.h"
#include "core/coplanar/cut_face.h"
#include "core/coplanar/facet_rings.h"
#include "core/coplanar/flatten.h"
#include "core/coplanar/lone_faces.h"
#include "core/coplanar/needles.h"
#include "core/coplanar/plane_fit.h"
#include "core/coplanar/straight_corners.h"
#include "core/geometry/facet_plane.h"
#include "core/geometry/point.h"

namespace dynmesh::coplanar {

using geometry::Point3;
using geometry::Vector3;

namespace {

// In which faces stay, until all do.
constexpr int kMostRounds = 12;
// What a mesh allows (core/plc/facet_rules.h), less something.
constexpr double kFlatEnough = 0.9e-9;

class FlatJoiner {
 public:
  FlatJoiner(std::vector<Feature> given, const JoinOptions& options)
      : features_(std::move(given)), options_(options) {
    const std::vector<Feature>& features = features_;
    for (std::size_t i = 0; i < features.size(); ++i) {
      last_ = std::max(last_, features[i].id);
      if (IsPoint(features[i])) points_.push_back(i);
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
      if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      CornerRing& ring = given_.emplace_back();
      for (const FeatureId id : f.rings.front()) {
        ring.push_back(corner_.at(id));
        named_before_[ring.back()] = true;
      }
      given_ids_.push_back(f.id);
    }
    is_exact_.assign(positions_.size(), false);
    kept_.corners.assign(positions_.size(), false);
    for (const Feature& f : features) {
      if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
      const Corner p = corner_.at(f.ends[0]), q = corner_.at(f.ends[1]);
      kept_.corners[p] = kept_.corners[q] = true;
      kept_.edges.push_back(std::minmax(p, q));
    }
    std::sort(kept_.edges.begin(), kept_.edges.end());
  }

  JoinedFaces Run() {
    Start();
    for (int round = 0; options_.join; ++round) {
      if (round == kMostRounds) {
        options_.join = false;
        Start();
        break;
      }
      MakePatches();
      moved_ = positions_;
      if (const auto bad = Flatten(patches_, roundings_, moved_); !bad.empty()) {
        for (const std::size_t p : bad) KeepOutput(of_patch_[p]);
        continue;
      }
      WriteFeatures();
      if (!KeepRefused()) break;
    }
    if (!options_.join) {
      kept_faces_.assign(faces_.size(), true);
      MakePatches();
      moved_ = positions_;
      WriteFeatures();
    }
    Count();
    return std::move(result_);
  }

 private:
  // The faces as they come, without those that have no area, and flat.
  void Start() {
    faces_ = given_;
    ids_ = given_ids_;
    kept_faces_.assign(faces_.size(), false);
    groups_.clear();
    for (const FeatureId id : ids_) groups_.push_back(options_.group ? options_.group(id) : 0);
    next_id_ = last_ + 1;
    result_ = {};
    if (options_.join) {
      result_.needles = DropNeedles(positions_, Within(), kept_.edges, faces_);
    }
    as_given_.clear();
    judged_.reset();
    for (std::size_t f = 0; f < faces_.size(); ++f) as_given_.push_back(faces_[f] == given_[f]);
    for (std::size_t f = 0, n = faces_.size(); f < n; ++f) {
      if (faces_[f].size() > 3 && !IsFlat(faces_[f])) Cut(f, !options_.join);
    }
    is_lone_ = options_.join ? LoneFaces(positions_, roundings_, faces_)
                             : std::vector<bool>(faces_.size(), true);
  }

  std::function<double(Corner)> Within() const {
    return [this](Corner c) {
      const Vector3& rounding = roundings_[c];
      return is_exact_[c] ? 0 : 2 * std::max({rounding[0], rounding[1], rounding[2]});
    };
  }

  PointRing PositionsOf(const CornerRing& ring) const {
    PointRing points;
    for (const Corner c : ring) points.push_back(positions_[c]);
    return points;
  }

  // Is a face of four corners and more within its rounding, or flat enough for a mesh?
  bool IsFlat(const CornerRing& ring) const { return IsFlatAsItIs(ring) || IsRounded(ring); }

  bool IsFlatAsItIs(const CornerRing& ring) const {
    const std::array<PointRing, 1> rings = {PositionsOf(ring)};
    const Vector3 area = AreaVector(rings[0]);
    if (!(geometry::Dot(area, area) > 0)) return true;  // refused by a mesh
    const geometry::FacetBounds bounds = geometry::BoundsOf(rings, geometry::PlaneOf(rings));
    double extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, bounds.hi[k] - bounds.lo[k]);
    return bounds.deviation <= kFlatEnough * extent;
  }

  bool IsRounded(const CornerRing& ring) const {
    if (!options_.join) return false;
    CornerRing sorted = ring;
    std::sort(sorted.begin(), sorted.end());
    const Vector3 area = AreaVector(PositionsOf(ring));
    const PlaneFit fit(PositionsOf(sorted), area, RoundingsAlong(area, sorted, roundings_));
    return std::all_of(sorted.begin(), sorted.end(), [&](Corner c) {
      return std::abs(fit.Height(positions_[c])) <=
             kBand * RoundingAlong(fit.normal(), roundings_[c]);
    });
  }

  // Into triangles, that are joined as others or are kept.
  void Cut(std::size_t f, bool is_kept) {
    const std::vector<CornerRing> triangles = CutFace(positions_, faces_[f]);
    if (triangles.empty()) {
      kept_faces_[f] = true;
      return;
    }
    ++result_.cut;
    for (const CornerRing& triangle : triangles) {
      if (&triangle == triangles.data()) {
        faces_[f] = triangle;
        kept_faces_[f] = is_kept;
        continue;
      }
      faces_.push_back(triangle);
      ids_.push_back(next_id_++);
      result_.parts.emplace_back(ids_.back(), ids_[f]);
      kept_faces_.push_back(is_kept);
      groups_.push_back(groups_[f]);
      is_lone_.push_back(true);
      as_given_.push_back(as_given_[f]);
    }
  }

  // Joins what is flat, of the faces that are not kept.
  void MakePatches() {
    std::vector<bool> stay = kept_faces_;
    bool any = false;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      if (faces_[f].empty() || is_lone_[f]) stay[f] = true;
      any = any || !stay[f];
    }
    std::vector<FlatRegion> regions;
    if (any) {
      regions = FindRoundedRegions(positions_, roundings_, faces_, kept_, groups_, stay);
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
    if (options_.join) DropStraight();
    // What is to be flat, by coordinates.
    std::map<FaceRings, std::size_t> order;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      if (IsPatch(i)) order.emplace(Canonical(out_[i]), i);
    }
    patches_.clear();
    of_patch_.clear();
    for (auto& [rings, i] : order) {
      patches_.push_back(rings);
      of_patch_.push_back(i);
    }
  }

  // Triangles keep their corners.
  void DropStraight() {
    std::vector<bool> kept = kept_.corners;
    std::vector<FaceRings> large;
    std::vector<std::size_t> of_large;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      if (out_[i].size() > 1 || out_[i].front().size() > 3) {
        large.push_back(std::move(out_[i]));
        of_large.push_back(i);
        continue;
      }
      for (const Corner c : out_[i].front()) kept[c] = true;
    }
    if (!large.empty()) DropStraightCorners(positions_, kept, large, Within());
    for (std::size_t k = 0; k < large.size(); ++k) out_[of_large[k]] = std::move(large[k]);
  }

  // The faces of a polygon stay as they were; a lone one is cut if it is not flat.
  void KeepOutput(std::size_t i) {
    for (const std::size_t f : members_[i]) {
      kept_faces_[f] = true;
      if (faces_[f].size() > 3 && !IsFlatAsItIs(faces_[f])) Cut(f, true);
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
      if (Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
      if (Is<ASegment, ASize>(f, Not<APoint, APolygon>)) {
        result_.features.push_back(f);
        continue;
      }
      const Corner c = corner_.at(f.id);
      if (named_before_[c] && !named[c] && !kept_.corners[c]) continue;
      result_.features.push_back(f);
      result_.features.back().position = moved_[c].c;
    }
    std::vector<std::pair<FeatureId, std::size_t>> by_id;
    for (std::size_t i = 0; i < out_.size(); ++i) by_id.emplace_back(IdOfOutput(i), i);
    std::sort(by_id.begin(), by_id.end());
    for (const auto& [id, i] : by_id) {
      Rings rings;
      for (const CornerRing& ring : out_[i]) {
        std::vector<FeatureId>& corners = rings.emplace_back();
        for (const Corner c : ring) corners.push_back(IdOf(c));
      }
      result_.features.push_back(Feature::Polygon(id, std::move(rings)));
    }
  }

  bool IsMoved(Corner c) const { return !(moved_[c] == positions_[c]); }

  bool IsMoved(const FaceRings& rings) const {
    return std::any_of(rings.begin(), rings.end(), [&](const CornerRing& ring) {
      return std::any_of(ring.begin(), ring.end(), [&](Corner c) { return IsMoved(c); });
    });
  }

  // Is it other than a face that was given, or its triangles?
  bool IsChanged(std::size_t i) const {
    const std::size_t f = members_[i].front();
    return members_[i].size() > 1 || !as_given_[f] || out_[i].front() != faces_[f] ||
           IsMoved(out_[i]);
  }

  // Where something that has changed is in conflict, faces stay as they were given. True if there
  // are such ones.
  bool KeepRefused() {
    if (!options_.conflicts) return false;
    absl::flat_hash_map<FeatureId, std::size_t> output_of;
    absl::flat_hash_set<FeatureId> changed;
    for (std::size_t i = 0; i < out_.size(); ++i) {
      if (!IsChanged(i)) continue;
      output_of.emplace(IdOfOutput(i), i);
      changed.insert(IdOfOutput(i));
    }
    for (const Feature& f : result_.features) {
      const bool is_moved = Visit(
          f, [&](const APoint& p) { return IsMoved(corner_.at(p.id)); },
          [&](const ASegment& s) {
            return IsMoved(corner_.at(s.ends[0])) || IsMoved(corner_.at(s.ends[1]));
          },
          // Those that have changed are known by now; sizes stay.
          [](const APolygon&) { return false; }, [](const ASize&) { return false; });
      if (is_moved) changed.insert(f.id);
    }
    if (changed.empty()) return false;
    const absl::flat_hash_set<FeatureId> blamed = Blamed(std::move(changed));
    if (blamed.empty()) return false;
    // What holds moved corners: all polygons that are to be flat there.
    std::vector<bool> stays(out_.size(), false), corner_stays(positions_.size(), false);
    bool any = false;
    for (const Feature& f : result_.features) {
      if (!blamed.contains(f.id)) continue;
      Visit(
          f, [&](const APoint& p) { corner_stays[corner_.at(p.id)] = true; },
          [&](const ASegment& s) {
            for (const FeatureId end : s.ends) corner_stays[corner_.at(end)] = true;
          },
          [&](const APolygon& p) {
            const std::size_t i = output_of.at(p.id);
            stays[i] = true;
            for (const CornerRing& ring : out_[i]) {
              for (const Corner c : ring) {
                if (!IsPatch(i)) corner_stays[c] = true;
              }
            }
          },
          Ignore<ASize>);
    }
    for (std::size_t i = 0; i < out_.size(); ++i) {
      for (const CornerRing& ring : out_[i]) {
        for (const Corner c : ring) {
          if (corner_stays[c] && IsMoved(c)) stays[i] = true;
        }
      }
    }
    for (std::size_t i = 0, n = out_.size(); i < n; ++i) {
      if (!stays[i] || !IsPatch(i)) continue;
      KeepOutput(i);
      any = true;
    }
    if (any) return true;
    // Then faces without area have changed their neighbours.
    for (Corner c = 0; c < corner_stays.size(); ++c) {
      any = any || (corner_stays[c] && !is_exact_[c]);
      if (corner_stays[c]) is_exact_[c] = true;
    }
    if (!any) options_.join = false;
    Start();
    return true;
  }

  // Those of `changed` that are in conflict. What was judged in the round before, without a
  // conflict, and is as it was then, is not judged again with others of that kind.
  absl::flat_hash_set<FeatureId> Blamed(absl::flat_hash_set<FeatureId> changed) {
    absl::flat_hash_set<FeatureId> blamed;
    if (options_.accepts && !std::exchange(is_asked_, true)) {
      result_.is_accepted = options_.accepts(result_.features);
      if (result_.is_accepted) return blamed;
    }
    absl::flat_hash_set<FeatureId> fresh;
    if (judged_) {
      for (const Feature& f : result_.features) {
        const bool is_known = !judged_->blamed.contains(f.id) && IsAsJudged(f) &&
                              (judged_->changed.contains(f.id) || !changed.contains(f.id));
        if (!is_known) fresh.insert(f.id);
      }
    }
    options_.conflicts(
        result_.features, [&](FeatureId id) { return changed.contains(id); },
        [&](FeatureId id) { return judged_ ? fresh.contains(id) : changed.contains(id); },
        [&](FeatureId id) { blamed.insert(id); });
    judged_.emplace();
    for (const Feature& f : result_.features) {
      if (!IsPoint(f)) judged_->rings.emplace(f.id, f.rings);
    }
    judged_->positions = moved_;
    judged_->blamed = blamed;
    judged_->changed = std::move(changed);
    return blamed;
  }

  // Is it the same, at the same place, as in the round before?
  bool IsAsJudged(const Feature& f) const {
    const auto is_at_its_place = [&](FeatureId id) {
      const Corner c = corner_.at(id);
      return moved_[c] == judged_->positions[c];
    };
    if (IsPoint(f)) return is_at_its_place(f.id);
    const auto was = judged_->rings.find(f.id);
    if (was == judged_->rings.end() || was->second != f.rings) return false;
    bool is_same = true;
    ForEachPointOf(f, [&](FeatureId id) { is_same = is_same && is_at_its_place(id); });
    return is_same;
  }

  // Is it to be flat?
  bool IsPatch(std::size_t i) const {
    std::size_t corners = 0;
    for (const CornerRing& ring : out_[i]) corners += ring.size();
    return corners > 3 && !(members_[i].size() == 1 && kept_faces_[members_[i].front()]);
  }

  FeatureId IdOfOutput(std::size_t i) const {
    FeatureId id = ids_[members_[i].front()];
    for (const std::size_t f : members_[i]) id = std::min(id, ids_[f]);
    return id;
  }

  void Count() {
    for (const std::vector<std::size_t>& faces : members_) {
      if (faces.size() < 2) continue;
      result_.joined += faces.size();
      ++result_.polygons;
    }
    for (const Feature& f : result_.features) {
      if (!IsPoint(f)) continue;
      const Corner c = corner_.at(f.id);
      const double distance2 = geometry::SquaredDistance(moved_[c], positions_[c]);
      if (distance2 == 0) continue;
      ++result_.moved;
      result_.most_moved = std::max(result_.most_moved, std::sqrt(distance2));
    }
  }

  std::vector<Feature> features_;
  JoinOptions options_;
  JoinedFaces result_;
  FeatureId last_ = 0, next_id_ = 0;
  std::vector<std::size_t> points_;  // in the order of coordinates
  std::vector<Point3> positions_, moved_;
  std::vector<Vector3> roundings_;
  absl::flat_hash_map<FeatureId, Corner> corner_;
  std::vector<bool> named_before_;
  Kept kept_;
  std::vector<CornerRing> given_;
  std::vector<FeatureId> given_ids_;
  std::vector<bool> is_exact_;     // corners at which no line is within rounding
  std::vector<CornerRing> faces_;  // empty: it is gone
  std::vector<FeatureId> ids_;     // of faces
  std::vector<std::size_t> groups_;
  std::vector<bool> kept_faces_;  // those that stay as they are
  std::vector<bool> is_lone_;     // those that are in one plane with no neighbour
  std::vector<bool> as_given_;    // those that are as without joining, but for motions
  // Of a round: polygons, and their faces; of them those that are to be flat.
  std::vector<FaceRings> out_;
  std::vector<std::vector<std::size_t>> members_;
  std::vector<FaceRings> patches_;
  std::vector<std::size_t> of_patch_;
  // Of the round before.
  struct Judged {
    absl::flat_hash_map<FeatureId, Rings> rings;  // of features but points
    std::vector<Point3> positions;                // by corner
    absl::flat_hash_set<FeatureId> changed, blamed;
  };
  std::optional<Judged> judged_;
  bool is_asked_ = false;  // JoinOptions::accepts
};

// Surely? So it is of most curved surfaces.
bool IsNothingToDo(const std::vector<Feature>& features, const JoinOptions& options) {
  absl::flat_hash_map<FeatureId, Corner> corner;
  std::vector<Point3> positions;
  std::vector<CornerRing> faces;
  for (const Feature& f : features) {
    if (!IsPoint(f)) continue;
    corner.emplace(f.id, static_cast<Corner>(positions.size()));
    positions.push_back({f.position});
  }
  for (const Feature& f : features) {
    if (!Is<APolygon>(f, Not<APoint, ASegment, ASize>)) continue;
    if (f.rings.front().size() > 3) return false;
    CornerRing& ring = faces.emplace_back();
    for (const FeatureId id : f.rings.front()) ring.push_back(corner.at(id));
  }
  if (!options.join) return true;
  std::vector<Vector3> roundings;
  for (const Point3& p : positions) {
    Vector3& rounding = roundings.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) rounding[k] = options.rounding(p.c[k]);
  }
  const std::vector<bool> lone = LoneFaces(positions, roundings, faces);
  return std::find(lone.begin(), lone.end(), false) == lone.end();
}

}  // namespace

JoinedFaces JoinFlat(std::vector<Feature> features, const JoinOptions& options) {
  if (IsNothingToDo(features, options)) {
    JoinedFaces joined;
    joined.features = std::move(features);
    return joined;
  }
  return FlatJoiner(std::move(features), options).Run();
}

}  // namespace dynmesh::coplanar
