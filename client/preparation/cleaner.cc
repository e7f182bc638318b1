#include "client/preparation/cleaner.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "client/cleaning/clean_input.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/preparation/farthest.h"
#include "client/preparation/open_edges.h"
#include "core/base/feature_kinds.h"
#include "core/base/rounding.h"
#include "core/base/text.h"
#include "core/io/formats/prepare_surface.h"
#include "dynmesh/options.h"

namespace dynmesh::preparation {
namespace {

using io::Geometry;
using text::Concat;

// Tolerances beyond the default of cleaning, in units of D.
constexpr double kSharesOfWithin[] = {1e-3, 1e-2, 1e-1, 0.5, 1};
// Joining moves corners by a few roundings of the file's numbers, and must not make new contacts.
constexpr double kRoundings = 32;
// Distances are told up to a factor of 2, from this share of the tolerance on.
constexpr double kLeastBound = 1.0 / 16;

template <class Kind, class Change>
void AddChanges(const std::vector<Change>& changes, int kinds, Report& report) {
  std::vector<std::size_t> counts(static_cast<std::size_t>(kinds));
  for (const Change& change : changes) ++counts[static_cast<std::size_t>(change.kind)];
  for (int k = 0; k < kinds; ++k) {
    report.Add(NameOf(static_cast<Kind>(k)), counts[static_cast<std::size_t>(k)]);
  }
}

bool HasEdges(const std::vector<Feature>& features) {
  return std::ranges::any_of(
      features, [](const Feature& f) { return Is<ASegment, APolygon>(f, Not<APoint, ASize>); });
}

// What cleaning begins with: the tolerance of `import --clean`, or some roundings of a surface
// file's numbers if that is more.
double LeastTolerance(const Geometry& geometry, double within) {
  const int dimension = geometry.options.dimension;
  const double limits =
      dimension == 2 ? cleaning::kDefaultCloseLimits : cleaning::kDefaultSurfaceLimits;
  const double rounding = geometry.rounding.Of(LargestMagnitude(geometry.options.box, dimension));
  return std::max(limits * LeastDistance(geometry.options),
                  std::min(kRoundings * rounding, within / 2));
}

std::shared_ptr<const io::FeatureLabels> WithoutAttributes(const io::FeatureLabels& given) {
  auto labels = std::make_shared<io::FeatureLabels>(given);
  labels->attributes = 0;
  labels->values.clear();
  return labels;
}

}  // namespace

Cleaner::Cleaner(Geometry raw, const io::GeometryOptions& reading, bool is_surface, bool is_closed,
                 double within)
    : raw_(std::move(raw)),
      reading_(reading),
      is_surface_(is_surface),
      is_closed_(is_closed),
      within_(within) {
  raw_.warnings.clear();
  raw_.verdict.reset();
  raw_.labels = WithoutAttributes(*raw_.labels);
}

absl::StatusOr<Prepared> Cleaner::Clean(const Cleaning& how, bool is_open_no_use) const {
  Prepared prepared = {raw_, {}};
  Report& report = prepared.report;
  report.is_mended = true;
  report.within = within_;
  std::vector<FeatureId> doubled;
  const absl::Status status = raw_.options.dimension == 2 ? CleanPlane(how.tolerance, prepared)
                                                          : CleanSpace(how, doubled, prepared);
  if (!status.ok()) return status;
  std::vector<Feature>& features = prepared.geometry.features;
  if (HasEdges(raw_.features) && !HasEdges(features)) {
    return absl::NotFoundError(
        Concat("nothing is left: 0 polygons and 0 segments; none has an area or a length of ",
               static_cast<float>(how.tolerance)));
  }
  std::vector<Feature> with_flaps;
  std::size_t flaps = 0;
  if (is_closed_ && !doubled.empty()) {
    with_flaps = features;
    flaps = DropFlaps(doubled, features);
  }
  if (is_open_no_use && !OpenEdgesOf(features).empty()) {
    return absl::FailedPreconditionError("edges are open");
  }
  std::optional<double> farthest = FarthestOf(prepared);
  if (!farthest && flaps != 0) {
    features = std::move(with_flaps);
    flaps = 0;
    farthest = FarthestOf(prepared);
  }
  if (!farthest) {
    return absl::OutOfRangeError(Concat("cleaning moves it by more than ", within_));
  }
  report.Add("flap dropped", flaps);
  report.farthest = *farthest;
  if (is_surface_) {
    prepared.geometry.surface = io::JoinFacesInOnePlane(reading_, prepared.geometry);
    report.Add("face joined", prepared.geometry.surface->joined);
  }
  if (raw_.options.dimension == 3) report.open_edges_after = OpenEdgesOf(features).size();
  return prepared;
}

std::uint64_t Cleaner::Steps() const { return cleaning::DefaultSteps(raw_.features.size()); }

std::vector<double> Cleaner::Tolerances() const {
  std::vector<double> tolerances = {LeastTolerance(raw_, within_)};
  for (const double share : kSharesOfWithin) {
    if (share * within_ > tolerances.back()) tolerances.push_back(share * within_);
  }
  return tolerances;
}

std::optional<double> Cleaner::FarthestOf(const Prepared& prepared) const {
  const int dimension = raw_.options.dimension;
  const std::vector<Feature>& result = prepared.geometry.features;
  const double least = std::min(kLeastBound * prepared.report.tolerance, within_);
  const auto there = FarthestBound(result, raw_.features, dimension, least, within_);
  // In 2D edges that are there and back are dropped, as they enclose nothing.
  if (!there || dimension == 2) return there;
  const auto back = FarthestBound(raw_.features, result, dimension, least, within_);
  if (!back) return back;
  return std::max(*there, *back);
}

absl::Status Cleaner::CleanPlane(double tolerance, Prepared& prepared) const {
  cleaning::CleanOptions options;
  options.tolerance = tolerance;
  absl::StatusOr<cleaning::CleanResult> cleaned = cleaning::CleanInput(raw_.features, options);
  if (!cleaned.ok()) return cleaned.status();
  prepared.geometry.features = std::move(cleaned->features);
  io::KeepPlacesOfParts(PartsOf(prepared.geometry.features), prepared.geometry);
  prepared.report.tolerance = tolerance;
  AddChanges<cleaning::ChangeKind>(cleaned->changes, cleaning::kChangeKinds, prepared.report);
  return absl::OkStatus();
}

absl::Status Cleaner::CleanSpace(const Cleaning& how, std::vector<FeatureId>& doubled,
                                 Prepared& prepared) const {
  cleaning::SurfaceCleanOptions options;
  options.tolerance = how.tolerance;
  options.least_angle = how.least_angle;
  options.most_contraction = how.most_contraction;
  options.max_steps = how.steps;
  while (options.first_doublings > 0 &&
         std::ldexp(how.tolerance, options.first_doublings) > within_ / 2) {
    --options.first_doublings;
  }
  options.holes = !is_surface_;
  absl::StatusOr<cleaning::SurfaceCleanResult> cleaned =
      cleaning::CleanSurfaces(raw_.features, options);
  if (!cleaned.ok()) return cleaned.status();
  prepared.geometry.features = std::move(cleaned->features);
  io::KeepPlacesOfParts(cleaned->parts, prepared.geometry);
  prepared.report.tolerance = cleaned->tolerance;
  doubled = std::move(cleaned->doubled);
  AddChanges<cleaning::SurfaceChangeKind>(cleaned->changes, cleaning::kSurfaceChangeKinds,
                                          prepared.report);
  return absl::OkStatus();
}

std::vector<std::pair<FeatureId, FeatureId>> Cleaner::PartsOf(
    const std::vector<Feature>& features) const {
  FeatureId last = 0, whole = 0;
  for (const Feature& f : raw_.features) last = std::max(last, f.id);
  std::vector<std::pair<FeatureId, FeatureId>> parts;
  for (const Feature& f : features) {
    if (!Is<ASegment>(f, Not<APoint, APolygon, ASize>)) continue;
    if (f.id <= last) {
      whole = f.id;
    } else {
      parts.emplace_back(f.id, whole);
    }
  }
  return parts;
}

}  // namespace dynmesh::preparation
