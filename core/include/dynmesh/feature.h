// Features: what a client puts into a mesh, and the edits that change them.
//
// Plain data, no invariants of their own: DynamicMesh::Apply validates a whole
// batch against the features present. Not thread-safe beyond what a value is.
#ifndef DYNMESH_FEATURE_H_
#define DYNMESH_FEATURE_H_

#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace dynmesh {

// Chosen by the client, unique in a mesh over all kinds of feature: 1 to kLastFeatureId, of a
// polygon (FeatureKind::kPolygon) 1 to kLastPolygonId.
using FeatureId = std::uint64_t;

inline constexpr FeatureId kNoFeature = 0;  // the id of no feature
// Owns the vertices and segments of the domain box. No client may use it.
inline constexpr FeatureId kBoxFeature = ~FeatureId{0};
// Greater ids are reserved: 2^64 - 65536 and up.
inline constexpr FeatureId kLastFeatureId = kBoxFeature - (FeatureId{1} << 16);
// 2^63 - 1: from 2^63 up a region's id is that of a set of polygons (mesh.h, RegionId).
inline constexpr FeatureId kLastPolygonId = ~FeatureId{0} >> 1;

// What a feature is.
enum class FeatureKind : std::uint8_t { kPoint = 1, kSegment = 2, kPolygon = 3, kSize = 4 };

// Closed chains of point features, by their ids: each ring's last point is joined to its
// first. A place is inside what an odd number of the rings goes around: one ring and holes
// in it, islands in the holes, or several parts side by side.
using Rings = std::vector<std::vector<FeatureId>>;

// What a region with a target length looks like; in space a disc is a ball.
enum class SizeShape : std::uint8_t { kPoint = 1, kDisc = 2, kBox = 3, kPolygon = 4 };
// Where the mesh is to be finer than its geometry asks, and how fine. No edge of a simplex
// that meets the region is longer than sqrt(2) times the target (as far as limits allow);
// around it sizes grow as fast as the quality asked for lets them, and no faster.
struct Sizing {
  SizeShape shape = SizeShape::kPoint;   // of the region
  double target = 0;                     // > 0, in the units of the mesh's box
  double radius = 0;                     // kDisc, >= 0
  std::array<double, 3> hi = {0, 0, 0};  // kBox: the upper corner
  friend bool operator==(const Sizing&, const Sizing&) = default;
};

// One feature. Which members count depends on `kind`; functions below make each kind.
struct Feature {
  FeatureId id = kNoFeature;               // unique in the mesh
  FeatureKind kind = FeatureKind::kPoint;  // which of the members below count
  // kPoint: the coordinates, in the units of the mesh's box; entries past the
  // dimension of the mesh are ignored. kSize: the point, the disc's centre or the box's
  // lower corner; the region may poke out of the mesh's box, this place may not. Not of a
  // sizing polygon.
  std::array<double, 3> position = {0, 0, 0};
  // kSegment: the two point features at its ends.
  std::array<FeatureId, 2> ends = {kNoFeature, kNoFeature};
  Sizing sizing = {};  // kSize
  // kPolygon: its edges become segments, shared with segment features and other polygons
  // that have the same ends; what lies inside is labelled, in space what lies inside of
  // polygons that close (mesh.h, RegionId). Sizing polygon: only where it is; its edges are
  // not kept.
  Rings rings = {};

  // A point `id` at (`x`, `y`), in space at (`x`, `y`, `z`).
  static Feature Point(FeatureId id, double x, double y, double z = 0) {
    return {id, FeatureKind::kPoint, {x, y, z}, {kNoFeature, kNoFeature}, {}, {}};
  }
  // A segment `id` between the point features `p` and `q`.
  static Feature Segment(FeatureId id, FeatureId p, FeatureId q) {
    return {id, FeatureKind::kSegment, {0, 0, 0}, {p, q}, {}, {}};
  }
  // A polygon `id` of `rings` of point features; in space they lie in one plane.
  static Feature Polygon(FeatureId id, Rings rings) {
    return {id, FeatureKind::kPolygon, {0, 0, 0}, {kNoFeature, kNoFeature}, {}, std::move(rings)};
  }
  // A sizing feature `id`: no longer edges than the `target` at the place (`x`, `y`).
  static Feature SizeAt(FeatureId id, double x, double y, double target) {
    return Size(id, {x, y, 0}, {SizeShape::kPoint, target, 0, {}});
  }
  // A sizing feature `id` with a `target` for the disc of `radius` around (`x`, `y`).
  static Feature SizeDisc(FeatureId id, double x, double y, double radius, double target) {
    return Size(id, {x, y, 0}, {SizeShape::kDisc, target, radius, {}});
  }
  // A sizing feature `id` with a `target` for the box from (`x0`, `y0`) to (`x1`, `y1`).
  static Feature SizeBox(FeatureId id, double x0, double y0, double x1, double y1, double target) {
    return Size(id, {x0, y0, 0}, {SizeShape::kBox, target, 0, {x1, y1, 0}});
  }
  // A sizing feature `id` with a `target` for the inside of `rings`, in the plane only.
  static Feature SizePolygon(FeatureId id, Rings rings, double target) {
    Feature size = Size(id, {0, 0, 0}, {SizeShape::kPolygon, target, 0, {}});
    size.rings = std::move(rings);
    return size;
  }
  // A sizing feature `id` of any shape: `sizing`, at `position` as `Feature::position` says. For
  // meshes of space, whose places have a z.
  static Feature Size(FeatureId id, const std::array<double, 3>& position, const Sizing& sizing) {
    return {id, FeatureKind::kSize, position, {kNoFeature, kNoFeature}, sizing, {}};
  }
  friend bool operator==(const Feature&, const Feature&) = default;
};

// One line of an edit script. Edits of a batch act in order on a draft of the
// feature set; only the result is validated, so a segment may precede its ends.
struct Edit {
  // What is done with the feature.
  enum class Action : std::uint8_t {
    kAdd = 1,     // a new feature; its id must be free
    kSet = 2,     // replaces the feature with that id (it must exist)
    kRemove = 3,  // only feature.id counts
    kMove = 4,    // a point keeps id and segments; only id and position count
  };
  Action action = Action::kAdd;  // what is done
  Feature feature;               // with what; of kRemove the id only

  // Adds `f`.
  static Edit Add(const Feature& f) { return {Action::kAdd, f}; }
  // Puts `f` in the place of the feature that has its id.
  static Edit Set(const Feature& f) { return {Action::kSet, f}; }
  // Removes the feature `id`.
  static Edit Remove(FeatureId id) {
    Edit e{Action::kRemove, {}};
    e.feature.id = id;
    return e;
  }
  // Moves the point `id` to (`x`, `y`), in space to (`x`, `y`, `z`).
  static Edit Move(FeatureId id, double x, double y, double z = 0) {
    return {Action::kMove, Feature::Point(id, x, y, z)};
  }
  friend bool operator==(const Edit&, const Edit&) = default;
};

// Edits that become one revision, all or none.
using EditBatch = std::vector<Edit>;

// A batch that adds `features`. O(features).
inline EditBatch AddAll(std::span<const Feature> features) {
  EditBatch batch;
  batch.reserve(features.size());
  for (const Feature& f : features) batch.push_back(Edit::Add(f));
  return batch;
}

}  // namespace dynmesh

#endif  // DYNMESH_FEATURE_H_
