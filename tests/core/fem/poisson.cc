#include "tests/core/fem/poisson.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <utility>

namespace dynmesh::test {
namespace {

// The corners of the face that lies opposite to each corner.
constexpr std::array<std::array<std::size_t, 3>, 4> kFaces = {
    {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};

// A rule of Grundmann and Moeller: places in barycentric coordinates, weights that sum up to 1.
struct Rule {
  std::vector<std::array<double, 4>> places;
  std::vector<double> weights;
};

Rule MakeRule() {
  constexpr int kS = 2, kD = 2 * kS + 1, kN = 3;  // exact for degree kD, in kN dimensions
  Rule rule;
  for (int i = 0; i <= kS; ++i) {
    const double base = kD + kN - 2 * i;
    const double sign = i % 2 == 0 ? 1 : -1;
    const double weight = sign * std::pow(2, -2 * kS) * std::pow(base, kD) * std::tgamma(kN + 1) /
                          (std::tgamma(i + 1) * std::tgamma(kD + kN - i + 1));
    const int sum = kS - i;
    for (int a = 0; a <= sum; ++a) {
      for (int b = 0; a + b <= sum; ++b) {
        for (int c = 0; a + b + c <= sum; ++c) {
          const int d = sum - a - b - c;
          rule.places.push_back(
              {(2 * a + 1) / base, (2 * b + 1) / base, (2 * c + 1) / base, (2 * d + 1) / base});
          rule.weights.push_back(weight);
        }
      }
    }
  }
  return rule;
}

Vector PlaceOf(const Corners& p, const std::array<double, 4>& barycentric) {
  Vector x = {};
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t i = 0; i < 3; ++i) x[i] += barycentric[k] * p[k][i];
  }
  return x;
}

// The integral of f(x, barycentric).
template <class F>
double Sum(const Corners& p, F f) {
  static const Rule rule = MakeRule();
  double sum = 0;
  for (std::size_t i = 0; i < rule.places.size(); ++i) {
    sum += rule.weights[i] * f(PlaceOf(p, rule.places[i]), rule.places[i]);
  }
  return VolumeOf(p) * sum;
}

double Product(const std::vector<double>& x, const std::vector<double>& y) {
  double sum = 0;
  for (std::size_t i = 0; i < x.size(); ++i) sum += x[i] * y[i];
  return sum;
}

// The number of eigenvalues of the tridiagonal matrix below x, by Sylvester's law of inertia.
int CountBelow(const std::vector<double>& diagonal, const std::vector<double>& off2, double x) {
  int count = 0;
  double pivot = 1;
  for (std::size_t i = 0; i < diagonal.size(); ++i) {
    pivot = diagonal[i] - x - (i == 0 ? 0 : off2[i - 1] / pivot);
    if (pivot == 0) pivot = -1e-300;
    count += pivot < 0;
  }
  return count;
}

// The greatest x with at most that many eigenvalues below it, by bisection from 0 on.
double Eigenvalue(const std::vector<double>& diagonal, const std::vector<double>& off2, int below) {
  double lo = 0, hi = 1;
  while (CountBelow(diagonal, off2, hi) <= below && std::isfinite(hi)) hi *= 2;
  for (int i = 0; i < 100; ++i) {
    // The least one may be many orders of magnitude below the greatest.
    const double middle = lo > 0 ? std::sqrt(lo * hi) : hi / 1024;
    (CountBelow(diagonal, off2, middle) <= below ? lo : hi) = middle;
    if (lo == 0 && hi < 1e-280) break;
  }
  return lo;
}

}  // namespace

Corners Domain::CornersOf(std::size_t cell) const {
  const auto& v = cells[cell];
  return {points[v[0]], points[v[1]], points[v[2]], points[v[3]]};
}

Domain DomainOf(const Mesh& mesh, bool is_whole) {
  std::unordered_map<VertexId, std::size_t> rows, used;
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) rows[mesh.vertices.ids[i]] = i;
  Domain domain;
  std::map<std::array<std::size_t, 3>, int> faces;
  for (std::size_t cell = 0; cell < mesh.simplex_count(); ++cell) {
    if (!is_whole && mesh.region(cell) == kNoRegion) continue;
    auto& corners = domain.cells.emplace_back();
    for (std::size_t k = 0; k < 4; ++k) {
      const VertexId id = mesh.simplices[4 * cell + k];
      const auto [place, is_new] = used.try_emplace(id, domain.points.size());
      if (is_new) {
        const double* p = &mesh.vertices.coordinates[3 * rows.at(id)];
        domain.points.push_back({p[0], p[1], p[2]});
      }
      corners[k] = place->second;
    }
    for (const auto& [a, b, c] : kFaces) {
      std::array<std::size_t, 3> face = {corners[a], corners[b], corners[c]};
      std::sort(face.begin(), face.end());
      ++faces[face];
    }
  }
  domain.is_on_border.assign(domain.points.size(), 0);
  for (const auto& [face, count] : faces) {
    if (count > 1) continue;
    for (const std::size_t v : face) domain.is_on_border[v] = 1;
  }
  return domain;
}

double VolumeOf(const Corners& p) { return Dot(p[1] - p[0], Cross(p[2] - p[0], p[3] - p[0])) / 6; }

std::array<Vector, 4> GradientsOf(const Corners& p) {
  const double scale = 6 * VolumeOf(p);
  std::array<Vector, 4> gradients;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& [a, b, c] = kFaces[k];
    const Vector normal = Cross(p[c] - p[a], p[b] - p[a]);  // inwards
    for (std::size_t i = 0; i < 3; ++i) gradients[k][i] = normal[i] / scale;
  }
  return gradients;
}

Matrix4 StiffnessOf(const Corners& p) {
  const double volume = VolumeOf(p);
  const std::array<Vector, 4> gradients = GradientsOf(p);
  Matrix4 matrix;
  for (std::size_t k = 0; k < 4; ++k) {
    for (std::size_t l = 0; l < 4; ++l) matrix[k][l] = volume * Dot(gradients[k], gradients[l]);
  }
  return matrix;
}

double Integrate(const Corners& p, const std::function<double(const Vector&)>& f) {
  return Sum(p, [&](const Vector& x, const auto&) { return f(x); });
}

StiffnessMatrix::StiffnessMatrix(const Domain& domain) {
  rows_.assign(domain.points.size(), kNoRow);
  std::size_t count = 0;
  for (std::size_t v = 0; v < rows_.size(); ++v) {
    if (domain.is_on_border[v] == 0) rows_[v] = count++;
  }
  struct Entry {
    std::size_t row, column;
    double value;
  };
  std::vector<Entry> parts;
  for (std::size_t cell = 0; cell < domain.cells.size(); ++cell) {
    const Matrix4 element = StiffnessOf(domain.CornersOf(cell));
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t l = 0; l < 4; ++l) {
        const std::size_t row = rows_[domain.cells[cell][k]], column = rows_[domain.cells[cell][l]];
        if (row != kNoRow && column != kNoRow) parts.push_back({row, column, element[k][l]});
      }
    }
  }
  std::stable_sort(parts.begin(), parts.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.row, a.column) < std::pair(b.row, b.column);
  });
  begins_.assign(count + 1, 0);
  diagonal_.assign(count, 0);
  for (std::size_t i = 0; i < parts.size();) {
    const auto [row, column, first] = parts[i];
    double sum = 0;
    for (; i < parts.size() && parts[i].row == row && parts[i].column == column; ++i) {
      sum += parts[i].value;
    }
    columns_.push_back(column);
    entries_.push_back(sum);
    begins_[row + 1] = columns_.size();
    if (row == column) diagonal_[row] = sum;
  }
  for (std::size_t row = 0; row < count; ++row) {
    for (std::size_t i = begins_[row]; i < begins_[row + 1]; ++i) {
      if (columns_[i] == row) continue;
      const double size = std::fabs(entries_[i]);
      largest_ = std::max(largest_, size);
      largest_scaled_ =
          std::max(largest_scaled_, size / std::sqrt(diagonal_[row] * diagonal_[columns_[i]]));
    }
  }
}

std::vector<double> StiffnessMatrix::Times(const std::vector<double>& x) const {
  std::vector<double> y(x.size(), 0);
  for (std::size_t row = 0; row < y.size(); ++row) {
    for (std::size_t i = begins_[row]; i < begins_[row + 1]; ++i) {
      y[row] += entries_[i] * x[columns_[i]];
    }
  }
  return y;
}

Solved ConjugateGradients(const StiffnessMatrix& matrix, const std::vector<double>& b,
                          bool is_scaled, double tolerance, int most_iterations) {
  const std::size_t n = matrix.size();
  Solved solved;
  solved.x.assign(n, 0);
  const auto precondition = [&](const std::vector<double>& r) {
    std::vector<double> z = r;
    if (is_scaled) {
      for (std::size_t i = 0; i < n; ++i) z[i] /= matrix.diagonal()[i];
    }
    return z;
  };
  std::vector<double> r = b, z = precondition(r), p = z;
  double rz = Product(r, z);
  const double aim = tolerance * tolerance * rz;
  std::vector<double> diagonal, off2;  // Lanczos's matrix, of the steps' lengths
  double alpha = 0, beta = 0;
  while (rz > aim && solved.iterations < most_iterations) {
    const std::vector<double> q = matrix.Times(p);
    const double before = alpha;
    alpha = rz / Product(p, q);
    diagonal.push_back(1 / alpha + (diagonal.empty() ? 0 : beta / before));
    for (std::size_t i = 0; i < n; ++i) solved.x[i] += alpha * p[i], r[i] -= alpha * q[i];
    z = precondition(r);
    const double next = Product(r, z);
    beta = next / rz;
    off2.push_back(beta / (alpha * alpha));
    for (std::size_t i = 0; i < n; ++i) p[i] = z[i] + beta * p[i];
    rz = next;
    ++solved.iterations;
  }
  solved.has_converged = rz <= aim;
  if (!diagonal.empty()) {
    solved.least = Eigenvalue(diagonal, off2, 0);
    solved.greatest = Eigenvalue(diagonal, off2, static_cast<int>(diagonal.size()) - 1);
  }
  return solved;
}

Errors SolvePoisson(const Domain& domain, const StiffnessMatrix& matrix, const Solution& solution,
                    Solved* solved) {
  std::vector<double> b(matrix.size(), 0), u(domain.points.size());
  for (std::size_t v = 0; v < u.size(); ++v) u[v] = solution.u(domain.points[v]);
  for (std::size_t cell = 0; cell < domain.cells.size(); ++cell) {
    const auto& v = domain.cells[cell];
    const Corners p = domain.CornersOf(cell);
    const Matrix4 element = StiffnessOf(p);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t row = matrix.row(v[k]);
      if (row == StiffnessMatrix::kNoRow) continue;
      b[row] += Sum(p, [&](const Vector& x, const auto& bary) { return bary[k] * solution.f(x); });
      for (std::size_t l = 0; l < 4; ++l) {
        if (domain.is_on_border[v[l]] != 0) b[row] -= element[k][l] * u[v[l]];
      }
    }
  }
  constexpr double kTolerance = 1e-12;
  constexpr int kMostIterations = 5000;
  *solved = ConjugateGradients(matrix, b, true, kTolerance, kMostIterations);
  for (std::size_t v = 0; v < u.size(); ++v) {
    if (matrix.row(v) != StiffnessMatrix::kNoRow) u[v] = solved->x[matrix.row(v)];
  }
  double l2 = 0, h1 = 0;
  for (std::size_t cell = 0; cell < domain.cells.size(); ++cell) {
    const auto& v = domain.cells[cell];
    const Corners p = domain.CornersOf(cell);
    const std::array<Vector, 4> gradients = GradientsOf(p);
    Vector gradient = {};
    for (std::size_t k = 0; k < 4; ++k) {
      for (std::size_t i = 0; i < 3; ++i) gradient[i] += u[v[k]] * gradients[k][i];
    }
    l2 += Sum(p, [&](const Vector& x, const auto& bary) {
      double value = -solution.u(x);
      for (std::size_t k = 0; k < 4; ++k) value += bary[k] * u[v[k]];
      return value * value;
    });
    h1 += Integrate(p, [&](const Vector& x) {
      const Vector difference = gradient - solution.gradient(x);
      return Dot(difference, difference);
    });
  }
  return {std::sqrt(l2), std::sqrt(h1)};
}

}  // namespace dynmesh::test
