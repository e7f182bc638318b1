#include "core/transfer/cell_transfer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/transfer/bounds.h"
#include "core/transfer/compensated_sum.h"

namespace dynmesh::transfer {
namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

// Solves the symmetric positive definite `a` . x = b (Cholesky); false if it is not.
template <std::size_t N>
bool Solve(std::array<double, N * N> a, std::array<double, N>& b) {
  for (std::size_t k = 0; k < N; ++k) {
    for (std::size_t j = 0; j < k; ++j) a[k * N + k] -= a[k * N + j] * a[k * N + j];
    if (!(a[k * N + k] > 0)) return false;
    a[k * N + k] = std::sqrt(a[k * N + k]);
    for (std::size_t i = k + 1; i < N; ++i) {
      for (std::size_t j = 0; j < k; ++j) a[i * N + k] -= a[i * N + j] * a[k * N + j];
      a[i * N + k] /= a[k * N + k];
    }
  }
  for (std::size_t i = 0; i < N; ++i) {
    for (std::size_t j = 0; j < i; ++j) b[i] -= a[i * N + j] * b[j];
    b[i] /= a[i * N + i];
  }
  for (std::size_t i = N; i-- > 0;) {
    for (std::size_t j = i + 1; j < N; ++j) b[i] -= a[j * N + i] * b[j];
    b[i] /= a[i * N + i];
  }
  return true;
}

template <std::size_t D>
double MeanOf(const double* values) {
  double sum = 0;
  for (std::size_t k = 0; k <= D; ++k) sum += values[k];
  return sum / static_cast<double>(D + 1);
}

// Undoes what rounding of a last sum may have added beyond the range of `old`.
void ClampToRangeOf(std::span<const double> old, std::span<double> values) {
  Range range;
  for (const double value : old) range.Hold(value);
  for (double& value : values) value = std::clamp(value, range.low, range.high);
}

// The old simplex with the largest overlap with new one j; of equals the first.
template <std::size_t D>
std::uint32_t LargestPieceOf(const Overlay<D>& overlay, const Exchange<D>& exchange,
                             std::size_t j) {
  double most = -1;
  std::uint32_t donor = kNone;
  for (const Piece<D>& piece : overlay.PiecesOf(j)) {
    if (!exchange.Counts(piece)) continue;
    const double measure = piece.measure();
    if (measure > most || (measure == most && piece.from < donor)) {
      most = measure, donor = piece.from;
    }
  }
  return donor;
}

}  // namespace

template <std::size_t D>
std::vector<std::uint32_t> HomesOf(const Overlay<D>& overlay, const Exchange<D>& exchange) {
  std::vector<std::uint32_t> homes(overlay.to.size(), kNone);
  for (std::size_t j = 0; j < overlay.to.size(); ++j) {
    if (exchange.MeasureOf(j) > 0.5 * overlay.to[j].measure) continue;
    // Less than half of it is in pieces: it is flat up to rounding.
    homes[j] = overlay.Locate(Centroid<D>(overlay.to[j].corners)).from;
  }
  return homes;
}

template <std::size_t D>
std::vector<std::uint32_t> DonorsOf(const Overlay<D>& overlay, const Exchange<D>& exchange) {
  std::vector<std::uint32_t> donors = HomesOf(overlay, exchange);
  for (std::size_t j = 0; j < donors.size(); ++j) {
    if (donors[j] == kNone) donors[j] = LargestPieceOf(overlay, exchange, j);
  }
  return donors;
}

template <std::size_t D>
CellTransfer<D>::CellTransfer(const Overlay<D>& overlay, const Exchange<D>& exchange)
    : overlay_(overlay), exchange_(exchange), homes_(HomesOf(overlay, exchange)) {}

// References have the least magnitude: sums of differences then round as little as sums of values.
template <std::size_t D>
std::vector<double> CellTransfer<D>::Relative(std::span<const double> old, std::size_t width,
                                              std::vector<double>& references) const {
  references.assign(exchange_.group_count(), std::numeric_limits<double>::infinity());
  const std::size_t count = overlay_.from.size();
  for (std::size_t i = 0; i < count * width; ++i) {
    double& reference = references[exchange_.group_from(i / width)];
    if (std::abs(old[i]) < std::abs(reference)) reference = old[i];
  }
  for (double& reference : references) {
    if (!std::isfinite(reference)) reference = 0;  // a group without old simplices
  }
  std::vector<double> from(count * width);
  for (std::size_t i = 0; i < from.size(); ++i) {
    from[i] = old[i] - references[exchange_.group_from(i / width)];
  }
  return from;
}

// The difference between the references of an old and a new simplex.
template <std::size_t D>
double CellTransfer<D>::Offset(const std::vector<double>& references, std::size_t i,
                               std::size_t j) const {
  return references[exchange_.group_from(i)] - references[exchange_.group_to(j)];
}

// Both are differences to the reference. Adds to the means of each group what it misses.
template <std::size_t D>
void CellTransfer<D>::Balance(std::span<const double> old_means, std::span<const double> all_old,
                              bool bounded, std::span<double> means) const {
  const std::size_t width = all_old.size() / old_means.size();
  for (std::uint32_t group = 0; group < exchange_.group_count(); ++group) {
    Sum missing, whole;
    Range range;
    for (std::size_t i = 0; i < overlay_.from.size(); ++i) {
      if (exchange_.group_from(i) != group) continue;
      missing.Add(overlay_.from[i].measure * old_means[i]);
      for (std::size_t k = 0; k < width; ++k) range.Hold(all_old[i * width + k]);
    }
    std::vector<std::size_t> members;
    std::vector<double> weights, values;
    for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
      if (exchange_.group_to(j) != group) continue;
      missing.Add(-overlay_.to[j].measure * means[j]);
      whole.Add(overlay_.to[j].measure);
      members.push_back(j);
      weights.push_back(overlay_.to[j].measure), values.push_back(means[j]);
    }
    if (!(whole.value() > 0)) continue;
    if (bounded) {
      Clamp(range, weights, missing.value(), values);
      for (std::size_t m = 0; m < members.size(); ++m) means[members[m]] = values[m];
    } else if (const double shift = missing.value() / whole.value(); shift != 0) {
      for (const std::size_t j : members) means[j] += shift;
    }
  }
}

template <std::size_t D>
std::vector<double> CellTransfer<D>::Means(std::span<const double> old, bool bounded) const {
  std::vector<double> references, to(overlay_.to.size());
  const std::vector<double> from = Relative(old, 1, references);
  for (std::size_t j = 0; j < to.size(); ++j) {
    if (homes_[j] != kNone) {
      to[j] = from[homes_[j]] + Offset(references, homes_[j], j);
      continue;
    }
    double mass = 0, measure = 0;
    for (const Piece<D>& piece : overlay_.PiecesOf(j)) {
      if (!exchange_.Counts(piece)) continue;
      const double m = piece.measure();
      mass += m * from[piece.from], measure += m;
    }
    to[j] = mass / measure;
  }
  Balance(from, from, bounded, to);
  for (std::size_t j = 0; j < to.size(); ++j) to[j] += references[exchange_.group_to(j)];
  if (bounded) ClampToRangeOf(old, to);
  return to;
}

template <std::size_t D>
std::vector<double> CellTransfer<D>::LinearMeans(const Stencil<D>& stencil,
                                                 std::span<const double> old, bool bounded,
                                                 std::vector<double>& at_corners) const {
  const std::size_t from_count = overlay_.from.size();
  std::vector<double> references, to(overlay_.to.size());
  const std::vector<double> from = Relative(old, 1, references);
  // Of each old simplex: its gradient, and its function at its corners.
  std::vector<Vec<D>> gradients(from_count);
  at_corners.resize(from_count * (D + 1));
  for (std::size_t i = 0; i < from_count; ++i) {
    gradients[i] = stencil.Gradient(i, old);
    for (std::size_t k = 0; k <= D; ++k) {
      const Vec<D> step = overlay_.from[i].corners[k] - stencil.centroid(i);
      at_corners[i * (D + 1) + k] = from[i] + Dot(gradients[i], step);
    }
  }
  for (std::size_t j = 0; j < to.size(); ++j) {
    const Vec<D> centroid = Centroid<D>(overlay_.to[j].corners);
    if (homes_[j] != kNone) {
      const std::uint32_t i = homes_[j];
      to[j] =
          from[i] + Offset(references, i, j) + Dot(gradients[i], centroid - stencil.centroid(i));
      continue;
    }
    double mass = 0, measure = 0;
    Vec<D> moment{}, gradient{};
    for (const Piece<D>& piece : overlay_.PiecesOf(j)) {
      if (!exchange_.Counts(piece)) continue;
      const PatchSimplex<D>& simplex = overlay_.from[piece.from];
      double of_piece = 0;
      for (std::size_t a = 0; a <= D; ++a) {
        const double at_corner = piece.share(a);
        mass += at_corner * at_corners[piece.from * (D + 1) + a];
        const Vec<D> step = simplex.corners[a] - centroid;
        for (std::size_t k = 0; k < D; ++k) moment[k] += at_corner * step[k];
        of_piece += at_corner;
      }
      for (std::size_t k = 0; k < D; ++k) gradient[k] += of_piece * gradients[piece.from][k];
      measure += of_piece;
    }
    // The pieces' centroid is the simplex's up to rounding, which matters for slivers.
    to[j] = mass / measure - Dot(moment, gradient) / (measure * measure);
  }
  Balance(from, from, bounded, to);
  for (std::size_t j = 0; j < to.size(); ++j) to[j] += references[exchange_.group_to(j)];
  for (std::size_t k = 0; k < at_corners.size(); ++k) {
    at_corners[k] += references[exchange_.group_from(k / (D + 1))];
  }
  if (bounded) ClampToRangeOf(old.first(from_count), to);
  return to;
}

template <std::size_t D>
std::vector<double> CellTransfer<D>::Functions(std::span<const double> old, bool bounded) const {
  constexpr std::size_t kCorners = D + 1;
  std::vector<double> references, to(overlay_.to.size() * kCorners);
  const std::vector<double> from = Relative(old, kCorners, references);
  for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
    std::array<double, kCorners> right{};
    bool solved = false;
    if (homes_[j] == kNone) {
      for (const Piece<D>& piece : overlay_.PiecesOf(j)) {
        if (!exchange_.Counts(piece)) continue;
        for (std::size_t a = 0; a < kCorners; ++a) {
          for (std::size_t b = 0; b < kCorners; ++b) {
            right[b] += piece.mass[a * kCorners + b] * from[piece.from * kCorners + a];
          }
        }
      }
      solved = Solve<kCorners>(exchange_.own(j), right);
    }
    if (!solved) {
      const std::uint32_t i =
          homes_[j] != kNone ? homes_[j] : LargestPieceOf(overlay_, exchange_, j);
      const Barycentric<D> coordinates(overlay_.from[i].corners);
      right.fill(Offset(references, i, j));
      for (std::size_t b = 0; b < kCorners; ++b) {
        const auto lambda = coordinates(overlay_.to[j].corners[b]);
        for (std::size_t a = 0; a < kCorners; ++a) right[b] += lambda[a] * from[i * kCorners + a];
      }
    }
    std::copy(right.begin(), right.end(), &to[j * kCorners]);
  }
  std::vector<double> old_means(overlay_.from.size()), means(overlay_.to.size());
  for (std::size_t i = 0; i < old_means.size(); ++i) old_means[i] = MeanOf<D>(&from[i * kCorners]);
  for (std::size_t j = 0; j < means.size(); ++j) means[j] = MeanOf<D>(&to[j * kCorners]);
  const std::vector<double> before = means;
  Balance(old_means, from, bounded, means);
  Range range;
  for (const double value : old) range.Hold(value);
  for (std::size_t j = 0; j < means.size(); ++j) {
    double* values = &to[j * kCorners];
    const double reference = references[exchange_.group_to(j)];
    const double shift = means[j] - before[j];
    if (shift != 0) {
      for (std::size_t k = 0; k < kCorners; ++k) values[k] += shift;
    }
    // Scaled towards the mean until all corners are within the range (Zhang and Shu 2010).
    double part = 1;
    if (bounded) {
      for (std::size_t k = 0; k < kCorners; ++k) {
        const double step = values[k] - means[j];
        if (step > 0) part = std::min(part, (range.high - reference - means[j]) / step);
        if (step < 0) part = std::min(part, (range.low - reference - means[j]) / step);
      }
    }
    for (std::size_t k = 0; k < kCorners; ++k) {
      if (part < 1) values[k] = means[j] + std::max(part, 0.0) * (values[k] - means[j]);
      values[k] += reference;
      if (bounded) values[k] = std::clamp(values[k], range.low, range.high);
    }
  }
  return to;
}

template std::vector<std::uint32_t> HomesOf(const Overlay<2>&, const Exchange<2>&);
template std::vector<std::uint32_t> HomesOf(const Overlay<3>&, const Exchange<3>&);
template std::vector<std::uint32_t> DonorsOf(const Overlay<2>&, const Exchange<2>&);
template std::vector<std::uint32_t> DonorsOf(const Overlay<3>&, const Exchange<3>&);
template class CellTransfer<2>;
template class CellTransfer<3>;

}  // namespace dynmesh::transfer
