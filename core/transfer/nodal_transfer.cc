#include "core/transfer/nodal_transfer.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/transfer/bounds.h"
#include "core/transfer/compensated_sum.h"

namespace dynmesh::transfer {

template <std::size_t D>
NodalTransfer<D>::NodalTransfer(const SlotMesh& mesh, const Overlay<D>& overlay,
                                const Exchange<D>& exchange, int rings)
    : overlay_(overlay),
      exchange_(exchange),
      rings_(rings),
      patch_(mesh, overlay, rings),
      sources_(patch_.vertices) {
  SlotIndex indices = patch_.indices;
  for (const auto& simplex : overlay.from) {
    auto& corners = old_corners_.emplace_back();
    for (std::size_t k = 0; k <= D; ++k) {
      const auto [number, is_new] = indices.Add(simplex.vertices[k]);
      if (is_new) sources_.push_back(simplex.vertices[k]);
      corners[k] = number;
    }
  }
  is_added_.assign(sources_.size(), false);
  for (const Slot slot : mesh.patch().added_vertices) {
    const std::uint32_t vertex = patch_.indices[slot];
    if (vertex == SlotIndex::kNone) continue;  // in no simplex
    is_added_[vertex] = true;
    Vec<D> position;
    std::copy_n(mesh.points().data() + At(slot) * D, D, position.begin());
    const auto at = overlay.Locate(position);
    births_.push_back({vertex, at.from, at.lambda});
  }
  FindParts();
  // Couplings to vertices that are not free are added to the diagonal.
  const auto free = static_cast<std::uint32_t>(patch_.free_count);
  diagonal_.assign(free, 0);
  couplings_.reserve(patch_.cells.size());
  for (const auto& cell : patch_.cells) {
    Coupling coupling;
    coupling.unit = cell.measure / static_cast<double>((D + 1) * (D + 2));
    std::size_t tied = 0;
    for (std::size_t k = 0; k <= D; ++k) {
      coupling.corners[k] = std::min(cell.corners[k], free);
      tied += coupling.corners[k] == free;
    }
    for (const std::uint32_t corner : cell.corners) {
      if (corner < free) diagonal_[corner] += coupling.unit * static_cast<double>(2 + tied);
    }
    if (tied < D) couplings_.push_back(coupling);
  }
}

// For the cavity's vertices; 0 for the others.
template <std::size_t D>
std::vector<double> NodalTransfer<D>::Residual(std::span<const double> from) const {
  constexpr std::size_t kCorners = D + 1;
  std::vector<double> residual(patch_.free_count, 0);
  Sum missing;  // computed from the measures
  const auto mean = [&](const auto& corners) {
    double sum = 0;
    for (const std::uint32_t corner : corners) sum += from[corner];
    return sum / static_cast<double>(kCorners);
  };
  for (std::size_t i = 0; i < overlay_.from.size(); ++i) {
    missing.Add(overlay_.from[i].measure * mean(old_corners_[i]));
  }
  for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
    const auto& cell = patch_.cells[j];
    missing.Add(-cell.measure * mean(cell.corners));
    std::array<double, kCorners> right{};
    for (const Piece<D>& piece : overlay_.PiecesOf(j)) {
      const auto& corners = old_corners_[piece.from];
      for (std::size_t a = 0; a < kCorners; ++a) {
        for (std::size_t b = 0; b < kCorners; ++b) {
          right[b] += piece.mass[a * kCorners + b] * from[corners[a]];
        }
      }
    }
    const auto& own = overlay_.own[j];
    const double measure = Total(own);
    for (std::size_t a = 0; a < kCorners; ++a) {
      for (std::size_t b = 0; b < kCorners; ++b) {
        right[b] -= own[a * kCorners + b] * from[cell.corners[a]];
      }
    }
    // Pieces fill a simplex up to rounding, unless it is flat up to rounding.
    const double scale = measure > 0.5 * cell.measure ? cell.measure / measure : 0;
    for (std::size_t b = 0; b < kCorners; ++b) residual[cell.corners[b]] += scale * right[b];
  }
  Sum weights;
  std::vector<double> in_cavity(patch_.cavity_count, 0);
  for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
    const double share = overlay_.to[j].measure / static_cast<double>(kCorners);
    for (const std::uint32_t corner : patch_.cells[j].corners) in_cavity[corner] += share;
    weights.Add(overlay_.to[j].measure);
  }
  for (const double r : residual) missing.Add(-r);
  if (const double rest = missing.value(); rest != 0 && weights.value() > 0) {
    for (std::size_t v = 0; v < in_cavity.size(); ++v) {
      residual[v] += rest * (in_cavity[v] / weights.value());
    }
  }
  return residual;
}

// y = M x. Both have a last entry for all vertices that are not free: 0 in x, arbitrary in y.
template <std::size_t D>
void NodalTransfer<D>::Multiply(std::span<const double> x, std::span<double> y) const {
  for (std::size_t v = 0; v < diagonal_.size(); ++v) y[v] = diagonal_[v] * x[v];
  for (const Coupling& coupling : couplings_) {
    double sum = 0;
    for (const std::uint32_t corner : coupling.corners) sum += x[corner];
    for (const std::uint32_t corner : coupling.corners) {
      y[corner] += coupling.unit * (sum - x[corner]);
    }
  }
}

// Conjugate gradients, scaled by the diagonal; then adds the residual, lumped.
template <std::size_t D>
std::vector<double> NodalTransfer<D>::Project(std::vector<double> residual) const {
  const std::size_t n = patch_.free_count;
  std::vector<double> x(n, 0);
  if (rings_ > 0) {
    constexpr int kMostSteps = 12;
    constexpr double kGain = 1e-2;
    std::vector<double> p(n + 1), z(n), mp(n + 1);
    const auto scaled = [&] {
      double dot = 0;
      for (std::size_t v = 0; v < n; ++v) {
        z[v] = diagonal_[v] > 0 ? residual[v] / diagonal_[v] : 0;
        dot += z[v] * residual[v];
      }
      return dot;
    };
    double rz = scaled();
    const double enough = kGain * kGain * rz;
    std::copy(z.begin(), z.end(), p.begin());
    for (int step = 0; step < kMostSteps && rz > enough; ++step) {
      Multiply(p, mp);
      double pmp = 0;
      for (std::size_t v = 0; v < n; ++v) pmp += p[v] * mp[v];
      if (!(pmp > 0)) break;
      const double alpha = rz / pmp;
      for (std::size_t v = 0; v < n; ++v) x[v] += alpha * p[v], residual[v] -= alpha * mp[v];
      const double next = scaled();
      const double beta = next / rz;
      rz = next;
      for (std::size_t v = 0; v < n; ++v) p[v] = z[v] + beta * p[v];
    }
  }
  for (std::size_t v = 0; v < n; ++v) {
    if (patch_.lumped[v] > 0) x[v] += residual[v] / patch_.lumped[v];
  }
  return x;
}

// Finds the part of the mesh of each simplex of the patch: a region that keeps its shape, or all
// others together. And the shares of each free vertex's hat function in the parts.
template <std::size_t D>
void NodalTransfer<D>::FindParts() {
  const RegionId any = overlay_.from[0].region;
  const auto is_other = [any](const auto& simplex) { return simplex.region != any; };
  if (!overlay_.has_regions && std::none_of(patch_.cells.begin(), patch_.cells.end(), is_other)) {
    part_count_ = 1;
    return;
  }
  std::map<RegionId, std::uint32_t> changed;  // regions of the overlay, and their groups
  for (std::size_t i = 0; i < overlay_.from.size(); ++i) {
    changed[overlay_.from[i].region] = exchange_.group_from(i);
  }
  for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
    changed[overlay_.to[j].region] = exchange_.group_to(j);
  }
  std::map<RegionId, std::uint32_t> parts;
  std::uint32_t others = SlotIndex::kNone;
  const auto part_of = [&](RegionId region) {
    const auto it = changed.find(region);
    if (overlay_.has_regions && it != changed.end() && it->second == 0) {
      if (others == SlotIndex::kNone) others = part_count_++, part_regions_.push_back(region);
      part_regions_[others] = std::min(part_regions_[others], region);
      return others;
    }
    const auto [part, is_new] = parts.try_emplace(region, part_count_);
    if (is_new) ++part_count_, part_regions_.push_back(region);
    return part->second;
  };
  for (const auto& simplex : overlay_.from) parts_from_.push_back(part_of(simplex.region));
  std::vector<std::uint32_t> cell_parts;
  for (const auto& cell : patch_.cells) cell_parts.push_back(part_of(cell.region));
  parts_to_.assign(cell_parts.begin(),
                   cell_parts.begin() + static_cast<std::ptrdiff_t>(overlay_.to.size()));
  if (part_count_ == 1) return;
  std::map<std::pair<std::uint32_t, std::uint32_t>, double> shares;
  for (std::size_t c = 0; c < patch_.cells.size(); ++c) {
    const auto& cell = patch_.cells[c];
    for (const std::uint32_t corner : cell.corners) {
      if (corner >= patch_.free_count) continue;
      shares[{corner, cell_parts[c]}] += cell.measure / static_cast<double>(D + 1);
    }
  }
  for (const auto& [key, share] : shares) shares_.push_back({key.first, key.second, share});
}

// Keeps the integral over each part by the change with the least lumped norm: a combination of the
// parts' shares, found by conjugate gradients.
template <std::size_t D>
void NodalTransfer<D>::KeepRegions(std::span<const double> from, std::span<double> change) const {
  if (part_count_ == 1) return;
  const auto mean = [&](const auto& corners) {
    double sum = 0;
    for (const std::uint32_t corner : corners) sum += from[corner];
    return sum / static_cast<double>(D + 1);
  };
  const auto missing_of = [&] {
    std::vector<Sum> missing(part_count_);
    for (std::size_t i = 0; i < overlay_.from.size(); ++i) {
      missing[parts_from_[i]].Add(overlay_.from[i].measure * mean(old_corners_[i]));
    }
    for (std::size_t j = 0; j < overlay_.to.size(); ++j) {
      missing[parts_to_[j]].Add(-overlay_.to[j].measure * mean(patch_.cells[j].corners));
    }
    for (const PartShare& share : shares_)
      missing[share.part].Add(-share.amount * change[share.vertex]);
    std::vector<double> values;
    for (const Sum& sum : missing) values.push_back(sum.value());
    return values;
  };
  std::vector<double> by_vertex(patch_.free_count);
  const auto spread = [&](const std::vector<double>& factors) {
    std::fill(by_vertex.begin(), by_vertex.end(), 0.0);
    for (const PartShare& s : shares_) by_vertex[s.vertex] += s.amount * factors[s.part];
    for (std::size_t v = 0; v < by_vertex.size(); ++v) {
      by_vertex[v] = patch_.lumped[v] > 0 ? by_vertex[v] / patch_.lumped[v] : 0;
    }
  };
  const auto dot = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
    return sum;
  };
  // Twice: the second pass corrects the rounding of the first.
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<double> r = missing_of(), p = r, x(part_count_, 0), ap(part_count_);
    double rr = dot(r, r);
    const double enough = 1e-32 * rr;
    for (std::uint32_t step = 0; step < 2 * part_count_ + 10 && rr > enough; ++step) {
      spread(p);
      std::fill(ap.begin(), ap.end(), 0.0);
      for (const PartShare& s : shares_) ap[s.part] += s.amount * by_vertex[s.vertex];
      const double pap = dot(p, ap);
      if (!(pap > 0)) break;
      for (std::size_t k = 0; k < x.size(); ++k) {
        x[k] += rr / pap * p[k], r[k] -= rr / pap * ap[k];
      }
      const double next = dot(r, r);
      for (std::size_t k = 0; k < p.size(); ++k) p[k] = r[k] + next / rr * p[k];
      rr = next;
    }
    spread(x);
    for (std::size_t v = 0; v < change.size(); ++v) change[v] += by_vertex[v];
  }
}

template <std::size_t D>
std::vector<double> NodalTransfer<D>::Values(std::span<double> old, bool bounded,
                                             std::vector<Flow>& flows) const {
  // A reference: the old value of least magnitude.
  double reference = 0;
  bool any = false;
  for (const auto& corners : old_corners_) {
    for (const std::uint32_t corner : corners) {
      if (!any || std::abs(old[corner]) < std::abs(reference)) reference = old[corner];
      any = true;
    }
  }
  std::vector<double> from(old.size());
  for (std::size_t v = 0; v < old.size(); ++v) from[v] = is_added_[v] ? 0 : old[v] - reference;
  for (const Birth& birth : births_) {
    double sum = 0;
    for (std::size_t a = 0; a <= D; ++a) {
      sum += birth.lambda[a] * from[old_corners_[birth.from][a]];
    }
    from[birth.vertex] = sum, old[birth.vertex] = sum + reference;
  }
  std::vector<double> change = Project(Residual(from));
  KeepRegions(from, change);

  std::vector<double> result(patch_.free_count);
  for (std::size_t v = 0; v < result.size(); ++v) {
    result[v] = change[v] == 0 ? old[v] : old[v] + change[v];
  }
  if (bounded) {
    Range range;
    for (const auto& corners : old_corners_) {
      for (const std::uint32_t corner : corners) range.Hold(old[corner]);
    }
    for (std::size_t v = 0; v < sources_.size(); ++v) {
      if (!is_added_[v]) range.Hold(old[v]);
    }
    if (part_count_ == 1) {
      Clamp(range, patch_.lumped, 0, result);
      return result;
    }
    for (const PartFlow& flow : ClampInParts(range, shares_, part_count_, patch_.lumped, result)) {
      flows.push_back({part_regions_[flow.from], part_regions_[flow.to], flow.amount});
    }
  }
  return result;
}

template class NodalTransfer<2>;
template class NodalTransfer<3>;

}  // namespace dynmesh::transfer
