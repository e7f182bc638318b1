// Meshes cut open in perspective, compared with rays.
#include "core/io/pictures/clip_picture.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/circumball.h"
#include "core/io/pictures/colour_ramp.h"
#include "core/io/pictures/svg_writer.h"
#include "gtest/gtest.h"
#include "tests/core/io/meshes/good_space_mesh.h"
#include "tests/core/io/meshes/sample_mesh.h"
#include "tests/core/mesh_data/made_up_mesh.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::io {
namespace {

using geometry::Cross;
using geometry::Difference;
using geometry::Dot;
using geometry::Vector3;
using testing::MakeGoodSpaceMesh;
using testing::MakeRandom;

constexpr Box kBox = {{0, 0, 0}, {8, 8, 8}};

// How far a ray from the eye goes to a triangle, and how near to an edge it passes; none: beside.
std::optional<std::pair<double, double>> Hit(const Vector3& eye, const Vector3& ray,
                                             const std::array<Vector3, 3>& t) {
  const Vector3 e = Difference(t[1], t[0]), f = Difference(t[2], t[0]), p = Cross(ray, f);
  const double det = Dot(e, p);
  if (std::abs(det) < 1e-14) return std::nullopt;
  const Vector3 s = Difference(eye, t[0]), q = Cross(s, e);
  const double u = Dot(s, p) / det, v = Dot(ray, q) / det;
  const double margin = std::min({u, v, 1 - u - v});
  if (margin < -1e-6) return std::nullopt;
  return std::pair(Dot(f, q) / det, margin);
}

bool IsInside(const MeshPicture& picture, const MeshPicture::Cell& cell,
              const MeshPicture::Position& p) {
  int signs = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto& a = picture.positions[cell.corners[k]];
    const auto& b = picture.positions[cell.corners[(k + 1) % 3]];
    signs += (b[0] - a[0]) * (p[1] - a[1]) > (b[1] - a[1]) * (p[0] - a[0]) ? 1 : -1;
  }
  return std::abs(signs) == 3;
}

// What is drawn last at a place is the tetrahedron that a ray through it meets first.
void ExpectFrontIsShown(testing::Random& random) {
  for (int round = 0; round < 6; ++round) {
    const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(random(), 60).mesh).value();
    const int axis = round % 3;
    const double at = 2 + static_cast<double>(random() % 400) / 100;
    const MeshPicture picture = ClipAt(mesh, axis, at, kBox);
    const ClipCamera camera(kBox, axis);
    ASSERT_GT(picture.cells.size(), 10U);
    std::vector<std::uint32_t> kept;
    for (std::uint32_t i = 0; i < mesh.tetrahedra.size(); ++i) {
      double middle = 0;
      for (const std::uint32_t v : mesh.tetrahedra[i]) {
        middle += mesh.vertices[v].position()[static_cast<std::size_t>(axis)] / 4;
      }
      if (middle <= at) kept.push_back(i);
    }
    int seen = 0;
    for (int shot = 0; shot < 400; ++shot) {
      const MeshPicture::Position p = {(static_cast<double>(random() % 2000) - 1000) / 3000,
                                       (static_cast<double>(random() % 2000) - 1000) / 3000};
      Vector3 ray;
      for (std::size_t k = 0; k < 3; ++k) {
        ray[k] = camera.ahead[k] + p[0] * camera.right[k] + p[1] * camera.up[k];
      }
      std::optional<std::uint32_t> nearest;
      double distance = INFINITY, next = INFINITY;  // the latter: of another tetrahedron
      bool is_clear = true;                         // no edge is near
      for (const std::uint32_t i : kept) {
        const auto& t = mesh.tetrahedra[i];
        for (std::size_t k = 0; k < 4; ++k) {
          std::array<Vector3, 3> side;
          for (std::size_t j = 0; j < 3; ++j) side[j] = mesh.vertices[t[(k + j) % 4]].position();
          const auto hit = Hit(camera.eye, ray, side);
          if (!hit) continue;
          is_clear &= hit->second > 1e-6;
          if (hit->first < distance) {
            if (nearest != i) next = distance;
            distance = hit->first, nearest = i;
          } else if (nearest != i) {
            next = std::min(next, hit->first);
          }
        }
      }
      // A flat tetrahedron is neither in front of its neighbour nor behind it.
      if (!is_clear || next - distance < 1e-9) continue;
      std::optional<std::uint32_t> last;
      for (const MeshPicture::Cell& cell : picture.cells) {
        if (IsInside(picture, cell, p)) last = cell.simplex;
      }
      EXPECT_EQ(last, nearest) << "axis " << axis << " at " << at << ", " << p[0] << " " << p[1];
      seen += nearest ? 1 : 0;
    }
    EXPECT_GT(seen, 50);
  }
}

TEST(ClipAt, ShowsWhatIsInFront) {
  testing::Random random = MakeRandom();
  ExpectFrontIsShown(random);
}

// Six vertices on one ball: its tetrahedra have one power of the eye, up to rounding.
TEST(ClipAt, ShowsWhatIsInFrontAmongTetrahedraOfOneBall) {
  testing::Random random(1983408151);
  ExpectFrontIsShown(random);
}

TEST(ClipAt, TellsTrianglesOfPolygons) {
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 60, false).mesh).value();
  std::size_t walls = 0;
  // The plate is across z: seen from above if what is above it is cut away.
  for (double at = 3; at < 5; at += 0.05) {
    const MeshPicture picture = ClipAt(mesh, 2, at, kBox);
    walls += static_cast<std::size_t>(std::count_if(picture.cells.begin(), picture.cells.end(),
                                                    [](const auto& cell) { return cell.is_wall; }));
    for (const auto& cell : picture.cells) EXPECT_TRUE(cell.light > 0.5 && cell.light <= 1);
  }
  EXPECT_GT(walls, 0U);
  EXPECT_TRUE(ClipAt(mesh, 2, -1, kBox).cells.empty());
  EXPECT_TRUE(ClipAt(IndexedMesh(), 2, 0, {{0, 0, 0}, {0, 0, 0}}).cells.empty());
}

TEST(Svg, OfAClipDrawsEachTriangleInItsOrder) {
  const test::TempFolder folder;
  const IndexedMesh mesh = IndexMesh(MakeGoodSpaceMesh(3, 60).mesh).value();
  SvgOptions options;
  options.is_clip = true;
  options.legend = true;
  options.cut_axis = 1;
  options.cut_at = 4.25;
  for (const char* fill :
       {"angle", "dihedral", "quality", "size", "exempt", "region", "plain", "none"}) {
    options.fill = ParseFill(fill).value();
    ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
    const std::string svg = folder.Read("m.svg");
    EXPECT_NE(svg.find(" tetrahedra, clipped at y = 4.25</title>"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(static_cast<std::size_t>(std::count(svg.begin(), svg.end(), 'z')),
              ClipAt(mesh, 1, 4.25, kBox).cells.size())
        << fill;
    const bool has_meaning = std::string(fill) != "plain" && std::string(fill) != "none";
    EXPECT_EQ(svg.find("<text") != std::string::npos, has_meaning) << fill;
  }
  const IndexedMesh planar = IndexMesh(testing::SampleMesh()).value();
  EXPECT_EQ(WriteSvg(planar, options, folder.Path("m.svg")).code(),
            absl::StatusCode::kInvalidArgument);
}

TEST(Svg, SizesHaveAScaleOfLengthsAndColoursThatDiffer) {
  double before = -1;
  for (int step = 0; step <= 30; ++step) {
    const std::string colour = ColourAt(kSizeRamp, step / 30.0);
    const auto channel = [&](std::size_t at) {
      return std::pow(std::stoi(colour.substr(at, 2), nullptr, 16) / 255.0, 2.2);
    };
    const double luminance = 0.2126 * channel(1) + 0.7152 * channel(3) + 0.0722 * channel(5);
    EXPECT_GT(luminance, before) << step;  // told apart without hues
    EXPECT_GT(luminance, 0.1) << step;     // dark lines show
    before = luminance;
  }
  const test::TempFolder folder;
  const IndexedMesh mesh = IndexMesh(testing::SampleMesh()).value();
  SvgOptions options;
  options.fill = SvgOptions::Fill::kSize;
  options.legend = true;
  ASSERT_TRUE(WriteSvg(mesh, options, folder.Path("m.svg")).ok());
  EXPECT_NE(folder.Read("m.svg").find(">shortest edge<"), std::string::npos);
  ASSERT_TRUE(WriteSvg(IndexedMesh(), options, folder.Path("m.svg")).ok());
}

}  // namespace
}  // namespace dynmesh::io
