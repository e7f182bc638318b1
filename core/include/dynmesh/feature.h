// Features: what a client puts into a mesh, and the edits that change them.
//
//   dynmesh::EditBatch batch = {dynmesh::Edit::Add(dynmesh::Feature::Point(1, 0.2, 0.5)),
//                               dynmesh::Edit::Add(dynmesh::Feature::Point(2, 0.8, 0.5)),
//                               dynmesh::Edit::Add(dynmesh::Feature::Segment(3, 1, 2))};
//
// Plain data without invariants: DynamicMesh::Apply validates a whole batch against the features
// present. Values; thread-compatible.
#ifndef DYNMESH_FEATURE_H_
#define DYNMESH_FEATURE_H_

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "dynmesh/label.h"

namespace dynmesh {

// Chosen by the client, unique in a mesh over all kinds of features. 1 to kLastFeatureId; of a
// polygon (FeatureKind::kPolygon) 1 to kLastPolygonId.
using FeatureId = std::uint64_t;

inline constexpr FeatureId kNoFeature = 0;  // the id of no feature
// The owner of the vertices and segments of the domain box. Clients cannot use it.
inline constexpr FeatureId kBoxFeature = ~FeatureId{0};
// 2^64 - 65537. Greater ids are reserved.
inline constexpr FeatureId kLastFeatureId = kBoxFeature - (FeatureId{1} << 16);
// 2^63 - 1. Region ids from 2^63 up are those of sets of polygons (mesh.h, RegionId).
inline constexpr FeatureId kLastPolygonId = ~FeatureId{0} >> 1;

// The kind of a feature.
enum class FeatureKind : std::uint8_t { kPoint = 1, kSegment = 2, kPolygon = 3, kSize = 4 };

// Closed chains of point features, by their ids. The last point of each ring is joined to its
// first. A position is inside iff an odd number of rings encloses it. So rings describe holes,
// islands in holes, and several parts side by side.
using Rings = std::vector<std::vector<FeatureId>>;

// The vertices of a polyline, as positions: they need not be point features. 2 to
// kMostPathVertices, no two equal ones one after the other. Edges may cross and overlap, and the
// last vertex may be the first.
using Path = std::vector<std::array<double, 3>>;
inline constexpr std::size_t kMostPathVertices = 65536;  // the most vertices of a Path

// The shape of a region with a target length; in 3D a disc is a ball. A capsule is all that is
// within a radius of a polyline.
enum class SizeShape : std::uint8_t {
  kPoint = 1,
  kDisc = 2,
  kBox = 3,
  kPolygon = 4,
  kCapsule = 5,
};
// Where the mesh must be finer than its geometry needs. No edge of a simplex that meets the region
// is longer than sqrt(2) times the target, as far as limits allow. Around the region sizes grow as
// fast as the quality bound lets them.
struct Sizing {
  SizeShape shape = SizeShape::kPoint;   // of the region
  double target = 0;                     // > 0, in the units of the mesh's box
  double radius = 0;                     // kDisc, kCapsule: >= 0
  std::array<double, 3> hi = {0, 0, 0};  // kBox: the upper corner
  Path path = {};                        // kCapsule: its vertices lie in the mesh's box
  friend bool operator==(const Sizing&, const Sizing&) = default;
};

// One feature. `kind` determines which members are used; the functions below make each kind.
struct Feature {
  FeatureId id = kNoFeature;               // unique in the mesh
  FeatureKind kind = FeatureKind::kPoint;  // which of the members below are used
  // kPoint: the coordinates, in the units of the mesh's box; those past the dimension are ignored.
  // kSize: the point, the disc's centre or the box's lower corner; not used by a sizing polygon or
  // a capsule. A point or centre must lie in the mesh's box. A disc or a capsule may extend beyond
  // it; a box must meet it.
  std::array<double, 3> position = {0, 0, 0};
  // kSegment: the two point features at its ends.
  std::array<FeatureId, 2> ends = {kNoFeature, kNoFeature};
  Sizing sizing = {};  // kSize
  // kPolygon: the rings. Edges become segments, shared with segment features and polygons with the
  // same ends. In 2D the simplices inside are labelled, in 3D those inside a closed surface of
  // polygons (mesh.h, RegionId). kSize: the region of a sizing polygon; its edges are not in the
  // mesh.
  Rings rings = {};
  // The client's marker and name, if any; any kind. The mesh does not depend on it. An edit may
  // carry it: Edit says what a missing one means.
  OptionalLabel label = {};
  // kSegment, kPolygon: in 2D the mesh puts no vertex on it: a segment stays one edge, a polygon's
  // edges stay edges. A point in which another triangle would get a vertex is left out if it lies
  // in the circle with such an edge as diameter: the triangle may then stay worse than the mesh's
  // quality (quality.h, SimplexVerdict::kUnsplit). What would have to lie there is refused
  // (error.h, ENCROACHED):
  // a point in the circle, or one on it on either side; a segment that meets the circle, or leaves
  // an end of the edge at less than 90 degrees, unless that segment is unsplit, too.
  // An edge of several features is unsplit if one of them is. Not in 3D, in quadtrees, or with
  // Criterion::kThesis.
  bool unsplit = false;

  // The same feature, unsplit.
  Feature Unsplit() const {
    Feature f = *this;
    f.unsplit = true;
    return f;
  }

  // A point `id` at (`x`, `y`), in 3D at (`x`, `y`, `z`).
  static Feature Point(FeatureId id, double x, double y, double z = 0) {
    return {id, FeatureKind::kPoint, {x, y, z}, {kNoFeature, kNoFeature}, {}, {}};
  }
  // A segment `id` between the point features `p` and `q`.
  static Feature Segment(FeatureId id, FeatureId p, FeatureId q) {
    return {id, FeatureKind::kSegment, {0, 0, 0}, {p, q}, {}, {}};
  }
  // A polygon `id` of `rings` of point features; in 3D they lie in one plane.
  static Feature Polygon(FeatureId id, Rings rings) {
    return {id, FeatureKind::kPolygon, {0, 0, 0}, {kNoFeature, kNoFeature}, {}, std::move(rings)};
  }
  // A sizing feature `id`: edges at (`x`, `y`) get at most the `target` length (Sizing).
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
  // A sizing feature `id` with a `target` for the inside of `rings`. 2D only.
  static Feature SizePolygon(FeatureId id, Rings rings, double target) {
    Feature size = Size(id, {0, 0, 0}, {SizeShape::kPolygon, target, 0, {}});
    size.rings = std::move(rings);
    return size;
  }
  // A sizing feature `id` with a `target` for all within `radius` of the polyline through the
  // vertices of `path`, 0 or more. In 2D and 3D. A mesh takes time O(n log n) in them, once.
  static Feature SizeCapsule(FeatureId id, Path path, double radius, double target) {
    return Size(id, {0, 0, 0}, {SizeShape::kCapsule, target, radius, {}, std::move(path)});
  }
  // A sizing feature `id` of any shape: `sizing`, at `position` as in Feature::position. For 3D,
  // where positions have a z.
  static Feature Size(FeatureId id, const std::array<double, 3>& position, const Sizing& sizing) {
    return {id, FeatureKind::kSize, position, {kNoFeature, kNoFeature}, sizing, {}};
  }
  friend bool operator==(const Feature&, const Feature&) = default;
};

// One edit. The edits of a batch act in order on a draft of the feature set. Only the result is
// validated: a segment may come before its ends.
struct Edit {
  // What is done with the feature.
  enum class Action : std::uint8_t {
    kAdd = 1,       // adds a feature, with its label if it has one; its id must be free
    kSet = 2,       // replaces the present feature with that id; keeps its label without a new one
    kRemove = 3,    // also removes the label; uses feature.id only
    kMove = 4,      // moves a point with its segments, keeps its label; uses id and position only
    kSetLabel = 5,  // replaces the label of the present feature; uses id and label only
  };
  Action action = Action::kAdd;  // what is done
  Feature feature;               // the new feature; of kRemove the id only

  // Adds `f`.
  static Edit Add(const Feature& f) { return {Action::kAdd, f}; }
  // Replaces the feature that has the id of `f` by `f`.
  static Edit Set(const Feature& f) { return {Action::kSet, f}; }
  // Removes the feature `id`.
  static Edit Remove(FeatureId id) {
    Edit e{Action::kRemove, {}};
    e.feature.id = id;
    return e;
  }
  // Moves the point `id` to (`x`, `y`), in 3D to (`x`, `y`, `z`).
  static Edit Move(FeatureId id, double x, double y, double z = 0) {
    return {Action::kMove, Feature::Point(id, x, y, z)};
  }
  // Gives the feature `id` this `label`, and no other; an empty one leaves it without. The mesh
  // stays as it is: the diff of such a batch has labels only.
  static Edit SetLabel(FeatureId id, FeatureLabel label) {
    Edit e{Action::kSetLabel, {}};
    e.feature.id = id;
    e.feature.label = std::move(label);
    return e;
  }
  friend bool operator==(const Edit&, const Edit&) = default;
};

// Edits that make one revision, all or none.
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
