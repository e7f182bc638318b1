// Checks of a quadtree's leaves as a file has them, independent of the program that made them: only
// core/io and the local feature size of dynmesh/quality.h are shared with it.
//
// Checks, by name:
//   cells    root side = side 2^level, the same for all; each leaf is a cell of the root's grid
//   cover    leaves cover the root once, without gap or overlap
//   balance  leaves that touch, if only in a corner, differ in side by a factor of 2 at most
//   lfs      (if the input is given) side / 4 <= lfs <= 4.5 sqrt(dimension) side at centres and
//            input points; the upper bound where lfs is below the root's side
#ifndef DYNMESH_CLIENT_VERIFY_VERIFY_QUADTREE_H_
#define DYNMESH_CLIENT_VERIFY_VERIFY_QUADTREE_H_

#include <cstdint>
#include <map>
#include <vector>

#include "client/verify/verify.h"
#include "core/io/quadtrees/leaf_list.h"
#include "dynmesh/feature.h"

namespace dynmesh::cli {

struct QuadtreeReport {
  std::vector<VerifyCheck> checks;  // in the order above
  int dimension = 2;
  std::uint64_t leaves = 0;
  double root_side = 0;
  std::map<int, std::uint64_t> leaves_of_level;
  // lfs / side at centres, where lfs is finite; NaN without such.
  double least_ratio = 0, greatest_ratio = 0;
  MeshHash hash;

  bool Passed() const;
};

// `features`: the input; null: unknown. Expected O(n 3^dimension) without it.
QuadtreeReport VerifyQuadtree(const io::LeafList& list, const std::vector<Feature>* features);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_VERIFY_VERIFY_QUADTREE_H_
