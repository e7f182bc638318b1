#include "tests/differential/locality_scenes.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

// The segment from (x0, y0) to (x1, y1), with ids 3i + 1 to 3i + 3.
void AddSegment(int i, double x0, double y0, double x1, double y1, Scene& scene) {
  const FeatureId id = Id(3 * i + 1);
  scene.features.push_back(Feature::Point(id, x0, y0));
  scene.features.push_back(Feature::Point(id + 1, x1, y1));
  scene.features.push_back(Feature::Segment(id + 2, id, id + 1));
}

// --- Beside long segments -----------------------------------------------------------------

// A long segment comes and goes.
void AddLongSegment(Scene& scene) {
  scene.features.push_back(Feature::Point(kFar, 0.1, 0.5));
  scene.features.push_back(Feature::Point(kFar + 1, 0.9, 0.5));
  InAndOut(Feature::Segment(kFar + 2, kFar, kFar + 1), scene);
}

// Points in the corner of the box about the ball of a long segment, outside of the ball.
Scene PointsInTheCorner(int n) {
  Scene scene;
  Random random(7);
  for (int i = 0; i < n; ++i) {
    const double x = 0.1 + 0.08 * random.Unit();
    scene.features.push_back(Feature::Point(Id(i + 1), x, 0.1 + 0.08 * random.Unit()));
  }
  AddLongSegment(scene);
  return scene;
}

// The same with short segments.
Scene SegmentsInTheCorner(int n) {
  Scene scene;
  Random random(7);
  const int side = static_cast<int>(std::sqrt(n));
  const double step = 0.08 / side;
  for (int i = 0; i < side * side; ++i) {
    const double x = 0.1 + (i % side + 0.1) * step, y = 0.1 + (i / side + 0.1) * step;
    const double turn = 1.2 * random.Unit();
    AddSegment(i, x, y, x + 0.7 * step * std::cos(turn), y + 0.7 * step * std::sin(turn), scene);
  }
  AddLongSegment(scene);
  return scene;
}

// Two walls 1/n apart, and a point between them.
Scene Channel(int n) {
  Scene scene;
  AddSegment(0, 0, 0.5, 1, 0.5, scene);
  AddSegment(1, 0.0137, 0.5 + 1.0 / n, 0.991, 0.5 + 1.0 / n, scene);
  InAndOut(Feature::Point(kFar, 0.5003, 0.5 + 0.37 / n), scene);
  InAndOut(Feature::Point(kFar, 0.2713, 0.5 + 0.81 / n), scene);
  return scene;
}

// n lines 1/n apart, and points between them.
Scene Comb(int n) {
  Scene scene;
  for (int i = 0; i < n; ++i) AddSegment(i, 0, (i + 0.5) / n, 1, (i + 0.5) / n, scene);
  InAndOut(Feature::Point(kFar, 0.5001, (n / 2) / static_cast<double>(n)), scene);
  InAndOut(Feature::Point(kFar, 0.7133, (n / 3 + 0.3) / n), scene);
  return scene;
}

// n lines that diverge.
Scene Fan(int n) {
  Scene scene;
  for (int i = 0; i < n; ++i) {
    const double t = (i + 0.5) / n - 0.5;
    AddSegment(i, 0.02, 0.5 + 0.2 * t, 0.98, 0.5 + t, scene);
  }
  for (const double x : {0.13, 0.42, 0.87}) {
    const double t = (n / 3) / static_cast<double>(n) - 0.5;
    InAndOut(Feature::Point(kFar, x, 0.5 + t * (0.2 + 0.8 * (x - 0.02) / 0.96)), scene);
  }
  return scene;
}

// n segments at one point; one is taken out and put back.
Scene Spokes(int n) {
  Scene scene;
  scene.features.push_back(Feature::Point(1, 0.5, 0.5));
  for (int i = 0; i < n; ++i) {
    const double turn = 2 * std::numbers::pi * i / n;
    const FeatureId id = Id(2 * i + 2);
    scene.features.push_back(
        Feature::Point(id, 0.5 + 0.45 * std::cos(turn), 0.5 + 0.45 * std::sin(turn)));
    scene.features.push_back(Feature::Segment(id + 1, 1, id));
  }
  for (const int i : {n / 3, n / 2}) {
    OutAndIn(Feature::Segment(Id(2 * i + 3), 1, Id(2 * i + 2)), scene);
  }
  return scene;
}

// --- Areas with a target length -----------------------------------------------------------

// A plate with a target of 1/n everywhere.
Scene Plate(int n) {
  Scene scene;
  scene.options.max_edge = 1.0 / n;
  const double corners[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 4; ++i) {
    scene.features.push_back(Feature::Point(Id(i + 1), corners[i][0], corners[i][1]));
  }
  scene.features.push_back(Feature::Polygon(9, {{1, 2, 3, 4}}));
  return scene;
}

Scene PointsInAPlate(int n) {
  Scene scene = Plate(n);
  Random random(7);
  for (int k = 0; k < 8; ++k) {
    const double x = random.Unit();
    InAndOut(Feature::Point(kFar, x, random.Unit()), scene);
  }
  return scene;
}

// A crack grows by steps of three targets.
Scene CrackInAPlate(int n) {
  Scene scene = Plate(n);
  const double h = 1.0 / n;
  double x = 0.1, y = 0.5;
  scene.features.push_back(Feature::Point(kFar, x, y));
  for (int k = 1; k <= 8; ++k) {
    x += 3 * h, y += (k % 3 - 1) * h;
    const FeatureId tip = kFar + Id(2 * k);
    scene.edits.push_back(
        {Edit::Add(Feature::Point(tip, x, y)), Edit::Add(Feature::Segment(tip + 1, tip - 2, tip))});
  }
  return scene;
}

// A polygon of twenty segments moves through the plate, half of a target at a time.
Scene RotorInAPlate(int n) {
  Scene scene = Plate(n);
  constexpr int kCorners = 20;
  const double h = 1.0 / n;
  const auto corner = [&](int i, int step) {
    const double turn = 2 * std::numbers::pi * (i + 0.1 * step) / kCorners;
    return std::pair(0.5 + 0.5 * h * step + 5 * h * std::cos(turn), 0.5 + 5 * h * std::sin(turn));
  };
  for (int i = 0; i < kCorners; ++i) {
    const auto [x, y] = corner(i, 0);
    scene.features.push_back(Feature::Point(kFar + Id(i), x, y));
    scene.features.push_back(
        Feature::Segment(kFar + Id(kCorners + i), kFar + Id(i), kFar + Id((i + 1) % kCorners)));
  }
  for (int step = 1; step <= 6; ++step) {
    EditBatch batch;
    for (int i = 0; i < kCorners; ++i) {
      const auto [x, y] = corner(i, step);
      batch.push_back(Edit::Move(kFar + Id(i), x, y));
    }
    scene.edits.push_back(batch);
  }
  return scene;
}

// A disc with a finer target moves through the plate.
Scene DiscInAPlate(int n) {
  Scene scene = Plate(n);
  const double h = 1.0 / n;
  const auto disc = [&](int step) {
    return Feature::SizeDisc(kFar, 0.5 + 0.4 * h * step, 0.5, 3 * h, 0.25 * h);
  };
  scene.features.push_back(disc(0));
  for (int step = 1; step <= 6; ++step) scene.edits.push_back({Edit::Set(disc(step))});
  return scene;
}

// A bent capsule with a finer target moves through the plate; then one of its vertices does.
Scene CapsuleInAPlate(int n) {
  Scene scene = Plate(n);
  const double h = 1.0 / n;
  const auto capsule = [&](double shift, double lift) {
    const double x = 0.5 + h * shift;
    return Feature::SizeCapsule(
        kFar, {{x - 5 * h, 0.5}, {x, 0.5 + 2 * h + h * lift}, {x + 5 * h, 0.5}}, 0.6 * h, 0.3 * h);
  };
  scene.features.push_back(capsule(0, 0));
  for (int step = 1; step <= 3; ++step) scene.edits.push_back({Edit::Set(capsule(0.4 * step, 0))});
  for (int step = 1; step <= 3; ++step) {
    scene.edits.push_back({Edit::Set(capsule(1.2, 0.3 * step))});
  }
  return scene;
}

// A short capsule comes and goes beside a long one, a chain of n edges across the domain.
Scene CapsuleBesideAChain(int n) {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  Path chain;
  for (int i = 0; i <= n; ++i) {
    const double x = static_cast<double>(i) / n;
    chain.push_back({x, 0.5 + (i % 2 == 0 ? 0 : 0.2 / n), x});
  }
  const double h = 1.0 / n;
  scene.features = {Feature::SizeCapsule(1, chain, 0.5 * h, h)};
  for (const double at : {0.25, 0.5, 0.7}) {
    InAndOut(Feature::SizeCapsule(kFar, {{at, 0.5, at}, {at + h, 0.5, at}}, 0.2 * h, 0.5 * h),
             scene);
  }
  return scene;
}

// Points inside of a box with a target, in 3D.
Scene PointsInASizedBox(int n) {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  scene.features = {Feature::Size(1, {0, 0, 0}, {SizeShape::kBox, 1.0 / n, 0, {1, 1, 1}})};
  Random random(7);
  for (int k = 0; k < 8; ++k) {
    const double x = 0.3 + 0.4 * random.Unit(), y = 0.3 + 0.4 * random.Unit();
    InAndOut(Feature::Point(kFar, x, y, 0.3 + 0.4 * random.Unit()), scene);
  }
  return scene;
}

// Points on either side of an area's border, up to eight targets away.
void PointsAtTheBorder(double border, double h, int dimension, Scene& scene) {
  Random random(7);
  for (const double beyond : {-2.5, -1.0, -0.4, 0.4, 1.0, 1.7, 3.0, 8.0}) {
    std::array<double, 3> p = {
        {border + beyond * h, 0.35 + 0.3 * random.Unit(), 0.35 + 0.3 * random.Unit()}};
    if (random.OneIn(2)) std::swap(p[0], p[1]);
    InAndOut(
        dimension == 2 ? Feature::Point(kFar, p[0], p[1]) : Feature::Point(kFar, p[0], p[1], p[2]),
        scene);
  }
}
Scene BorderOfAnArea(int n) {
  Scene scene;
  scene.features = {Feature::SizeBox(1, 0.3, 0.3, 0.7, 0.7, 1.0 / n)};
  PointsAtTheBorder(0.7, 1.0 / n, 2, scene);
  return scene;
}
Scene BorderOfADisc(int n) {
  Scene scene;
  scene.features = {Feature::SizeDisc(1, 0.5, 0.5, 0.2, 1.0 / n)};
  PointsAtTheBorder(0.7, 1.0 / n, 2, scene);
  return scene;
}
Scene BorderOfABox(int n) {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  scene.features = {
      Feature::Size(1, {0.3, 0.3, 0.3}, {SizeShape::kBox, 1.0 / n, 0, {0.7, 0.7, 0.7}})};
  PointsAtTheBorder(0.7, 1.0 / n, 3, scene);
  return scene;
}

// Points beside a wall, parallel to an axis, along which there is a target of 1 / n.
Scene WallWithATarget(int n) {
  Scene scene;
  const double h = 1.0 / n, y = 0.37;
  AddSegment(0, 0.02, y, 0.98, y, scene);
  scene.features.push_back(Feature::SizeCapsule(kFar + 1, {{0.02, y}, {0.98, y}}, 0, h));
  Random random(7);
  for (int k = 0; k < 12; ++k) {
    const double x = 0.1 + 0.8 * random.Unit();
    InAndOut(Feature::Point(kFar, x, y + (k % 2 == 0 ? h : -h) * (0.4 + 1.2 * random.Unit())),
             scene);
  }
  return scene;
}
// The same in 3D.
Scene SegmentWithATarget(int n) {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  const double h = 1.0 / n, y = 0.37, z = 0.61;
  scene.features = {Feature::Point(1, 0.02, y, z), Feature::Point(2, 0.98, y, z),
                    Feature::Segment(3, 1, 2),
                    Feature::SizeCapsule(4, {{0.02, y, z}, {0.98, y, z}}, 0, h)};
  Random random(7);
  for (int k = 0; k < 8; ++k) {
    const double x = 0.1 + 0.8 * random.Unit();
    InAndOut(Feature::Point(kFar, x, y + (0.4 + 1.2 * random.Unit()) * h, z), scene);
  }
  return scene;
}

// A point among discs of all targets between 1 / n and 4 / n, as a field of sizes has them.
Scene DiscsOfManyTargets(int n) {
  Scene scene;
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const double x = random.Unit(), y = random.Unit();
    scene.features.push_back(Feature::SizeDisc(Id(i + 1), x, y, 0.05 + 0.1 * random.Unit(),
                                               (1 + 3 * random.Unit()) / n));
  }
  for (int k = 0; k < 12; ++k) {
    const double x = 0.1 + 0.8 * random.Unit();
    InAndOut(Feature::Point(kFar, x, 0.1 + 0.8 * random.Unit()), scene);
  }
  return scene;
}

// --- Sizes without effect ------------------------------------------------------------------

// Over points that are nearer to each other.
Scene SizeOverFinerPoints(int n) {
  Scene scene;
  scene.features = MakeFeatures(Distribution::kUniform, n, 7);
  InAndOut(Feature::SizeBox(kFar, 0, 0, 1, 1, 0.9), scene);
  return scene;
}

// The first size in a mesh of points: from now on feature positions matter, and none has moved.
Scene FirstSize(int n) {
  Scene scene;
  scene.features = MakeFeatures(Distribution::kUniform, n, 7);
  InAndOut(Feature::SizeDisc(kFar, 0.5, 0.5, 1e-3, 3e-4), scene);
  return scene;
}

// Discs of a coarse target over a fine one.
Scene CoarseSizesOverAFineOne(int n) {
  Scene scene;
  const double fine = 0.5 / n;
  scene.features = {Feature::SizeBox(1, 0.2, 0.2, 0.8, 0.8, fine)};
  for (int k = 0; k < 3; ++k) {
    InAndOut(Feature::SizeDisc(kFar + Id(k), 0.4 + 0.1 * k, 0.5, 0.05, 8 * fine), scene);
  }
  return scene;
}

// --- In 3D --------------------------------------------------------------------------------

// n by n parallel lines; one is taken out and put back.
Scene ParallelLines(int n) {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  for (int i = 0; i < n * n; ++i) {
    const double y = (i / n) / static_cast<double>(n), z = (i % n) / static_cast<double>(n);
    const FeatureId id = Id(3 * i + 1);
    scene.features.push_back(Feature::Point(id, 0, y, z));
    scene.features.push_back(Feature::Point(id + 1, 1, y, z));
    scene.features.push_back(Feature::Segment(id + 2, id, id + 1));
  }
  const FeatureId middle = Id(3 * (n / 2 * n + n / 2) + 1);
  OutAndIn(Feature::Segment(middle + 2, middle, middle + 1), scene);
  return scene;
}

}  // namespace

const std::vector<LocalityScene>& LocalityScenes() {
  static const auto* const scenes = [] {
    auto* const all = new std::vector<LocalityScene>{
        {"PointsInTheCorner", PointsInTheCorner, 500, 8000, 70, 16},
        {"SegmentsInTheCorner", SegmentsInTheCorner, 400, 6400, 60, 16},
        {"Channel", Channel, 50, 800, 250, 140},
        {"Comb", Comb, 20, 80, 90, 20},
        {"Fan", Fan, 20, 80, 150, 40},
        {"Spokes", Spokes, 100, 1600, 180, 15},
        {"RotorInAPlate", RotorInAPlate, 30, 120, 420, 260},
        {"DiscInAPlate", DiscInAPlate, 30, 120, 350, 110},
        {"CapsuleInAPlate", CapsuleInAPlate, 30, 120, 350, 160},
        {"CapsuleBesideAChain", CapsuleBesideAChain, 10, 40, 400, 100},
        {"PointsInAPlate", PointsInAPlate, 20, 80, 60, 20},
        {"CrackInAPlate", CrackInAPlate, 30, 120, 90, 30},
        {"PointsInASizedBox", PointsInASizedBox, 6, 14, 90, 20},
        {"BorderOfAnArea", BorderOfAnArea, 50, 400, 30, 12},
        {"BorderOfADisc", BorderOfADisc, 50, 400, 40, 18},
        {"BorderOfABox", BorderOfABox, 30, 60, 55, 16},
        {"DiscsOfManyTargets", DiscsOfManyTargets, 50, 200, 50, 25},
        {"WallWithATarget", WallWithATarget, 669, 10'692, 80, 40},
        {"SegmentWithATarget", SegmentWithATarget, 55, 218, 120, 60},
        {"SizeOverFinerPoints", SizeOverFinerPoints, 1000, 16'000, 90, 30},
        {"FirstSize", FirstSize, 1000, 64'000, 440, 200},
        {"CoarseSizesOverAFineOne", CoarseSizesOverAFineOne, 10, 40, 60, 0},
        {"ParallelLines", ParallelLines, 5, 10, 400, 60},
    };
    for (const LocalityScene& scene : SpaceLocalityScenes()) all->push_back(scene);
    return all;
  }();
  return *scenes;
}

}  // namespace dynmesh::test
