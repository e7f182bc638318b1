// SVR of segments and facets on the way: no mesh is bad, and no vertex is in a protected ball.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "core/svr/svr.h"

namespace dynmesh::svr::svr_plc_test {
namespace {

using geometry::Point2;
using geometry::Point3;

template <int D>
MeshOptions OptionsIn() {
  MeshOptions options;
  options.dimension = D;
  options.quality = DefaultQuality(D);
  return options;
}

// A box between lo and hi: its corners, edges, and facets.
void AddBox(PlcInput<3>& input, const Point3& lo, const Point3& hi, meshing::FeatureSlot* slot) {
  std::array<VertexIndex, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    Point3 p;
    for (int k = 0; k < 3; ++k) p[k] = (i >> k & 1) != 0 ? hi[k] : lo[k];
    corners[i] = input.AddPoint(p, (*slot)++);
  }
  for (std::size_t i = 0; i < 8; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if ((i >> k & 1) == 0) input.AddSegment(corners[i], corners[i | 1u << k], (*slot)++);
    }
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t x = std::size_t{1} << (k + 1) % 3, y = std::size_t{1} << (k + 2) % 3;
    for (const std::size_t at : {std::size_t{0}, std::size_t{1} << k}) {
      const std::vector<std::vector<VertexIndex>> rings = {
          {corners[at], corners[at | x], corners[at | x | y], corners[at | y]}};
      input.AddFacet(rings, (*slot)++);
    }
  }
}

// Squares in each other, and points.
void Fill(PlcInput<2>& input, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  meshing::FeatureSlot slot = 1;
  double margin = 0.1 * unit(bits);
  for (int square = 0; square < 4 && margin < 0.4; ++square) {
    std::array<VertexIndex, 4> corners;
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = i == 1 || i == 2 ? 1 - margin : margin, y = i >= 2 ? 1 - margin : margin;
      corners[i] = input.AddPoint({{x, y}}, slot++);
    }
    for (std::size_t i = 0; i < 4; ++i) input.AddSegment(corners[i], corners[(i + 1) % 4], slot++);
    const double next = margin + 0.15 * unit(bits) * unit(bits) + 0.001;
    for (int i = 0; i < 3; ++i) {
      const double x = margin + (next - margin) * (0.1 + 0.8 * unit(bits));
      input.AddPoint({{x, margin + (1 - 2 * margin) * (0.1 + 0.8 * unit(bits))}}, slot++);
    }
    margin = next;
  }
}
// Boxes in each other, and points between them.
void Fill(PlcInput<3>& input, std::uint64_t seed) {
  std::mt19937_64 bits(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  meshing::FeatureSlot slot = 1;
  double margin = 0.05 * unit(bits);
  for (int box = 0; box < 2; ++box) {
    AddBox(input, {{margin, margin, margin}}, {{1 - margin, 1 - margin, 1 - margin}}, &slot);
    const double next = margin + 0.05 + 0.2 * unit(bits);
    for (int i = 0; i < 3; ++i) {
      const double x = margin + (next - margin) * (0.1 + 0.8 * unit(bits));
      input.AddPoint({{x, 0.2 + 0.6 * unit(bits), 0.2 + 0.6 * unit(bits)}}, slot++);
    }
    margin = next;
  }
}

template <int D>
void ExpectKept(std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const MeshOptions options = OptionsIn<D>();
  PlcInput<D> input(options);
  Fill(input, seed);
  Kernel<D> mesh;
  Svr<D, PlcInput<D>> svr(input.options(), &input, &mesh);
  double worst = 0, kept = 0;
  int times_kept = 0;
  svr.Run([&] {
    const double ratio = std::sqrt(svr.WorstSquaredRatio());
    worst = std::max(worst, ratio);
    if (!svr.is_kept()) return false;
    ++times_kept;
    kept = std::max(kept, ratio);
    return false;
  });
  std::string why;
  EXPECT_TRUE(mesh.Check(&why)) << why;
  // As without features (svr_test.cc).
  EXPECT_GT(times_kept, 50);
  EXPECT_LE(kept, 2 * options.quality * (1 + 1e-5));
  EXPECT_LT(worst, 20 * 2 * options.quality);
  EXPECT_LE(std::sqrt(svr.WorstSquaredRatio()), options.quality * (1 + 1e-5));
  // Of every subsegment the open ball is empty.
  input.ForEachSubsegment([&](SubsegmentIndex, VertexIndex a, VertexIndex b) {
    EXPECT_TRUE(IsEdge<D>(mesh, a, b));
    for (VertexIndex v = 0; v < input.elements().vertex_end(); ++v) {
      EXPECT_FALSE(
          geometry::InDiametralBall(input.position(a), input.position(b), input.position(v)));
    }
  });
  std::printf(
      "%dD, seed %d: %d vertices, worst ratio on the way %.2f; %.2f where nothing skinny waits\n",
      D, static_cast<int>(seed), static_cast<int>(mesh.vertex_count()), worst, kept);
}

TEST(SvrPlc, NoMeshOnTheWayIsBad) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) ExpectKept<2>(seed);
  for (std::uint64_t seed = 1; seed <= 3; ++seed) ExpectKept<3>(seed);
}

}  // namespace
}  // namespace dynmesh::svr::svr_plc_test
