// The holes of a surface: closed chains of edges that have one face.
//
// Functions of the faces' coordinates, but for ids. Pure, thread-safe.
#ifndef DYNMESH_CLIENT_PREPARATION_OPEN_LOOPS_H_
#define DYNMESH_CLIENT_PREPARATION_OPEN_LOOPS_H_

#include <cstddef>
#include <vector>

#include "client/cleaning/node_table.h"
#include "dynmesh/feature.h"

namespace dynmesh::preparation {

struct OpenLoop {
  std::vector<FeatureId> corners;  // each once, in order
  double length = 0;               // the sum of its edges'
  cleaning::Point3 middle = {};    // the mean of its corners
};

// Those of the polygons, by ascending length. Where several meet in a corner, each goes through it
// once. Edges that are in no loop, because an edge beside them has three faces, are left out.
// REQUIRES: corners of polygons are points of `features`. Expected O(n lg n) for n corners.
std::vector<OpenLoop> OpenLoopsOf(const std::vector<Feature>& features);

// Loops with more corners are not filled: it takes their third power.
inline constexpr std::size_t kMostCornersFilled = 1000;

// Closes the loops that are not longer than `longest`, by a polygon if their corners are in one
// plane, else by triangles of their corners with the least area. No triangle is one of the faces: a
// loop round a single triangle stays open. New polygons have the ids after the last. Returns how
// many loops. O(n^3) for the n corners of a loop that is not flat.
std::size_t FillLoops(double longest, std::vector<Feature>& features);

}  // namespace dynmesh::preparation

#endif  // DYNMESH_CLIENT_PREPARATION_OPEN_LOOPS_H_
