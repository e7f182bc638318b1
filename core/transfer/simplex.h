// A simplex of D dimensions: its measure, its half-spaces, and barycentric coordinates that are
// correct on slivers, too. Pure functions of coordinates, O(1).
#ifndef DYNMESH_CORE_TRANSFER_SIMPLEX_H_
#define DYNMESH_CORE_TRANSFER_SIMPLEX_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

namespace dynmesh::transfer {

template <std::size_t D>
using Vec = std::array<double, D>;

template <std::size_t D>
Vec<D> operator-(const Vec<D>& a, const Vec<D>& b) {
  Vec<D> r;
  for (std::size_t k = 0; k < D; ++k) r[k] = a[k] - b[k];
  return r;
}
template <std::size_t D>
double Dot(const Vec<D>& a, const Vec<D>& b) {
  double sum = a[0] * b[0];
  for (std::size_t k = 1; k < D; ++k) sum += a[k] * b[k];
  return sum;
}
inline Vec<3> Cross(const Vec<3>& a, const Vec<3>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

template <std::size_t D>
using Corners = std::array<Vec<D>, D + 1>;

// D! times the measure, positive where `c` is positively oriented.
inline double ScaledMeasure(const Corners<2>& c) {
  const Vec<2> u = c[1] - c[0], v = c[2] - c[0];
  return u[0] * v[1] - u[1] * v[0];
}
inline double ScaledMeasure(const Corners<3>& c) {
  return Dot(c[1] - c[0], Cross(c[2] - c[0], c[3] - c[0]));
}

// Not negative: a simplex inverted by rounding counts as 0.
template <std::size_t D>
double Measure(const Corners<D>& c) {
  constexpr double kFactorial = D == 2 ? 2 : 6;
  return std::max(0.0, ScaledMeasure(c) / kFactorial);
}

template <std::size_t D>
Vec<D> Centroid(const Corners<D>& corners) {
  Vec<D> sum{};
  for (const Vec<D>& c : corners) {
    for (std::size_t k = 0; k < D; ++k) sum[k] += c[k];
  }
  for (double& x : sum) x /= static_cast<double>(D + 1);
  return sum;
}

// The half-space of a face's plane that contains the simplex: normal . (x - on_plane) >= 0. The
// left side is, up to rounding, D! measure times the barycentric coordinate.
template <std::size_t D>
struct HalfSpace {
  Vec<D> normal;
  Vec<D> on_plane;
  double operator()(const Vec<D>& x) const { return Dot(normal, x - on_plane); }
  // A bound for the rounding error of the value at a position on the plane, if all coordinates of
  // it and the simplex are at most `extent` in magnitude.
  double Noise(double extent) const {
    double sum = 0;
    for (const double n : normal) sum += std::abs(n);
    return 16 * std::numeric_limits<double>::epsilon() * sum * extent;
  }
};

inline std::array<HalfSpace<2>, 3> HalfSpaces(const Corners<2>& c) {
  std::array<HalfSpace<2>, 3> result;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec<2>&a = c[(k + 1) % 3], &b = c[(k + 2) % 3];
    result[k] = {{a[1] - b[1], b[0] - a[0]}, a};
  }
  return result;
}
inline std::array<HalfSpace<3>, 4> HalfSpaces(const Corners<3>& c) {
  // The corners of the face opposite to each corner, such that the cross product points inwards.
  constexpr std::size_t kFaces[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
  std::array<HalfSpace<3>, 4> result;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& [p, q, r] = kFaces[k];
    result[k] = {Cross(c[q] - c[p], c[r] - c[p]), c[p]};
  }
  return result;
}

// Barycentric coordinates by elimination with complete pivoting. It is backward stable: the result
// for x is exact for a position within rounding of x, however thin the simplex is, as long as the
// coordinates are not large. So linear functions are interpolated up to rounding.
template <std::size_t D>
class Barycentric {
 public:
  Barycentric() = default;
  explicit Barycentric(const Corners<D>& c) : origin_(c[0]) {
    for (std::size_t row = 0; row < D; ++row) {
      for (std::size_t column = 0; column < D; ++column) {
        lu_[row][column] = c[column + 1][row] - c[0][row];
      }
      rows_[row] = columns_[row] = row;
    }
    for (std::size_t k = 0; k < D; ++k) Pivot(k);
  }

  // Has the simplex no extent in some direction?
  bool is_flat() const { return flat_; }

  // All 0 except the first if the simplex is flat.
  std::array<double, D + 1> operator()(const Vec<D>& x) const {
    std::array<double, D + 1> lambda = {1};
    if (flat_) return lambda;
    Vec<D> y;
    for (std::size_t i = 0; i < D; ++i) {
      y[i] = x[rows_[i]] - origin_[rows_[i]];
      for (std::size_t j = 0; j < i; ++j) y[i] -= lu_[i][j] * y[j];
    }
    for (std::size_t i = D; i-- > 0;) {
      for (std::size_t j = i + 1; j < D; ++j) y[i] -= lu_[i][j] * y[j];
      y[i] *= inverse_pivots_[i];
    }
    for (std::size_t i = 0; i < D; ++i) {
      lambda[columns_[i] + 1] = y[i];
      lambda[0] -= y[i];
    }
    return lambda;
  }

 private:
  void Pivot(std::size_t k) {
    std::size_t row = k, column = k;
    for (std::size_t i = k; i < D; ++i) {
      for (std::size_t j = k; j < D; ++j) {
        if (std::abs(lu_[i][j]) > std::abs(lu_[row][column])) row = i, column = j;
      }
    }
    std::swap(lu_[k], lu_[row]), std::swap(rows_[k], rows_[row]);
    for (std::size_t i = 0; i < D; ++i) std::swap(lu_[i][k], lu_[i][column]);
    std::swap(columns_[k], columns_[column]);
    if (lu_[k][k] == 0) flat_ = true;
    if (flat_) return;
    inverse_pivots_[k] = 1 / lu_[k][k];
    for (std::size_t i = k + 1; i < D; ++i) {
      lu_[i][k] /= lu_[k][k];
      for (std::size_t j = k + 1; j < D; ++j) lu_[i][j] -= lu_[i][k] * lu_[k][j];
    }
  }

  std::array<Vec<D>, D> lu_;
  Vec<D> inverse_pivots_;
  std::array<std::size_t, D> rows_, columns_;
  Vec<D> origin_;
  bool flat_ = false;
};

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_SIMPLEX_H_
