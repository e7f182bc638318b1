// The last part of BatchCheck: does the result need more vertices than the mesh may have?
//
// Checks all added regions, and added features near each other; if there are very many, the longest
// segments and the largest facets. The answer is a function of features and batch: candidates are
// chosen by measure and id, never by the order of visits.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <tuple>
#include <utility>

#include "core/plc/batch_check.h"
#include "core/plc/least_vertices.h"
#include "core/plc/messages.h"
#include "core/plc/validation_terms.h"

namespace dynmesh::plc {
namespace {

using geometry::Point;

// The most segments or facets for which neighbours are searched.
constexpr std::size_t kMostProbed = 4096;
// The most neighbours per segment: the nearest to its middle.
constexpr std::size_t kNearest = 4;
// Keeps the greatest `count` of `things`; their order breaks ties.
template <class Thing>
void KeepGreatest(std::vector<Thing>& things, std::size_t count) {
  if (things.size() <= count) return;
  std::nth_element(things.begin(), things.begin() + static_cast<std::ptrdiff_t>(count),
                   things.end(), [](const Thing& a, const Thing& b) { return b < a; });
  things.resize(count);
}

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
  if (sizes.empty() || !Counts(ValidationTerm::kSizesNeedFewVertices)) return absl::OkStatus();
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

// Visits present segments except those that the batch changes, which are hidden.
template <int D>
template <class Visit>
void BatchCheck<D>::ForSegmentsWithin(const Point<D>& p, double distance, Visit visit) {
  if (present_ != nullptr) {
    present_->QueryWithin(
        p, distance,
        [&](const SegmentFeature<D>& s) {
          if (!IsHidden(s)) visit(s);
        },
        &cost_);
  }
  entered_.QueryWithin(p, distance, visit, &cost_);
}

// The neighbour within `distance` of the middle of s that makes the most vertices on s.
template <int D>
std::pair<double, SegmentFeature<D>> BatchCheck<D>::CrowdOn(const SegmentFeature<D>& s,
                                                            double distance) {
  Point<D> middle;
  for (int k = 0; k < D; ++k) middle[k] = 0.5 * (s.p[k] + s.q[k]);
  const EdgeKey own = KeyOf(s);
  std::vector<std::tuple<double, EdgeKey, SegmentFeature<D>>> near;
  ForSegmentsWithin(middle, distance, [&](const SegmentFeature<D>& t) {
    const EdgeKey key = KeyOf(t);
    if (key == own) return;
    const double d = DistanceOf(t, middle);
    if (d > distance) return;
    const auto before = [&](const auto& entry) {
      return std::tie(std::get<0>(entry), std::get<1>(entry)) <= std::tie(d, key);
    };
    const auto slot = std::find_if_not(near.begin(), near.end(), before);
    if (slot != near.begin() && std::get<1>(*std::prev(slot)) == key) return;  // visited before
    near.insert(slot, {d, key, t});
    if (near.size() > kNearest) near.pop_back();
  });
  std::pair<double, SegmentFeature<D>> most{0, {}};
  for (const auto& [d, key, t] : near) {
    const double vertices = LeastVerticesOn(s, t, options_.limits, limit_);
    if (vertices > most.first) most = {vertices, t};
  }
  return most;
}

template <int D>
absl::Status BatchCheck<D>::CheckSegmentGaps() {
  const auto& added = delta_.added_segments;
  if (added.empty() || !Counts(ValidationTerm::kSegmentGapsSmall)) return absl::OkStatus();
  const double most = static_cast<double>(options_.limits.max_vertices);
  const double need = most / static_cast<double>(std::min(added.size(), kMostProbed));
  struct Probed {
    double reach;  // neighbours farther away make fewer vertices than needed
    std::size_t at;
    bool operator<(const Probed& other) const {
      return std::tie(reach, other.at) < std::tie(other.reach, at);
    }
  };
  std::vector<Probed> probed;
  for (std::size_t i = 0; i < added.size(); ++i) {
    const double reach = DistanceFor(added[i], need);
    if (reach > limit_) probed.push_back({reach, i});  // no features are nearer than limit_
  }
  KeepGreatest(probed, kMostProbed);
  struct Gap {
    double vertices;
    std::size_t at;
    SegmentFeature<D> other;
  };
  std::vector<Gap> gaps;
  double sum = 0;
  for (const Probed& p : probed) {
    if (steps_.Stop(16)) return InterruptedError();
    auto [vertices, other] = CrowdOn(added[p.at], p.reach);
    if (!(vertices > 0)) continue;
    sum += vertices;
    gaps.push_back({vertices, p.at, std::move(other)});
  }
  if (sum <= most) return absl::OkStatus();
  const Gap& worst = *std::min_element(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) {
    return std::tie(b.vertices, a.at) < std::tie(a.vertices, b.at);
  });
  const SegmentFeature<D>& s = added[worst.at];
  const EditIndex edit =
      std::max({draft_.BlameOf(s.id), draft_.BlameOf(s.p_id), draft_.BlameOf(s.q_id)});
  return GapDemandError<D>(s, worst.other, LeastDistance(s, worst.other), worst.vertices, sum,
                           options_, edit);
}

template <int D>
absl::Status BatchCheck<D>::CheckFacetGaps() {
  if constexpr (D == 3) {
    const auto& added = delta_.added_facets;
    if (added.empty() || !Counts(ValidationTerm::kFacetGapsSmall)) return absl::OkStatus();
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
