// Validation of MeshOptions, and the domain that they define.
//
// Rounding of the domain: everything is a multiple of one power of two g, two ulps of (a bound of)
// the domain's largest coordinate. The side l is rounded up to a multiple of g, the centre to the
// nearest one. Then i*l and lo + i*l are exact for i = 0..N-1. So the domain is exactly a square or
// cube, its border points are exact, and (hi - lo) / (N-1) == l. The user's box is in its middle.
#include "dynmesh/options.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/strings/str_cat.h"
#include "core/base/root_cube.h"
#include "core/base/rounding.h"
#include "core/base/text.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

// Bounds that keep all products within the exponents of a double. In 2D, products of four
// coordinates or distances occur (in-circle), in 3D of six (the square of a volume; in-sphere has
// five). The domain is up to 17 times as large as the box. The least distance is 2^-42 of it. So in
// 3D the extremes are 2^(6 * 155) and 2^(-6 * 152).
struct Range {
  int most_magnitude, least_extent;  // powers of two
};
constexpr Range RangeIn(int dimension) {
  return dimension == 2 ? Range{200, -140} : Range{150, -110};
}
// The least longest side of the box, in ulps of its largest coordinate.
constexpr double kMinExtentUlps = 0x1p20;

std::string Shortest(double x) {
  std::array<char, 32> text;
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), x).ptr};
}

absl::Status BadOption(std::string message) {
  return MakeError(absl::StatusCode::kInvalidArgument, std::move(message),
                   {reason::kBadOption, {}, std::nullopt});
}

// The longest side; 1 for a box without extent.
double LongestSide(const Box& box, int dimension) {
  double l = 0;
  for (int i = 0; i < dimension; ++i) l = std::max(l, box.hi[i] - box.lo[i]);
  return l > 0 ? l : 1;
}

absl::Status ValidateBox(const Box& box, int dimension) {
  for (int i = 0; i < dimension; ++i) {
    const char axis = "xyz"[i];
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
  const Range range = RangeIn(dimension);
  if (magnitude > std::ldexp(1.0, range.most_magnitude)) {
    return BadOption(absl::StrCat("box: coordinate of magnitude ", Shortest(magnitude),
                                  " is above 2^", range.most_magnitude,
                                  "; choose a larger unit of length"));
  }
  const double side = LongestSide(box, dimension);
  if (side < std::ldexp(1.0, range.least_extent)) {
    return BadOption(absl::StrCat("box: longest side ", Shortest(side), " is below 2^",
                                  range.least_extent, "; choose a smaller unit of length"));
  }
  if (magnitude > 0 && side < kMinExtentUlps * UlpOf(magnitude)) {
    return BadOption(absl::StrCat(
        "box: longest side ", Shortest(side), " is too small beside coordinates of magnitude ",
        Shortest(magnitude), " (at least ", Shortest(kMinExtentUlps * UlpOf(magnitude)),
        " is needed); move the origin nearer to the box"));
  }
  return absl::OkStatus();
}

absl::Status ValidateQuality(const MeshOptions& options) {
  const bool plane = options.dimension == 2;
  const double least = plane ? kMinQuality2D : kMinQuality3D;
  if (!(options.quality >= least && options.quality <= kMaxQuality)) {
    return BadOption(absl::StrCat("quality: ", Shortest(options.quality), " is not in ",
                                  Shortest(least), " to ", Shortest(kMaxQuality)));
  }
  if (options.criterion != Criterion::kEdge && options.criterion != Criterion::kThesis) {
    return BadOption(absl::StrCat("criterion: ", static_cast<int>(options.criterion),
                                  " is neither edge nor thesis"));
  }
  const double least_thesis = plane ? kMinThesisQuality2D : kMinThesisQuality3D;
  if (options.criterion == Criterion::kThesis && options.quality < least_thesis) {
    return BadOption(absl::StrCat(
        "quality: ", Shortest(options.quality), " is below ", Shortest(least_thesis),
        ", the least for criterion thesis, which may refine without end nearer to 1; raise it or "
        "choose criterion edge"));
  }
  return absl::OkStatus();
}

// Vertices of the bare domain box: a grid on its border, and in 3D those that refinement adds
// inside, up to 0.45 times as many (at rho 1.2; a few at 2).
std::uint64_t LeastVertices(const MeshOptions& options) {
  const auto n = static_cast<std::uint64_t>(BorderVertices(options));
  std::uint64_t all = 1, inside = 1;
  for (int i = 0; i < options.dimension; ++i) all *= n, inside *= n - 2;
  return options.dimension == 2 ? all - inside : (all - inside) * 3 / 2;
}

}  // namespace

// Those that only a mesh of kind delaunay has. `what`: the other kind, with its article.
absl::Status RefuseQuality(const MeshOptions& options, const char* what) {
  const auto refuse = [&](const char* field, double value, double only) {
    return BadOption(absl::StrCat(field, ": ", Shortest(value),
                                  " is for meshes of kind delaunay; leave it at ", Shortest(only),
                                  " for ", what));
  };
  if (const double usual = DefaultQuality(options.dimension); options.quality != usual) {
    return refuse("quality", options.quality, usual);
  }
  if (options.criterion != Criterion::kEdge) {
    return BadOption(absl::StrCat(
        "criterion: thesis is for meshes of kind delaunay; leave it at edge for ", what));
  }
  if (options.max_edge != 0) return refuse("max_edge", options.max_edge, 0);
  if (options.min_dihedral != 0) return refuse("min_dihedral", options.min_dihedral, 0);
  return absl::OkStatus();
}

absl::Status ValidateKind(const MeshOptions& options) {
  switch (options.kind) {
    case MeshKind::kDelaunay:
      return absl::OkStatus();
    case MeshKind::kQuadtree:
      return RefuseQuality(options, "a quadtree");
    case MeshKind::kTriangulation:
      if (options.dimension != 2) {
        return BadOption("kind: triangulation is for meshes of dimension 2; choose delaunay");
      }
      return RefuseQuality(options, "a triangulation");
  }
  return BadOption(absl::StrCat("kind: ", static_cast<int>(options.kind),
                                " is none of delaunay, quadtree, triangulation"));
}

std::string_view NameOf(MeshKind kind) {
  switch (kind) {
    case MeshKind::kDelaunay:
      return "delaunay";
    case MeshKind::kQuadtree:
      return "quadtree";
    case MeshKind::kTriangulation:
      return "triangulation";
  }
  return "?";
}

absl::StatusOr<MeshKind> MeshKindOf(std::string_view name) {
  for (const MeshKind kind : {MeshKind::kDelaunay, MeshKind::kQuadtree, MeshKind::kTriangulation}) {
    if (name == NameOf(kind)) return kind;
  }
  return absl::InvalidArgumentError(absl::StrCat(
      "a kind of mesh is delaunay, quadtree or triangulation, found ", text::Quoted(name)));
}

absl::Status ValidateOptions(const MeshOptions& options) {
  if (options.dimension != 2 && options.dimension != 3) {
    return BadOption(absl::StrCat("dimension: ", options.dimension, " is neither 2 nor 3"));
  }
  if (absl::Status status = ValidateBox(options.box, options.dimension); !status.ok())
    return status;
  if (absl::Status status = ValidateKind(options); !status.ok()) return status;
  if (absl::Status status = ValidateQuality(options); !status.ok()) return status;
  if (options.max_edge != 0 && !(options.max_edge > 0 && std::isfinite(options.max_edge))) {
    return BadOption(absl::StrCat("max_edge: ", Shortest(options.max_edge),
                                  " is no length; leave it 0 for none"));
  }
  if (!(options.min_dihedral >= 0 && options.min_dihedral <= kMaxMinDihedral)) {
    return BadOption(absl::StrCat("min_dihedral: ", Shortest(options.min_dihedral),
                                  " is not in 0 to ", Shortest(kMaxMinDihedral), " degrees"));
  }
  if (options.min_dihedral > 0 && options.dimension != 3) {
    return BadOption(absl::StrCat("min_dihedral: ", Shortest(options.min_dihedral),
                                  " is for meshes of dimension 3; leave it 0"));
  }
  const std::uint64_t least_vertices =
      options.kind == MeshKind::kQuadtree ? 1 : LeastVertices(options);
  if (options.limits.max_vertices < least_vertices) {
    return BadOption(absl::StrCat("limits.max_vertices: ", options.limits.max_vertices,
                                  " is below the ", least_vertices, " of the bare domain box"));
  }
  if (options.limits.max_vertices > MostVertices(options.dimension)) {
    return BadOption(absl::StrCat("limits.max_vertices: ", options.limits.max_vertices,
                                  " is above ", MostVertices(options.dimension),
                                  ", the most that a mesh of dimension ", options.dimension,
                                  " can have"));
  }
  if (options.limits.max_depth < 1) {
    return BadOption(
        absl::StrCat("limits.max_depth: ", options.limits.max_depth, " is not positive"));
  }
  return absl::OkStatus();
}

// N of Sec. 4.4, odd so that the grid has a middle. 2D: no accepted quality needs more than 7. 3D:
// the proof's bound tends to infinity for rho -> 1; below 1.2 it is more than practice needs, but
// kept.
int BorderVertices(const MeshOptions& options) {
  if (options.dimension == 2) return 7;
  const double rho = options.quality;
  if (rho >= 2) return 9;
  const double n = 3 + std::sqrt(2.0) * (std::sqrt(2.0) * rho / (rho - 1) + 1);
  return static_cast<int>(std::ceil(n)) | 1;
}

namespace {

template <std::size_t D>
Box RootBox(const Box& box) {
  std::array<double, D> lo, hi;
  std::copy_n(box.lo.begin(), D, lo.begin());
  std::copy_n(box.hi.begin(), D, hi.begin());
  const RootCube<D> root = RootAround(lo, hi);
  Box domain;
  for (std::size_t k = 0; k < D; ++k) {
    domain.lo[k] = root.lo[k];
    domain.hi[k] = root.lo[k] + std::ldexp(1.0, root.exponent);
  }
  return domain;
}

}  // namespace

Box DomainBox(const MeshOptions& options) {
  if (options.kind == MeshKind::kQuadtree) {
    return options.dimension == 2 ? RootBox<2>(options.box) : RootBox<3>(options.box);
  }
  const Box& box = options.box;
  const int dimension = options.dimension;
  const double longest = LongestSide(box, dimension);
  const double half = (BorderVertices(options) - 1) / 2;
  // At least every coordinate of the result, |centre| + half l, plus half its side. A multiple of g
  // below twice this needs at most 53 bits.
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
