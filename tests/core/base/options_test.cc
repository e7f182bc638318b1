#include "dynmesh/options.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <string>

#include "absl/status/status.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

MeshOptions InBox(double x0, double y0, double x1, double y1) {
  MeshOptions options;
  options.box.lo = {x0, y0, 0};
  options.box.hi = {x1, y1, 0};
  return options;
}

void ExpectRefused(const MeshOptions& options, const std::string& field) {
  const absl::Status status = ValidateOptions(options);
  EXPECT_EQ(status.code(), absl::StatusCode::kInvalidArgument) << field;
  EXPECT_EQ(status.message().substr(0, field.size()), field) << status;
  ASSERT_TRUE(GetErrorDetail(status).has_value());
  EXPECT_EQ(GetErrorDetail(status)->reason, reason::kBadOption);
  EXPECT_EQ(GetErrorDetail(status)->edit, std::nullopt);
}

TEST(Options, DefaultsAreValid) { EXPECT_EQ(ValidateOptions(MeshOptions()), absl::OkStatus()); }

TEST(Options, BoxesOfEveryShapeAreValid) {
  EXPECT_TRUE(ValidateOptions(InBox(-1, -2, 3, 4)).ok());
  EXPECT_TRUE(ValidateOptions(InBox(0.5, 0, 0.5, 1)).ok());  // no width
  EXPECT_TRUE(ValidateOptions(InBox(7, 7, 7, 7)).ok());      // no extent
  EXPECT_TRUE(ValidateOptions(InBox(0, 0, 0, 0)).ok());
  EXPECT_TRUE(ValidateOptions(InBox(0x1p200, 0, 0x1p200, 0x1p200)).ok());
  EXPECT_TRUE(ValidateOptions(InBox(0, 0, 0x1p-140, 0)).ok());
  EXPECT_TRUE(ValidateOptions(InBox(-0.0, -0.0, 1, 1)).ok());
  EXPECT_TRUE(ValidateOptions(InBox(0x1p31, 0, 0x1p31, 0)).ok());  // l = 1 is 2^21 ulps
}

TEST(Options, EntriesPastTheDimensionAreIgnored) {
  MeshOptions options;
  options.box.lo[2] = kNan;
  options.box.hi[2] = -kInf;
  EXPECT_TRUE(ValidateOptions(options).ok());
}

TEST(Options, ALeastDihedralAngleIsOfSpace) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  for (const double degrees : {0.0, 1e-9, 10.0, kMaxMinDihedral}) {
    options.min_dihedral = degrees;
    EXPECT_TRUE(ValidateOptions(options).ok()) << degrees;
  }
  for (const double degrees : {-1.0, 20.001, kNan, kInf}) {
    options.min_dihedral = degrees;
    ExpectRefused(options, "min_dihedral");
  }
  options = MeshOptions();
  options.min_dihedral = 10;
  ExpectRefused(options, "min_dihedral");
}

TEST(Options, BadBoxesAreRefused) {
  ExpectRefused(InBox(kNan, 0, 1, 1), "box: x");
  ExpectRefused(InBox(0, 0, 1, kInf), "box: y");
  ExpectRefused(InBox(0, -kInf, 1, 1), "box: y");
  ExpectRefused(InBox(1, 0, 0, 1), "box: lo 1 is above hi 0 in x");
  ExpectRefused(InBox(0, 1, 1, 0), "box: lo 1 is above hi 0 in y");
  ExpectRefused(InBox(0, 0, 0x1.8p200, 1), "box: coordinate");
  ExpectRefused(InBox(0, -0x1p201, 1, 1), "box: coordinate");
  ExpectRefused(InBox(0, 0, 0x1p-141, 0), "box: longest side");
  ExpectRefused(InBox(0, 0, 0, std::numeric_limits<double>::denorm_min()), "box: longest side");
  ExpectRefused(InBox(1, 0, 1 + 0x1p-33, 0), "box: longest side");  // 2^19 ulps
  ExpectRefused(InBox(0x1p60, 0, 0x1p60, 0), "box: longest side");  // no extent: l = 1
}

TEST(Options, OtherBadFieldsAreRefused) {
  const auto with = [](const std::function<void(MeshOptions&)>& change) {
    MeshOptions options;
    change(options);
    return options;
  };
  for (const int dimension : {-1, 0, 1, 4}) {
    ExpectRefused(with([&](MeshOptions& o) { o.dimension = dimension; }), "dimension");
  }
  for (const double quality : {0.0, 0.999, -2.0, 100.5, kInf, kNan}) {
    ExpectRefused(with([&](MeshOptions& o) { o.quality = quality; }), "quality");
  }
  ExpectRefused(with([](MeshOptions& o) { o.criterion = static_cast<Criterion>(0); }), "criterion");
  ExpectRefused(with([](MeshOptions& o) { o.limits.max_vertices = 23; }), "limits.max_vertices");
  for (const int dimension : {2, 3}) {
    MeshOptions most;
    most.dimension = dimension;
    most.limits.max_vertices = MostVertices(dimension);
    EXPECT_TRUE(ValidateOptions(most).ok()) << dimension;
    ++most.limits.max_vertices;
    ExpectRefused(most, "limits.max_vertices: ");
  }
  ExpectRefused(with([](MeshOptions& o) { o.limits.max_depth = 0; }), "limits.max_depth");
  ExpectRefused(with([](MeshOptions& o) { o.limits.max_depth = -5; }), "limits.max_depth");
  for (const double quality : {1.0, 2.0, 100.0}) {
    EXPECT_TRUE(ValidateOptions(with([&](MeshOptions& o) { o.quality = quality; })).ok());
  }
}

MeshOptions InSpace(double quality = kDefaultQuality3D) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = quality;
  return options;
}

TEST(Options, OfSpace) {
  EXPECT_EQ(ValidateOptions(InSpace()), absl::OkStatus());
  for (const double quality : {1.2, kDefaultQuality2D, 100.0}) {
    EXPECT_TRUE(ValidateOptions(InSpace(quality)).ok()) << quality;
  }
  for (const double quality : {1.0, std::nextafter(1.2, 0.0), 100.5, kNan}) {
    ExpectRefused(InSpace(quality), "quality: ");
  }
  MeshOptions thesis = InSpace(std::nextafter(2.0, 0.0));
  thesis.criterion = Criterion::kThesis;
  ExpectRefused(thesis, "quality: 1.9999999999999998 is below 2, the least for criterion thesis");
  thesis.quality = 2;
  EXPECT_TRUE(ValidateOptions(thesis).ok());
  thesis.dimension = 2;
  thesis.quality = 1.5;
  EXPECT_TRUE(ValidateOptions(thesis).ok());
}

TEST(Options, BoxesOfSpace) {
  const auto with = [](double lo, double hi) {
    MeshOptions options = InSpace();
    options.box.lo[2] = lo;
    options.box.hi[2] = hi;
    return options;
  };
  EXPECT_TRUE(ValidateOptions(with(3, 3)).ok());
  EXPECT_TRUE(ValidateOptions(with(0, 0x1p150)).ok());
  ExpectRefused(with(kNan, 1), "box: z");
  ExpectRefused(with(1, kInf), "box: z");
  ExpectRefused(with(1, 0), "box: lo 1 is above hi 0 in z");
  ExpectRefused(with(0, 0x1.1p150), "box: coordinate");
  MeshOptions tiny = InSpace();
  tiny.box.hi = {0, 0, 0x1p-110};
  EXPECT_TRUE(ValidateOptions(tiny).ok());
  tiny.box.hi[2] = 0x1p-111;
  ExpectRefused(tiny, "box: longest side");
  EXPECT_NE(ValidateOptions(tiny).message().find("below 2^-110"), std::string::npos);
}

// Half as many again as the border has; BorderVertices is the number per side.
TEST(Options, LeastVerticesInSpaceGoWithQuality) {
  for (const auto& [quality, least] : {std::pair(2.0, 579u), std::pair(1.2, 2307u)}) {
    MeshOptions options = InSpace(quality);
    options.limits.max_vertices = least;
    EXPECT_TRUE(ValidateOptions(options).ok()) << quality;
    --options.limits.max_vertices;
    ExpectRefused(options, "limits.max_vertices: ");
  }
}

TEST(Options, TheThesisCriterionWantsMoreRoom) {
  MeshOptions options;
  options.criterion = Criterion::kThesis;
  for (const double quality : {1.0, 1.1, std::nextafter(1.4142, 0.0)}) {
    options.quality = quality;
    ExpectRefused(options, "quality");
    EXPECT_NE(
        ValidateOptions(options).message().find("below 1.4142, the least for criterion thesis"),
        std::string::npos);
    options.criterion = Criterion::kEdge;
    EXPECT_TRUE(ValidateOptions(options).ok());
    options.criterion = Criterion::kThesis;
  }
  for (const double quality : {1.4142, kDefaultQuality2D, 100.0}) {
    options.quality = quality;
    EXPECT_TRUE(ValidateOptions(options).ok()) << quality;
  }
}

TEST(DomainBox, IsSixTimesTheUnitSquare) {
  const Box domain = DomainBox(InBox(0, 0, 1, 1));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(domain.lo[i], -2.5);
    EXPECT_EQ(domain.hi[i], 3.5);
  }
}

TEST(DomainBox, TakesTheLongestSide) {
  const Box domain = DomainBox(InBox(0, 0, 4, 1));
  EXPECT_EQ(domain.lo[0], -10);
  EXPECT_EQ(domain.hi[0], 14);
  EXPECT_EQ(domain.lo[1], -11.5);
  EXPECT_EQ(domain.hi[1], 12.5);
}

TEST(DomainBox, OfABoxWithoutExtentHasUnitLength) {
  const Box domain = DomainBox(InBox(7, -1, 7, -1));
  EXPECT_EQ(domain.lo[0], 4);
  EXPECT_EQ(domain.hi[0], 10);
  EXPECT_EQ(domain.lo[1], -4);
  EXPECT_EQ(domain.hi[1], 2);
}

// For any box: the domain is a square to the bit, its border points are exact, and the user's box
// lies inside, at least two sides from the border.
TEST(DomainBox, IsAnExactSquareAroundAnyBox) {
  const unsigned seed = 20240611;
  std::mt19937_64 random(seed);
  const auto real = [&](double lo, double hi) {
    return std::uniform_real_distribution<double>(lo, hi)(random);
  };
  int tried = 0;
  for (int i = 0; i < 20000; ++i) {
    const double size = std::ldexp(real(0.5, 1), static_cast<int>(real(-130, 190)));
    const double offset = size * std::ldexp(real(-1, 1), static_cast<int>(real(-5, 34)));
    const double x = offset + size * real(-1, 1), y = offset * real(-1, 1);
    const MeshOptions options = InBox(x, y, x + size * real(0, 1), y + size * real(0, 1));
    if (!ValidateOptions(options).ok()) continue;
    ++tried;
    SCOPED_TRACE(testing::Message() << "seed " << seed << ", try " << i);
    const Box domain = DomainBox(options);
    const double l = (domain.hi[0] - domain.lo[0]) / 6;
    const double wanted =
        std::max(options.box.hi[0] - options.box.lo[0], options.box.hi[1] - options.box.lo[1]);
    ASSERT_GE(l, wanted);
    ASSERT_LE(l, wanted * (1 + 0x1p-15));
    for (int axis = 0; axis < 2; ++axis) {
      ASSERT_EQ(domain.hi[axis] - domain.lo[axis], 6 * l);
      for (int k = 1; k <= 6; ++k) {
        // Exact: adding and taking away again loses nothing.
        const double border = domain.lo[axis] + k * l;
        ASSERT_EQ(border - domain.lo[axis], k * l);
        ASSERT_EQ(border, domain.hi[axis] - (6 - k) * l);
      }
      ASSERT_LE(domain.lo[axis] + 2 * l, options.box.lo[axis]);
      ASSERT_GE(domain.hi[axis] - 2 * l, options.box.hi[axis]);
    }
  }
  EXPECT_GT(tried, 10000);
}

}  // namespace
}  // namespace dynmesh
