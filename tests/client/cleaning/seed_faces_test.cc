#include "client/cleaning/seed_faces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <utility>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/seed.h"

namespace dynmesh::cleaning::seed_faces_test {
namespace {

// Points by id, then closed chains and single segments between them.
class Drawing {
 public:
  FeatureId Point(double x, double y) {
    features_.push_back(Feature::Point(++last_, x, y));
    return last_;
  }
  void Segment(FeatureId p, FeatureId q) { features_.push_back(Feature::Segment(++last_, p, q)); }
  void Ring(const std::vector<FeatureId>& ring) {
    for (std::size_t i = 0; i < ring.size(); ++i) Segment(ring[i], ring[(i + 1) % ring.size()]);
  }
  std::vector<FeatureId> Square(double lo, double hi) {
    const std::vector<FeatureId> ring = {Point(lo, lo), Point(hi, lo), Point(hi, hi),
                                         Point(lo, hi)};
    Ring(ring);
    return ring;
  }
  const std::vector<Feature>& features() const { return features_; }
  std::vector<SeedFace> Find(const std::vector<cleaning::Point>& seeds) const {
    return FindSeedFaces(features_, seeds);
  }

 private:
  std::vector<Feature> features_;
  FeatureId last_ = 0;
};

using Edges = std::set<std::pair<FeatureId, FeatureId>>;

// The edges of all rings; each ring has no point twice, no edge occurs twice.
Edges EdgesOf(const Rings& rings) {
  Edges edges;
  for (const auto& ring : rings) {
    EXPECT_GE(ring.size(), 3U);
    EXPECT_EQ(std::set<FeatureId>(ring.begin(), ring.end()).size(), ring.size());
    for (std::size_t i = 0; i < ring.size(); ++i) {
      EXPECT_TRUE(edges.insert(std::minmax(ring[i], ring[(i + 1) % ring.size()])).second);
    }
  }
  return edges;
}

Edges EdgesOf(const std::vector<FeatureId>& ring) { return EdgesOf(Rings{ring}); }

Edges Union(Edges a, const Edges& b) {
  a.insert(b.begin(), b.end());
  return a;
}

TEST(SeedFaces, OfNestedSquaresHaveTheNextOneAsHole) {
  Drawing drawing;
  const auto a = drawing.Square(0, 10), b = drawing.Square(2, 8), c = drawing.Square(4, 6);
  const auto faces = drawing.Find({{1, 1}, {3, 3}, {5, 5}, {11, 11}, {5, 4.5}});
  EXPECT_EQ(EdgesOf(faces[0].rings), Union(EdgesOf(a), EdgesOf(b)));
  EXPECT_EQ(EdgesOf(faces[1].rings), Union(EdgesOf(b), EdgesOf(c)));
  EXPECT_EQ(EdgesOf(faces[2].rings), EdgesOf(c));
  EXPECT_TRUE(faces[3].rings.empty());
  EXPECT_FALSE(faces[3].same_as);
  EXPECT_TRUE(faces[4].rings.empty());
  EXPECT_EQ(faces[4].same_as, 2U);
}

TEST(SeedFaces, BridgesAndLooseEndsAreNoBoundary) {
  Drawing drawing;
  const auto a = drawing.Square(0, 10), b = drawing.Square(4, 6);
  drawing.Segment(a[0], b[0]);                                // a bridge
  drawing.Segment(a[1], drawing.Point(8, 2));                 // a dangling end
  drawing.Segment(drawing.Point(1, 8), drawing.Point(2, 9));  // an isolated segment
  const auto outside = drawing.Point(-5, -5);
  drawing.Segment(outside, a[0]);
  const auto faces = drawing.Find({{1, 5}, {5, 5}, {-1, 0}});
  EXPECT_EQ(EdgesOf(faces[0].rings), Union(EdgesOf(a), EdgesOf(b)));
  EXPECT_EQ(EdgesOf(faces[1].rings), EdgesOf(b));
  EXPECT_TRUE(faces[2].rings.empty());
}

TEST(SeedFaces, CutRingsWhereTheyTouch) {
  // Two triangles inside a square that touch each other, and one that touches the square.
  Drawing drawing;
  const auto a = drawing.Square(0, 10);
  const auto m = drawing.Point(5, 5), n = drawing.Point(3, 7), o = drawing.Point(3, 3);
  const auto p = drawing.Point(7, 7), q = drawing.Point(7, 3);
  const auto r = drawing.Point(4, 1), s = drawing.Point(1, 2);
  drawing.Ring({m, n, o});
  drawing.Ring({m, p, q});
  drawing.Ring({a[0], r, s});
  const auto faces = drawing.Find({{5, 9}, {4, 5}, {6, 5}, {1.5, 1}});
  EXPECT_EQ(EdgesOf(faces[0].rings).size(), 13U);
  EXPECT_EQ(faces[0].rings.size(), 4U);
  EXPECT_EQ(EdgesOf(faces[1].rings), EdgesOf({m, n, o}));
  EXPECT_EQ(EdgesOf(faces[2].rings), EdgesOf({m, p, q}));
  EXPECT_EQ(EdgesOf(faces[3].rings), EdgesOf({a[0], r, s}));
}

TEST(SeedFaces, KnowTheSegmentThatASeedIsOn) {
  Drawing drawing;
  const auto a = drawing.Square(0, 3);
  const auto faces = drawing.Find({{1.5, 0}, {0, 0}, {3, 3}, {std::nextafter(3.0, 0), 1}, {-1, 0}});
  EXPECT_EQ(faces[0].on, 5U);
  EXPECT_NE(faces[1].on, kNoFeature);
  EXPECT_NE(faces[2].on, kNoFeature);
  EXPECT_EQ(EdgesOf(faces[3].rings), EdgesOf(a));
  EXPECT_EQ(faces[4].on, kNoFeature);
}

TEST(SeedFaces, OfNothingAreOutside) {
  EXPECT_TRUE(FindSeedFaces({}, {}).empty());
  const std::vector<Point> seeds = {{0, 0}};
  EXPECT_TRUE(FindSeedFaces({}, seeds)[0].rings.empty());
  EXPECT_TRUE(
      FindSeedFaces({Feature::Point(1, 0, 0), Feature::Segment(2, 1, 1), Feature::Segment(3, 1, 7)},
                    seeds)[0]
          .rings.empty());
}

// Any input that crosses or overlaps: some rings along the segments, and termination.
TEST(SeedFaces, TakeAnySegments) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  for (int round = 0; round < 500; ++round) {
    Drawing drawing;
    Edges segments;
    const FeatureId n = 3 + random() % 12;
    for (FeatureId i = 0; i < n; ++i) {
      drawing.Point(static_cast<double>(random() % 6), static_cast<double>(random() % 6));
    }
    for (std::uint64_t i = random() % (3 * n); i > 0; --i) {
      const FeatureId p = 1 + random() % n, q = 1 + random() % n;
      drawing.Segment(p, q);
      segments.insert(std::minmax(p, q));
    }
    const auto faces = drawing.Find({{2.5, 2.25}, {1.25, 3.5}, {4.75, 4.5}});
    for (const SeedFace& face : faces) {
      for (const auto& edge : EdgesOf(face.rings)) EXPECT_TRUE(segments.contains(edge));
    }
  }
}

// A grid with random edges left out. The oracle floods cells: a face is a connected set, and its
// boundary is the edges with it on one side.
TEST(SeedFaces, EqualFloodedCells) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  for (int round = 0; round < 200; ++round) {
    const int n = 2 + static_cast<int>(random() % 9);
    const std::uint64_t percent = random() % 101;
    Drawing drawing;
    std::vector<std::vector<FeatureId>> id(static_cast<std::size_t>(n + 1));
    for (int x = 0; x <= n; ++x) {
      // Sheared, so that a ray is along an edge only by chance.
      for (int y = 0; y <= n; ++y) {
        id[static_cast<std::size_t>(x)].push_back(drawing.Point(x, y + (round % 2) * 0.25 * x));
      }
    }
    const auto at = [&](int x, int y) {
      return id[static_cast<std::size_t>(x)][static_cast<std::size_t>(y)];
    };
    std::set<std::pair<FeatureId, FeatureId>> present;
    const auto maybe = [&](FeatureId p, FeatureId q) {
      if (random() % 100 >= percent) return;
      drawing.Segment(p, q);
      present.insert(std::minmax(p, q));
    };
    for (int x = 0; x <= n; ++x) {
      for (int y = 0; y <= n; ++y) {
        if (x < n) maybe(at(x, y), at(x + 1, y));
        if (y < n) maybe(at(x, y), at(x, y + 1));
      }
    }
    // Cells -1 .. n, those of the rim are outside.
    const auto edge_between = [&](int x, int y, int dx, int dy) -> std::pair<FeatureId, FeatureId> {
      const int x0 = dx > 0 ? x + 1 : x, y0 = dy > 0 ? y + 1 : y;
      if (dx != 0) return {at(x0, y), at(x0, y + 1)};
      return {at(x, y0), at(x + 1, y0)};
    };
    const auto inside = [&](int x, int y) { return x >= 0 && x < n && y >= 0 && y < n; };
    const int sx = static_cast<int>(random() % static_cast<std::uint64_t>(n));
    const int sy = static_cast<int>(random() % static_cast<std::uint64_t>(n));
    std::set<std::pair<int, int>> flooded = {{sx, sy}};
    std::vector<std::pair<int, int>> open = {{sx, sy}};
    bool unbounded = false;
    std::vector<std::pair<FeatureId, FeatureId>> met;
    while (!open.empty()) {
      const auto [x, y] = open.back();
      open.pop_back();
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const auto edge = edge_between(x, y, dx, dy);
        if (present.contains(std::minmax(edge.first, edge.second))) {
          met.push_back(std::minmax(edge.first, edge.second));
        } else if (!inside(x + dx, y + dy)) {
          unbounded = true;
        } else if (flooded.emplace(x + dx, y + dy).second) {
          open.emplace_back(x + dx, y + dy);
        }
      }
    }
    Edges expected;
    for (const auto& edge : met) {
      if (std::count(met.begin(), met.end(), edge) == 1) expected.insert(edge);
    }
    const auto faces = drawing.Find({{sx + 0.5, sy + 0.5 + (round % 2) * 0.25 * (sx + 0.5)}});
    if (unbounded) {
      EXPECT_TRUE(faces[0].rings.empty());
    } else {
      EXPECT_EQ(EdgesOf(faces[0].rings), expected);
    }
  }
}

}  // namespace
}  // namespace dynmesh::cleaning::seed_faces_test
