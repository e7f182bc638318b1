// Features: what a client puts into a mesh, and the edits that change them.
//
// Plain data, no invariants of their own: DynamicMesh::Apply validates a whole
// batch against the features present. Not thread-safe beyond what a value is.
#ifndef DYNMESH_FEATURE_H_
#define DYNMESH_FEATURE_H_

#include <array>
#include <cstdint>
#include <vector>

namespace dynmesh {

// Chosen by the client, at least 1, unique in a mesh over all kinds of feature.
using FeatureId = std::uint64_t;

inline constexpr FeatureId kNoFeature = 0;
// Owns the vertices and segments of the domain box. No client may use it.
inline constexpr FeatureId kBoxFeature = ~FeatureId{0};

enum class FeatureKind : std::uint8_t { kPoint = 1, kSegment = 2 };

struct Feature {
  FeatureId id = kNoFeature;
  FeatureKind kind = FeatureKind::kPoint;
  // kPoint: the coordinates, in the units of the mesh's box; entries past the
  // dimension of the mesh are ignored.
  std::array<double, 3> position = {0, 0, 0};
  // kSegment: the two point features at its ends.
  std::array<FeatureId, 2> ends = {kNoFeature, kNoFeature};

  static Feature Point(FeatureId id, double x, double y, double z = 0) {
    return {id, FeatureKind::kPoint, {x, y, z}, {kNoFeature, kNoFeature}};
  }
  static Feature Segment(FeatureId id, FeatureId p, FeatureId q) {
    return {id, FeatureKind::kSegment, {0, 0, 0}, {p, q}};
  }
  friend bool operator==(const Feature&, const Feature&) = default;
};

// One line of an edit script. Edits of a batch act in order on a draft of the
// feature set; only the result is validated, so a segment may precede its ends.
struct Edit {
  enum class Action : std::uint8_t {
    kAdd = 1,     // a new feature; its id must be free
    kSet = 2,     // replaces the feature with that id (it must exist)
    kRemove = 3,  // only feature.id counts
    kMove = 4,    // a point keeps id and segments; only id and position count
  };
  Action action = Action::kAdd;
  Feature feature;

  static Edit Add(const Feature& f) { return {Action::kAdd, f}; }
  static Edit Set(const Feature& f) { return {Action::kSet, f}; }
  static Edit Remove(FeatureId id) {
    Edit e{Action::kRemove, {}};
    e.feature.id = id;
    return e;
  }
  static Edit Move(FeatureId id, double x, double y, double z = 0) {
    return {Action::kMove, Feature::Point(id, x, y, z)};
  }
  friend bool operator==(const Edit&, const Edit&) = default;
};

using EditBatch = std::vector<Edit>;

}  // namespace dynmesh

#endif  // DYNMESH_FEATURE_H_
