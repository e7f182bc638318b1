#include "tests/support/workload.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/space_workload.h"

namespace dynmesh::test {
namespace {

// A lattice of cells with a cross, an L or a single segment in some: segments that
// meet at right angles only.
std::vector<Feature> SegmentsOnLattice(int n, double turn, Random& random) {
  std::vector<Feature> features;
  const int side = std::max(1, static_cast<int>(std::sqrt(n / 3.0)));
  const double c = std::cos(turn), s = std::sin(turn);
  FeatureId id = 0;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double x = (i + 0.5) / side - 0.5, y = (j + 0.5) / side - 0.5;
      const double reach = (0.05 + 0.4 * random.Unit()) / side;
      const auto at = [&](double dx, double dy) {
        const double u = 0.7 * (x + dx), v = 0.7 * (y + dy);
        features.push_back(Feature::Point(++id, 0.5 + c * u - s * v, 0.5 + s * u + c * v));
        return id;
      };
      const FeatureId middle = at(0, 0);
      if (random.OneIn(4)) continue;
      const FeatureId east = at(reach, 0);
      const bool corner = random.OneIn(2);
      const FeatureId north = corner ? at(0, reach * (0.3 + random.Unit())) : kNoFeature;
      const bool across = random.OneIn(3);
      const FeatureId west = across ? at(-reach, 0) : kNoFeature;
      features.push_back(Feature::Segment(++id, middle, east));
      if (corner) features.push_back(Feature::Segment(++id, north, middle));
      if (across) features.push_back(Feature::Segment(++id, west, middle));
    }
  }
  return features;
}

std::vector<Feature> Diagonals(int n, Random& random) {
  std::vector<Feature> features;
  const int side = std::max(1, static_cast<int>(std::sqrt(n)) - 1);
  const auto id_at = [&](int i, int j) { return static_cast<FeatureId>(1 + i * (side + 1) + j); };
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j) {
      features.push_back(Feature::Point(id_at(i, j), i / 8.0, j / 8.0));
    }
  }
  FeatureId id = id_at(side, side) + 1;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      if (random.OneIn(2)) features.push_back(Feature::Segment(id++, id_at(i, j), id_at(i + 1, j)));
      if (random.OneIn(2)) features.push_back(Feature::Segment(id++, id_at(i, j), id_at(i, j + 1)));
      if (random.OneIn(3)) continue;
      features.push_back(random.OneIn(2)
                             ? Feature::Segment(id++, id_at(i, j), id_at(i + 1, j + 1))
                             : Feature::Segment(id++, id_at(i + 1, j), id_at(i, j + 1)));
    }
  }
  return features;
}

// A bundle of segments side by side, gaps much narrower than they are long, and points
// just off them: midpoints of one encroach on the others, in long cascades.
std::vector<Feature> Parallel(int n, Random& random) {
  std::vector<Feature> features;
  FeatureId id = 0;
  double y = 0.3;
  while (static_cast<int>(features.size()) < n && y < 0.95) {
    const double left = 0.1 + 0.3 * random.Unit();
    const double right = left + 0.1 + 0.5 * random.Unit();
    features.push_back(Feature::Point(++id, left, y));
    features.push_back(Feature::Point(++id, right, y + 0.01 * (random.Unit() - 0.5)));
    features.push_back(Feature::Segment(id + 1, id - 1, id));
    ++id;
    if (random.OneIn(2)) {
      const double x = left + (right - left) * random.Unit();
      features.push_back(Feature::Point(++id, x, y + 0.01 + 0.01 * random.Unit()));
    }
    y += 0.025 + 0.05 * random.Unit();
  }
  return features;
}

// On a lattice of cells: a fan of two to six segments, the angle from one to the next
// anything from 0.002 to 120 degrees, some of equal length; now and then two ends next to
// each other are joined, which makes two more sharp angles.
std::vector<Feature> Wedges(int n, Random& random) {
  std::vector<Feature> features;
  const int side = std::max(1, static_cast<int>(std::sqrt(n / 8.0)));
  FeatureId id = 0;
  const auto point = [&](double x, double y) {
    features.push_back(Feature::Point(++id, x, y));
    return id;
  };
  for (int cell = 0; cell < side * side; ++cell) {
    const double x = (cell / side + 0.5) / side, y = (cell % side + 0.5) / side;
    const FeatureId apex = point(x, y);
    const double length = 0.45 / side;
    double angle = 2 * std::numbers::pi * random.Unit();
    const double end = angle + 1.9 * std::numbers::pi;
    FeatureId last = kNoFeature;  // the tip of the segment before, if as long as can be
    for (int spokes = 2 + random.Below(5); spokes > 0 && angle < end; --spokes) {
      const double r = random.OneIn(2) ? length
                                       : length * std::ldexp(1.0, -random.Below(6)) *
                                             (0.5 + 0.5 * random.Unit());
      const FeatureId tip = point(x + r * std::cos(angle), y + r * std::sin(angle));
      features.push_back(Feature::Segment(++id, apex, tip));
      if (r == length && last != kNoFeature && random.OneIn(3)) {
        features.push_back(Feature::Segment(++id, last, tip));
      }
      last = r == length ? tip : kNoFeature;
      angle += (random.OneIn(2) ? 2.1 : 0.3) * std::ldexp(random.Unit(), -random.Below(16)) + 4e-5;
    }
  }
  return features;
}

// Points, a few segments, and regions that ask for lengths between the features' and far
// below; some overlap, some poke out of the box.
std::vector<Feature> Sized(int n, Random& random) {
  std::vector<Feature> features;
  FeatureId id = 0;
  const int points = std::max(2, n / 2);
  for (int i = 0; i < points; ++i) {
    const double x = random.Unit();
    features.push_back(Feature::Point(++id, x, random.Unit()));
  }
  const int rows = std::max(1, n / 8);
  for (int i = 0; i < rows; ++i) {
    const double y = (i + 0.5) / rows;
    features.push_back(Feature::Point(++id, 0.3 + 0.1 * random.Unit(), y));
    features.push_back(Feature::Point(++id, 0.6 + 0.1 * random.Unit(), y));
    features.push_back(Feature::Segment(id + 1, id - 1, id));
    ++id;
  }
  for (int i = 0; i < std::max(2, n / 6); ++i) {
    const double x = random.Unit(), y = random.Unit();
    const double size = std::ldexp(0.5 + random.Unit(), -2 - random.Below(4));
    const double target = size * std::ldexp(0.5 + random.Unit(), -random.Below(3));
    switch (random.Below(3)) {
      case 0:
        features.push_back(Feature::SizeAt(++id, x, y, 0.1 * target));
        break;
      case 1:
        features.push_back(Feature::SizeDisc(++id, x, y, 0.5 * size, target));
        break;
      default:
        features.push_back(
            Feature::SizeBox(++id, x, y, x + size, y + size * random.Unit(), target));
    }
  }
  return features;
}

// As Sized, with capsules and a few discs. Some capsules are thinner than their target, some lie
// over each other, some poke out of the box.
std::vector<Feature> Capsules(int n, Random& random) {
  std::vector<Feature> features;
  FeatureId id = 0;
  for (int i = 0; i < std::max(2, n / 2); ++i) {
    const double x = random.Unit();
    features.push_back(Feature::Point(++id, x, random.Unit()));
  }
  const int rows = std::max(1, n / 8);
  for (int i = 0; i < rows; ++i) {
    const double y = (i + 0.5) / rows;
    features.push_back(Feature::Point(++id, 0.1 + 0.2 * random.Unit(), y));
    features.push_back(Feature::Point(++id, 0.6 + 0.3 * random.Unit(), y));
    features.push_back(Feature::Segment(id + 1, id - 1, id));
    ++id;
  }
  for (int i = 0; i < std::max(3, n / 8); ++i) {
    const double size = std::ldexp(0.5 + random.Unit(), -2 - random.Below(4));
    const double target = size * (0.15 + 0.5 * random.Unit());
    if (random.OneIn(5)) {
      const double x = random.Unit();
      features.push_back(Feature::SizeDisc(++id, x, random.Unit(), 0.5 * size, target));
      continue;
    }
    const double radius = std::ldexp(size, -1 - random.Below(6));
    features.push_back(
        Feature::SizeCapsule(++id, RandomPath(random, 2, 2 * size, 6), radius, target));
  }
  return features;
}

// Rectangles of cells of a crooked grid, with edges of the grid as their edges: they share some,
// are nested, touch; some have a hole, some a second part. Segment features on some edges of the
// grid, and sizing regions with such rings.
std::vector<Feature> Polygons(int n, Random& random) {
  std::vector<Feature> features;
  const int side = std::max(3, static_cast<int>(std::sqrt(n)) - 1);
  const auto id_at = [&](int i, int j) { return static_cast<FeatureId>(1 + i * (side + 1) + j); };
  for (int i = 0; i <= side; ++i) {
    for (int j = 0; j <= side; ++j) {
      const double x = (i + 0.5 + 0.3 * (random.Unit() - 0.5)) / (side + 1);
      const double y = (j + 0.5 + 0.3 * (random.Unit() - 0.5)) / (side + 1);
      features.push_back(Feature::Point(id_at(i, j), x, y));
    }
  }
  FeatureId id = id_at(side, side);
  const auto ring = [&](int i0, int j0, int i1, int j1) {
    std::vector<FeatureId> points;
    for (int i = i0; i < i1; ++i) points.push_back(id_at(i, j0));
    for (int j = j0; j < j1; ++j) points.push_back(id_at(i1, j));
    for (int i = i1; i > i0; --i) points.push_back(id_at(i, j1));
    for (int j = j1; j > j0; --j) points.push_back(id_at(i0, j));
    std::rotate(points.begin(), points.begin() + random.Below(static_cast<int>(points.size())),
                points.end());
    if (random.OneIn(2)) std::reverse(points.begin(), points.end());
    return points;
  };
  for (int k = 0; k < std::max(2, n / 5); ++k) {
    const int i0 = random.Below(side), j0 = random.Below(side);
    const int i1 = i0 + 1 + random.Below(side - i0), j1 = j0 + 1 + random.Below(side - j0);
    Rings rings = {ring(i0, j0, i1, j1)};
    if (i1 - i0 > 2 && j1 - j0 > 2) rings.push_back(ring(i0 + 1, j0 + 1, i1 - 1, j1 - 1));
    if (i1 + 1 < side && random.OneIn(2)) rings.push_back(ring(i1 + 1, 0, side, side));
    const double target = std::ldexp(0.5 + random.Unit(), -4 - random.Below(2));
    features.push_back(random.OneIn(8) ? Feature::SizePolygon(++id, std::move(rings), target)
                                       : Feature::Polygon(++id, std::move(rings)));
  }
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      if (random.OneIn(6)) {
        features.push_back(Feature::Segment(++id, id_at(i, j), id_at(i + 1, j)));
      }
    }
  }
  return features;
}

}  // namespace

Path RandomPath(Random& random, int dimension, double length, int most) {
  const auto axes = static_cast<std::size_t>(dimension);
  std::array<double, 3> at = {0, 0, 0};
  for (std::size_t k = 0; k < axes; ++k) at[k] = random.Unit();
  Path path = {at};
  const int edges = 1 + random.Below(most);
  for (int i = 0; i < edges; ++i) {
    const int kind = random.Below(8);
    const Path::value_type before = path.size() > 1 ? path[path.size() - 2] : at;
    for (std::size_t k = 0; k < axes; ++k) {
      double step = length * (2 * random.Unit() - 1);
      if (kind == 0) step = before[k] - at[k];          // back
      if (kind == 1) step = 0.5 * (at[k] - before[k]);  // on
      at[k] = std::clamp(at[k] + step, 0.0, 1.0);
    }
    if (at != path.back()) path.push_back(at);
    at = path.back();
  }
  if (path.size() > 2 && path.back() != path.front() && random.OneIn(4))
    path.push_back(path.front());
  if (path.size() == 1) {
    at[0] += at[0] < 0.5 ? 0.25 : -0.25;
    path.push_back(at);
  }
  return path;
}

std::vector<FeatureId> PointsOf(const Feature& feature) {
  std::vector<FeatureId> points;
  if (feature.kind == FeatureKind::kSegment) points = {feature.ends[0], feature.ends[1]};
  for (const auto& ring : feature.rings) points.insert(points.end(), ring.begin(), ring.end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  return points;
}

std::string NameOf(Distribution d) {
  switch (d) {
    case Distribution::kUniform:
      return "Uniform";
    case Distribution::kClustered:
      return "Clustered";
    case Distribution::kCircle:
      return "Circle";
    case Distribution::kGrid:
      return "Grid";
    case Distribution::kLine:
      return "Line";
    case Distribution::kDyadicLine:
      return "DyadicLine";
    case Distribution::kTwoScale:
      return "TwoScale";
    case Distribution::kSegmentsAxis:
      return "SegmentsAxis";
    case Distribution::kSegmentsTurned:
      return "SegmentsTurned";
    case Distribution::kDiagonals:
      return "Diagonals";
    case Distribution::kParallel:
      return "Parallel";
    case Distribution::kWedges:
      return "Wedges";
    case Distribution::kSized:
      return "Sized";
    case Distribution::kPolygons:
      return "Polygons";
    case Distribution::kCapsules:
      return "Capsules";
    case Distribution::kSpaceUniform:
      return "SpaceUniform";
    case Distribution::kSpaceClustered:
      return "SpaceClustered";
    case Distribution::kSpaceGrid:
      return "SpaceGrid";
    case Distribution::kSphere:
      return "Sphere";
    case Distribution::kLineAndCircle:
      return "LineAndCircle";
    case Distribution::kSpaceTwoScale:
      return "SpaceTwoScale";
    case Distribution::kGridEdges:
      return "GridEdges";
    case Distribution::kTurnedGridEdges:
      return "TurnedGridEdges";
    case Distribution::kSkewGridEdges:
      return "SkewGridEdges";
    case Distribution::kSpaceSized:
      return "SpaceSized";
    case Distribution::kSpaceCapsules:
      return "SpaceCapsules";
  }
  return "?";
}

bool HasSegments(Distribution d) {
  return d == Distribution::kSegmentsAxis || d == Distribution::kSegmentsTurned ||
         d == Distribution::kDiagonals || d == Distribution::kParallel ||
         d == Distribution::kWedges || d == Distribution::kSized || d == Distribution::kPolygons ||
         d == Distribution::kCapsules || d >= Distribution::kGridEdges;
}

std::vector<Feature> MakeFeatures(Distribution d, int n, std::uint64_t seed) {
  Random random(seed);
  std::vector<Feature> features;
  const auto add = [&](double x, double y) {
    features.push_back(Feature::Point(features.size() + 1, x, y));
  };
  switch (d) {
    case Distribution::kUniform:
      for (int i = 0; i < n; ++i) {
        const double x = random.Unit();
        add(x, random.Unit());
      }
      break;
    case Distribution::kClustered: {
      double cx = 0.5, cy = 0.5, spread = 0.1;
      for (int i = 0; i < n; ++i) {
        if (i % 20 == 0) {
          cx = 0.1 + 0.8 * random.Unit();
          cy = 0.1 + 0.8 * random.Unit();
          spread = 0.1 * std::ldexp(1.0, -random.Below(14));
        }
        const double x = cx + spread * (random.Unit() - 0.5);
        add(x, cy + spread * (random.Unit() - 0.5));
      }
      break;
    }
    case Distribution::kCircle:
      for (int i = 0; i < n; ++i) {
        const double a = 2 * std::numbers::pi * i / n;
        add(0.5 + 0.4 * std::cos(a), 0.5 + 0.4 * std::sin(a));
      }
      break;
    case Distribution::kGrid: {
      const int side = std::max(1, static_cast<int>(std::sqrt(n)));
      const double step = std::ldexp(1.0, -static_cast<int>(std::ceil(std::log2(side))));
      for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side; ++j) add(i * step, j * step);
      }
      break;
    }
    case Distribution::kLine:
      for (int i = 0; i < n; ++i) add((i + 0.5) / n, 0.5);
      break;
    case Distribution::kDyadicLine: {
      const double step = std::ldexp(1.0, -static_cast<int>(std::ceil(std::log2(n))));
      for (int i = 0; i < n; ++i) add(i * step, 0.5);
      break;
    }
    case Distribution::kTwoScale:
      for (int i = 0; i < (n + 1) / 2; ++i) {
        const double x = random.Unit() * 0.9, y = random.Unit();
        add(x, y);
        if (i % 3 == 0) add(x + 0x1p-40, y);
      }
      break;
    case Distribution::kSegmentsAxis:
      return SegmentsOnLattice(n, 0, random);
    case Distribution::kSegmentsTurned:
      return SegmentsOnLattice(n, 0.3, random);
    case Distribution::kDiagonals:
      return Diagonals(std::min(n, 64), random);
    case Distribution::kParallel:
      return Parallel(n, random);
    case Distribution::kWedges:
      return Wedges(n, random);
    case Distribution::kSized:
      return Sized(n, random);
    case Distribution::kPolygons:
      return Polygons(n, random);
    case Distribution::kCapsules:
      return Capsules(n, random);
    default:
      return MakeSpaceFeatures(d, n, seed);
  }
  return features;
}

}  // namespace dynmesh::test
