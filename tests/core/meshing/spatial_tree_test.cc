// The bucket quadtree against a plain list of points. Cells are not visible from outside, but on a
// lattice the paths of all lattice points determine them.
#include "core/meshing/spatial_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::spatial_tree_test {
namespace {

using NodeIndex = std::uint32_t;
using Nodes = std::set<NodeIndex>;

constexpr int kLattice = 64;
// The tree's root for the unit square or cube: its cells' borders are lattice lines.
constexpr double kRootLo = -1.5, kRootHi = 2.5;

enum class Layout { kUniform, kOnLattice, kClusters, kCoincident };
constexpr Layout kAllLayouts[] = {Layout::kUniform, Layout::kOnLattice, Layout::kClusters,
                                  Layout::kCoincident};

// Each coordinate is what `coordinate()` says.
template <int D, class F>
geometry::Point<D> PointOf(F coordinate) {
  geometry::Point<D> p;
  for (int i = 0; i < D; ++i) p[i] = coordinate();
  return p;
}

template <int D>
geometry::Point<D> RandomPoint(Layout layout, test::Random& random) {
  switch (layout) {
    case Layout::kUniform:
      return PointOf<D>([&] { return random.Unit(); });
    case Layout::kOnLattice:  // borders of cells, and of the box
      return PointOf<D>([&] { return random.Below(kLattice + 1) / double{kLattice}; });
    case Layout::kClusters: {
      const double spread = std::ldexp(random.Unit(), -random.Below(50));
      return PointOf<D>([&] {
        return std::clamp(0.25 * random.Below(5) + spread * (random.Unit() - 0.5), 0.0, 1.0);
      });
    }
    case Layout::kCoincident: {
      geometry::Point<D> p = PointOf<D>([] { return 0.3; });
      p[0] = 0.5 * random.Below(3);
      return p;
    }
  }
  return {};
}
template <int D>
geometry::Point<D> RandomPointAround(test::Random& random) {
  return PointOf<D>([&] { return 1.4 * random.Unit() - 0.2; });
}

// A tree and its list model; and the subscribers of each node, as the engine stores them.
template <int D>
class Pair {
 public:
  using Tree = SpatialTree<D>;
  using Point = geometry::Point<D>;

  Pair() : tree(PointOf<D>([] { return 0; }), PointOf<D>([] { return 1; })) {}

  void Insert(std::uint32_t id, const Point& p) {
    tree.Insert(id, p);
    points[id] = p;
  }
  void Remove(std::uint32_t id) {
    const auto may_merge = [&](NodeIndex, NodeIndex) { return mergeable; };
    tree.Remove(id, points.at(id), may_merge, [&](NodeIndex first, NodeIndex parent) {
      ++merges;
      for (auto& [box, places] : subscribed) {
        for (int k = 0; k < Tree::kChildren; ++k) {
          if (places.erase(first + static_cast<NodeIndex>(k)) > 0) places.insert(parent);
        }
      }
    });
    points.erase(id);
  }
  std::uint32_t AnyId(test::Random& random) const {
    auto it = points.begin();
    std::advance(it, random.Below(static_cast<int>(points.size())));
    return it->first;
  }

  std::set<std::uint32_t> InBall(const Point& centre, double radius2) const {
    std::set<std::uint32_t> ids;
    double r2 = radius2;
    tree.VisitBall(centre, r2, [&](std::uint32_t id, const Point& p, double d2) {
      EXPECT_EQ(p, points.at(id));
      EXPECT_EQ(d2, geometry::SquaredDistance(p, centre));
      EXPECT_TRUE(ids.insert(id).second) << "visited twice";
    });
    return ids;
  }
  // From the root down.
  std::vector<std::pair<NodeIndex, std::uint32_t>> PartsOnPath(const Point& p) const {
    std::vector<std::pair<NodeIndex, std::uint32_t>> parts;
    tree.VisitPath(p, [&](NodeIndex n, std::uint32_t part) { parts.emplace_back(n, part); });
    return parts;
  }
  std::map<NodeIndex, std::uint32_t> PartsOfCover(const Extent<D>& box) const {
    std::map<NodeIndex, std::uint32_t> parts;
    tree.Cover(box, [&](NodeIndex n, std::uint32_t of) { parts[n] = of; });
    return parts;
  }
  Nodes Path(const Point& p) const {
    Nodes nodes;
    tree.VisitPath(p, [&](NodeIndex n, std::uint32_t) { nodes.insert(n); });
    return nodes;
  }
  Nodes Cover(const Extent<D>& box) const {
    Nodes nodes;
    tree.Cover(box, [&](NodeIndex n, std::uint32_t) { EXPECT_TRUE(nodes.insert(n).second); });
    return nodes;
  }

  Tree tree;
  std::map<std::uint32_t, Point> points;
  std::vector<std::pair<Extent<D>, Nodes>> subscribed;
  int merges = 0;
  bool mergeable = true;
};

template <int D>
Extent<D> RandomBox(test::Random& random) {
  const double side = std::ldexp(random.Unit(), -random.Below(8));
  Extent<D> box = Extent<D>::Nothing();
  box.AddBall(PointOf<D>([&] { return random.Unit(); }), side);
  return box;
}

template <int D>
geometry::Point<D> RandomPointIn(const Extent<D>& box, test::Random& random) {
  geometry::Point<D> p;
  for (int i = 0; i < D; ++i) {
    const double lo = std::max(box.lo[i], kRootLo);
    const double hi = std::min(box.hi[i], std::nextafter(kRootHi, 0));
    const int how = random.Below(4);
    p[i] = how == 0 ? lo : how == 1 ? hi : std::min(hi, lo + random.Unit() * (hi - lo));
  }
  return p;
}

template <int D>
void CheckBalls(const Pair<D>& pair, test::Random& random) {
  for (int k = 0; k < 4; ++k) {
    // A centre anywhere, or at a point; a radius of any size, or to some point exactly.
    geometry::Point<D> centre = RandomPointAround<D>(random);
    if (random.OneIn(2)) centre = pair.points.at(pair.AnyId(random));
    double radius2 = std::ldexp(random.Unit(), -random.Below(60));
    if (random.OneIn(3)) {
      radius2 = geometry::SquaredDistance(centre, pair.points.at(pair.AnyId(random)));
    }
    std::set<std::uint32_t> wanted;
    double nearest2 = INFINITY;
    for (const auto& [id, p] : pair.points) {
      const double d2 = geometry::SquaredDistance(p, centre);
      nearest2 = std::min(nearest2, d2);
      if (d2 <= radius2) wanted.insert(id);
    }
    ASSERT_EQ(pair.InBall(centre, radius2), wanted);
    double shrinking = INFINITY;
    pair.tree.VisitBall(
        centre, shrinking,
        [&](std::uint32_t, const geometry::Point<D>&, double d2) { shrinking = d2; });
    ASSERT_EQ(shrinking, nearest2);
  }
}

// The points in any of some balls, each once.
template <int D>
void CheckUnions(const Pair<D>& pair, test::Random& random) {
  std::vector<typename SpatialTree<D>::Ball> balls;
  Extent<D> box = Extent<D>::Nothing();
  for (int k = random.Below(5); k >= 0; --k) {
    geometry::Point<D> centre = RandomPointAround<D>(random);
    if (random.OneIn(2)) centre = pair.points.at(pair.AnyId(random));
    const double radius = std::ldexp(random.Unit(), -random.Below(30));
    balls.push_back({centre, radius * radius});
    box.AddBall(centre, radius * (1 + 1e-9));
  }
  std::set<std::uint32_t> wanted, visited;
  for (const auto& [id, p] : pair.points) {
    if (std::ranges::any_of(balls, [&](const auto& ball) {
          return geometry::SquaredDistance(p, ball.centre) <= ball.radius2;
        })) {
      wanted.insert(id);
    }
  }
  const auto visit = [&](std::uint32_t id, const geometry::Point<D>& p) {
    EXPECT_EQ(p, pair.points.at(id));
    EXPECT_TRUE(visited.insert(id).second) << "visited twice";
  };
  ASSERT_TRUE(pair.tree.VisitBalls(balls, box, 1'000'000, visit));
  ASSERT_EQ(visited, wanted);
  if (wanted.empty()) return;
  visited.clear();
  const int few = random.Below(static_cast<int>(wanted.size()));
  ASSERT_FALSE(pair.tree.VisitBalls(balls, box, few, visit)) << "there are more";
  ASSERT_LE(static_cast<int>(visited.size()), few);
}

// A subscriber to a cover of a box is on the path of all points in it, after any splits and merges
// since.
template <int D>
void CheckSubscriptions(Pair<D>& pair, test::Random& random) {
  for (const auto& [box, places] : pair.subscribed) {
    const Nodes path = pair.Path(RandomPointIn(box, random));
    ASSERT_TRUE(
        std::any_of(path.begin(), path.end(), [&](NodeIndex n) { return places.contains(n); }));
  }
  if (pair.subscribed.size() >= 60) {
    pair.subscribed.erase(pair.subscribed.begin() + random.Below(60));
  }
  const Extent<D> box = RandomBox<D>(random);
  const Nodes cover = pair.Cover(box);
  ASSERT_LE(cover.size(), std::size_t{1} << D);
  for (int k = 0; k < 8; ++k) {
    const Nodes path = pair.Path(RandomPointIn(box, random));
    ASSERT_EQ(
        std::count_if(path.begin(), path.end(), [&](NodeIndex n) { return cover.contains(n); }), 1);
  }
  pair.subscribed.emplace_back(box, cover);
}

// In a node of the cover a point of the box is in the box's parts. Few points outside are: none
// that is farther from it than a slab along some axis.
template <int D>
void CheckParts(const Pair<D>& pair, test::Random& random) {
  const Extent<D> box = RandomBox<D>(random);
  const auto cover = pair.PartsOfCover(box);
  for (int k = 0; k < 8; ++k) {
    const bool inside = k % 2 == 0;
    const geometry::Point<D> p =
        inside ? RandomPointIn(box, random) : RandomPoint<D>(Layout::kUniform, random);
    double side = 2 * (kRootHi - kRootLo);
    for (const auto& [node, part] : pair.PartsOnPath(p)) {
      side /= 2;
      const auto of = cover.find(node);
      if (of == cover.end()) continue;
      const bool is_read = (of->second & part) == part;
      ASSERT_EQ(std::popcount(part), D);
      ASSERT_TRUE(is_read || !inside);
      const double slab = side / SpatialTree<D>::kSlabs;
      for (int i = 0; i < D; ++i) {
        ASSERT_TRUE(!is_read || (box.lo[i] - slab <= p[i] && p[i] <= box.hi[i] + slab));
      }
    }
  }
}

template <int D>
void CheckRandomUpdates(Layout layout) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    Pair<D> pair;
    std::uint32_t next = 0;
    int most = 200;
    for (int step = 0; step < 3000; ++step) {
      if (step % 500 == 0) most = most == 200 ? 5 : 200;  // grow, then shrink: merges
      const int size = static_cast<int>(pair.points.size());
      if (size == 0 || (size < most && !random.OneIn(4))) {
        pair.Insert(next++, RandomPoint<D>(layout, random));
      } else {
        pair.Remove(pair.AnyId(random));
      }
      if (!pair.points.empty() && step % 3 == 0) {
        ASSERT_NO_FATAL_FAILURE(CheckBalls(pair, random));
        ASSERT_NO_FATAL_FAILURE(CheckUnions(pair, random));
      }
      ASSERT_NO_FATAL_FAILURE(CheckSubscriptions(pair, random));
      ASSERT_NO_FATAL_FAILURE(CheckParts(pair, random));
    }
    EXPECT_GT(pair.merges, 10);
    while (!pair.points.empty()) pair.Remove(pair.points.begin()->first);
    EXPECT_EQ(pair.Path(PointOf<D>([] { return 0.5; })), Nodes{0})
        << "nothing but the root is left";
  }
}

class SpatialTreeTest : public testing::TestWithParam<Layout> {};

TEST_P(SpatialTreeTest, IsAListOfPointsAfterAnyInsertionsAndRemovals) {
  CheckRandomUpdates<2>(GetParam());
}
TEST_P(SpatialTreeTest, IsAListOfPointsInSpaceAfterAnyInsertionsAndRemovals) {
  CheckRandomUpdates<3>(GetParam());
}

std::string NameOfLayout(const testing::TestParamInfo<Layout>& its) {
  static constexpr const char* kNames[] = {"Uniform", "Lattice", "Clusters", "Coincident"};
  return kNames[static_cast<int>(its.param)];
}
INSTANTIATE_TEST_SUITE_P(All, SpatialTreeTest, testing::ValuesIn(kAllLayouts), NameOfLayout);

// Points on a lattice, no more than fit a leaf at each: no cell is smaller than the lattice's.
void InsertLatticePoints(Pair<2>& pair, test::Random& random) {
  std::map<std::pair<double, double>, int> copies;
  for (std::uint32_t id = 0; id < 1500; ++id) {
    const geometry::Point2 p = RandomPoint<2>(Layout::kOnLattice, random);
    const geometry::Point2 q =
        random.OneIn(3) ? p : geometry::Point2{{p[0] / 4 + 0.25, p[1] / 4 + 0.5}};
    const geometry::Point2 r = {
        {std::floor(q[0] * kLattice) / kLattice, std::floor(q[1] * kLattice) / kLattice}};
    if (++copies[{r[0], r[1]}] <= static_cast<int>(LeafChains<2>::kCapacity)) pair.Insert(id, r);
  }
}

// Each cell that meets a box of lattice corners holds a lattice point of it.
TEST(SpatialTree, VisitsExactlyTheCellsThatMeetABox) {
  const std::uint64_t seed = 9;
  test::Random random(seed);
  Pair<2> pair;
  InsertLatticePoints(pair, random);
  for (int i = 0; i < 300; ++i) {
    const int most = random.OneIn(20) ? 4 * kLattice : random.Below(20);
    Extent<2> box;
    for (int k = 0; k < 2; ++k) {
      const int lo = random.Below(3 * kLattice) - kLattice;
      box.lo[k] = lo / double{kLattice};
      box.hi[k] = (lo + random.Below(most + 1)) / double{kLattice};
    }
    Nodes wanted;
    for (double x = std::max(box.lo[0], kRootLo); x <= box.hi[0] && x < kRootHi;
         x += 1.0 / kLattice) {
      for (double y = std::max(box.lo[1], kRootLo); y <= box.hi[1] && y < kRootHi;
           y += 1.0 / kLattice) {
        wanted.merge(pair.Path({{x, y}}));
      }
    }
    Nodes visited;
    pair.tree.VisitBoxIf(
        box, [](const geometry::Point2&, double) { return true; },
        [&](NodeIndex n) { EXPECT_TRUE(visited.insert(n).second) << "visited twice"; });
    ASSERT_EQ(visited, wanted) << "seed " << seed << " box " << i;
  }
}

// The same tree: a cell's size follows from the lattice points with paths through it.
TEST(SpatialTree, VisitsExactlyTheCellsThatMeetABall) {
  const std::uint64_t seed = 11;
  test::Random random(seed);
  Pair<2> pair;
  InsertLatticePoints(pair, random);
  std::map<NodeIndex, Extent<2>> cells;
  for (double x = kRootLo; x < kRootHi; x += 1.0 / kLattice) {
    for (double y = kRootLo; y < kRootHi; y += 1.0 / kLattice) {
      for (const NodeIndex n : pair.Path({{x, y}})) {
        Extent<2>& cell = cells.try_emplace(n, Extent<2>::Nothing()).first->second;
        cell.AddBall({{x, y}}, 0);
        cell.AddBall({{x + 1.0 / kLattice, y + 1.0 / kLattice}}, 0);
      }
    }
  }
  for (int i = 0; i < 1000; ++i) {
    const geometry::Point2 centre = {{3 * random.Unit() - 1, 3 * random.Unit() - 1}};
    const double radius = std::ldexp(random.Unit(), -random.Below(8));
    Nodes visited;
    pair.tree.VisitCells({centre, radius * radius}, [&](NodeIndex n) {
      EXPECT_TRUE(visited.insert(n).second) << "visited twice";
    });
    for (const auto& [n, cell] : cells) {
      double d2 = 0;
      for (int k = 0; k < 2; ++k) {
        const double d = std::max({cell.lo[k] - centre[k], centre[k] - cell.hi[k], 0.0});
        d2 += d * d;
      }
      const bool near = d2 <= radius * radius;
      if (std::fabs(std::sqrt(d2) - radius) < 1e-12) continue;  // rounding may decide
      ASSERT_EQ(visited.contains(n), near) << "seed " << seed << " ball " << i << " node " << n;
    }
  }
}

TEST(SpatialTree, PathsBeginAtTheRootAndEndWhereThePointIs) {
  test::Random random(10);
  Pair<2> pair;
  for (std::uint32_t id = 0; id < 500; ++id) {
    pair.Insert(id, RandomPoint<2>(Layout::kOnLattice, random));
    const geometry::Point2 p = pair.points.at(id);
    std::vector<NodeIndex> path;
    pair.tree.VisitPath(p, [&](NodeIndex n, std::uint32_t) { path.push_back(n); });
    ASSERT_EQ(path.front(), 0u);
    // The leaf alone covers the point.
    ASSERT_EQ(pair.Cover({p.c, p.c}), Nodes{path.back()});
  }
}

TEST(Extent, HoldsTheBallsAddedWithTheirBorders) {
  Extent<2> box = Extent<2>::Nothing();
  EXPECT_FALSE(box.Contains({{0, 0}}));
  box.AddBall({{1, 2}}, 0.5);
  EXPECT_TRUE(box.Contains({{0.5, 2.5}}));
  EXPECT_FALSE(box.Contains({{0.4, 2}}));
  box.AddBall({{-1, 2}}, 0);
  EXPECT_TRUE(box.Contains({{-1, 1.5}}));
  EXPECT_FALSE(box.Contains({{-1, 1.4}}));
}

// A leaf without points is split for the boxes that it is to keep, if there are many.
TEST(SpatialTree, ACrowdedLeafIsSplitForABoxToKeep) {
  using geometry::Point2;
  SpatialTree<2> tree({{0, 0}}, {{1, 1}});
  tree.Insert(1, {{0.75, 0.75}});
  const Extent<2> box{{0.3, 0.3}, {0.31, 0.31}};
  std::vector<std::uint32_t> kept;
  const auto keep = [&](bool is_crowded) {
    kept.clear();
    tree.CoverToKeep(
        box, [&](std::uint32_t) { return is_crowded; },
        [&](std::uint32_t node, std::uint32_t) { kept.push_back(node); });
  };
  keep(false);
  EXPECT_EQ(kept, std::vector<std::uint32_t>{0});
  EXPECT_EQ(tree.node_count(), 1U);
  keep(true);
  EXPECT_LE(kept.size(), 4U);
  EXPECT_GT(tree.node_count(), 16U);
  // Down to cells as small as the box; what is in the box has one of them on its path.
  for (const double x : {0.3, 0.305, 0.31}) {
    std::vector<std::uint32_t> path;
    tree.VisitPath({{x, 0.304}}, [&](std::uint32_t node, std::uint32_t) { path.push_back(node); });
    EXPECT_EQ(std::ranges::count_if(
                  path, [&](std::uint32_t n) { return std::ranges::count(kept, n) != 0; }),
              1);
  }
  double r2 = 1;
  int found = 0;
  tree.VisitBall({{0.5, 0.5}}, r2, [&](std::uint32_t, const Point2&, double) { ++found; });
  EXPECT_EQ(found, 1);
  const std::size_t nodes = tree.node_count();
  keep(true);
  EXPECT_EQ(tree.node_count(), nodes);
}

// Leaves that were kept apart merge when a point leaves a cell around them.
TEST(SpatialTree, LeavesThatMayNotMergeDoSoLater) {
  test::Random random(test::NewSeed());
  Pair<2> pair;
  for (std::uint32_t id = 0; id < 1000; ++id) {
    pair.Insert(id, PointOf<2>([&] { return id < 900 ? 0.01 * random.Unit() : random.Unit(); }));
  }
  pair.mergeable = false;
  for (std::uint32_t id = 0; id < 990; ++id) pair.Remove(id);
  EXPECT_EQ(pair.merges, 0);
  pair.mergeable = true;
  for (std::uint32_t id = 990; id < 999; ++id) pair.Remove(id);
  EXPECT_GT(pair.merges, 50);
  pair.Remove(999);
  EXPECT_EQ(pair.Path({{0.001, 0.001}}).size(), 1U);
}

}  // namespace
}  // namespace dynmesh::meshing::spatial_tree_test
