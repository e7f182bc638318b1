// Sizes that move, grow, and change target and shape, beside and inside of others that stay, with
// points, walls and, in 3D, a plate among them. After every revision the mesh and its complete
// trace are those from scratch, and each operation, executed again, makes what its record says.
// What is looked at for a size that moves follows its rim, not its area; for one that changes
// nothing it is nearly nothing.
//
// DYNMESH_NIGHTLY=1 runs long scripts.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "tests/differential/differential.h"
#include "tests/support/nightly.h"
#include "tests/support/seed.h"

namespace dynmesh::test::moving_sizes_test {
namespace {

// --- Random scripts -------------------------------------------------------------------------

template <int D>
class SizesScript {
 public:
  explicit SizesScript(std::uint64_t seed, MeshOptions options)
      : random_(seed), options_(options), mesh_(options, AlwaysPropagate()) {}

  void Run(int revisions) {
    ASSERT_NO_FATAL_FAILURE(Apply(Others()));
    EditBatch first;
    for (int i = 1 + random_.Below(4); i > 0; --i) first.push_back(Edit::Add(AnySize(next_++)));
    ASSERT_NO_FATAL_FAILURE(Apply(first));
    for (int i = 0; i < revisions; ++i) {
      EditBatch batch;
      for (int k = random_.OneIn(3) ? 2 + random_.Below(4) : 1; k > 0; --k) AddEdit(batch);
      ASSERT_NO_FATAL_FAILURE(Apply(batch)) << "revision " << i;
    }
  }
  int applied() const { return applied_; }

 private:
  static constexpr double kTarget = D == 2 ? 0.03 : 0.16;  // about

  std::array<double, 3> AnyPosition() {
    std::array<double, 3> p = {0, 0, 0};
    for (std::size_t k = 0; k < D; ++k) {
      p[k] = random_.OneIn(5) ? random_.Below(9) / 8.0 : random_.Unit();
    }
    return p;
  }
  double AnyTarget() {
    const double some[] = {1, 1.05, 1.5, 2, 2, 4, 0.8};
    return kTarget * (random_.OneIn(3) ? 0.8 + 3 * random_.Unit() : some[random_.Below(7)]);
  }
  double AnyRadius() {
    return random_.OneIn(8) ? (random_.OneIn(3) ? 4 : 0) : 0.35 * random_.Unit();
  }
  // Points, a wall with its ends among them, in 3D a plate.
  EditBatch Others() {
    EditBatch batch;
    for (FeatureId id = 1; id <= 4; ++id) {
      const auto p = AnyPosition();
      batch.push_back(Edit::Add(Feature::Point(id, 0.05 + 0.9 * p[0], p[1], p[2])));
    }
    const double y = random_.OneIn(2) ? 0.37 : 0.5;
    batch.push_back(Edit::Add(Feature::Point(11, 0.03, y, D == 3 ? 0.4 : 0)));
    batch.push_back(Edit::Add(Feature::Point(12, 0.97, 0.45, D == 3 ? 0.4 : 0)));
    batch.push_back(Edit::Add(Feature::Segment(13, 11, 12)));
    // The corners of a polygon.
    const double corners[][2] = {{0.2, 0.1}, {0.8, 0.15}, {0.7, 0.9}, {0.4, 0.6}, {0.15, 0.8}};
    for (FeatureId i = 0; i < 5; ++i) {
      const auto& [cx, cy] = corners[i];
      batch.push_back(Edit::Add(Feature::Point(21 + i, cx, cy, D == 3 ? 0.8 : 0)));
    }
    if (D == 3) batch.push_back(Edit::Add(Feature::Polygon(31, {{21, 22, 23, 24, 25}})));
    return batch;
  }
  Feature AnySize(FeatureId id) {
    const auto p = AnyPosition();
    switch (random_.Below(D == 2 ? 5 : 4)) {
      case 0:
        return Feature::Size(id, p, {SizeShape::kPoint, AnyTarget(), 0, {}});
      case 1: {
        auto hi = p;
        for (std::size_t k = 0; k < D; ++k) hi[k] += 0.5 * random_.Unit();
        return Feature::Size(id, p, {SizeShape::kBox, AnyTarget(), 0, hi});
      }
      case 2: {
        Path path = {p, AnyPosition()};
        if (random_.OneIn(2)) path.push_back(AnyPosition());
        return Feature::SizeCapsule(id, path, AnyRadius() / 2, AnyTarget());
      }
      case 3:
        return Feature::Size(id, p, {SizeShape::kDisc, AnyTarget(), AnyRadius(), {}});
      default:
        return Feature::SizePolygon(id, {{21, 22, 23, 24, 25}}, AnyTarget());
    }
  }
  // By a thousandth of a target, a target, or far.
  Feature Moved(Feature f) {
    const double steps[] = {1e-12, 1e-3, 1e-3, 1, 5};
    const double step = steps[random_.Below(5)] * f.sizing.target;
    for (std::size_t k = 0; k < D; ++k) {
      const double d = step * (random_.Unit() - 0.5);
      f.position[k] += d;
      if (f.sizing.shape == SizeShape::kBox) f.sizing.hi[k] += d;
      for (auto& vertex : f.sizing.path) vertex[k] += d;
    }
    return f;
  }
  void AddEdit(EditBatch& batch) {
    std::vector<Feature> sizes = mesh_.Features();
    std::erase_if(sizes, [](const Feature& f) { return f.kind != FeatureKind::kSize; });
    if (sizes.empty() || (sizes.size() < 6 && random_.OneIn(4))) {
      batch.push_back(Edit::Set(AnySize(next_++)));
      return;
    }
    Feature f = sizes[static_cast<std::size_t>(random_.Below(static_cast<int>(sizes.size())))];
    switch (random_.Below(9)) {
      case 0:
        f = AnySize(f.id);  // another shape elsewhere
        break;
      case 1:
        f.sizing.target = random_.OneIn(2) ? AnyTarget() : 1.001 * f.sizing.target;
        break;
      case 2:
        f.sizing.radius *= random_.OneIn(2) ? 1 + 1e-3 * random_.Unit() : 0.5 + random_.Unit();
        break;
      case 3:
        batch.push_back(Edit::Remove(f.id));
        return;
      case 4: {  // the same inside, as another feature or as none
        Feature inner = f;
        inner.id = next_++;
        inner.sizing.target *= random_.OneIn(2) ? 1 : 1 + random_.Below(4);
        inner.sizing.radius *= 0.9;
        batch.push_back(Edit::Set(inner));
        return;
      }
      case 5: {  // takes another's place
        batch.push_back(Edit::Remove(f.id));
        f.id = next_++;
        f = Moved(f);
        break;
      }
      default:
        f = Moved(f);
    }
    if (f.sizing.shape != SizeShape::kDisc && f.sizing.shape != SizeShape::kCapsule) {
      f.sizing.radius = 0;
    }
    batch.push_back(Edit::Set(f));
    if (random_.OneIn(8)) {
      const auto p = AnyPosition();
      batch.push_back(Edit::Set(Feature::Point(1, 0.05 + 0.9 * p[0], p[1], p[2])));
    }
  }
  // A batch that is refused changes nothing. Now and then one is cancelled half-way first.
  void Apply(const EditBatch& batch) {
    const MeshHash before = mesh_.hash();
    batches_.push_back(batch);
    if (random_.OneIn(4)) {
      int left = random_.Below(random_.OneIn(2) ? 10 : 400);
      const auto diff = mesh_.Apply(batch, {.interrupted = [&] { return --left < 0; }});
      if (diff.ok()) return Check();
      ASSERT_EQ(mesh_.hash(), before);
    }
    const auto diff = mesh_.Apply(batch, ApplyOptions{});
    if (!diff.ok()) {
      ASSERT_EQ(mesh_.hash(), before) << diff.status();
      batches_.pop_back();
      return;
    }
    ++applied_;
    Check();
  }
  void Check() {
    const Difference difference = CompareWithScratch(mesh_, random_.OneIn(2), random_.OneIn(4));
    ASSERT_EQ(difference.what, "") << ToScript(options_, batches_);
    ASSERT_EQ(mesh_.FirstUnreproduced(), "") << ToScript(options_, batches_);
  }

  Random random_;
  const MeshOptions options_;
  LiveMesh<D> mesh_;
  std::vector<EditBatch> batches_;
  FeatureId next_ = 100;
  int applied_ = 0;
};

template <int D>
void RunScripts(int scripts, int revisions, void (*adapt)(MeshOptions&)) {
  std::uint64_t seed = NewSeed();
  int applied = 0;
  for (int i = 0; i < (IsNightly() ? 20 : 1) * scripts; ++i, ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    MeshOptions options = DefaultsIn<D>();
    adapt(options);
    SizesScript<D> script(seed, options);
    script.Run(revisions);
    if (::testing::Test::HasFatalFailure()) return;
    applied += script.applied();
  }
  EXPECT_GT(applied, scripts * revisions / 4);
}

TEST(MovingSizes, AreThoseFromScratch) {
  RunScripts<2>(8, 20, [](MeshOptions&) {});
}
TEST(MovingSizes, AreThoseFromScratchUnderAMaximalEdge) {
  RunScripts<2>(3, 12, [](MeshOptions& options) { options.max_edge = 0.09; });
}
TEST(MovingSizes, AreThoseFromScratchByTheThesissCriterion) {
  RunScripts<2>(3, 10, [](MeshOptions& options) { options.criterion = Criterion::kThesis; });
}
TEST(MovingSizes, AreThoseFromScratchInSpace) {
  RunScripts<3>(4, 8, [](MeshOptions&) {});
}
TEST(MovingSizes, AreThoseFromScratchInSpaceUnderAMaximalEdge) {
  RunScripts<3>(2, 5, [](MeshOptions& options) { options.max_edge = 0.4; });
}
TEST(MovingSizes, AreThoseFromScratchWithCures) {
  RunScripts<3>(2, 5, [](MeshOptions& options) { options.min_dihedral = 10; });
}

// --- What is looked at ------------------------------------------------------------------------

struct Looks {
  std::uint64_t notified = 0, cells = 0, nodes = 0;
};

// The most in one of the revisions that set `sizes`, one after the other, in a mesh of `before` and
// the first of them.
template <int D>
Looks MostLooks(std::vector<Feature> before, const std::vector<Feature>& sizes) {
  LiveMesh<D> mesh(DefaultsIn<D>(), AlwaysPropagate());
  before.push_back(sizes.front());
  EXPECT_TRUE(mesh.Apply(AddAll(before), ApplyOptions{}).ok());
  Looks most;
  for (std::size_t i = 1; i < sizes.size(); ++i) {
    const auto diff = mesh.Apply({Edit::Set(sizes[i])}, ApplyOptions{});
    EXPECT_TRUE(diff.ok()) << diff.status();
    most.notified = std::max(most.notified, diff->work.notified);
    most.cells = std::max(most.cells, diff->work.visited_cells);
    most.nodes = std::max(most.nodes, diff->work.visited_nodes);
  }
  EXPECT_EQ(CompareWithScratch(mesh, true).what, "");
  std::cout << D << "D, " << mesh.Stats().vertices << " vertices: notified " << most.notified
            << ", cells " << most.cells << ", nodes " << most.nodes << "\n";
  return most;
}

// A size, and the same moved by a thousandth of its target, twice.
std::vector<Feature> Shifted(const Feature& size) {
  std::vector<Feature> sizes = {size};
  for (int i = 1; i <= 2; ++i) {
    Feature f = size;
    const double d = 1e-3 * i * size.sizing.target;
    f.position[0] += d;
    if (f.sizing.shape == SizeShape::kBox) f.sizing.hi[0] += d;
    for (auto& vertex : f.sizing.path) vertex[0] += d;
    sizes.push_back(f);
  }
  return sizes;
}

void ExpectAtMostTimes(double times, const Looks& of, const Looks& as) {
  EXPECT_LE(static_cast<double>(of.notified), times * static_cast<double>(as.notified));
  EXPECT_LE(static_cast<double>(of.cells), times * static_cast<double>(as.cells));
  EXPECT_LE(static_cast<double>(of.nodes), times * static_cast<double>(as.nodes));
}

// A quarter of the target: four times the rim, 16 times the area (in 3D half: 4 and 8).
TEST(MovingSizes, LookAtTheirRim) {
  const auto shapes = [](double h) {
    return std::vector<Feature>{
        Feature::SizeDisc(100, 0.503, 0.497, 0.2, h),
        Feature::SizeBox(100, 0.303, 0.297, 0.7, 0.71, h),
        Feature::SizeCapsule(100, {{0.3, 0.4}, {0.6, 0.61}, {0.7, 0.6}}, 0.15, h),
    };
  };
  const auto coarse = shapes(0.016), fine = shapes(0.004);
  for (std::size_t i = 0; i < coarse.size(); ++i) {
    SCOPED_TRACE("shape " + std::to_string(i));
    ExpectAtMostTimes(6, MostLooks<2>({}, Shifted(fine[i])), MostLooks<2>({}, Shifted(coarse[i])));
  }
}

// A polygon moves with a corner.
TEST(MovingSizes, LookAtTheRimOfAPolygon) {
  const auto looks = [](double h) {
    LiveMesh<2> mesh(DefaultsIn<2>(), AlwaysPropagate());
    EditBatch load;
    const double corners[][2] = {{0.3, 0.3}, {0.7, 0.33}, {0.72, 0.7}, {0.28, 0.69}};
    for (FeatureId i = 0; i < 4; ++i) {
      load.push_back(Edit::Add(Feature::Point(1 + i, corners[i][0], corners[i][1])));
    }
    load.push_back(Edit::Add(Feature::SizePolygon(9, {{1, 2, 3, 4}}, h)));
    EXPECT_TRUE(mesh.Apply(load, ApplyOptions{}).ok());
    const auto diff =
        mesh.Apply({Edit::Set(Feature::Point(3, 0.72 + 1e-3 * h, 0.7))}, ApplyOptions{});
    EXPECT_TRUE(diff.ok());
    EXPECT_EQ(CompareWithScratch(mesh, true).what, "");
    return Looks{diff->work.notified, diff->work.visited_cells, diff->work.visited_nodes};
  };
  ExpectAtMostTimes(6, looks(0.004), looks(0.016));
}

TEST(MovingSizes, LookAtTheirRimInSpace) {
  const auto ball = [](double h) {
    return Shifted(Feature::Size(100, {0.503, 0.497, 0.51}, {SizeShape::kDisc, h, 0.25, {}}));
  };
  ExpectAtMostTimes(6, MostLooks<3>({}, ball(0.02)), MostLooks<3>({}, ball(0.04)));
}

// A size as coarse as what is around it, or coarser by octaves, comes, moves and grows inside.
TEST(MovingSizes, LookAtNothingInsideAFinerSize) {
  const Feature outer = Feature::SizeDisc(1, 0.5, 0.5, 0.3, 0.008);
  std::vector<Feature> sizes;
  for (const double target : {0.008, 0.016, 0.032}) {
    for (const double radius : {0.05, 0.2, 0.15}) {
      sizes.push_back(Feature::SizeDisc(2, 0.48 + 0.1 * radius, 0.51, radius, target));
    }
    sizes.push_back(Feature::SizeBox(2, 0.4, 0.4, 0.6, 0.62, target));
  }
  const Looks looks = MostLooks<2>({outer}, sizes);
  EXPECT_EQ(looks.notified, 0);
  EXPECT_EQ(looks.cells, 0);
  EXPECT_EQ(looks.nodes, 0);
}

TEST(MovingSizes, LookAtNothingInsideAFinerSizeInSpace) {
  const Feature outer = Feature::Size(1, {0.5, 0.5, 0.5}, {SizeShape::kDisc, 0.06, 0.35, {}});
  std::vector<Feature> sizes;
  for (const double target : {0.06, 0.12}) {
    for (const double radius : {0.05, 0.2, 0.15}) {
      sizes.push_back(Feature::Size(2, {0.5, 0.48, 0.51}, {SizeShape::kDisc, target, radius, {}}));
    }
  }
  const Looks looks = MostLooks<3>({outer}, sizes);
  EXPECT_EQ(looks.notified, 0);
  EXPECT_EQ(looks.cells, 0);
  EXPECT_EQ(looks.nodes, 0);
}

}  // namespace
}  // namespace dynmesh::test::moving_sizes_test
