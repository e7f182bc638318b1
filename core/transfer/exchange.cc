#include "core/transfer/exchange.h"

#include <map>

namespace dynmesh::transfer {
namespace {

// The share of a region's measure in the cavity that may overlap other regions if its shape is
// unchanged: more than rounding, less than any edit.
constexpr double kRounding = 1e-10;

struct Extent {
  double measure = 0, elsewhere = 0;
  std::uint32_t group = 0;
};

}  // namespace

template <std::size_t D>
Exchange<D>::Exchange(const Overlay<D>& overlay)
    : overlay_(overlay), groups_from_(overlay.from.size()), groups_to_(overlay.to.size()) {
  if (!overlay.has_regions) return;
  std::map<RegionId, Extent> regions;
  for (const auto& simplex : overlay.from) regions[simplex.region].measure += simplex.measure;
  for (const auto& simplex : overlay.to) regions[simplex.region].measure += simplex.measure;
  for (const Piece<D>& piece : overlay.pieces) {
    const RegionId from = overlay.from[piece.from].region, to = overlay.to[piece.to].region;
    if (from == to) continue;
    const double measure = piece.measure();
    regions[from].elsewhere += measure, regions[to].elsewhere += measure;
  }
  for (auto& [region, extent] : regions) {
    if (extent.elsewhere > kRounding * extent.measure) continue;
    extent.group = static_cast<std::uint32_t>(group_count_++);
  }
  for (std::size_t i = 0; i < overlay.from.size(); ++i) {
    groups_from_[i] = regions[overlay.from[i].region].group;
  }
  for (std::size_t j = 0; j < overlay.to.size(); ++j) {
    groups_to_[j] = regions[overlay.to[j].region].group;
  }
}

template <std::size_t D>
double Exchange<D>::MeasureOf(std::size_t j) const {
  return Total(own(j));
}

template class Exchange<2>;
template class Exchange<3>;

}  // namespace dynmesh::transfer
