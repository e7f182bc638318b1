#include "client/preparation/prepare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cleaning/clean_input.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/preparation/default_limit.h"
#include "client/preparation/farthest.h"
#include "client/preparation/open_edges.h"
#include "core/base/feature_kinds.h"
#include "core/base/rounding.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/prepare_surface.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::preparation {
namespace {

using io::Geometry;
using text::Concat;

// Tolerances of cleaning beyond its default, in units of D.
constexpr double kSharesOfWithin[] = {1e-3, 1e-2, 1e-1, 0.5, 1};
// Joining moves corners by a few roundings of the file's numbers, and must not make new contacts.
constexpr double kRoundings = 32;
// In degrees. What meets at a lesser angle becomes one, in a surface that a mesh refuses for an
// angle: twice what it takes at a corner.
constexpr double kLeastAngle = 0.002;
// Open loops that are told one by one.
constexpr std::size_t kLoopsTold = 5;
// Distances are told up to a factor of 2, from this share of the tolerance on.
constexpr double kLeastBound = 1.0 / 16;

double DiagonalOf(const std::vector<Feature>& features, int dimension) {
  const Box box = io::BoundingBox(features, dimension);
  double sum = 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(dimension); ++k) {
    sum += (box.hi[k] - box.lo[k]) * (box.hi[k] - box.lo[k]);
  }
  return std::sqrt(sum);
}

// In 2D, gaps that take more vertices than this, or that for each feature, are too fine to be
// meant.
constexpr std::uint64_t kVerticesOfGaps = 200'000, kVerticesOfGapsForFeature = 100;

// Are there two points within `distance` of each other in x, or anything but points?
// Points without such a pair are surely accepted, and that is found out sooner than by a mesh.
bool MayBeRefused(const std::vector<Feature>& features, double distance) {
  std::vector<double> xs;
  for (const Feature& f : features) {
    if (!IsPoint(f)) return true;
    xs.push_back(f.position[0]);
  }
  std::ranges::sort(xs);
  for (std::size_t i = 1; i < xs.size(); ++i) {
    if (!(xs[i] - xs[i - 1] > distance)) return true;
  }
  return xs.empty();
}

// OK if a mesh accepts it, and gaps do not take too many vertices, as far as that is known before.
absl::Status Refusal(const Geometry& geometry) {
  MeshOptions options = geometry.options;
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (!MayBeRefused(geometry.features, LeastDistance(options))) return absl::OkStatus();
  options.limits.max_vertices =
      options.dimension == 2
          ? std::max(kVerticesOfGaps, kVerticesOfGapsForFeature * geometry.features.size())
          : DefaultMostVertices(geometry.features, options);
  const auto mesh = DynamicMesh::Create(options);
  return mesh.ok() ? (*mesh)->Validate(AddAll(geometry.features)) : mesh.status();
}

// A refusal that names features, or is for the size of the mesh. Others are of the options.
bool IsOfFeatures(const absl::Status& refusal) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(refusal);
  return detail && (!detail->features.empty() || detail->reason == reason::kVertexLimit);
}

bool IsOfAngle(const absl::Status& refusal) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(refusal);
  return detail && detail->reason == reason::kSmallAngle;
}

// ---- what was done

template <class Kind, class Change>
void AddChanges(const std::vector<Change>& changes, int kinds, Report& report) {
  std::vector<std::size_t> counts(static_cast<std::size_t>(kinds));
  for (const Change& change : changes) ++counts[static_cast<std::size_t>(change.kind)];
  for (int k = 0; k < kinds; ++k) {
    const std::size_t count = counts[static_cast<std::size_t>(k)];
    if (count != 0) report.changes.emplace_back(NameOf(static_cast<Kind>(k)), count);
  }
}

void AddCount(const char* what, std::size_t count, Report& report) {
  if (count != 0) report.changes.emplace_back(what, count);
}

// ---- one tolerance

bool HasEdges(const std::vector<Feature>& features) {
  return std::ranges::any_of(
      features, [](const Feature& f) { return Is<ASegment, APolygon>(f, Not<APoint, ASize>); });
}

// The geometry that a file has, as it is to be cleaned.
class Cleaner {
 public:
  // `is_closed`: the input has no open edges.
  Cleaner(Geometry raw, const io::GeometryOptions& reading, bool is_surface, bool is_closed,
          double within)
      : raw_(std::move(raw)),
        reading_(reading),
        is_surface_(is_surface),
        is_closed_(is_closed),
        within_(within) {
    raw_.warnings.clear();
    DropAttributes();
  }

  // What cleaning with the tolerance makes; in 3D what meets at less than `least_angle` degrees
  // becomes one. RESOURCE_EXHAUSTED and INVALID_ARGUMENT as cleaning;
  // OUT_OF_RANGE if it is too far from the input; NOT_FOUND if nothing is left.
  absl::StatusOr<Prepared> Clean(double tolerance, double least_angle, std::uint64_t steps) const {
    Prepared prepared = {raw_, {}};
    Report& report = prepared.report;
    report.is_mended = true;
    report.within = within_;
    std::vector<FeatureId> doubled;
    const absl::Status status = raw_.options.dimension == 2
                                    ? CleanPlane(tolerance, prepared)
                                    : CleanSpace(tolerance, least_angle, steps, doubled, prepared);
    if (!status.ok()) return status;
    if (HasEdges(raw_.features) && !HasEdges(prepared.geometry.features)) {
      return absl::NotFoundError(
          Concat("nothing is left: 0 polygons and 0 segments; none has an area or a length of ",
                 static_cast<float>(tolerance)));
    }
    const int dimension = raw_.options.dimension;
    std::vector<Feature> with_flaps;
    std::size_t flaps = 0;
    if (is_closed_ && !doubled.empty()) {
      with_flaps = prepared.geometry.features;
      flaps = DropFlaps(doubled, prepared.geometry.features);
    }
    std::optional<double> farthest = FarthestOf(prepared);
    if (!farthest && flaps != 0) {
      prepared.geometry.features = std::move(with_flaps);
      flaps = 0;
      farthest = FarthestOf(prepared);
    }
    if (!farthest) return TooFar();
    AddCount("flap dropped", flaps, report);
    report.farthest = *farthest;
    if (is_surface_) {
      const io::SurfaceCounts counts = io::JoinFacesInOnePlane(reading_, prepared.geometry);
      prepared.geometry.surface = counts;
      prepared.geometry.options.box = io::BoundingBox(prepared.geometry.features, dimension);
      AddCount("face joined", counts.joined, report);
    }
    if (dimension == 3) {
      report.open_edges_after = OpenEdgesOf(prepared.geometry.features).size();
    }
    return prepared;
  }

  // Of cleaning in 3D, for one tolerance.
  std::uint64_t Steps() const { return cleaning::DefaultSteps(raw_.features.size()); }

  // Those to be tried, ascending.
  std::vector<double> Tolerances() const {
    const int dimension = raw_.options.dimension;
    const double limits =
        dimension == 2 ? cleaning::kDefaultCloseLimits : cleaning::kDefaultSurfaceLimits;
    const double rounding = raw_.rounding.Of(LargestMagnitude(raw_.options.box, dimension));
    std::vector<double> tolerances = {std::max(limits * LeastDistance(raw_.options),
                                               std::min(kRoundings * rounding, within_ / 2))};
    for (const double share : kSharesOfWithin) {
      if (share * within_ > tolerances.back()) tolerances.push_back(share * within_);
    }
    return tolerances;
  }

 private:
  // A bound of how far the result and the input are from each other; nothing if it is too much.
  std::optional<double> FarthestOf(const Prepared& prepared) const {
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

  absl::Status TooFar() const {
    return absl::OutOfRangeError(Concat("cleaning moves it by more than ", within_));
  }

  void DropAttributes() {
    auto labels = std::make_shared<io::FeatureLabels>(*raw_.labels);
    labels->attributes = 0;
    labels->values.clear();
    raw_.labels = std::move(labels);
  }

  absl::Status CleanPlane(double tolerance, Prepared& prepared) const {
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

  absl::Status CleanSpace(double tolerance, double least_angle, std::uint64_t steps,
                          std::vector<FeatureId>& doubled, Prepared& prepared) const {
    cleaning::SurfaceCleanOptions options;
    options.tolerance = tolerance;
    options.least_angle = least_angle;
    options.max_steps = steps;
    while (options.first_doublings > 0 &&
           std::ldexp(tolerance, options.first_doublings) > within_ / 2) {
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

  // New segments follow the one that they are a part of.
  std::vector<std::pair<FeatureId, FeatureId>> PartsOf(const std::vector<Feature>& features) const {
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

  Geometry raw_;
  const io::GeometryOptions& reading_;
  bool is_surface_, is_closed_;
  double within_;
};

// What a mesh refuses of what was read, and its open edges. Returns whether these may be closed.
bool Describe(const Geometry& geometry, double within, Report& report) {
  report.found = Refusal(geometry);
  report.within = within;
  AddCount("ring closed", geometry.mended.closed, report);
  AddCount("ring dropped", geometry.mended.dropped, report);
  if (geometry.options.dimension != 3) return false;
  const std::vector<OpenEdge> open = OpenEdgesOf(geometry.features);
  report.open_edges = report.open_edges_after = open.size();
  return !open.empty() && MayBeClosed(open, within);
}

// The result of the least tolerance that a mesh accepts; if open edges are `to_close`, that of the
// least one that closes them, if there is one. NOT_FOUND if the least tolerance leaves nothing.
absl::StatusOr<std::optional<Prepared>> Mend(const Cleaner& cleaner, const Report& as_read,
                                             bool to_close) {
  std::optional<Prepared> best;
  const std::vector<double> tolerances = cleaner.Tolerances();
  // Halved after each tolerance that takes them all: twice as many are enough for all tolerances.
  std::uint64_t steps = cleaner.Steps();
  for (const double tolerance : tolerances) {
    absl::StatusOr<Prepared> cleaned = cleaner.Clean(tolerance, 0, steps);
    absl::Status refusal = cleaned.ok() ? Refusal(cleaned->geometry) : absl::OkStatus();
    if (IsOfAngle(refusal)) {
      cleaned = cleaner.Clean(tolerance, kLeastAngle, steps);
      if (cleaned.ok()) refusal = Refusal(cleaned->geometry);
    }
    if (absl::IsNotFound(cleaned.status()) && tolerance == tolerances.front()) {
      return cleaned.status();
    }
    if (absl::IsNotFound(cleaned.status())) break;
    if (absl::IsResourceExhausted(cleaned.status())) steps = std::max<std::uint64_t>(steps / 2, 1);
    if (!cleaned.ok() || !refusal.ok()) continue;
    cleaned->report.found = as_read.found;
    cleaned->report.open_edges = as_read.open_edges;
    const bool is_closed = cleaned->report.open_edges_after == 0;
    if (is_closed || (!best && !as_read.found.ok())) best = *std::move(cleaned);
    if (best && (is_closed || !to_close)) break;
  }
  return best;
}

// `prepared` with its holes filled, if a mesh accepts that; else as it is.
void Fill(double longest, const io::GeometryOptions& reading, Prepared& prepared) {
  Geometry filled = prepared.geometry;
  const std::size_t count = FillLoops(longest, filled.features);
  if (count == 0) return;
  Report& report = prepared.report;
  report.unfilled = Refusal(filled);
  if (IsOfFeatures(report.unfilled)) {
    // Its polygons may have several rings: they are cleaned as those of a file of facets.
    const Cleaner cleaner(filled, reading, /*is_surface=*/false, /*is_closed=*/false,
                          report.within - report.farthest);
    absl::StatusOr<std::optional<Prepared>> mended = Mend(cleaner, report, /*to_close=*/false);
    if (!mended.ok() || !*mended) return;
    filled = std::move((*mended)->geometry);
    report.farthest += (*mended)->report.farthest;
    report.tolerance = std::max(report.tolerance, (*mended)->report.tolerance);
    for (const auto& change : (*mended)->report.changes) report.changes.push_back(change);
    report.unfilled = absl::OkStatus();
  }
  if (!report.unfilled.ok()) return;
  prepared.geometry = std::move(filled);
  report.is_mended = true;
  report.open_edges_after = OpenEdgesOf(prepared.geometry.features).size();
  AddCount("hole filled", count, report);
}

absl::Status CheckLength(const char* flag, const std::optional<double>& length) {
  if (!length || (*length > 0 && std::isfinite(*length))) return absl::OkStatus();
  return absl::InvalidArgumentError(Concat(flag, ": it must be above 0, found ", *length));
}

}  // namespace

bool MayBePrepared(const std::string& path, const PrepareOptions& options) {
  if (options.within || options.fill_holes) return true;
  const io::Format* const format = io::FindFormat(path);
  if (format == nullptr) return false;
  if (format->Is(io::kSurface) || format->Is(io::kMap)) return true;
  return format->extension == ".poly" || format->extension == ".node";
}

absl::StatusOr<Prepared> Prepare(const std::string& path, const io::GeometryOptions& reading,
                                 const PrepareOptions& options) {
  for (const auto& [flag, length] :
       {std::pair("--within", options.within), {"--fill-holes", options.fill_holes}}) {
    if (absl::Status status = CheckLength(flag, length); !status.ok()) return status;
  }
  const auto start = std::chrono::steady_clock::now();
  const auto finish = [&](Prepared prepared) {
    if (options.fill_holes && prepared.report.open_edges_after != 0) {
      Fill(*options.fill_holes, reading, prepared);
    }
    if (prepared.report.open_edges_after != 0) {
      prepared.report.open_loops = OpenLoopsOf(prepared.geometry.features);
    }
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    prepared.report.seconds = seconds.count();
    return prepared;
  };
  const auto within_of = [&](const Geometry& geometry) {
    return options.within.value_or(kDefaultWithin *
                                   DiagonalOf(geometry.features, geometry.options.dimension));
  };
  io::GeometryOptions how = reading;
  const bool may_be = MayBePrepared(path, options);
  if (may_be) how.mend_rings = true;
  absl::StatusOr<Geometry> given = io::ReadGeometry(path, how);
  if (!may_be) {
    if (!given.ok()) return given.status();
    return Prepared{*std::move(given), {}};
  }
  const io::Format* const format = io::FindFormat(path);  // null: a script of any extension
  const bool is_surface = format != nullptr && format->Is(io::kSurface);
  const absl::Status unread = given.status();
  const bool given_ok = given.ok();
  Prepared as_read;
  bool to_close = false;
  if (given.ok()) {
    as_read.geometry = *std::move(given);
    const Geometry& geometry = as_read.geometry;
    const bool in_space = geometry.options.dimension == 3;
    if (in_space && !is_surface && !options.within && !options.fill_holes) return as_read;
    const double within = within_of(geometry);
    to_close = Describe(geometry, within, as_read.report);
    const absl::Status& found = as_read.report.found;
    if (found.ok() ? !to_close : !IsOfFeatures(found)) return finish(std::move(as_read));
  } else {
    as_read.report.found = unread;
  }
  how.faces = io::FaceRules::kAsTheyCome;
  absl::StatusOr<Geometry> raw = io::ReadGeometry(path, how);
  if (raw.ok() && within_of(*raw) > 0 && ValidateOptions(raw->options).ok()) {
    const double within = within_of(*raw);
    const bool is_closed = given_ok && as_read.report.open_edges == 0;
    const Cleaner cleaner(*std::move(raw), reading, is_surface, is_closed, within);
    absl::StatusOr<std::optional<Prepared>> mended = Mend(cleaner, as_read.report, to_close);
    if (!mended.ok()) {
      return absl::InvalidArgumentError(Concat(path, ": ", text::View(mended.status().message())));
    }
    if (*mended) return finish(**std::move(mended));
  }
  if (!unread.ok()) return unread;
  return finish(std::move(as_read));
}

std::string TextOf(const Report& report) {
  std::string text;
  for (const auto& [what, count] : report.changes) {
    text += Concat(text.empty() ? "" : ", ", count, " x ", what);
  }
  if (report.is_mended) {
    text += absl::StrFormat("; at most %.2g from the input, tolerance %.2g", report.farthest,
                            report.tolerance);
  }
  return text;
}

std::string TextOfLoops(const Report& report) {
  if (report.open_loops.empty()) return "";
  const std::size_t count = report.open_loops.size();
  std::string text = Concat(count, count == 1 ? " loop" : " loops", " of edges with one face: ");
  const std::size_t told = std::min(count, kLoopsTold);
  for (std::size_t i = 0; i < told; ++i) {
    const OpenLoop& loop = report.open_loops[i];
    text += absl::StrFormat("%s%d edges, %.4g long, round (%.4g, %.4g, %.4g)", i == 0 ? "" : "; ",
                            loop.corners.size(), loop.length, loop.middle[0], loop.middle[1],
                            loop.middle[2]);
  }
  if (told < count) {
    text += absl::StrFormat("; others up to %.4g long", report.open_loops.back().length);
  }
  if (!report.unfilled.ok()) {
    return Concat(text, ". Filled, a mesh refuses it: ", text::View(report.unfilled.message()));
  }
  return text + ". --fill-holes LENGTH fills those up to LENGTH";
}

}  // namespace dynmesh::preparation
