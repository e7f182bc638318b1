#include "client/preparation/prepare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/cleaning/clean_surfaces.h"
#include "client/preparation/cleaner.h"
#include "client/preparation/default_limit.h"
#include "client/preparation/open_edges.h"
#include "client/preparation/thinning.h"
#include "core/base/feature_kinds.h"
#include "core/base/rounding.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "core/io/formats/prepare_surface.h"
#include "dynmesh/error.h"
#include "dynmesh/valid_features.h"

namespace dynmesh::preparation {
namespace {

using io::Geometry;
using text::Concat;

// In degrees. What meets at a lesser angle becomes one, in a surface that a mesh refuses for an
// angle: twice what it takes at a corner.
constexpr double kLeastAngle = 0.002;
// The same at a common edge of faces, if nothing else helps.
constexpr double kLeastAngleAtEdges = 0.1;
// How long what is contracted may be, in units of D, if cutting alone does not end.
constexpr double kShareOfContractions = 0.25;
// The least tolerances that are tried so: a refusal is not to take much longer than without.
constexpr std::size_t kTolerancesOfContraction = 2;
// Tolerances for what takes too many vertices, in units of D.
constexpr double kSharesOfTooFine[] = {0.1, 0.5, 1};
// Of fewer faces, what does not meet is so far apart, in roundings of the file's numbers: joining
// moves corners by a few of them.
constexpr double kRoundingsApart = 4;
// Open loops that are told one by one.
constexpr std::size_t kLoopsTold = 5;

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

// Are there two points within `distance` of each other in all coordinates, or anything but points?
// Points without such a pair are surely accepted, and that is found out sooner than by a mesh. May
// be true needlessly, if that takes longer than O(n).
bool MayBeRefused(const std::vector<Feature>& features, int dimension, double distance) {
  using Position = std::array<double, 3>;
  const std::size_t n = features.size();
  double lo = std::numeric_limits<double>::infinity(), hi = -lo;
  for (const Feature& f : features) {
    if (!IsPoint(f)) return true;
    lo = std::min(lo, f.position[0]);
    hi = std::max(hi, f.position[0]);
  }
  // By x, in about as many slots as there are points: in order but for those in a slot.
  const double scale = static_cast<double>(n) / (hi - lo);
  if (n == 0 || !std::isfinite(scale)) return true;
  const auto slot_of = [&](double x) {
    return std::min(n - 1, static_cast<std::size_t>((x - lo) * scale));
  };
  std::vector<std::uint32_t> ends(n + 1, 0);
  for (const Feature& f : features) ++ends[slot_of(f.position[0]) + 1];
  std::partial_sum(ends.begin(), ends.end(), ends.begin());
  std::vector<Position> points(n);
  for (const Feature& f : features) points[ends[slot_of(f.position[0])]++] = f.position;
  for (std::size_t slot = 0, begin = 0; slot < n; begin = ends[slot++]) {
    std::sort(points.data() + begin, points.data() + ends[slot]);
  }
  const auto is_near = [&](const Position& p, const Position& q, int k) {
    const auto at = static_cast<std::size_t>(k);
    return !(std::abs(q[at] - p[at]) > distance);
  };
  std::size_t steps = 8 * n;  // that are worth taking
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n && is_near(points[i], points[j], 0); ++j) {
      if (steps-- == 0) return true;
      if (is_near(points[i], points[j], 1) &&
          (dimension == 2 || is_near(points[i], points[j], 2))) {
        return true;
      }
    }
  }
  return false;
}

// OK if a mesh accepts it, and gaps do not take too many vertices, as far as that is known before.
io::Verdict VerdictOn(const std::vector<Feature>& features, MeshOptions options) {
  if (absl::Status status = ValidateOptions(options); !status.ok()) return status;
  if (!MayBeRefused(features, options.dimension, LeastDistance(options))) return nullptr;
  options.limits.max_vertices =
      options.dimension == 2
          ? std::max(kVerticesOfGaps, kVerticesOfGapsForFeature * features.size())
          : DefaultMostVertices(features, options);
  return ValidFeatures::Of(features, options);
}

// What a mesh refuses of it. It may have been asked already, as faces were joined.
absl::Status Refusal(Geometry& geometry) {
  if (!geometry.verdict) geometry.verdict = VerdictOn(geometry.features, geometry.options);
  return geometry.verdict->status();
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

// What a mesh refuses of what was read, and its open edges. Returns whether these may be closed.
bool Describe(Geometry& geometry, double within, Report& report) {
  report.found = Refusal(geometry);
  report.within = within;
  report.Add("ring closed", geometry.mended.closed);
  report.Add("ring dropped", geometry.mended.dropped);
  if (geometry.options.dimension != 3) return false;
  const std::vector<OpenEdge> open = OpenEdgesOf(geometry.features);
  report.open_edges = report.open_edges_after = open.size();
  return !open.empty() && MayBeClosed(open, within);
}

// The result of the least tolerance that a mesh accepts; if open edges are `to_close`, that of the
// least one that closes them, if there is one. NOT_FOUND if the least tolerance leaves nothing.
// `sharp` gets those after which a mesh refused it for an angle.
absl::StatusOr<std::optional<Prepared>> Mend(const Cleaner& cleaner, const Report& as_read,
                                             bool to_close, const std::vector<double>& tolerances,
                                             Cleaning how, std::vector<double>& sharp) {
  std::optional<Prepared> best;
  const double least_angle = std::exchange(how.least_angle, 0);
  // Halved after each tolerance that takes them all: twice as many are enough for all tolerances.
  const bool is_contracting = how.most_contraction > 0;
  // Rounds of contraction cut more for each comparison: fewer steps, and none are halved.
  how.steps = is_contracting ? cleaner.Steps() * 2 / 5 : cleaner.Steps();
  for (const double tolerance : tolerances) {
    const bool is_open_no_use = to_close && (best || as_read.found.ok());
    how.tolerance = tolerance;
    how.least_angle = 0;
    absl::StatusOr<Prepared> cleaned = cleaner.Clean(how, is_open_no_use);
    absl::Status refusal = cleaned.ok() ? Refusal(cleaned->geometry) : absl::OkStatus();
    if (IsOfAngle(refusal)) {
      how.least_angle = least_angle;
      cleaned = cleaner.Clean(how, is_open_no_use);
      if (cleaned.ok()) refusal = Refusal(cleaned->geometry);
      if (IsOfAngle(refusal)) sharp.push_back(tolerance);
    }
    if (absl::IsNotFound(cleaned.status()) && tolerance == tolerances.front()) {
      return cleaned.status();
    }
    if (absl::IsNotFound(cleaned.status())) break;
    if (absl::IsResourceExhausted(cleaned.status()) && !is_contracting) {
      how.steps = std::max<std::uint64_t>(how.steps / 2, 1);
    }
    if (!cleaned.ok() || !refusal.ok()) continue;
    cleaned->report.found = as_read.found;
    cleaned->report.open_edges = as_read.open_edges;
    const bool is_closed = cleaned->report.open_edges_after == 0;
    if (is_closed || (!best && !as_read.found.ok())) best = *std::move(cleaned);
    if (best && (is_closed || !to_close)) break;
  }
  return best;
}

// The same, of no tolerance below the `least`. Where that does not help, and a mesh refuses results
// for an angle, what meets at a larger one becomes one, too; at last short edges of needles are
// contracted.
absl::StatusOr<std::optional<Prepared>> Mend(const Cleaner& cleaner, const Report& as_read,
                                             bool to_close, double least) {
  std::vector<double> tolerances = cleaner.Tolerances(), sharp, still_sharp;
  std::erase_if(tolerances, [&](double tolerance) { return tolerance < least; });
  auto mended = Mend(cleaner, as_read, to_close, tolerances, {.least_angle = kLeastAngle}, sharp);
  if (mended.ok() && !*mended && !sharp.empty()) {
    mended =
        Mend(cleaner, as_read, to_close, sharp, {.least_angle = kLeastAngleAtEdges}, still_sharp);
  }
  // A file that a mesh accepts, or that is no surface of 3D, has no crossing needles.
  if (!mended.ok() || *mended || as_read.found.ok() || !cleaner.is_in_space()) return mended;
  if (tolerances.size() > kTolerancesOfContraction) tolerances.resize(kTolerancesOfContraction);
  const double most = kShareOfContractions * as_read.within;
  return Mend(cleaner, as_read, to_close, tolerances,
              {.least_angle = kLeastAngle, .most_contraction = most}, still_sharp);
}

// `prepared` with fewer faces, at most `within` from what it was, if there are fewer, and a mesh
// accepts that; else as it is.
void Thin(double within, const io::GeometryOptions& reading, Prepared& prepared) {
  if (!(within > 0)) return;
  Report& report = prepared.report;
  const MeshOptions& mesh = prepared.geometry.options;
  const double rounding = prepared.geometry.rounding.Of(LargestMagnitude(mesh.box, 3));
  const double tolerance = std::max(cleaning::kDefaultSurfaceLimits * LeastDistance(mesh),
                                    std::min(kRoundingsApart * rounding, within / 8));
  Geometry thinned = prepared.geometry;
  const ThinningCounts counts = DropCorners(within, tolerance, thinned);
  if (counts.dropped == 0) return;
  io::JoinFacesInOnePlane(reading, thinned);
  if (!Refusal(thinned).ok()) return;
  prepared.geometry = std::move(thinned);
  report.is_thinned = true;
  report.triangles_read = counts.before;
  report.triangles = counts.after;
  report.farthest = std::min(report.farthest + within, report.within);
  report.tolerance = std::max(report.tolerance, tolerance);
  if (report.open_edges_after != 0) {
    report.open_edges_after = OpenEdgesOf(prepared.geometry.features).size();
  }
  report.Add("point dropped", counts.dropped);
}

// `prepared` with its holes filled, if a mesh accepts that; else as it is.
void Fill(double longest, const io::GeometryOptions& reading, Prepared& prepared) {
  Geometry filled = prepared.geometry;
  filled.verdict.reset();
  const std::size_t count = FillLoops(longest, filled.features);
  if (count == 0) return;
  Report& report = prepared.report;
  report.unfilled = Refusal(filled);
  if (IsOfFeatures(report.unfilled)) {
    // Its polygons may have several rings: they are cleaned as those of a file of facets.
    const Cleaner cleaner(filled, reading, /*is_surface=*/false, /*is_closed=*/false,
                          report.within - report.farthest);
    absl::StatusOr<std::optional<Prepared>> mended =
        Mend(cleaner, report, /*to_close=*/false, /*least=*/0);
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
  report.Add("hole filled", count);
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

absl::StatusOr<Prepared> Prepare(const std::string& path, const io::GeometryOptions& as_asked,
                                 const PrepareOptions& options) {
  for (const auto& [flag, length] : {std::pair("--within", options.within),
                                     {"--fill-holes", options.fill_holes},
                                     {"--mending-tolerance", options.least_tolerance}}) {
    if (absl::Status status = CheckLength(flag, length); !status.ok()) return status;
  }
  const auto start = std::chrono::steady_clock::now();
  const bool may_be = MayBePrepared(path, options);
  io::GeometryOptions reading = as_asked;
  if (may_be) reading.judge = VerdictOn;
  const io::Format* const format = io::FindFormat(path);  // null: a script of any extension
  const bool is_surface = format != nullptr && format->Is(io::kSurface);
  const auto within_of = [&](const Geometry& geometry) {
    return options.within.value_or(kDefaultWithin *
                                   DiagonalOf(geometry.features, geometry.options.dimension));
  };
  const auto finish = [&](Prepared prepared) {
    Report& report = prepared.report;
    if (is_surface && !reading.keep_facets && (report.is_mended || report.found.ok())) {
      // What fills holes may have to be mended, too.
      const double left = report.within - report.farthest;
      Thin(options.fill_holes ? left / 2 : left, reading, prepared);
    }
    if (options.fill_holes && report.open_edges_after != 0) {
      Fill(*options.fill_holes, reading, prepared);
    }
    if (report.open_edges_after != 0) report.open_loops = OpenLoopsOf(prepared.geometry.features);
    report.least_tolerance = options.least_tolerance;
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    report.seconds = seconds.count();
    return prepared;
  };
  io::GeometryOptions how = reading;
  if (may_be) how.mend_rings = true;
  absl::StatusOr<Geometry> given = io::ReadGeometry(path, how);
  if (!may_be) {
    if (!given.ok()) return given.status();
    return Prepared{*std::move(given), {}};
  }
  const absl::Status unread = given.status();
  const bool given_ok = given.ok();
  Prepared as_read;
  bool to_close = false;
  if (given.ok()) {
    as_read.geometry = *std::move(given);
    Geometry& geometry = as_read.geometry;
    const bool in_space = geometry.options.dimension == 3;
    if (in_space && !is_surface && !options.within && !options.fill_holes) return as_read;
    const double within = within_of(geometry);
    to_close = Describe(geometry, within, as_read.report);
    absl::Status& found = as_read.report.found;
    if (found.ok() && is_surface && options.least_tolerance) {
      found = MakeError(
          absl::StatusCode::kResourceExhausted,
          Concat("mending is to have a tolerance of ", *options.least_tolerance, " or more"),
          {reason::kVertexLimit, {}, {}});
    }
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
    absl::StatusOr<std::optional<Prepared>> mended =
        Mend(cleaner, as_read.report, to_close, options.least_tolerance.value_or(0));
    if (!mended.ok()) {
      return absl::InvalidArgumentError(Concat(path, ": ", text::View(mended.status().message())));
    }
    if (*mended) return finish(**std::move(mended));
  }
  if (!unread.ok()) return unread;
  return finish(std::move(as_read));
}

std::optional<double> LargerTolerance(const Report& report) {
  for (const double share : kSharesOfTooFine) {
    if (share * report.within > report.tolerance) return share * report.within;
  }
  return std::nullopt;
}

std::optional<double> ToleranceIfTooFine(const Report& report, const absl::Status& refusal) {
  const std::optional<ErrorDetail> detail = GetErrorDetail(refusal);
  if (!absl::IsResourceExhausted(refusal) || !detail) return std::nullopt;
  const bool may_help = detail->reason == reason::kVertexLimit ||
                        (detail->reason == reason::kDepthLimit && report.open_edges_after == 0);
  return may_help ? LargerTolerance(report) : std::nullopt;
}

std::string TextOf(const Report& report) {
  std::string text;
  for (const auto& [what, count] : report.changes) {
    text += Concat(text.empty() ? "" : ", ", count, " x ", what);
  }
  if (report.is_thinned) {
    text += Concat(", ", report.triangles_read, " triangles became ", report.triangles);
  }
  if (report.is_mended || report.is_thinned) {
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
