#include "tests/support/space_workload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace dynmesh::test {
namespace {

using Place = std::array<double, 3>;

// Of a distribution of points, the i-th of n.
Place PlaceOf(Distribution d, int i, int n, Random& random) {
  const double x = random.Unit(), y = random.Unit(), z = random.Unit();
  const int side = std::max(1, static_cast<int>(std::cbrt(n)));
  const double step = std::ldexp(1.0, -static_cast<int>(std::ceil(std::log2(side))));
  const Place cell = {i % side * step, i / side % side * step, i / (side * side) * step};
  switch (d) {
    case Distribution::kSpaceClustered: {
      const double scale = std::ldexp(1.0, -random.Below(12));
      return {0.3 + 0.5 * scale * x, 0.6 - 0.5 * scale * y, 0.2 + 0.5 * scale * z};
    }
    case Distribution::kSpaceGrid:
      return cell;
    case Distribution::kSphere: {
      const double height = 2 * z - 1, r = std::sqrt(1 - height * height);
      const double turn = 2 * std::numbers::pi * x;
      return {0.5 + 0.45 * r * std::cos(turn), 0.5 + 0.45 * r * std::sin(turn),
              0.5 + 0.45 * height};
    }
    case Distribution::kLineAndCircle: {
      // So many tetrahedra between the two as there are pairs.
      if (i % 2 == 0) return {0.5, 0.5, (i + 0.5) / n};
      const double turn = 2 * std::numbers::pi * i / n;
      return {0.5 + 0.4 * std::cos(turn), 0.5 + 0.4 * std::sin(turn), 0.5};
    }
    case Distribution::kSpaceTwoScale:
      return {cell[0] + (random.OneIn(2) ? 0x1p-30 : 0), cell[1], cell[2]};
    default:
      return {x, y, z};
  }
}

// The point of the unit cube that a point of a grid comes to.
Place GridPlace(Distribution d, double x, double y, double z) {
  if (d == Distribution::kTurnedGridEdges) {
    return {0.45 + 0.8 * x - 0.6 * y, 0.1 + 0.6 * x + 0.8 * y, 0.25 + z};
  }
  // Columns lean to one side by 66 degrees, rows to another by 72.
  if (d == Distribution::kSkewGridEdges) {
    return {0.1 + x + 0.3 * y + 0.4 * z, 0.2 + 0.92 * y + 0.1 * z, 0.2 + 0.9 * z};
  }
  return {0.25 + x, 0.25 + y, 0.25 + z};
}

// A grid of points and some of its edges: at right angles, or in one line, where they meet, but
// for skew ones.
std::vector<Feature> GridEdges(Distribution d, int n, Random& random) {
  const int side = std::clamp(static_cast<int>(std::cbrt(n)), 2, 8);
  const auto id_at = [&](int i, int j, int k) {
    return static_cast<FeatureId>(1 + i + side * (j + side * k));
  };
  std::vector<Feature> features;
  const double step = 0.5 / side;
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const Place p = GridPlace(d, i * step, j * step, k * step);
        features.push_back(Feature::Point(id_at(i, j, k), p[0], p[1], p[2]));
      }
    }
  }
  FeatureId id = id_at(side - 1, side - 1, side - 1);
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        const auto join = [&](int to_i, int to_j, int to_k) {
          if (std::max({to_i, to_j, to_k}) == side || random.OneIn(3)) return;
          features.push_back(Feature::Segment(++id, id_at(i, j, k), id_at(to_i, to_j, to_k)));
        };
        join(i + 1, j, k);
        join(i, j + 1, k);
        join(i, j, k + 1);
      }
    }
  }
  return features;
}

// Points, a few segments side by side, and regions that ask for lengths down to a part of the
// features'; some overlap, some poke out of the box.
std::vector<Feature> SizedInSpace(int n, Random& random) {
  std::vector<Feature> features;
  FeatureId id = 0;
  const auto any = [&]() -> Place {
    const double x = random.Unit(), y = random.Unit();
    return {x, y, random.Unit()};
  };
  for (int i = 0; i < std::max(2, n / 2); ++i) {
    const Place p = any();
    features.push_back(Feature::Point(++id, p[0], p[1], p[2]));
  }
  const int rows = std::max(1, n / 8);
  for (int i = 0; i < rows; ++i) {
    const double z = (i + 0.5) / rows;
    features.push_back(Feature::Point(++id, 0.3 + 0.1 * random.Unit(), 0.5, z));
    features.push_back(Feature::Point(++id, 0.6 + 0.1 * random.Unit(), 0.4, z));
    features.push_back(Feature::Segment(id + 1, id - 1, id));
    ++id;
  }
  for (int i = 0; i < std::max(2, n / 6); ++i) {
    const Place p = any();
    const double size = std::ldexp(0.5 + random.Unit(), -2 - random.Below(2));
    Sizing sizing;
    sizing.shape = static_cast<SizeShape>(1 + random.Below(3));
    sizing.target = size * (0.4 + 0.6 * random.Unit());
    if (sizing.shape == SizeShape::kPoint) sizing.target *= 0.2;
    if (sizing.shape == SizeShape::kDisc) sizing.radius = 0.5 * size;
    for (std::size_t k = 0; k < 3 && sizing.shape == SizeShape::kBox; ++k) {
      sizing.hi[k] = p[k] + size * random.Unit();
    }
    features.push_back(Feature::Size(++id, p, sizing));
  }
  return features;
}

// As SizedInSpace, with capsules and a few balls.
std::vector<Feature> CapsulesInSpace(int n, Random& random) {
  std::vector<Feature> features;
  for (Feature& f : SizedInSpace(n, random)) {
    if (f.kind != FeatureKind::kSize) features.push_back(std::move(f));
  }
  FeatureId id = features.back().id;
  for (int i = 0; i < std::max(2, n / 8); ++i) {
    const double size = std::ldexp(0.5 + random.Unit(), -2 - random.Below(2));
    const double target = size * (0.4 + 0.6 * random.Unit());
    if (random.OneIn(5)) {
      const double x = random.Unit(), y = random.Unit();
      features.push_back(
          Feature::Size(++id, {x, y, random.Unit()}, {SizeShape::kDisc, target, 0.5 * size, {}}));
      continue;
    }
    const double radius = std::ldexp(size, -1 - random.Below(5));
    features.push_back(Feature::SizeCapsule(++id, RandomPath(random, 3, size, 4), radius, target));
  }
  return features;
}

}  // namespace

std::vector<Feature> MakeSpaceFeatures(Distribution d, int n, std::uint64_t seed) {
  Random random(seed);
  if (d == Distribution::kGridEdges || d == Distribution::kTurnedGridEdges ||
      d == Distribution::kSkewGridEdges) {
    return GridEdges(d, n, random);
  }
  if (d == Distribution::kSpaceSized) return SizedInSpace(n, random);
  if (d == Distribution::kSpaceCapsules) return CapsulesInSpace(n, random);
  std::vector<Feature> features;
  for (int i = 0; i < n; ++i) {
    const Place p = PlaceOf(d, i, n, random);
    features.push_back(Feature::Point(features.size() + 1, p[0], p[1], p[2]));
  }
  return features;
}

}  // namespace dynmesh::test
