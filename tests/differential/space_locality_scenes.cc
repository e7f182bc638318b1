#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "tests/differential/locality_scenes.h"
#include "tests/support/surfaces.h"
#include "tests/support/workload.h"

namespace dynmesh::test {
namespace {

Scene InSpace() {
  Scene scene;
  scene.options.dimension = 3;
  scene.options.quality = kDefaultQuality3D;
  return scene;
}

void AddAllOf(const std::vector<Feature>& features, Scene& scene) {
  scene.features.insert(scene.features.end(), features.begin(), features.end());
}

// A box of thickness 1 / n; points in it and above it.
Scene Slab(int n) {
  Scene scene = InSpace();
  scene.options.box = {{-1, -1, -1}, {2, 2, 2}};
  const double t = 1.0 / n;
  AddAllOf(BoxSurface(1, {0, 0, 0}, {1, 1, t}), scene);
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
  AddAllOf(BoxSurface(1, {0.2, 0.2, 0.2}, {0.8, 0.8, 0.8}), scene);
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
  // A corner of wedge i, at this distance from the edge and in this direction.
  const auto corner = [&](FeatureId id, int i, double distance, double degrees, int end) {
    const double x = 0.05 + side * (i % n + 0.1), y = 0.05 + side * (i / n + 0.3);
    const double turn = degrees * std::numbers::pi / 180;
    return Feature::Point(id, x + distance * side * std::cos(turn),
                          y + distance * side * std::sin(turn), 0.5 + 0.3 * side * end);
  };
  const auto outer = [&](FeatureId id, int i, double degrees, int end) {
    return corner(id, i, 0.7, degrees, end);
  };
  for (int i = 0; i < n * n; ++i) {
    const FeatureId id = Id(10 * i + 1);
    scene.features.push_back(corner(id, i, 0, 0, -1));
    scene.features.push_back(corner(id + 1, i, 0, 0, 1));
    for (const int sheet : {0, 1}) {
      const FeatureId first = id + 2 + Id(2 * sheet);
      scene.features.push_back(outer(first, i, 5.0 * sheet, 1));
      scene.features.push_back(outer(first + 1, i, 5.0 * sheet, -1));
      scene.features.push_back(
          Feature::Polygon(id + 6 + Id(sheet), {{id, id + 1, first, first + 1}}));
    }
  }
  const int middle = n / 2 * n + n / 2;
  const FeatureId id = Id(10 * middle + 1);
  OutAndIn(Feature::Polygon(id + 7, {{id, id + 1, id + 4, id + 5}}), scene);
  for (const double degrees : {2.0, 5.0}) {
    scene.edits.push_back({Edit::Set(outer(id + 4, middle, degrees, 1)),
                           Edit::Set(outer(id + 5, middle, degrees, -1))});
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
  const std::vector<Feature> triangles = GridTriangles(n, kFar, id);
  AddAllOf(triangles, scene);
  OutAndIn(triangles[static_cast<std::size_t>(2 * (n / 2 * n + n / 2) + 1)], scene);
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
