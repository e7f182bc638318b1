#include "client/cli/finest_gap.h"

#include <cmath>
#include <cstdint>

#include "absl/strings/str_format.h"
#include "core/base/steps.h"
#include "core/base/text.h"
#include "core/plc/plc.h"
#include "core/plc/segment_gaps.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// Cleaning keeps half of the tolerance between a point and a segment, in 3D a fourth: so many times
// a distance is surely enough to join what is so near.
constexpr double kTolerances2D = 2.5;
constexpr double kTolerances3D = 5;
// A warning before a mesh is tried: less than the share that explains a refusal (finest_place.cc).
constexpr double kShareToWarnOf = 0.02;
// Cleaning leaves gaps that a mesh affords easily.
constexpr double kShareLeft = 0.1;

// Up to two digits.
double RoundedUp(double x) {
  if (!(x > 0)) return 0;
  const double unit = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::ceil(x / unit) * unit;
}

template <int D>
std::optional<FinestGap> Find(const std::vector<Feature>& features, MeshOptions options) {
  const auto most = static_cast<double>(options.limits.max_vertices);
  options.limits.max_vertices = std::uint64_t{1} << 50;  // the gaps are wanted, not a refusal
  const auto delta = plc::Plc<D>(options).Check(plc::Edits::Adding(features));
  if (!delta.ok()) return std::nullopt;
  AllSteps steps;
  const plc::SegmentGaps<D> found = plc::GapsAmong<D>(delta->added_segments, options, most, steps,
                                                      [](const auto&, double, auto) {});
  if (!(found.sum > kShareToWarnOf * most)) return std::nullopt;
  const auto& [at, worst] = found.Worst();
  FinestGap gap;
  gap.features = {delta->added_segments[at].id, worst.other.id};
  for (std::size_t k = 0; k < D; ++k) gap.place[k] = worst.place[static_cast<int>(k)];
  gap.distance = worst.distance;
  gap.vertices = found.sum;
  gap.tolerance = RoundedUp((D == 2 ? kTolerances2D : kTolerances3D) *
                            found.DistanceBelowWhich(kShareLeft * std::min(most, found.sum)));
  return gap;
}

}  // namespace

std::optional<FinestGap> FindFinestGap(const std::vector<Feature>& features,
                                       const MeshOptions& options) {
  if (options.kind != MeshKind::kDelaunay) return std::nullopt;
  return options.dimension == 2 ? Find<2>(features, options) : Find<3>(features, options);
}

std::string TextOf(const FinestGap& gap, int dimension,
                   const std::function<std::string(FeatureId)>& where) {
  const bool are_of_one = gap.features[0] == gap.features[1];
  std::string places, place;
  for (const FeatureId id : gap.features) {
    const std::string at = where(id);
    if (!at.empty() && (places.empty() || !are_of_one)) {
      places += Concat(places.empty() ? " (" : ", ", at);
    }
  }
  for (int k = 0; k < dimension; ++k) {
    place += absl::StrFormat("%s%.9g", k == 0 ? "" : ", ", gap.place[static_cast<std::size_t>(k)]);
  }
  const std::string features = are_of_one
                                   ? Concat("two edges of feature ", gap.features[0])
                                   : Concat("features ", gap.features[0], " and ", gap.features[1]);
  return Concat("it is finest at (", place, "), where ", features, " are ",
                absl::StrFormat("%.2g", gap.distance), " apart", places, places.empty() ? "" : ")");
}

std::string AdviceFor(const FinestGap& gap) {
  return Concat("`dynmesh import INPUT --clean --tolerance ",
                absl::StrFormat("%.2g", gap.tolerance),
                " -o CLEAN.dynmesh` joins features that are so near to each other");
}

}  // namespace dynmesh::cli
