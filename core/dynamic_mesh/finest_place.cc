#include "core/dynamic_mesh/finest_place.h"

#include <optional>
#include <set>
#include <string>
#include <utility>

#include "absl/strings/str_format.h"
#include "core/base/steps.h"
#include "core/base/text.h"
#include "core/plc/message_parts.h"
#include "core/plc/segment_gaps.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

// Gaps that cause a smaller share of the vertices, or a few of them, are not the reason. The bound
// is a fourth of the truth.
constexpr double kLeastShare = 0.1;
constexpr double kLeastVertices = 16;

}  // namespace

template <int D>
absl::Status NameFinestPlace(absl::Status status, const plc::Delta<D>& added,
                             const plc::Plc<D>& present, const MeshOptions& options) {
  if (status.code() != absl::StatusCode::kResourceExhausted) return status;
  std::optional<ErrorDetail> detail = GetErrorDetail(status);
  if (!detail || !detail->features.empty()) return status;
  std::set<plc::EdgeKey> removed;
  for (const auto& s : added.removed_segments) removed.insert(plc::KeyOf(s));
  std::uint64_t cost = 0;
  const auto also = [&](const plc::SegmentFeature<D>& s, double distance,
                        absl::FunctionRef<void(const plc::SegmentFeature<D>&)> visit) {
    present.index().QueryWithin(
        s, distance,
        [&](const plc::SegmentFeature<D>& t) {
          if (!removed.contains(plc::KeyOf(t))) visit(t);
        },
        &cost);
  };
  AllSteps steps;
  const auto most = static_cast<double>(options.limits.max_vertices);
  const plc::SegmentGaps<D> found =
      plc::GapsAmong<D>(added.added_segments, options, most, steps, also);
  if (found.gaps.empty() || !(found.sum > kLeastShare * most)) return status;
  const auto& [at, gap] = found.Worst();
  if (gap.vertices < kLeastVertices) return status;
  const plc::SegmentFeature<D>& s = added.added_segments[at];
  detail->features = {s.id, gap.other.id};
  return MakeError(
      status.code(),
      text::Concat(text::View(status.message()), "; it is finest at ", plc::Text(gap.place),
                   ", where ", plc::Text(s), " and ", plc::Text(gap.other), " are ",
                   absl::StrFormat("%.2g", gap.distance), " apart"),
      *std::move(detail));
}

template absl::Status NameFinestPlace(absl::Status, const plc::Delta<2>&, const plc::Plc<2>&,
                                      const MeshOptions&);
template absl::Status NameFinestPlace(absl::Status, const plc::Delta<3>&, const plc::Plc<3>&,
                                      const MeshOptions&);

}  // namespace dynmesh
