#include "client/cleaning/meeting_search.h"

#include <random>
#include <set>
#include <utility>

#include "gtest/gtest.h"

namespace dynmesh::cleaning::meeting_search_test {
namespace {

constexpr double kTolerance = 1e-4;

// Long and short segments, some in a dense corner, some from one hub.
LineGraph RandomGraph(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  LineGraph graph(kTolerance);
  FeatureId id = 0;
  const auto node = [&](double x, double y) {
    const auto near = graph.nodes.Near({x, y});
    return near ? *near : graph.AddNode({x, y}, ++id);
  };
  const Node hub = node(0.3, 0.7);
  for (int i = 0; i < 300; ++i) {
    const double x = unit(random), y = unit(random), u = unit(random), v = unit(random);
    switch (random() % 4) {
      case 0:
        graph.Connect(node(x, y), node(u, v), ++id);
        break;
      case 1:
        graph.Connect(node(x, y), node(x + u / 50, y + v / 50), ++id);
        break;
      case 2:
        graph.Connect(node(x / 100, y / 100), node(u / 100, v / 100), ++id);
        break;
      default:
        graph.Connect(hub, node(u, v), ++id);
        break;
    }
    if (i == 200) graph.round = 1;
  }
  graph.Settle();
  return graph;
}

double Side(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

TEST(MeetingSearch, NoCrossingIsMissed) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const LineGraph graph = RandomGraph(seed);
    for (const int since : {0, 1}) {
      std::set<std::pair<EdgeIndex, EdgeIndex>> visited;
      VisitEdgesThatMeet(graph, since, [&](EdgeIndex e, EdgeIndex f) {
        EXPECT_LT(e, f);
        EXPECT_TRUE(graph.edges[e].born >= since || graph.edges[f].born >= since);
        visited.emplace(e, f);
        return true;
      });
      std::size_t crossings = 0;
      for (EdgeIndex e = 0; e < graph.edges.size(); ++e) {
        for (EdgeIndex f = e + 1; f < graph.edges.size(); ++f) {
          if (graph.edges[e].born < since && graph.edges[f].born < since) continue;
          const Point &a = graph.nodes.at(graph.edges[e].a), &b = graph.nodes.at(graph.edges[e].b);
          const Point &c = graph.nodes.at(graph.edges[f].a), &d = graph.nodes.at(graph.edges[f].b);
          if (Side(a, b, c) * Side(a, b, d) >= 0 || Side(c, d, a) * Side(c, d, b) >= 0) continue;
          ++crossings;
          EXPECT_TRUE(visited.contains({e, f})) << "seed " << seed;
        }
      }
      EXPECT_GT(crossings, 100U);
      EXPECT_LT(visited.size(), graph.edges.size() * graph.edges.size() / 2);
    }
  }
}

TEST(MeetingSearch, NoPlaceNearAnEdgeIsMissedAndNoneComesTwice) {
  constexpr double kReach = 0.003;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const LineGraph graph = RandomGraph(seed);
    std::set<std::pair<EdgeIndex, Node>> visited;
    VisitNodesNearEdges(graph, kReach, 0,
                        [&](EdgeIndex e, Node v) { EXPECT_TRUE(visited.emplace(e, v).second); });
    for (EdgeIndex e = 0; e < graph.edges.size(); ++e) {
      const Point &a = graph.nodes.at(graph.edges[e].a), &b = graph.nodes.at(graph.edges[e].b);
      for (Node v = 0; v < graph.nodes.size(); ++v) {
        const Point& p = graph.nodes.at(v);
        const double along = (b[0] - a[0]) * (p[0] - a[0]) + (b[1] - a[1]) * (p[1] - a[1]);
        const double length2 = SquaredDistance(a, b);
        if (along < 0 || along > length2) continue;
        const double side = Side(a, b, p);
        if (side * side >= kReach * kReach * length2) continue;
        EXPECT_TRUE(visited.contains({e, v})) << "seed " << seed;
      }
    }
  }
}

TEST(MeetingSearch, EndsEarlyWhenTold) {
  const LineGraph graph = RandomGraph(1);
  int visits = 0;
  VisitEdgesThatMeet(graph, 0, [&](EdgeIndex, EdgeIndex) { return ++visits < 3; });
  EXPECT_EQ(visits, 3);
}

}  // namespace
}  // namespace dynmesh::cleaning::meeting_search_test
