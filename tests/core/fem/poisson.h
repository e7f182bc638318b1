// Poisson's equation on tetrahedra with linear elements: -Laplace u = f, u given on the border.
//
// The effect of a mesh's shape on this matrix: its entries, its condition number, the errors of its
// solution. Small and simple, for tests; O(tetrahedra) memory, and a sort. Entries are computed
// from gradients; the test compares them with the formula with cotangents of dihedral angles.
#ifndef DYNMESH_TESTS_CORE_FEM_POISSON_H_
#define DYNMESH_TESTS_CORE_FEM_POISSON_H_

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

#include "dynmesh/mesh.h"

namespace dynmesh::test {

using Vector = std::array<double, 3>;

inline Vector operator-(const Vector& a, const Vector& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline double Dot(const Vector& a, const Vector& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vector Cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

using Corners = std::array<Vector, 4>;
using Matrix4 = std::array<std::array<double, 4>, 4>;

// The tetrahedra in use, with their vertices.
struct Domain {
  std::vector<Vector> points;
  std::vector<std::array<std::size_t, 4>> cells;  // positively oriented
  std::vector<char> is_on_border;                 // of each point
  Corners CornersOf(std::size_t cell) const;
};
// The tetrahedra of `mesh` in a region; `is_whole`: all.
Domain DomainOf(const Mesh& mesh, bool is_whole);

double VolumeOf(const Corners& p);
// The gradients of the four hat functions.
std::array<Vector, 4> GradientsOf(const Corners& p);
// The integrals of products of these.
Matrix4 StiffnessOf(const Corners& p);

// Integrates over the tetrahedron; exact for polynomials of degree 5.
double Integrate(const Corners& p, const std::function<double(const Vector&)>& f);

// A solution to compare with.
struct Solution {
  std::function<double(const Vector&)> u, f;  // f = -Laplace u
  std::function<Vector(const Vector&)> gradient;
};

// The matrix of the points that are not on the border, by rows.
class StiffnessMatrix {
 public:
  explicit StiffnessMatrix(const Domain& domain);
  std::size_t size() const { return diagonal_.size(); }
  const std::vector<double>& diagonal() const { return diagonal_; }
  double largest_entry() const { return largest_; }                // off the diagonal, unscaled
  double largest_scaled_entry() const { return largest_scaled_; }  // with the diagonal scaled to 1
  // The row of that point; kNoRow on the border.
  std::size_t row(std::size_t point) const { return rows_[point]; }
  std::vector<double> Times(const std::vector<double>& x) const;
  static constexpr std::size_t kNoRow = ~std::size_t{0};

 private:
  std::vector<std::size_t> rows_, begins_, columns_;
  std::vector<double> entries_, diagonal_;
  double largest_ = 0, largest_scaled_ = 0;
};

// The result of conjugate gradients. The extreme eigenvalues are those of Lanczos's tridiagonal
// matrix, so they lie within the true ones, and near them if the method has converged.
struct Solved {
  std::vector<double> x;
  int iterations = 0;
  bool has_converged = false;
  double least = 0, greatest = 0;  // eigenvalues
  double condition() const { return greatest / least; }
};
// Solves matrix * x = b until the residual is `tolerance` times the first. `is_scaled`:
// preconditioned by the diagonal; eigenvalues are then those of the matrix scaled by it from both
// sides.
Solved ConjugateGradients(const StiffnessMatrix& matrix, const std::vector<double>& b,
                          bool is_scaled, double tolerance, int most_iterations);

struct Errors {
  double l2 = 0, h1 = 0;  // of u, of its gradient, both in L2
};
// Solves with u on the border; `solved` gets the statistics for the scaled matrix.
Errors SolvePoisson(const Domain& domain, const StiffnessMatrix& matrix, const Solution& solution,
                    Solved* solved);

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_CORE_FEM_POISSON_H_
