#include "client/preparation/attempts.h"

#include <algorithm>
#include <string_view>

#include "core/base/text.h"
#include "dynmesh/error.h"

namespace dynmesh::preparation {
namespace {

using text::Concat;

// Surfaces that are mended well take 4 to 28 for each feature, in files that others publish; those
// with a needle that is too fine take hundreds, and stop at no limit.
constexpr std::uint64_t kFirstFewest = 100'000, kFirstForFeature = 30;

bool IsOf(std::string_view why, const absl::Status& refusal) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(refusal);
  return absl::IsResourceExhausted(refusal) && detail && detail->reason == why;
}

}  // namespace

std::uint64_t FirstMostVertices(const std::vector<Feature>& features) {
  return std::max<std::uint64_t>(kFirstFewest, kFirstForFeature * features.size());
}

bool IsOfVertexLimit(const absl::Status& refusal) { return IsOf(reason::kVertexLimit, refusal); }

bool IsTooFine(const absl::Status& refusal) {
  return IsOfVertexLimit(refusal) || IsOf(reason::kDepthLimit, refusal);
}

std::string TextOfNext(const absl::Status& refusal, std::optional<std::uint64_t> most,
                       std::optional<double> tolerance) {
  const std::string with =
      tolerance ? Concat(" with --mending-tolerance ", *tolerance) : std::string();
  const std::string why = most && IsOfVertexLimit(refusal)
                              ? Concat("its mesh would have more than ", *most, " vertices")
                              : std::string(text::View(refusal.message()));
  return Concat(why, "; tried again", with);
}

std::string TextOfLast(std::optional<double> tolerance) {
  const std::string with =
      tolerance ? Concat(" with --mending-tolerance ", *tolerance) : std::string();
  return Concat("no larger tolerance helps; tried again", with,
                ", with a higher limit of vertices");
}

}  // namespace dynmesh::preparation
