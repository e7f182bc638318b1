#include "client/cli/refusals.h"

#include <algorithm>
#include <optional>

#include "absl/container/flat_hash_map.h"
#include "absl/container/flat_hash_set.h"
#include "client/cli/command.h"
#include "core/base/text.h"
#include "core/coplanar/merge_coplanar.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

constexpr std::size_t kMostTold = 10;
// Features validated for the count, all rounds together.
constexpr std::size_t kMostWork = 5'000'000;

// Leaves out what a refusal blames.
class Remaining {
 public:
  explicit Remaining(std::vector<Feature> features) : features_(std::move(features)) {}

  const std::vector<Feature>& features() const { return features_; }

  // Leaves out the blamed feature that fewest others need: the last one, not a point if there is
  // another. False if there is none.
  bool LeaveOut(const std::vector<FeatureId>& blamed) {
    absl::flat_hash_map<FeatureId, FeatureKind> kind_of;
    for (const Feature& f : features_) kind_of[f.id] = f.kind;
    std::optional<FeatureId> victim;
    for (const FeatureId id : blamed) {
      const auto kind = kind_of.find(id);
      if (kind == kind_of.end()) continue;
      if (!victim || kind->second != FeatureKind::kPoint ||
          kind_of[*victim] == FeatureKind::kPoint) {
        victim = id;
      }
    }
    if (!victim) return false;
    const auto names = [&](const Feature& f) {
      if (f.id == *victim) return true;
      if (f.kind == FeatureKind::kSegment && std::ranges::count(f.ends, *victim) != 0) return true;
      return std::ranges::any_of(
          f.rings, [&](const auto& ring) { return std::ranges::count(ring, *victim) != 0; });
    };
    std::erase_if(features_, names);
    return true;
  }

 private:
  std::vector<Feature> features_;
};

Refusals Find(absl::Status status, const DynamicMesh& mesh, const std::vector<Feature>& features,
              std::size_t most_work) {
  Refusals refusals;
  Remaining remaining(features);
  std::size_t work = 0;
  while (!status.ok()) {
    const std::optional<ErrorDetail> found = GetErrorDetail(status);
    ++refusals.count;
    ++refusals.by_reason[found ? found->reason : "OTHER"];
    if (refusals.count <= kMostTold) refusals.first.push_back(status);
    refusals.is_complete = false;
    if (work >= most_work || !found || !remaining.LeaveOut(found->features)) break;
    work += remaining.features().size() + 1;
    status = mesh.Validate(AddAll(remaining.features()));
    refusals.is_complete = status.ok();
  }
  return refusals;
}

std::size_t CountPolygons(const std::vector<Feature>& features) {
  return static_cast<std::size_t>(
      std::ranges::count(features, FeatureKind::kPolygon, &Feature::kind));
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

// Of what `import --clean` mends.
void AdviseCleaning(const Refusals& refusals) {
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
  PrintWarning(
      Concat("`dynmesh import INPUT --clean -o CLEAN.poly` mends what crosses, overlaps, "
             "touches or is there twice (here ",
             count, ")"));
}

}  // namespace

Refusals FindRefusals(const std::vector<Feature>& features, const MeshOptions& options,
                      std::size_t most_work) {
  const absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = DynamicMesh::Create(options);
  const absl::Status status = mesh.ok() ? (*mesh)->Validate(AddAll(features)) : mesh.status();
  if (status.ok()) return {};
  if (!mesh.ok()) return {1, {{"OTHER", 1}}, {status}, true};
  return Find(status, **mesh, features, most_work);
}

int ReportRefusals(const absl::Status& first, const Input& input, bool is_merged, bool is_refined) {
  const int code = ReportError(Locate(first, input.where));
  const std::optional<ErrorDetail> detail = GetErrorDetail(first);
  if (!detail || detail->features.empty()) return code;
  absl::StatusOr<std::unique_ptr<DynamicMesh>> mesh = DynamicMesh::Create(input.options);
  if (!mesh.ok()) return code;
  const Refusals refusals = Find(first, **mesh, input.features, kMostWork);
  for (std::size_t i = 1; i < refusals.first.size(); ++i) {
    ReportError(Locate(refusals.first[i], input.where));
  }
  if (!is_refined) AdviseCleaning(refusals);
  if (refusals.count > 1) {
    PrintWarning(
        Concat(refusals.is_complete ? "" : "at least ", refusals.count, " refusals",
               refusals.count > kMostTold ? Concat(", the first ", kMostTold, " told") : ""));
  }
  if (input.options.dimension == 3 && !is_merged && !is_refined) AdviseMerging(input, **mesh);
  return code;
}

}  // namespace dynmesh::cli
