// Linear least squares in D unknowns. Pure functions.
#ifndef DYNMESH_CORE_TRANSFER_LEAST_SQUARES_H_
#define DYNMESH_CORE_TRANSFER_LEAST_SQUARES_H_

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "core/transfer/simplex.h"

namespace dynmesh::transfer {

inline constexpr std::size_t kMostRows = 96;

template <std::size_t D>
struct LinearFit {
  Vec<D> solution{};
  // The least pivot relative to the greatest: 0 if the rows leave a direction undetermined.
  double strength = 0;
};

// The least-squares solution of rows . g = right sides, by Householder reflections with column
// pivoting. Undetermined directions get 0. Overwrites both. O(n).
template <std::size_t D>
LinearFit<D> LeastSquares(std::span<Vec<D>> rows, std::span<double> right) {
  LinearFit<D> fit;
  Vec<D>& g = fit.solution;
  std::array<std::size_t, D> columns;
  for (std::size_t k = 0; k < D; ++k) columns[k] = k;
  const std::size_t n = rows.size();
  std::size_t rank = 0;
  double first = 0;
  for (; rank < std::min(n, D); ++rank) {
    const auto norm2 = [&](std::size_t c) {
      double sum = 0;
      for (std::size_t i = rank; i < n; ++i) sum += rows[i][c] * rows[i][c];
      return sum;
    };
    std::size_t best = rank;
    for (std::size_t c = rank + 1; c < D; ++c) {
      if (norm2(columns[c]) > norm2(columns[best])) best = c;
    }
    std::swap(columns[rank], columns[best]);
    const std::size_t c = columns[rank];
    const double norm = std::sqrt(norm2(c));
    if (rank == 0) first = norm;
    fit.strength = rank + 1 < D || first == 0 ? 0 : norm / first;
    if (norm <= 1e-13 * first || norm == 0) break;
    // Reflects the column to (-sign norm, 0, ...).
    const double alpha = rows[rank][c] > 0 ? -norm : norm;
    std::array<double, kMostRows> v{};
    for (std::size_t i = rank; i < n; ++i) v[i - rank] = rows[i][c];
    v[0] -= alpha;
    double v2 = 0;
    for (std::size_t i = rank; i < n; ++i) v2 += v[i - rank] * v[i - rank];
    const auto reflect = [&](auto&& at) {
      double dot = 0;
      for (std::size_t i = rank; i < n; ++i) dot += v[i - rank] * at(i);
      const double scale = 2 * dot / v2;
      for (std::size_t i = rank; i < n; ++i) at(i) -= scale * v[i - rank];
    };
    for (std::size_t other = rank; other < D; ++other) {
      reflect([&](std::size_t i) -> double& { return rows[i][columns[other]]; });
    }
    reflect([&](std::size_t i) -> double& { return right[i]; });
    rows[rank][c] = alpha;
  }
  for (std::size_t k = rank; k-- > 0;) {
    double sum = right[k];
    for (std::size_t j = k + 1; j < rank; ++j) sum -= rows[k][columns[j]] * g[columns[j]];
    g[columns[k]] = sum / rows[k][columns[k]];
  }
  return fit;
}

}  // namespace dynmesh::transfer

#endif  // DYNMESH_CORE_TRANSFER_LEAST_SQUARES_H_
