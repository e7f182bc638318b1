// Consequences of a lower bound of dihedral angles and of sizes for the matrix of linear elements
// for Poisson's equation, whatever the rest of the mesh.
//
//   w       minus the entry of an element's matrix for two corners: |ij| cot(the angle at ij) / 6,
//           where ij is the edge opposite to that of the two
//   cot     that of the bound on angles; L  a tetrahedron's longest edge
//   V_k     the volume of the tetrahedra at vertex k
//   mu      pi^2 (1 / a^2 + 1 / b^2 + 1 / c^2), the least eigenvalue of -Laplace in the box
//           that the domain takes, so no more than in the domain
//
// 1. w <= |ij| cot / 6. An element's entry on the diagonal is the sum of three w, so <= L cot / 2,
//    and that bounds the others, too: the matrix is semidefinite.
// 2. An element's greatest eigenvalue is <= its trace, twice the sum of six w, <= 2 L cot. So that
//    of the matrix is <= the sum of 2 L cot over the tetrahedra of a vertex, where it is greatest.
// 3. An element's mass matrix is >= volume / 20, so u'Mu >= sum of u_k^2 V_k / 20, and
//    u'Ku >= mu u'Mu: the least eigenvalue is >= mu / 20 times the least V_k.
// 4. Scaled by its diagonal D the matrix has no eigenvalue > 4, whatever the angles: that is an
//    element's bound. By 3 none is < mu / 20 times the least V_k / D_k; by 1 D_k <= the sum of
//    L cot / 2 over the tetrahedra at k.
#ifndef DYNMESH_TESTS_CORE_FEM_MATRIX_BOUNDS_H_
#define DYNMESH_TESTS_CORE_FEM_MATRIX_BOUNDS_H_

#include <utility>

#include "tests/core/fem/poisson.h"

namespace dynmesh::test {

double CotangentOf(double degrees);

// The sums over the tetrahedra, and the resulting bounds (1 to 4).
struct Shape {
  double least_angle = 180, greatest_angle = 0;  // dihedral, degrees
  int slivers = 0;                               // tetrahedra with an angle below the bound
  int flat = 0;                                  // without a volume: there is no matrix
  double worst_cotangent = 0;                    // the greatest w / (|ij| / 6)
  double worst_entry = 0;                        // the greatest |entry| / (L / 2)
  double worst_difference = 0;  // between w and its formula, in units of the greatest entry
  double greatest_bound = 0;    // of the greatest eigenvalue
  double least_bound = 0;       // of the least
  double scaled_bound = 0;      // of the scaled matrix's condition
};
// `bound` in degrees.
Shape ShapeOf(const Domain& domain, double bound);

// The lower and the upper corner of the domain's bounding box.
std::pair<Vector, Vector> BoxOf(const Domain& domain);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CORE_FEM_MATRIX_BOUNDS_H_
