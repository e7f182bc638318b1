#include "client/preparation/prepare.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <utility>

#include "absl/strings/str_format.h"
#include "client/preparation/cleaner.h"
#include "client/preparation/default_limit.h"
#include "client/preparation/open_edges.h"
#include "client/preparation/thinning.h"
#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"

namespace dynmesh::preparation {
namespace {

using io::Geometry;
using text::Concat;

// In degrees. What meets at a lesser angle becomes one, in a surface that a mesh refuses for an
// angle: twice what it takes at a corner.
constexpr double kLeastAngle = 0.002;
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

// What a mesh refuses of what was read, and its open edges. Returns whether these may be closed.
bool Describe(const Geometry& geometry, double within, Report& report) {
  report.found = Refusal(geometry);
  report.within = within;
  report.Add("ring closed", geometry.mended.closed);
  report.Add("ring dropped", geometry.mended.dropped);
  if (geometry.options.dimension != 3) return false;
  const std::vector<OpenEdge> open = OpenEdgesOf(geometry.features);
  report.open_edges = report.open_edges_after = open.size();
  return !open.empty() && MayBeClosed(open, within);
}

// What cleaning made, before faces in one plane were joined and after it.
struct Mended {
  Prepared cleaned, joined;
};

// The result of the least tolerance that a mesh accepts; if open edges are `to_close`, that of the
// least one that closes them, if there is one. NOT_FOUND if the least tolerance leaves nothing.
absl::StatusOr<std::optional<Mended>> Mend(const Cleaner& cleaner, const Report& as_read,
                                           bool to_close) {
  std::optional<Mended> best;
  const std::vector<double> tolerances = cleaner.Tolerances();
  // Halved after each tolerance that takes them all: twice as many are enough for all tolerances.
  std::uint64_t steps = cleaner.Steps();
  for (const double tolerance : tolerances) {
    Mended now;
    const auto refusal_of = [&](double least_angle) -> absl::StatusOr<absl::Status> {
      absl::StatusOr<Prepared> cleaned = cleaner.Clean(tolerance, least_angle, steps);
      if (!cleaned.ok()) return cleaned.status();
      now.cleaned = *std::move(cleaned);
      now.cleaned.report.found = as_read.found;
      now.cleaned.report.open_edges = as_read.open_edges;
      now.joined = cleaner.Joined(now.cleaned);
      return Refusal(now.joined.geometry);
    };
    absl::StatusOr<absl::Status> refusal = refusal_of(0);
    if (refusal.ok() && IsOfAngle(*refusal)) refusal = refusal_of(kLeastAngle);
    const absl::Status failure = refusal.status();
    if (absl::IsNotFound(failure) && tolerance == tolerances.front()) return failure;
    if (absl::IsNotFound(failure)) break;
    if (absl::IsResourceExhausted(failure)) steps = std::max<std::uint64_t>(steps / 2, 1);
    if (!failure.ok() || !refusal->ok()) continue;
    const bool is_closed = now.joined.report.open_edges_after == 0;
    if (is_closed || (!best && !as_read.found.ok())) best = std::move(now);
    if (best && (is_closed || !to_close)) break;
  }
  return best;
}

// The surface with fewer faces, at most `within` from what it was, if there are fewer, and a mesh
// accepts that.
std::optional<Prepared> Thinned(const Cleaner& cleaner, Prepared cleaned, double within) {
  Report& report = cleaned.report;
  if (!(within > 0)) return std::nullopt;
  report.faces_read = CountOf<APolygon>(cleaned.geometry.features, Not<APoint, ASegment, ASize>);
  const std::size_t dropped = Thin(within, report.tolerance, cleaned.geometry);
  if (dropped == 0) return std::nullopt;
  report.is_thinned = true;
  report.faces = CountOf<APolygon>(cleaned.geometry.features, Not<APoint, ASegment, ASize>);
  report.farthest += within;
  report.Add("point dropped", dropped);
  Prepared joined = cleaner.Joined(std::move(cleaned));
  if (!Refusal(joined.geometry).ok()) return std::nullopt;
  return joined;
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
    absl::StatusOr<std::optional<Mended>> mended = Mend(cleaner, report, /*to_close=*/false);
    if (!mended.ok() || !*mended) return;
    Prepared& joined = (*mended)->joined;
    filled = std::move(joined.geometry);
    report.farthest += joined.report.farthest;
    report.tolerance = std::max(report.tolerance, joined.report.tolerance);
    for (const auto& change : joined.report.changes) report.changes.push_back(change);
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
  const bool may_be_thinned = is_surface && !reading.keep_facets;
  const absl::Status unread = given.status();
  Prepared result;  // as it was read, at first
  bool to_close = false;
  if (given.ok()) {
    result.geometry = *std::move(given);
    const Geometry& geometry = result.geometry;
    const bool in_space = geometry.options.dimension == 3;
    if (in_space && !is_surface && !options.within && !options.fill_holes) return result;
    to_close = Describe(geometry, within_of(geometry), result.report);
    const absl::Status& found = result.report.found;
    if (found.ok() ? !to_close && !may_be_thinned : !IsOfFeatures(found)) {
      return finish(std::move(result));
    }
  } else {
    result.report.found = unread;
  }
  how.faces = io::FaceRules::kAsTheyCome;
  absl::StatusOr<Geometry> raw = io::ReadGeometry(path, how);
  if (!raw.ok() || !(within_of(*raw) > 0) || !ValidateOptions(raw->options).ok()) {
    if (!unread.ok()) return unread;
    return finish(std::move(result));
  }
  const double within = within_of(*raw);
  const bool is_closed = unread.ok() && result.report.open_edges == 0;
  const Cleaner cleaner(*std::move(raw), reading, is_surface, is_closed, within);
  const bool is_accepted = unread.ok() && result.report.found.ok();
  std::optional<Prepared> cleaned;  // of the result, before faces in one plane were joined
  if (!is_accepted || to_close) {
    absl::StatusOr<std::optional<Mended>> mended = Mend(cleaner, result.report, to_close);
    if (!mended.ok()) {
      return absl::InvalidArgumentError(Concat(path, ": ", text::View(mended.status().message())));
    }
    if (*mended) {
      cleaned = std::move((*mended)->cleaned);
      result = std::move((*mended)->joined);
    } else if (!unread.ok()) {
      return unread;
    }
  }
  if (!may_be_thinned) return finish(std::move(result));
  if (!cleaned && is_accepted) {
    absl::StatusOr<Prepared> made = cleaner.Clean(cleaner.Tolerances().front(), 0, cleaner.Steps());
    if (made.ok()) {
      cleaned = *std::move(made);
      cleaned->report.is_mended = false;
      cleaned->report.open_edges = result.report.open_edges;
    }
  }
  if (cleaned) {
    // What fills holes may have to be mended, too.
    const double left = (within - cleaned->report.farthest) * (options.fill_holes ? 0.5 : 1);
    if (auto thinned = Thinned(cleaner, *std::move(cleaned), left)) result = *std::move(thinned);
  }
  return finish(std::move(result));
}

std::string TextOf(const Report& report) {
  std::string text;
  for (const auto& [what, count] : report.changes) {
    text += Concat(text.empty() ? "" : ", ", count, " x ", what);
  }
  if (report.is_thinned) {
    text += Concat(", ", report.faces_read, " faces became ", report.faces);
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
