// The best triangulation of a closed chain of nodes in 3D, without further nodes. The chain need
// not be flat.
//
// A function of the chain's coordinates and numbering: of equally good triangulations the first one
// is taken. Pure, thread-safe. O(n^3) for n nodes (G. Klincsek, Minimal triangulations of polygonal
// domains, 1980).
#ifndef DYNMESH_CLIENT_CLEANING_HOLE_TRIANGULATION_H_
#define DYNMESH_CLIENT_CLEANING_HOLE_TRIANGULATION_H_

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "client/cleaning/node_table.h"
#include "client/cleaning/patch_distance.h"

namespace dynmesh::cleaning {

// The cotangent of the triangle's least angle; infinite without area.
double LargestCotangent(const TriangleCorners& triangle);

// That of its largest angle.
double LeastCotangent(const TriangleCorners& triangle);

// Of its circumscribed circle; infinite without area.
double SquaredCircumradius(const TriangleCorners& triangle);

// Its height over the longest edge.
double HeightOf(const TriangleCorners& triangle);

// The best triangulation has the largest least angle, or the least area. A chain that bounds a part
// of a surface is folded less by the latter.
enum class HoleMeasure { kLeastAngle, kArea };

// Indices into `chain`, each triple ascending: so all are oriented as the chain. None is one of
// `forbidden`, triples of that kind; empty if there is none without these. REQUIRES: at least three
// nodes.
std::vector<std::array<std::size_t, 3>> TriangulateHole(
    std::span<const Point3> chain, HoleMeasure measure = HoleMeasure::kLeastAngle,
    std::span<const std::array<std::size_t, 3>> forbidden = {});

}  // namespace dynmesh::cleaning

#endif  // DYNMESH_CLIENT_CLEANING_HOLE_TRIANGULATION_H_
