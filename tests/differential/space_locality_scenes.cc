#include <array>
#include <cmath>
#include <numbers>

#include "tests/differential/locality_scenes.h"
#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

Scene InSpace() {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  return scene;
}

// The faces of a box; ids from `first` on.
void AddBox(FeatureId first, const std::array<double, 3>& lo, const std::array<double, 3>& hi,
            Scene& scene) {
  for (FeatureId i = 0; i < 8; ++i) {
    scene.features.push_back(Feature::Point(first + i, i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1],
                                            i & 4 ? hi[2] : lo[2]));
  }
  constexpr FeatureId kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                      {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
  for (FeatureId face = 0; face < 6; ++face) {
    const auto& c = kFaces[face];
    scene.features.push_back(Feature::Polygon(
        first + 8 + face, {{first + c[0], first + c[1], first + c[2], first + c[3]}}));
  }
}

// A box of thickness 1 / n; points in it and above it.
Scene Slab(int n) {
  Scene scene = InSpace();
  scene.options.box = {{-1, -1, -1}, {2, 2, 2}};
  const double t = 1.0 / n;
  AddBox(1, {0, 0, 0}, {1, 1, t}, scene);
  Random random(7);
  for (const double height : {0.5 * t, 0.4 * t, 3 * t, 1.3 * t}) {
    const double x = 0.2 + 0.6 * random.Unit();
    InAndOut(Feature::Point(kFar, x, 0.2 + 0.6 * random.Unit(), height), scene);
  }
  return scene;
}

// Between two plates that are tilted a little, and so far apart.
Scene TiltedPlates(int n) {
  Scene scene = InSpace();
  const double t = 0.5 / n;
  for (const int plate : {0, 1}) {
    const FeatureId first = Id(10 * plate + 1);
    const double z = 0.3 + plate * t;
    scene.features.push_back(Feature::Point(first, 0.2, 0.2, z));
    scene.features.push_back(Feature::Point(first + 1, 0.8, 0.2, z + 0.1));
    scene.features.push_back(Feature::Point(first + 2, 0.8, 0.8, z + 0.3));
    scene.features.push_back(Feature::Point(first + 3, 0.2, 0.8, z + 0.2));
    scene.features.push_back(
        Feature::Polygon(first + 4, {{first, first + 1, first + 2, first + 3}}));
  }
  for (const double along : {0.3, 0.5}) {
    const double z = 0.3 + 0.1 * (along - 0.2) / 0.6 + 0.2 * (0.5 - 0.2) / 0.6;
    InAndOut(Feature::Point(kFar, along, 0.5, z + 0.45 * t), scene);
  }
  return scene;
}

// Points beside a plate that goes through a small area with a target and far beyond it.
Scene PlateThroughASizedBox(int n) {
  Scene scene = InSpace();
  const double h = 1.0 / n;
  scene.features = {Feature::Point(1, 0.05, 0.05, 0.5),
                    Feature::Point(2, 0.95, 0.05, 0.5),
                    Feature::Point(3, 0.95, 0.95, 0.5),
                    Feature::Point(4, 0.05, 0.95, 0.5),
                    Feature::Polygon(5, {{1, 2, 3, 4}}),
                    Feature::Size(20, {0.4, 0.4, 0.4}, {SizeShape::kBox, h, 0, {0.6, 0.6, 0.6}})};
  Random random(7);
  for (const double beyond : {-1.0, 0.5, 2.0, 4.0}) {
    const double y = 0.42 + 0.16 * random.Unit();
    InAndOut(Feature::Point(kFar, 0.6 + beyond * h, y, 0.5 + 0.6 * h), scene);
  }
  return scene;
}

// Points beside the face of a box in an area with a target of 1 / n.
Scene FacetsInASizedBox(int n) {
  Scene scene = InSpace();
  const double h = 1.0 / n;
  AddBox(1, {0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}, scene);
  scene.features.push_back(Feature::Size(20, {0, 0, 0}, {SizeShape::kBox, h, 0, {1, 1, 1}}));
  Random random(7);
  for (const double above : {0.4, -0.6, 0.2}) {
    const double x = 0.3 + 0.4 * random.Unit();
    InAndOut(Feature::Point(kFar, x, 0.3 + 0.4 * random.Unit(), 0.2 + above * h), scene);
  }
  return scene;
}

// n^2 wedges of two sheets at 5 degrees. A sheet of the middle one leaves and comes back, and it
// shuts to 2 degrees.
Scene Wedges(int n) {
  Scene scene = InSpace();
  const double side = 0.9 / n;
  const auto outer = [&](int i, double degrees, double along) {
    const double x = 0.05 + side * (i % n + 0.1), y = 0.05 + side * (i / n + 0.3);
    const double turn = degrees * std::numbers::pi / 180;
    return std::array{x + 0.7 * side * std::cos(turn), y + 0.7 * side * std::sin(turn),
                      0.5 + 0.3 * side * along};
  };
  const auto add = [&](FeatureId id, const std::array<double, 3>& p) {
    scene.features.push_back(Feature::Point(id, p[0], p[1], p[2]));
  };
  for (int i = 0; i < n * n; ++i) {
    const FeatureId id = Id(10 * i + 1);
    const double x = 0.05 + side * (i % n + 0.1), y = 0.05 + side * (i / n + 0.3);
    add(id, {x, y, 0.5 - 0.3 * side});
    add(id + 1, {x, y, 0.5 + 0.3 * side});
    for (const int sheet : {0, 1}) {
      const FeatureId first = id + 2 + Id(2 * sheet);
      add(first, outer(i, 5.0 * sheet, 1));
      add(first + 1, outer(i, 5.0 * sheet, -1));
      scene.features.push_back(
          Feature::Polygon(id + 6 + Id(sheet), {{id, id + 1, first, first + 1}}));
    }
  }
  const int middle = n / 2 * n + n / 2;
  const FeatureId id = Id(10 * middle + 1);
  OutAndIn(Feature::Polygon(id + 7, {{id, id + 1, id + 4, id + 5}}), scene);
  for (const double degrees : {2.0, 5.0}) {
    EditBatch moved;
    for (const int end : {0, 1}) {
      const auto p = outer(middle, degrees, 1 - 2 * end);
      moved.push_back(Edit::Set(Feature::Point(id + 4 + Id(end), p[0], p[1], p[2])));
    }
    scene.edits.push_back(moved);
  }
  return scene;
}

// Triangles over a grid whose heights are random, as of a scan. A face in the middle leaves and
// comes back, and a corner moves.
Scene Scan(int n) {
  Scene scene = InSpace();
  Random random(7);
  const double side = 0.9 / n;
  const auto id = [&](int x, int y) { return Id(1 + x + (n + 1) * y); };
  const auto corner = [&](int x, int y) {
    return Feature::Point(id(x, y), 0.05 + side * (x + 0.2 * random.Unit()), 0.05 + side * y,
                          0.5 + 0.7 * side * random.Unit());
  };
  for (int y = 0; y <= n; ++y) {
    for (int x = 0; x <= n; ++x) scene.features.push_back(corner(x, y));
  }
  Feature middle;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      const FeatureId first = kFar + 2 * id(x, y);
      scene.features.push_back(
          Feature::Polygon(first, {{id(x, y), id(x + 1, y), id(x + 1, y + 1)}}));
      scene.features.push_back(
          Feature::Polygon(first + 1, {{id(x, y), id(x + 1, y + 1), id(x, y + 1)}}));
      if (x == n / 2 && y == n / 2) middle = scene.features.back();
    }
  }
  OutAndIn(middle, scene);
  for (int i = 0; i < 3; ++i) scene.edits.push_back({Edit::Set(corner(n / 2, n / 2))});
  return scene;
}

}  // namespace

std::vector<LocalityScene> SpaceLocalityScenes() {
  return {
      {"PlateThroughASizedBox", PlateThroughASizedBox, 20, 60, 320, 75},
      {"Slab", Slab, 12, 48, 700, 150},
      {"TiltedPlates", TiltedPlates, 12, 48, 750, 130},
      {"FacetsInASizedBox", FacetsInASizedBox, 12, 24, 180, 30},
      {"Wedges", Wedges, 3, 6, 1250, 340},
      {"Scan", Scan, 8, 20, 1200, 240},
  };
}

}  // namespace dynmesh::test
