// The last part of BatchCheck: does the result need more vertices than the mesh may have?
//
// Checks all added regions, and added features near each other; if there are very many, the longest
// segments (segment_gaps.h) and the largest facets. The answer is a function of features and batch:
// candidates are chosen by measure and id, never by the order of visits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>
#include <tuple>
#include <utility>

#include "core/plc/batch_check.h"
#include "core/plc/least_vertices.h"
#include "core/plc/messages.h"
#include "core/plc/segment_gaps.h"
#include "core/plc/validation_terms.h"

namespace dynmesh::plc {
namespace {

// The most facets for which neighbours are searched.
constexpr std::size_t kMostProbed = 4096;

}  // namespace

template <int D>
absl::Status BatchCheck<D>::CheckDemand() {
  if (absl::Status status = CheckSizeDemand(); !status.ok()) return status;
  if constexpr (D == 3) {
    if (absl::Status status = CheckFacetGaps(); !status.ok()) return status;
  }
  return CheckSegmentGaps();
}

template <int D>
absl::Status BatchCheck<D>::CheckSizeDemand() const {
  const auto& sizes = delta_.added_sizes;
  if (sizes.empty() || !IsOn(ValidationTerm::kSizesNeedFewVertices)) return absl::OkStatus();
  const Box domain = DomainBox(options_);
  const double most = static_cast<double>(options_.limits.max_vertices);
  double sum = 0, largest = 0;
  std::size_t at = 0;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    const double vertices = LeastVerticesIn(sizes[i], domain);
    sum += vertices;
    if (vertices > largest) largest = vertices, at = i;
  }
  if (sum <= most) return absl::OkStatus();
  const double all = largest > most ? largest : LeastVerticesIn(std::span(sizes), domain);
  if (all <= most) return absl::OkStatus();
  return SizeDemandError(sizes[at], largest, all, options_, draft_.BlameOf(sizes[at].id));
}

template <int D>
absl::Status BatchCheck<D>::CheckSegmentGaps() {
  // Unsplit ones get no vertices.
  const bool any_unsplit = std::ranges::any_of(delta_.added_segments, &SegmentFeature<D>::unsplit);
  std::vector<SegmentFeature<D>> split;
  if (any_unsplit) {
    std::ranges::copy_if(delta_.added_segments, std::back_inserter(split),
                         [](const SegmentFeature<D>& s) { return !s.unsplit; });
  }
  const auto& added = any_unsplit ? split : delta_.added_segments;
  if (added.empty() || !IsOn(ValidationTerm::kSegmentGapsSmall)) return absl::OkStatus();
  const double most = static_cast<double>(options_.limits.max_vertices);
  // Present segments count, except those that the batch changes, which are hidden.
  const auto query = [&](const SegmentFeature<D>& s, double distance,
                         absl::FunctionRef<void(const SegmentFeature<D>&)> visit) {
    if (present_ != nullptr) {
      present_->QueryWithin(
          s, distance,
          [&](const SegmentFeature<D>& t) {
            if (!IsHidden(t)) visit(t);
          },
          &cost_);
    }
    entered_.QueryWithin(s, distance, visit, &cost_);
  };
  const SegmentGaps<D> found =
      FindSegmentGaps<D>(added, NeedOf(added.size(), most), options_.limits, limit_, steps_, query);
  if (steps_.stopped()) return InterruptedError();
  if (found.sum <= most) return absl::OkStatus();
  const auto& [at, gap] = found.Worst();
  const SegmentFeature<D>& s = added[at];
  const EditIndex edit =
      std::max({draft_.BlameOf(s.id), draft_.BlameOf(s.p_id), draft_.BlameOf(s.q_id)});
  return GapDemandError<D>(s, gap.other, gap.distance, gap.vertices, found.sum, options_, edit);
}

template <int D>
absl::Status BatchCheck<D>::CheckFacetGaps() {
  if constexpr (D == 3) {
    const auto& added = delta_.added_facets;
    if (added.empty() || !IsOn(ValidationTerm::kFacetGapsSmall)) return absl::OkStatus();
    const double most = static_cast<double>(options_.limits.max_vertices);
    const double need = most / static_cast<double>(std::min(added.size(), kMostProbed));
    // Vertices on a facet, and the facet over it.
    struct Gap {
      double vertices = 0;
      Facet facet, other;
    };
    std::map<FeatureId, Gap> gaps;  // by id: a fixed order keeps the bits of the sum
    const auto note = [&](const Facet& f, const Facet& g) {
      const double vertices = LeastVerticesOn(f, g, options_.quality, limit_);
      if (!(vertices > 0)) return;
      Gap& gap = gaps[f.id()];
      if (std::tuple(vertices, gap.other.id()) <= std::tuple(gap.vertices, g.id())) return;
      gap = {vertices, f, g};
    };
    const std::size_t probed = std::min(added.size(), kMostProbed);
    for (std::size_t i = 0; i < probed; ++i) {
      if (steps_.Stop(16)) return InterruptedError();
      const Facet facet(added[i]);
      const double reach = DistanceFor(facet, need, options_.quality);
      if (!(reach > limit_)) continue;
      absl::flat_hash_set<FeatureId> seen;
      const auto see = [&](const Facet& other) {
        if (other.id() == facet.id() || !seen.insert(other.id()).second) return;
        note(facet, other);
        note(other, facet);
      };
      if (present_ != nullptr) {
        present_->QueryWithin(
            facet, reach,
            [&](const Facet& other) {
              if (!hidden_facets_.contains(other.id())) see(other);
            },
            &cost_);
      }
      entered_.QueryWithin(facet, reach, see, &cost_);
    }
    double sum = 0;
    const Gap* worst = nullptr;
    for (const auto& [id, gap] : gaps) {
      sum += gap.vertices;
      if (worst == nullptr ||
          std::tuple(worst->vertices, id) < std::tuple(gap.vertices, worst->facet.id())) {
        worst = &gap;
      }
    }
    if (sum <= most) return absl::OkStatus();
    // The one to blame first.
    const bool is_other = draft_.BlameOf(worst->other.id()) > draft_.BlameOf(worst->facet.id());
    const Facet &first = is_other ? worst->other : worst->facet,
                &second = is_other ? worst->facet : worst->other;
    const double distance =
        std::abs(worst->other.plane().Height(worst->facet.feature().positions.front().front()));
    return GapDemandError<D>(first, second, distance, worst->vertices, sum, options_,
                             draft_.BlameOf(first.id()));
  }
  return absl::OkStatus();
}

template absl::Status BatchCheck<2>::CheckDemand();
template absl::Status BatchCheck<3>::CheckDemand();

}  // namespace dynmesh::plc
