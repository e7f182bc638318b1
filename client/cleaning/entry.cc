#include "client/cleaning/entry.h"

#include <string>

#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "dynmesh/error.h"

namespace dynmesh::cleaning {
namespace {

using text::Concat;

constexpr double kMinTolerance = 0x1p-41;  // relative to the largest coordinate: 2^11 ulps

absl::Status Refuse(const char* reason, std::vector<FeatureId> ids, std::string message) {
  return MakeError(absl::StatusCode::kInvalidArgument, std::move(message),
                   {reason, std::move(ids), std::nullopt});
}

}  // namespace

absl::StatusOr<FeatureId> CheckFeatures(const std::vector<Feature>& features, double tolerance,
                                        const EntryLimits& limits) {
  const double most = std::ldexp(1, limits.max_exponent);
  absl::flat_hash_map<FeatureId, const Feature*> known;
  FeatureId max_id = 0;
  double magnitude = 0;
  for (const Feature& f : features) {
    if (f.id == kNoFeature || f.id > limits.max_id) {
      return Refuse(reason::kBadId, {f.id},
                    Concat("feature ", f.id, ": ids run from 1 to ", limits.max_id, " here"));
    }
    if (!known.emplace(f.id, &f).second) {
      return Refuse(reason::kIdInUse, {f.id}, Concat("feature ", f.id, " stands twice"));
    }
    max_id = std::max(max_id, f.id);
    if (!IsPoint(f)) continue;
    for (std::size_t i = 0; i < limits.dimension; ++i) {
      const double x = std::abs(f.position[i]);
      if (!(x <= most)) {
        return Refuse(reason::kNotFinite, {f.id},
                      Concat("point ", f.id, " has a coordinate that is not finite or above 2^",
                             limits.max_exponent));
      }
      magnitude = std::max(magnitude, x);
    }
  }
  const auto is_point = [&known](FeatureId id) {
    const auto it = known.find(id);
    return it != known.end() && IsPoint(*it->second);
  };
  for (const Feature& f : features) {
    if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
    for (const FeatureId end : f.ends) {
      if (is_point(end)) continue;
      return Refuse(reason::kUnknownEnd, {f.id, end},
                    Concat("segment ", f.id, " ends at ", end, ", which is no point; add it"));
    }
  }
  for (const Feature& f : features) {
    for (const auto& ring : f.rings) {
      for (const FeatureId corner : ring) {
        if (is_point(corner)) continue;
        return Refuse(
            reason::kUnknownEnd, {f.id, corner},
            Concat("polygon ", f.id, " has the corner ", corner, ", which is no point; add it"));
      }
    }
  }
  if (!(tolerance > 0 && tolerance <= most && tolerance >= kMinTolerance * magnitude)) {
    return absl::InvalidArgumentError(
        Concat("the tolerance ", tolerance, " is not between ", kMinTolerance * magnitude,
               " (2^-41 of the largest coordinate) and 2^", limits.max_exponent));
  }
  return max_id;
}

}  // namespace dynmesh::cleaning
