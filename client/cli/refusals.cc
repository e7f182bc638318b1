#include "client/cli/refusals.h"

#include <algorithm>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cli/command.h"
#include "client/cli/finest_gap.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/coplanar/merge_coplanar.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// Leaves out what a refusal blames.
class Remaining {
 public:
  explicit Remaining(std::vector<Feature> features) : features_(std::move(features)) {}

  const std::vector<Feature>& features() const { return features_; }

  // Leaves out the blamed feature that fewest others need: the last one, not a point if there is
  // another. False if there is none.
  bool LeaveOut(const std::vector<FeatureId>& blamed) {
    absl::flat_hash_map<FeatureId, bool> is_point;
    for (const Feature& f : features_) is_point[f.id] = IsPoint(f);
    std::optional<FeatureId> victim;
    for (const FeatureId id : blamed) {
      const auto known = is_point.find(id);
      if (known == is_point.end()) continue;
      if (!victim || !known->second || is_point[*victim]) victim = id;
    }
    if (!victim) return false;
    const auto names = [&](const Feature& f) {
      if (f.id == *victim) return true;
      bool names_it = false;
      ForEachPointOf(f, [&](FeatureId id) { names_it = names_it || id == *victim; });
      return names_it;
    };
    std::erase_if(features_, names);
    return true;
  }

 private:
  std::vector<Feature> features_;
};

Refusals Find(absl::Status status, const DynamicMesh& mesh, const std::vector<Feature>& features,
              bool all) {
  Refusals refusals;
  Remaining remaining(features);
  while (!status.ok()) {
    const std::optional<ErrorDetail> found = GetErrorDetail(status);
    ++refusals.count;
    ++refusals.by_reason[found ? found->reason : "OTHER"];
    if (refusals.count <= kMostTold) refusals.first.push_back(status);
    refusals.is_complete = false;
    if ((refusals.count >= kMostTold && !all) || !found || !remaining.LeaveOut(found->features)) {
      break;
    }
    status = mesh.Validate(AddAll(remaining.features()));
    refusals.is_complete = status.ok();
  }
  return refusals;
}

std::size_t CountPolygons(const std::vector<Feature>& features) {
  return CountOf<APolygon>(features, Not<APoint, ASegment, ASize>);
}

// If that helps.
void AdviseMerging(const Input& input, const DynamicMesh& mesh) {
  const auto merged = coplanar::MergeCoplanar(input.features);
  if (!merged.ok()) return;
  const std::size_t before = CountPolygons(input.features), after = CountPolygons(*merged);
  if (after == before || !mesh.Validate(AddAll(*merged)).ok()) return;
  PrintWarning(Concat(before, " faces lie in ", after,
                      " planes: --merge-coplanar joins them, and takes away the angles between "
                      "their inner edges"));
}

// Of what cleaning mends.
void AdviseCleaning(const Refusals& refusals, const std::string& mending) {
  std::size_t count = 0;
  for (const char* const mended :
       {reason::kDegenerateSegment, reason::kDuplicatePoint, reason::kDuplicateSegment,
        reason::kPointOnSegment, reason::kSegmentsCross, reason::kSegmentsOverlap,
        reason::kNonPlanar, reason::kDuplicatePolygon, reason::kPointOnPolygon,
        reason::kSegmentMeetsPolygon, reason::kPolygonsMeet, reason::kTooClose}) {
    const auto found = refusals.by_reason.find(mended);
    if (found != refusals.by_reason.end()) count += found->second;
  }
  if (count == 0) return;
  PrintWarning(Concat(mending, " mends what crosses, overlaps, touches or is there twice (here ",
                      count, "), if that needs no move beyond its tolerance"));
}

}  // namespace

Refusals FindRefusals(const std::vector<Feature>& features, const MeshOptions& options, bool all) {
  const absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = DynamicMesh::Create(options);
  const absl::Status status = mesh.ok() ? (*mesh)->Validate(AddAll(features)) : mesh.status();
  if (status.ok()) return {};
  if (!mesh.ok()) return {1, {{"OTHER", 1}}, {status}, true};
  return Find(status, **mesh, features, all);
}

int ReportRefusals(const absl::Status& first, const Input& input, const RefusalWishes& wishes) {
  const int code = ReportError(Locate(first, input.where));
  const std::optional<ErrorDetail> detail = GetErrorDetail(first);
  if (!detail || detail->features.empty()) return code;
  absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = DynamicMesh::Create(input.options);
  if (!mesh.ok()) return code;
  const Refusals refusals = Find(first, **mesh, input.features, wishes.all);
  for (std::size_t i = 1; i < refusals.first.size(); ++i) {
    ReportError(Locate(refusals.first[i], input.where));
  }
  if (wishes.mended_within) {
    PrintWarning(Concat("mending within ", static_cast<float>(*wishes.mended_within),
                        " does not help; --within allows more"));
  } else if (!wishes.is_refined) {
    AdviseCleaning(refusals, wishes.mending);
  }
  if (refusals.count > 1) {
    std::string rest;
    if (!refusals.is_complete && !wishes.all) {
      rest = ": the search ended there, --all looks on";
    } else if (refusals.count > kMostTold) {
      rest = Concat(", the first ", kMostTold, " told");
    }
    PrintWarning(
        Concat(refusals.is_complete ? "" : "at least ", refusals.count, " refusals", rest));
  }
  if (input.options.dimension == 3 && !wishes.is_merged && !wishes.is_refined) {
    AdviseMerging(input, **mesh);
  }
  return code;
}

int ReportTooLarge(const absl::Status& error, const Input& input, const std::string& why) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(error);
  const std::optional<FinestGap> gap = FindFinestGap(input.features, input.options);
  absl::Status told = Locate(error, input.where);
  if (gap && (!detail || detail->features.empty())) {
    told = absl::Status(error.code(), Concat(text::View(error.message()), "; ",
                                             TextOf(*gap, input.options.dimension, input.where)));
  }
  const int code = ReportError(told);
  if (gap) PrintWarning(AdviceFor(*gap));
  if (detail && detail->reason == reason::kVertexLimit && !why.empty()) {
    PrintWarning(Concat("max_vertices = ", input.options.limits.max_vertices, " is ", why));
  }
  return code;
}

}  // namespace dynmesh::cli
