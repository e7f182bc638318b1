// Which options a mesh can be made with, and the domain that they span.
//
// Rounding of the domain: everything is rounded to multiples of one power of two
// g, two ulps of (a bound of) the domain's largest coordinate. The side l goes up to
// a multiple of g, the centre to the nearest one; then i*l and lo + i*l are exact for
// i = 0..N-1, so the domain is a square or cube to the bit, its border points are exact, and
// (hi - lo) / (N-1) gives l back. The user's box lies in its middle.
#include "dynmesh/options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

// Products of four coordinates, and of four of the smallest distances allowed in a
// box, must stay within the exponents of a double.
constexpr double kMaxMagnitude = 0x1p200;
constexpr double kMinExtent = 0x1p-140;
// Longest side of the box, in ulps of its largest coordinate.
constexpr double kMinExtentUlps = 0x1p20;
constexpr std::uint64_t kMinVertices = 24;

std::string Shortest(double x) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

absl::Status BadOption(std::string message) {
  return MakeError(absl::StatusCode::kInvalidArgument, std::move(message),
                   {reason::kBadOption, {}, std::nullopt});
}

double UlpOf(double magnitude) { return std::ldexp(1.0, std::ilogb(magnitude) - 52); }

// The longest side; 1 for a box of no extent.
double LongestSide(const Box& box, int dimension) {
  double l = 0;
  for (int i = 0; i < dimension; ++i) l = std::max(l, box.hi[i] - box.lo[i]);
  return l > 0 ? l : 1;
}

double LargestMagnitude(const Box& box, int dimension) {
  double m = 0;
  for (int i = 0; i < dimension; ++i) m = std::max({m, std::abs(box.lo[i]), std::abs(box.hi[i])});
  return m;
}

absl::Status ValidateBox(const Box& box, int dimension) {
  for (int i = 0; i < dimension; ++i) {
    const char axis = "xy"[i];
    if (!std::isfinite(box.lo[i]) || !std::isfinite(box.hi[i])) {
      return BadOption(absl::StrCat("box: ", std::string(1, axis), " from ", Shortest(box.lo[i]),
                                    " to ", Shortest(box.hi[i]), " is not finite"));
    }
    if (box.lo[i] > box.hi[i]) {
      return BadOption(absl::StrCat("box: lo ", Shortest(box.lo[i]), " is above hi ",
                                    Shortest(box.hi[i]), " in ", std::string(1, axis),
                                    "; swap them"));
    }
  }
  const double magnitude = LargestMagnitude(box, dimension);
  if (magnitude > kMaxMagnitude) {
    return BadOption(absl::StrCat("box: coordinate of magnitude ", Shortest(magnitude),
                                  " is above 2^200; choose a larger unit of length"));
  }
  const double side = LongestSide(box, dimension);
  if (side < kMinExtent) {
    return BadOption(absl::StrCat("box: longest side ", Shortest(side),
                                  " is below 2^-140; choose a smaller unit of length"));
  }
  if (magnitude > 0 && side < kMinExtentUlps * UlpOf(magnitude)) {
    return BadOption(absl::StrCat(
        "box: longest side ", Shortest(side), " is too small beside coordinates of magnitude ",
        Shortest(magnitude), " (at least ", Shortest(kMinExtentUlps * UlpOf(magnitude)),
        " is needed); move the origin nearer to the box"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status ValidateOptions(const MeshOptions& options) {
  if (options.dimension == 3) {
    return BadOption("dimension: 3 is to come; only 2 is implemented");
  }
  if (options.dimension != 2) {
    return BadOption(absl::StrCat("dimension: ", options.dimension, " is not 2"));
  }
  if (absl::Status status = ValidateBox(options.box, options.dimension); !status.ok()) return status;
  if (!(options.quality >= kMinQuality2D && options.quality <= kMaxQuality)) {
    return BadOption(absl::StrCat("quality: ", Shortest(options.quality), " is not in ",
                                  Shortest(kMinQuality2D), " to ", Shortest(kMaxQuality)));
  }
  if (options.criterion != Criterion::kEdge && options.criterion != Criterion::kThesis) {
    return BadOption(absl::StrCat("criterion: ", static_cast<int>(options.criterion),
                                  " is neither edge nor thesis"));
  }
  if (options.criterion == Criterion::kThesis && options.quality < kMinThesisQuality2D) {
    return BadOption(absl::StrCat(
        "quality: ", Shortest(options.quality), " is below ", Shortest(kMinThesisQuality2D),
        ", the least for criterion thesis, which may refine without end nearer to 1; raise it or "
        "choose criterion edge"));
  }
  if (options.max_edge != 0 && !(options.max_edge > 0 && std::isfinite(options.max_edge))) {
    return BadOption(absl::StrCat("max_edge: ", Shortest(options.max_edge),
                                  " is no length; leave it 0 for none"));
  }
  if (options.limits.max_vertices < kMinVertices) {
    return BadOption(absl::StrCat("limits.max_vertices: ", options.limits.max_vertices,
                                  " is below the ", kMinVertices, " of the bare domain box"));
  }
  if (options.limits.max_depth < 1) {
    return BadOption(
        absl::StrCat("limits.max_depth: ", options.limits.max_depth, " is not positive"));
  }
  return absl::OkStatus();
}

// N of Sec. 4.4, odd so that the grid has a middle. In the plane no accepted quality needs more
// than 7. In space the proof's bound explodes towards 1; below 1.2 it is more than practice
// needs, and kept.
int BorderVertices(const MeshOptions& options) {
  if (options.dimension == 2) return 7;
  const double rho = options.quality;
  if (rho >= 2) return 9;
  const double n = 3 + std::sqrt(2.0) * (std::sqrt(2.0) * rho / (rho - 1) + 1);
  return static_cast<int>(std::ceil(n)) | 1;
}

Box DomainBox(const MeshOptions& options) {
  const Box& box = options.box;
  const int dimension = options.dimension;
  const double longest = LongestSide(box, dimension);
  const double half = (BorderVertices(options) - 1) / 2;
  // Above every coordinate of the result, |centre| + half l, and above half its side: what
  // is a multiple of g and less than twice this needs no more than 53 bits.
  const double bound = LargestMagnitude(box, dimension) + (half + 0.5) * longest;
  const double g = 2 * UlpOf(bound);
  const double l = std::ceil(longest / g) * g;
  Box domain;
  for (int i = 0; i < dimension; ++i) {
    const double centre = std::nearbyint((box.lo[i] + (box.hi[i] - box.lo[i]) / 2) / g) * g;
    domain.lo[i] = centre - half * l;
    domain.hi[i] = centre + half * l;
  }
  return domain;
}

}  // namespace dynmesh
