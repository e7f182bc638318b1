#include "tests/bench/edit_scenes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <utility>

#include "absl/container/flat_hash_set.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

using test::Distribution;
using test::Random;

// Makes features with ids from 1.
class Maker {
 public:
  FeatureId Point(double x, double y, double z = 0) { return Put(Feature::Point(Next(), x, y, z)); }
  FeatureId Segment(FeatureId p, FeatureId q) { return Put(Feature::Segment(Next(), p, q)); }
  FeatureId Polygon(std::vector<FeatureId> ring) {
    return Put(Feature::Polygon(Next(), {std::move(ring)}));
  }
  std::vector<Feature> Take() { return std::move(features_); }

 private:
  FeatureId Next() const { return features_.size() + 1; }
  FeatureId Put(const Feature& f) {
    features_.push_back(f);
    return f.id;
  }
  std::vector<Feature> features_;
};

// sqrt(n) / 4 lines across the square, and points between them.
std::vector<Feature> LongSegments(int n) {
  Maker make;
  Random random(1);
  const int lines = std::max(4, static_cast<int>(std::sqrt(n) / 4));
  for (int i = 0; i < lines; ++i) {
    const double y = (i + 0.5) / lines;
    make.Segment(make.Point(0.02, y), make.Point(0.98, y));
  }
  for (int i = 0; i < n; ++i) {
    const double between = 0.1 + 0.8 * random.Unit();  // of the way from line to line
    const int line = random.Below(lines - 1);
    make.Point(0.02 + 0.96 * random.Unit(), (line + 0.5 + between) / lines);
  }
  return make.Take();
}

// A base with n / 4 teeth: the nearer they are, the more vertices each carries.
std::vector<Feature> Comb(int n) {
  Maker make;
  const int teeth = n / 4;
  FeatureId before = kNoFeature;
  for (int i = 0; i < teeth; ++i) {
    const double x = 0.05 + 0.9 * i / (teeth - 1);
    const FeatureId foot = make.Point(x, 0.1);
    if (before != kNoFeature) make.Segment(before, foot);
    make.Segment(foot, make.Point(x, 0.3));
    before = foot;
  }
  return make.Take();
}

// Corners of a box: bit k of the index says which side.
std::array<FeatureId, 8> Corners(Maker& make, const std::array<double, 3>& lo, double side) {
  std::array<FeatureId, 8> corners;
  for (std::size_t i = 0; i < 8; ++i) {
    const auto at = [&](std::size_t k) { return lo[k] + ((i >> k & 1) != 0 ? side : 0); };
    corners[i] = make.Point(at(0), at(1), at(2));
  }
  return corners;
}

// A grid of boxes, each of six polygons.
std::vector<Feature> Boxes(int n) {
  Maker make;
  const int along = std::max(2, static_cast<int>(std::cbrt(n / 14.0)));
  const double pitch = 1.0 / along, side = 0.5 * pitch;
  for (int i = 0; i < along * along * along; ++i) {
    const auto at = [&](int k) { return (k + 0.25) * pitch; };
    const auto c =
        Corners(make, {at(i % along), at(i / along % along), at(i / along / along)}, side);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t x = std::size_t{1} << (k + 1) % 3, y = std::size_t{1} << (k + 2) % 3;
      for (const std::size_t from : {std::size_t{0}, std::size_t{1} << k}) {
        make.Polygon({c[from], c[from | x], c[from | x | y], c[from | y]});
      }
    }
  }
  return make.Take();
}

// Squares above each other, as wide as the cube: cbrt(n) / 2 of them, and points between them.
std::vector<Feature> LongPlates(int n) {
  Maker make;
  Random random(1);
  const int plates = std::max(3, static_cast<int>(std::cbrt(n) / 2));
  for (int i = 0; i < plates; ++i) {
    const double z = (i + 0.5) / plates;
    make.Polygon({make.Point(0.02, 0.02, z), make.Point(0.98, 0.02, z), make.Point(0.98, 0.98, z),
                  make.Point(0.02, 0.98, z)});
  }
  for (int i = 0; i < n; ++i) {
    const double z = (random.Below(plates - 1) + 0.6 + 0.8 * random.Unit()) / plates;
    make.Point(0.05 + 0.9 * random.Unit(), 0.05 + 0.9 * random.Unit(), z);
  }
  return make.Take();
}

struct Scene {
  const char* name;
  int dimension;
  std::function<std::vector<Feature>(int)> make;
  FeatureKind edited;
  int most = 1'000'000;
};
std::function<std::vector<Feature>(int)> Of(Distribution d) {
  return [d](int n) { return test::MakeFeatures(d, n, 1); };
}
const std::vector<Scene>& Scenes() {
  using enum FeatureKind;
  static const std::vector<Scene> scenes = {
      {"points, uniform", 2, Of(Distribution::kUniform), kPoint},
      {"points, clustered", 2, Of(Distribution::kClustered), kPoint},
      {"points, circle", 2, Of(Distribution::kCircle), kPoint},
      {"points, two scales", 2, Of(Distribution::kTwoScale), kPoint},
      {"segments, short", 2, Of(Distribution::kSegmentsTurned), kSegment},
      {"segments, long", 2, LongSegments, kSegment},
      {"points beside long segments", 2, LongSegments, kPoint},
      {"teeth of a comb", 2, Comb, kSegment, 10'000},  // n^2 / 80 vertices
      {"polygons", 2, Of(Distribution::kPolygons), kPolygon, 10'000},
      {"points, uniform, 3D", 3, Of(Distribution::kSpaceUniform), kPoint},
      {"points, clustered, 3D", 3, Of(Distribution::kSpaceClustered), kPoint},
      {"points, line and circle, 3D", 3, Of(Distribution::kLineAndCircle), kPoint},
      {"points, two scales, 3D", 3, Of(Distribution::kSpaceTwoScale), kPoint},
      {"segments, short, 3D", 3, Of(Distribution::kTurnedGridEdges), kSegment},
      {"polygons of boxes, 3D", 3, Boxes, kPolygon},
      {"polygons, long, 3D", 3, LongPlates, kPolygon},
      {"points beside long polygons, 3D", 3, LongPlates, kPoint}};
  return scenes;
}

const Scene& SceneOf(const std::string& name) {
  return *std::ranges::find(Scenes(), name, &Scene::name);
}

}  // namespace

int MostFeatures(const std::string& name) { return SceneOf(name).most; }

std::vector<std::string> EditSceneNames() {
  std::vector<std::string> names;
  for (const Scene& scene : Scenes()) names.emplace_back(scene.name);
  return names;
}

EditScene MakeEditScene(const std::string& name, int n) {
  const Scene& scene = SceneOf(name);
  EditScene made = {name, scene.dimension, scene.make(n), {}};
  // Quadtrees have no sizing features.
  std::erase_if(made.features, [](const Feature& f) { return f.kind == FeatureKind::kSize; });
  absl::flat_hash_set<FeatureId> used;
  for (const Feature& f : made.features) {
    for (const FeatureId id : test::PointsOf(f)) used.insert(id);
  }
  for (std::size_t i = 0; i < made.features.size(); ++i) {
    const Feature& f = made.features[i];
    if (f.kind == scene.edited && !used.contains(f.id)) made.edited.push_back(i);
  }
  return made;
}

}  // namespace dynmesh
