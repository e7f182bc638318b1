// Means over median-dual cells, against a slow and obvious oracle: each simplex is divided into the
// (D + 1)! simplices between a vertex, the middle of an edge at it, and so on to the middle of the
// whole; those at a vertex are its part. All pairs of old and new ones are clipped by each other.
#include <algorithm>
#include <numeric>

#include "tests/core/geometry/random_points.h"
#include "tests/core/transfer/field_lab.h"

namespace dynmesh::dual_test {
namespace {

using testing::Index;

template <std::size_t D>
using Simplex = transfer::Corners<D>;

template <std::size_t D>
double SizeOf(const Simplex<D>& simplex) {
  return std::abs(transfer::ScaledMeasure(simplex)) / (D == 2 ? 2 : 6);
}

// Of the D-simplices that fill corner `corner`'s part of `of`.
template <std::size_t D>
std::vector<Simplex<D>> PartOf(const Simplex<D>& of, std::size_t corner) {
  std::vector<Simplex<D>> result;
  std::array<std::size_t, D + 1> order;
  std::iota(order.begin(), order.end(), std::size_t{0});
  do {
    if (order[0] != corner) continue;
    Simplex<D> part;
    for (std::size_t k = 0; k <= D; ++k) {
      part[k].fill(0);
      for (std::size_t i = 0; i <= k; ++i) {
        for (std::size_t x = 0; x < D; ++x) {
          part[k][x] += of[order[i]][x] / static_cast<double>(k + 1);
        }
      }
    }
    result.push_back(part);
  } while (std::next_permutation(order.begin(), order.end()));
  return result;
}

// The measure of the part of `simplex` where each of these half-spaces is not negative.
template <std::size_t D>
double Clip(const Simplex<D>& simplex, std::span<const transfer::HalfSpace<D>> halves) {
  if (halves.empty()) return SizeOf<D>(simplex);
  std::array<double, D + 1> at;
  std::size_t most = 0, least = 0;
  for (std::size_t k = 0; k <= D; ++k) {
    at[k] = halves[0](simplex[k]);
    if (at[k] > at[most]) most = k;
    if (at[k] < at[least]) least = k;
  }
  const double noise = halves[0].Noise(10);  // the mesh is within -10 to 10
  if (at[most] <= noise) return 0;
  if (at[least] >= -noise) return Clip<D>(simplex, halves.subspan(1));
  Simplex<D> one = simplex, other = simplex;
  for (std::size_t x = 0; x < D; ++x) {
    const double t = at[most] / (at[most] - at[least]);
    one[least][x] = other[most][x] = simplex[most][x] + t * (simplex[least][x] - simplex[most][x]);
  }
  return Clip<D>(one, halves) + Clip<D>(other, halves);
}

template <std::size_t D>
double Overlap(const Simplex<D>& a, Simplex<D> b) {
  for (std::size_t x = 0; x < D; ++x) {
    const auto by = [x](const auto& p, const auto& q) { return p[x] < q[x]; };
    if (std::ranges::max(a, by)[x] <= std::ranges::min(b, by)[x]) return 0;
    if (std::ranges::max(b, by)[x] <= std::ranges::min(a, by)[x]) return 0;
  }
  if (transfer::ScaledMeasure(b) < 0) std::swap(b[0], b[1]);
  const auto halves = transfer::HalfSpaces(b);
  return Clip<D>(a, halves);
}

template <std::size_t D>
Simplex<D> CornersOf(const SlotMesh& mesh, const Slot* vertices) {
  Simplex<D> corners;
  for (std::size_t k = 0; k <= D; ++k) {
    std::copy_n(&mesh.points()[Index(vertices[k]) * D], D, corners[k].begin());
  }
  return corners;
}

// Of one vertex in `of_each`; others stay.
template <std::size_t D>
std::vector<double> Oracle(const SlotMesh& mesh, std::vector<double> u, std::size_t of_each) {
  const MeshPatch& patch = mesh.patch();
  struct Old {
    Simplex<D> simplex;
    double value;
  };
  std::vector<Old> olds;
  for (std::size_t i = 0; i < patch.removed_simplices.size(); ++i) {
    const Slot* corners = &patch.removed_corners[i * (D + 1)];
    for (std::size_t k = 0; k <= D; ++k) {
      for (const auto& part : PartOf<D>(CornersOf<D>(mesh, corners), k)) {
        olds.push_back({part, u[Index(corners[k])]});
      }
    }
  }
  std::vector<bool> is_added(mesh.regions().size(), false);
  for (const Slot slot : patch.added_simplices) is_added[Index(slot)] = true;
  std::vector<double> mass(mesh.ids().size(), 0), measure(mass.size(), 0);
  std::vector<bool> changes(mass.size(), false);
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (!testing::IsLive(mesh, c)) continue;
    const Slot* corners = &mesh.cells()[c * (D + 1)];
    const Simplex<D> simplex = CornersOf<D>(mesh, corners);
    for (std::size_t k = 0; k <= D; ++k) {
      const std::size_t v = Index(corners[k]);
      if (v % of_each != 0) continue;
      const double part = SizeOf<D>(simplex) / static_cast<double>(D + 1);
      measure[v] += part;
      if (!is_added[c]) {
        mass[v] += part * u[v];
        continue;
      }
      changes[v] = true;
      for (const auto& own : PartOf<D>(simplex, k)) {
        for (const Old& old : olds) mass[v] += old.value * Overlap<D>(own, old.simplex);
      }
    }
  }
  for (std::size_t v = 0; v < u.size(); ++v) {
    if (changes[v]) u[v] = mass[v] / measure[v];
  }
  return u;
}

class Dual : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimension, Dual, ::testing::Values(2, 3),
                         [](const auto& of) { return std::to_string(of.param) + "D"; });

TEST_P(Dual, MeansAreThoseOfClippedCells) {
  constexpr std::size_t kOfEach = 10;  // in 3D: it is slow
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0, 1);
  EditBatch batch;
  const FeatureId points = dimension == 2 ? 60 : 5;
  for (FeatureId id = 1; id <= points; ++id) {
    batch.push_back(Edit::Add(Feature::Point(id, draw(random), draw(random), draw(random))));
  }
  auto mesh = std::move(DynamicMesh::Create(testing::UnitBox(dimension))).value();
  ASSERT_TRUE(mesh->Apply(batch).ok());
  SlotMesh slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  int edits = 0;
  for (int e = 0; e < (dimension == 2 ? 30 : 2); ++e) {
    std::vector<double> u(slots.ids().size());
    for (double& value : u) value = draw(random);
    const FeatureId id = 1 + random() % points;
    const auto diff = mesh->Apply({Edit::Move(id, draw(random), draw(random), draw(random))});
    if (!diff.ok()) continue;
    ++edits;
    ASSERT_TRUE(slots.Apply(*diff).ok());
    u.resize(slots.ids().size());
    const std::vector<double> wanted =
        dimension == 2 ? Oracle<2>(slots, u, 1) : Oracle<3>(slots, u, kOfEach);
    auto transfer = Transfer::Make(slots);
    ASSERT_TRUE(transfer.ok());
    ASSERT_TRUE(transfer->Carry({.kind = FieldKind::kDual}, u).ok());
    for (std::size_t v = 0; v < u.size(); ++v) {
      if (slots.ids()[v] == 0 || (dimension == 3 && v % kOfEach != 0)) continue;
      ASSERT_NEAR(u[v], wanted[v], 1e-10) << "edit " << e;
    }
  }
  EXPECT_GT(edits, 0);
}

}  // namespace
}  // namespace dynmesh::dual_test
