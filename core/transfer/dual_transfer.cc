#include "core/transfer/dual_transfer.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "core/transfer/bounds.h"
#include "core/transfer/cell_transfer.h"
#include "core/transfer/clipper.h"
#include "core/transfer/compensated_sum.h"

namespace dynmesh::transfer {
namespace {

constexpr std::uint32_t kNoHome = ~std::uint32_t{0};  // of HomesOf

// A simplex of a piece, by the old and the new simplex's coordinates at its corners, cut along the
// planes on which two coordinates are equal until each has one that is the greatest.
//
// Edges are bisected, one after the other. The share of the measure on either side is that of the
// edge, so positions are not needed and parts add up to the whole.
template <std::size_t D>
class Cutter {
 public:
  using Row = std::array<double, D + 1>;
  using Table = std::array<Row, D + 1>;
  struct Simplex {
    Table in_old, in_new;
    double measure;
  };

  // Adds to measures[a * (D + 1) + b] what lies in the old simplex's part a and the new one's b.
  explicit Cutter(std::array<double, (D + 1) * (D + 1)>& measures) : measures_(measures) {}

  void CutByOld(const Simplex& simplex, int depth = 0) {
    const Cut cut = CutOf(simplex.in_old);
    if (cut.is_whole || depth >= kMostCuts) return CutByNew(simplex, cut.part, 0);
    Simplex one, other;
    Bisect(simplex, cut, one, other);
    CutByOld(one, depth + 1), CutByOld(other, depth + 1);
  }

 private:
  // What is as small may be rounding: the plane goes through the corner. Relative to the greatest
  // coordinate, which is large in a sliver only.
  static constexpr double kNoise = 1e-12;
  // A plane cuts at most 4 edges, and there are 6 planes: more would be rounding.
  static constexpr int kMostCuts = 24;

  void CutByNew(const Simplex& simplex, std::size_t old_part, int depth) {
    const Cut cut = CutOf(simplex.in_new);
    if (cut.is_whole || depth >= kMostCuts) {
      measures_[old_part * (D + 1) + cut.part] += simplex.measure;
      return;
    }
    Simplex one, other;
    Bisect(simplex, cut, one, other);
    CutByNew(one, old_part, depth + 1), CutByNew(other, old_part, depth + 1);
  }

  // Where an edge is to be cut: at `t` from corner p to corner q. Or the simplex is a whole: `part`
  // is the greatest everywhere.
  struct Cut {
    bool is_whole = false;
    std::size_t part = 0;
    std::size_t p = 0, q = 0;
    double t = 0;
  };

  static Cut CutOf(const Table& table) {
    Cut cut;
    double noise = 1;
    for (const Row& row : table) {
      for (const double x : row) noise = std::max(noise, std::abs(x));
    }
    noise *= kNoise;
    // The coordinates that are the greatest at each corner.
    std::uint32_t everywhere = ~std::uint32_t{0};
    for (std::size_t i = 0; i <= D; ++i) {
      const double most = *std::max_element(table[i].begin(), table[i].end()) - noise;
      std::uint32_t greatest = 0;
      for (std::size_t k = 0; k <= D; ++k) {
        greatest |= std::uint32_t{table[i][k] >= most} << k;
      }
      everywhere &= greatest;
    }
    if (everywhere != 0) {
      cut.is_whole = true;
      cut.part = static_cast<std::size_t>(std::countr_zero(everywhere));
      return cut;
    }
    // Those that another one is nowhere below never are.
    std::uint32_t never = 0;
    for (std::size_t a = 0; a <= D; ++a) {
      for (std::size_t b = 0; b <= D; ++b) {
        if (b == a || (never >> b & 1) != 0) continue;
        bool is_below = true;
        for (const Row& row : table) is_below &= row[a] <= row[b];
        never |= std::uint32_t{is_below} << a;
      }
    }
    // One plane after the other, so that each cuts an edge once.
    for (std::size_t a = 0; a <= D; ++a) {
      for (std::size_t b = a + 1; b <= D; ++b) {
        if (((never >> a | never >> b) & 1) != 0) continue;
        std::size_t p = 0, q = 0;
        for (std::size_t i = 1; i <= D; ++i) {
          if (table[i][a] - table[i][b] > table[p][a] - table[p][b]) p = i;
          if (table[i][a] - table[i][b] < table[q][a] - table[q][b]) q = i;
        }
        const double high = table[p][a] - table[p][b], low = table[q][a] - table[q][b];
        if (high <= noise || low >= -noise) continue;
        cut.p = p, cut.q = q, cut.t = high / (high - low);
        return cut;
      }
    }
    cut.is_whole = true;  // up to rounding
    Row sums{};
    for (const Row& row : table) {
      for (std::size_t k = 0; k <= D; ++k) sums[k] += row[k];
    }
    cut.part = static_cast<std::size_t>(std::max_element(sums.begin(), sums.end()) - sums.begin());
    return cut;
  }

  static void Bisect(const Simplex& simplex, const Cut& cut, Simplex& one, Simplex& other) {
    const auto [is_whole, part, p, q, t] = cut;
    one = other = simplex;
    for (std::size_t k = 0; k <= D; ++k) {
      const Table &in_old = simplex.in_old, &in_new = simplex.in_new;
      one.in_old[q][k] = other.in_old[p][k] = in_old[p][k] + t * (in_old[q][k] - in_old[p][k]);
      one.in_new[q][k] = other.in_new[p][k] = in_new[p][k] + t * (in_new[q][k] - in_new[p][k]);
    }
    one.measure *= t, other.measure *= 1 - t;
  }

  std::array<double, (D + 1) * (D + 1)>& measures_;
};

}  // namespace

template <std::size_t D>
DualTransfer<D>::DualTransfer(const Overlay<D>& overlay, const Exchange<D>& exchange)
    : overlay_(overlay), exchange_(exchange) {
  FindOverlaps();
}

template <std::size_t D>
void DualTransfer<D>::FindOverlaps() {
  constexpr std::uint32_t kCorners = D + 1;
  const std::vector<std::uint32_t> homes = HomesOf(overlay_, exchange_);
  for (std::uint32_t j = 0; j < overlay_.to.size(); ++j) {
    if (homes[j] != kNoHome) {  // flat up to rounding
      for (std::uint32_t k = 0; k < kCorners; ++k) {
        for (std::uint32_t a = 0; a < kCorners; ++a) {
          overlaps_.push_back({homes[j] * kCorners + a, j * kCorners + k, 0});
        }
      }
      continue;
    }
    const Clipper<D> clipper(overlay_.to[j]);
    for (const Piece<D>& piece : overlay_.PiecesOf(j)) {
      if (!exchange_.Counts(piece)) continue;
      std::array<double, (D + 1) * (D + 1)> measures{};
      Cutter<D> cutter(measures);
      clipper.ForEachSimplex(overlay_.from[piece.from],
                             [&](const auto& in_old, const auto& in_new, double measure) {
                               cutter.CutByOld({in_old, in_new, measure});
                             });
      for (std::uint32_t a = 0; a < kCorners; ++a) {
        for (std::uint32_t b = 0; b < kCorners; ++b) {
          const double measure = measures[a * kCorners + b];
          if (measure > 0) {
            overlaps_.push_back({piece.from * kCorners + a, j * kCorners + b, measure});
          }
        }
      }
    }
  }
}

template <std::size_t D>
std::vector<double> DualTransfer<D>::OfCorners(std::span<const double> old) const {
  constexpr std::size_t kCorners = D + 1;
  std::vector<double> references(exchange_.group_count(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < old.size(); ++i) {
    double& reference = references[exchange_.group_from(i / kCorners)];
    if (std::abs(old[i]) < std::abs(reference)) reference = old[i];
  }
  for (double& reference : references) {
    if (!std::isfinite(reference)) reference = 0;  // a group without old simplices
  }
  const auto reference_of = [&](std::size_t j) { return references[exchange_.group_to(j)]; };
  std::vector<double> from(old.size()), to(overlay_.to.size() * kCorners), weights(to.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    from[i] = old[i] - references[exchange_.group_from(i / kCorners)];
  }
  std::vector<double> plain(to.size()), plain_count(to.size());  // where no overlap has a measure
  for (const Overlap& overlap : overlaps_) {
    const double value =
        old[overlap.from] - reference_of(overlap.to / kCorners);  // homes may be of other groups
    to[overlap.to] += overlap.measure * value, weights[overlap.to] += overlap.measure;
    plain[overlap.to] += value, plain_count[overlap.to] += 1;
  }
  for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
    double sum = 0, count = 0;
    for (std::size_t k = 0; k < kCorners; ++k) {
      sum += plain[j * kCorners + k], count += plain_count[j * kCorners + k];
    }
    for (std::size_t k = 0; k < kCorners; ++k) {
      double& value = to[j * kCorners + k];
      if (weights[j * kCorners + k] > 0) {
        value /= weights[j * kCorners + k];
      } else {  // of a sliver
        value = count > 0 ? sum / count : 0;
      }
    }
  }
  Balance(from, to);
  Range range;
  for (const double value : old) range.Hold(value);
  for (std::size_t i = 0; i < to.size(); ++i) {
    to[i] = std::clamp(to[i] + reference_of(i / kCorners), range.low, range.high);
  }
  return to;
}

// Both are differences to the reference. Adds to the parts of each group what it misses, within the
// range.
template <std::size_t D>
void DualTransfer<D>::Balance(std::span<const double> from, std::span<double> to) const {
  constexpr std::size_t kCorners = D + 1;
  const auto groups = static_cast<std::uint32_t>(exchange_.group_count());
  for (std::uint32_t group = 0; group < groups; ++group) {
    Sum missing;
    Range range;
    for (std::size_t i = 0; i < from.size(); ++i) {
      if (exchange_.group_from(i / kCorners) != group) continue;
      missing.Add(overlay_.from[i / kCorners].measure / kCorners * from[i]);
      range.Hold(from[i]);
    }
    std::vector<std::size_t> members;
    std::vector<double> weights, values;
    for (std::size_t i = 0; i < to.size(); ++i) {
      if (exchange_.group_to(i / kCorners) != group) continue;
      const double weight = overlay_.to[i / kCorners].measure / kCorners;
      missing.Add(-weight * to[i]);
      members.push_back(i), weights.push_back(weight), values.push_back(to[i]);
    }
    if (members.empty() || !(range.low < range.high)) continue;  // nothing, or a constant
    Clamp(range, weights, missing.value(), values);
    for (std::size_t m = 0; m < members.size(); ++m) to[members[m]] = values[m];
  }
}

template <std::size_t D>
DualNodes<D>::DualNodes(const SlotMesh& mesh, const Overlay<D>& overlay)
    : patch_(mesh, overlay, 0), new_count_(overlay.to.size()) {
  sources_.assign(patch_.vertices.begin(),
                  patch_.vertices.begin() + static_cast<std::ptrdiff_t>(patch_.cavity_count));
  SlotIndex indices(sources_.size());
  for (const Slot slot : sources_) indices.Add(slot);
  for (const auto& simplex : overlay.from) {
    for (const Slot vertex : simplex.vertices) {
      const auto [number, is_new] = indices.Add(vertex);
      if (is_new) sources_.push_back(vertex);
      old_corners_.push_back(number);
    }
  }
  is_added_.assign(sources_.size(), false);
  for (const Slot slot : mesh.patch().added_vertices) {
    const std::uint32_t vertex = indices[slot];
    if (vertex != SlotIndex::kNone) is_added_[vertex] = true;
  }
}

template <std::size_t D>
std::vector<double> DualNodes<D>::AtCorners(std::span<const double> old) const {
  std::vector<double> values;
  values.reserve(old_corners_.size());
  for (const std::uint32_t corner : old_corners_) values.push_back(old[corner]);
  return values;
}

template <std::size_t D>
std::vector<double> DualNodes<D>::Values(std::span<const double> old,
                                         std::span<const double> parts) const {
  constexpr std::size_t kCorners = D + 1;
  const std::size_t count = patch_.cavity_count;
  // Sums are over differences to a value of the vertex, so constants stay to the bit.
  std::vector<double> base(count), sum(count, 0), weight(count, 0);
  std::vector<bool> is_known(count, false);
  for (std::size_t v = 0; v < count; ++v) {
    if (!is_added_[v]) base[v] = old[v], is_known[v] = true;
  }
  for (std::size_t c = 0; c < patch_.cells.size(); ++c) {
    const auto& cell = patch_.cells[c];
    for (std::size_t k = 0; k < kCorners; ++k) {
      const std::uint32_t v = cell.corners[k];
      if (v >= count) continue;
      weight[v] += cell.measure;
      if (c >= new_count_) continue;  // its part stays
      if (!is_known[v]) base[v] = parts[c * kCorners + k], is_known[v] = true;
      sum[v] += cell.measure * (parts[c * kCorners + k] - base[v]);
    }
  }
  std::vector<double> result(count);
  for (std::size_t v = 0; v < count; ++v) {
    result[v] = weight[v] > 0 ? base[v] + sum[v] / weight[v] : base[v];
  }
  Range range;
  for (std::size_t v = 0; v < sources_.size(); ++v) {
    if (!is_added_[v]) range.Hold(old[v]);
  }
  for (double& value : result) value = std::clamp(value, range.low, range.high);
  return result;
}

template class DualTransfer<2>;
template class DualTransfer<3>;
template class DualNodes<2>;
template class DualNodes<3>;

}  // namespace dynmesh::transfer
