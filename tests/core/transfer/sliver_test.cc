// Meshes made by hand of simplices so thin that rounding affects their measures: constants are
// nevertheless preserved to the bit and linear fields up to rounding.
#include <cmath>
#include <functional>
#include <string>

#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/diff_meshes.h"
#include "core/transfer/simplex.h"
#include "tests/core/geometry/random_points.h"
#include "tests/core/transfer/field_lab.h"

namespace dynmesh {
namespace {

using testing::FieldFunction;
using testing::GreatestError;
using testing::RowCount;
using testing::Sample;
using Random = std::mt19937_64;

template <std::size_t D>
using Places = std::vector<transfer::Vec<D>>;

// `cells` by indices of places, in any orientation.
template <std::size_t D>
Mesh MakeMesh(const Places<D>& places, std::vector<std::array<std::size_t, D + 1>> cells,
              std::uint64_t revision) {
  Mesh mesh;
  mesh.dimension = static_cast<int>(D);
  mesh.revision = revision;
  std::vector<bool> used(places.size(), false);
  for (auto& cell : cells) {
    transfer::Corners<D> corners;
    for (std::size_t k = 0; k <= D; ++k) corners[k] = places[cell[k]], used[cell[k]] = true;
    if (transfer::ScaledMeasure(corners) < 0) std::swap(cell[0], cell[1]);
    std::array<VertexId, D + 1> ids;
    for (std::size_t k = 0; k <= D; ++k) {
      ids[k] = VertexIdAt(places[cell[k]].data(), static_cast<int>(D));
    }
    const auto row = mesh_data::InCanonicalOrder(ids);
    mesh.simplices.insert(mesh.simplices.end(), row.begin(), row.end());
  }
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (!used[i]) continue;
    mesh.vertices.ids.push_back(VertexIdAt(places[i].data(), static_cast<int>(D)));
    mesh.vertices.coordinates.insert(mesh.vertices.coordinates.end(), places[i].begin(),
                                     places[i].end());
    mesh.vertices.containing_dimensions.push_back(static_cast<std::uint8_t>(D));
    mesh.vertices.owners.push_back(kNoFeature);
  }
  mesh.hash = ComputeHash(mesh);
  return mesh;
}

// Turned and moved, so that nothing is along an axis.
template <std::size_t D>
void Turn(Random& random, Places<D>& places) {
  std::uniform_real_distribution<double> draw(-1, 1);
  const double angle = 3 * draw(random), c = std::cos(angle), s = std::sin(angle);
  const double scale = std::exp2(5 * draw(random));
  transfer::Vec<D> shift;
  for (double& x : shift) x = draw(random);
  for (auto& place : places) {
    const double x = place[0], y = place[1];
    place[0] = c * x - s * y, place[1] = s * x + c * y;
    if constexpr (D == 3) {
      const double z = place[2];
      place[2] = c * z - s * place[0], place[0] = s * z + c * place[0];
    }
    for (std::size_t k = 0; k < D; ++k) place[k] = scale * (place[k] + shift[k]);
  }
}

// Carries fields from one mesh to the other and back, ten times.
template <std::size_t D>
void Check(const Mesh& a, const Mesh& b, bool has_stencils, const std::string& what) {
  const FieldFunction linear = [](const double* x) {
    return 0.5 + 2 * x[0] - x[1] + (D == 3 ? 0.7 * x[2] : 0);
  };
  const FieldFunction constant = [](const double*) { return 0.1; };
  double size = 0;
  for (const double x : a.vertices.coordinates) size = std::max(size, 4 * std::abs(x));
  for (const FieldKind kind :
       {FieldKind::kP0, FieldKind::kP0Linear, FieldKind::kP1, FieldKind::kDG1}) {
    SlotMesh slots = SlotMesh::FromMesh(a).value();
    std::vector<double> ones = Sample(slots, kind, constant), u = Sample(slots, kind, linear);
    Mesh from = a, to = b;
    for (int trip = 0; trip < 20; ++trip) {
      const std::uint64_t revision = slots.revision();
      from.revision = revision, to.revision = revision + 1;
      ASSERT_TRUE(slots.Apply(mesh_data::DiffMeshes(from, to)).ok());
      std::swap(from, to);
      ones.resize(RowCount(slots, kind)), u.resize(RowCount(slots, kind));
      auto transfer = Transfer::Make(slots);
      ASSERT_TRUE(transfer.ok());
      ASSERT_TRUE(transfer->Carry({.kind = kind}, ones).ok());
      ASSERT_TRUE(transfer->Carry({.kind = kind}, u).ok());
    }
    const bool is_linear = kind == FieldKind::kP1 || kind == FieldKind::kDG1 ||
                           (kind == FieldKind::kP0Linear && has_stencils);
    EXPECT_EQ(GreatestError(slots, kind, ones, constant), 0) << what;
    if (is_linear) {
      EXPECT_LE(GreatestError(slots, kind, u, linear), 1e-12 * size)
          << what << ", kind " << static_cast<int>(kind);
    }
  }
}

// Of two places in a simplex, and of the simplex. Those of the places go down to 1e-9 of the
// length: angles of 1e-7 degrees.
struct Heights {
  double h, g, top;
};

Heights DrawHeights(Random& random, int trial) {
  std::uniform_real_distribution<double> draw(0, 1);
  const double least = trial % 2 == 0 ? 30 : 14;
  const double h = std::exp2(-1 - least * draw(random)), g = std::exp2(-1 - least * draw(random));
  return {h, g, trial % 2 == 0 ? 1 : 4 * std::max(h, g)};
}

std::string Text(const Heights& heights) {
  return "h " + std::to_string(std::log10(heights.h)) + ", g " +
         std::to_string(std::log10(heights.g)) + ", top " + std::to_string(heights.top);
}

TEST(Slivers, OfThePlane) {
  Random random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    // A triangle in a larger one with three around it; in the inner one two places near an edge,
    // one of them in each mesh.
    const auto [h, g, top] = DrawHeights(random, trial);
    const double x = 0.2 + 0.6 * draw(random), y = 0.2 + 0.6 * draw(random);
    Places<2> places = {{0, 0},
                        {1, 0},
                        {0.5, top},
                        {-3, -2},
                        {4, -1.5},
                        {0.4, 5},
                        {x, h * top * std::min(x, 1 - x)},
                        {y, g * top * std::min(y, 1 - y)}};
    Turn<2>(random, places);
    const std::vector<std::array<std::size_t, 3>> around = {{3, 4, 0}, {4, 1, 0}, {4, 5, 1},
                                                            {5, 2, 1}, {5, 3, 2}, {3, 0, 2}};
    auto with = [&](std::size_t q) {
      auto cells = around;
      cells.push_back({0, 1, q}), cells.push_back({1, 2, q}), cells.push_back({2, 0, q});
      return MakeMesh<2>(places, cells, 0);
    };
    const std::string what = Text({h, g, top});
    Check<2>(with(6), with(7), true, what);
    if (::testing::Test::HasFailure()) return;
    auto without = around;
    without.push_back({0, 1, 2});
    Check<2>(with(6), MakeMesh<2>(places, without, 0), true, what);
    if (::testing::Test::HasFailure()) return;
  }
}

TEST(Slivers, OfSpace) {
  Random random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0, 1);
  for (int trial = 0; trial < 300; ++trial) {
    const auto [h, g, top] = DrawHeights(random, trial);
    Places<3> places = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, top}};
    for (const double height : {h, g}) {
      const double x = 0.1 + 0.3 * draw(random), y = 0.1 + 0.3 * draw(random);
      places.push_back({x, y, 0.1 * height * top});
    }
    Turn<3>(random, places);
    const auto with = [&](std::size_t q) {
      return MakeMesh<3>(places, {{0, 1, 2, q}, {0, 1, 3, q}, {1, 2, 3, q}, {0, 2, 3, q}}, 0);
    };
    const std::string what = Text({h, g, top});
    Check<3>(with(4), with(5), false, what);
    if (::testing::Test::HasFailure()) return;
    Check<3>(with(4), MakeMesh<3>(places, {{0, 1, 2, 3}}, 0), false, what);
    if (::testing::Test::HasFailure()) return;
  }
}

}  // namespace
}  // namespace dynmesh
