// Makes polygons of the faces of a surface file that lie in one plane within the rounding of the
// file's numbers, and moves their corners onto the plane.
//
//   * Faces within the rounding of a line go (needles.h).
//   * Faces that share edges and are within kBand roundings of their plane become one polygon
//     (FindRoundedRegions). A corner that all rings go straight through, within two roundings, is
//     dropped.
//   * Corners move, by kMostRoundings at most, until each polygon is as flat as doubles allow
//     (flatten.h). Where that does not do for all planes at a corner, faces stay as they were.
//   * Polygons of four and more corners that are not flat become triangles.
//   * Where what is joined or has moved is in conflict with other features, the faces stay as they
//     were; all of them, if conflicts do not end.
//
// The polygons are a function of the faces and their coordinates, not of the order of faces,
// corners and features, nor of the faces' orientation. Only ids depend on ids. Thread-safe. O(n lg
// n) for n corners, times the rounds in which faces stay: mostly one to three.
#ifndef DYNMESH_CORE_COPLANAR_JOIN_FLAT_H_
#define DYNMESH_CORE_COPLANAR_JOIN_FLAT_H_

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::coplanar {

// Calls found(f) for each of `features` that is looked at and is illegal by itself or in conflict
// with another one. Pairs of which none is new need not be judged: they were before, without a
// conflict, or do not matter.
using Conflicts = std::function<void(
    const std::vector<Feature>& features, const std::function<bool(FeatureId)>& is_looked_at,
    const std::function<bool(FeatureId)>& is_new, const std::function<void(FeatureId)>& found)>;
// True if no features are in conflict.
using Accepts = std::function<bool(const std::vector<Feature>& features)>;

struct JoinOptions {
  // How far a coordinate may be from what was meant.
  std::function<double(double coordinate)> rounding;
  // Faces of different groups are not joined. May be null.
  std::function<std::size_t(FeatureId)> group;
  bool join = true;     // false: only what is not flat is cut
  bool holes = true;    // polygons may have several rings
  Conflicts conflicts;  // what a mesh refuses; may be null
  // Asked first, if there is anything to ask: mostly nothing is in conflict. May be null.
  Accepts accepts;
};

struct JoinedFaces {
  std::vector<Feature> features;
  std::vector<std::pair<FeatureId, FeatureId>> parts;  // new ids, and the faces they were a part of
  std::size_t joined = 0, polygons = 0;                // faces, to so many polygons
  std::size_t needles = 0;                             // faces that went
  std::size_t cut = 0;                                 // faces that became triangles
  std::size_t moved = 0;                               // corners
  double most_moved = 0;                               // the largest distance
  bool is_accepted = false;                            // `accepts` has said so of these features
};

// REQUIRES: each polygon has one ring of three corners or more, all of them points of `features`,
// no two points at one place. Coordinates are in the domain of the predicates.
JoinedFaces JoinFlat(std::vector<Feature> features, const JoinOptions& options);

}  // namespace dynmesh::coplanar

#endif  // DYNMESH_CORE_COPLANAR_JOIN_FLAT_H_
