// Refinement in 3D, points only: after every edit it equals a run from scratch, in vertices and
// complete trace, and no tetrahedron is over rho.
//
// DYNMESH_NIGHTLY=1 runs long scripts.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Exact_rational.h>
#include <CGAL/Simple_cartesian.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/constructions.h"
#include "core/meshing/refinement.h"
#include "core/meshing/trace_audit.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::space_refinement_test {
namespace {

using geometry::Point3;
using Traced = Refinement<3, sac::Engine>;
using Untraced = Refinement<3, sac::UntracedEngine>;
using test::Random;

enum class Kind { kUniform, kClustered, kGrid, kTurnedGrid, kSphere, kLineAndCircle, kTwoScale };
constexpr const char* kNames[] = {"Uniform", "Clustered",     "Grid",    "TurnedGrid",
                                  "Sphere",  "LineAndCircle", "TwoScale"};

MeshOptions Options(double rho) {
  MeshOptions options;
  options.dimension = 3;
  options.quality = rho;
  return options;
}

Point3 RandomPoint(Kind kind, Random& random) {
  const auto unit = [&] { return random.Unit(); };
  switch (kind) {
    case Kind::kUniform:
      return {{unit(), unit(), unit()}};
    case Kind::kClustered: {
      const double scale = std::ldexp(1.0, -random.Below(12));
      return {{0.3 + 0.5 * scale * unit(), 0.6 - 0.5 * scale * unit(), 0.2 + 0.5 * scale * unit()}};
    }
    case Kind::kGrid:
      return {{random.Below(5) * 0.25, random.Below(5) * 0.25, random.Below(5) * 0.25}};
    case Kind::kTurnedGrid: {
      const double x = random.Below(4) * 0.2, y = random.Below(4) * 0.2, z = random.Below(4) * 0.2;
      return {{0.1 + 0.6 * x + 0.48 * y, 0.4 - 0.8 * x / 2 + 0.6 * y, 0.1 + z}};
    }
    case Kind::kSphere: {
      Point3 p;
      double length = 0;
      do {
        length = 0;
        for (int k = 0; k < 3; ++k) p[k] = unit() - 0.5, length += p[k] * p[k];
      } while (length > 0.25 || length < 0.01);
      for (int k = 0; k < 3; ++k) p[k] = 0.5 + 0.5 * p[k] / std::sqrt(length);
      return p;
    }
    case Kind::kLineAndCircle: {
      if (random.OneIn(2)) return {{0.5, 0.5, random.Below(40) / 40.0}};
      const double turn = random.Below(40) * 0.15707963267948966;
      return {{0.5 + 0.5 * std::cos(turn), 0.5 + 0.5 * std::sin(turn), 0.5}};
    }
    default: {
      const double grain = random.OneIn(2) ? 0x1p-30 : 0;
      return {{random.Below(4) * 0.25 + grain, random.Below(4) * 0.25, random.Below(4) * 0.25}};
    }
  }
}

// Circumradius over the shortest edge, by rationals: doubles are useless for nearly flat ones.
double Ratio(const std::array<Point3, 4>& p, double shortest2) {
  using Exact = CGAL::Simple_cartesian<CGAL::Exact_rational>;
  const auto at = [&](int i) { return Exact::Point_3(p[i][0], p[i][1], p[i][2]); };
  const Exact::Point_3 x = CGAL::circumcenter(at(0), at(1), at(2), at(3));
  return std::sqrt(CGAL::to_double(CGAL::squared_distance(x, at(0))) / shortest2);
}

template <class R>
std::set<Point3> VerticesOf(const R& refinement) {
  std::set<Point3> vertices;
  refinement.elements().ForEachVertex([&](VertexIndex, const auto& v) { vertices.insert(v.p); });
  return vertices;
}

template <class R>
void Fill(R& refinement, const std::set<Point3>& points) {
  for (const Point3& p : points) refinement.AddPoint(p, 1);
  refinement.Propagate([] { return false; });
}

class SpaceRefinement : public testing::TestWithParam<std::tuple<Kind, double>> {};

TEST_P(SpaceRefinement, IsFromScratchAfterEveryEdit) {
  const auto [kind, rho] = GetParam();
  const char* nightly = std::getenv("DYNMESH_NIGHTLY");
  const int revisions = nightly != nullptr && *nightly != '0' ? 1500 : 12;
  const std::uint64_t seed = 3'000;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const MeshOptions options = Options(rho);
  Traced dynamic(options, nullptr);
  dynamic.Propagate([] { return false; });
  std::set<Point3> points;
  std::vector<std::pair<Point3, VertexIndex>> present;
  for (int revision = 0; revision < revisions; ++revision) {
    // Several at once, so that edits meet.
    for (int i = 1 + random.Below(6); i > 0; --i) {
      if (present.size() > 5 && random.OneIn(present.size() < 60 ? 3 : 2)) {
        const auto at = static_cast<std::size_t>(random.Below(static_cast<int>(present.size())));
        dynamic.RemovePoint(present[at].second);
        points.erase(present[at].first);
        present[at] = present.back();
        present.pop_back();
      } else {
        const Point3 p = RandomPoint(kind, random);
        if (points.insert(p).second) present.emplace_back(p, dynamic.AddPoint(p, 1));
      }
    }
    dynamic.Propagate([] { return false; });
    dynamic.TakeChanges([](auto...) {}, [](auto...) {});
    Traced fresh(options, nullptr);
    Fill(fresh, points);
    std::vector<std::string> problems;
    ASSERT_EQ(VerticesOf(dynamic), VerticesOf(fresh)) << "revision " << revision;
    const std::uint64_t ours = Audit(dynamic, &problems), theirs = Audit(fresh, &problems);
    ASSERT_TRUE(problems.empty()) << "revision " << revision << ": " << problems[0];
    ASSERT_EQ(ours, theirs) << "revision " << revision;
    if (revision % 4 == 0) {
      Untraced untraced(options, nullptr);
      Fill(untraced, points);
      ASSERT_EQ(VerticesOf(untraced), VerticesOf(fresh)) << "revision " << revision;
    }
  }
}

TEST_P(SpaceRefinement, NoTetrahedronIsOverRho) {
  using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
  const auto [kind, rho] = GetParam();
  Random random(77);
  std::set<Point3> points;
  for (int i = 0; i < 300; ++i) points.insert(RandomPoint(kind, random));
  Untraced refinement(Options(rho), nullptr);
  Fill(refinement, points);
  std::vector<Kernel::Point_3> vertices;
  for (const Point3& p : VerticesOf(refinement)) vertices.emplace_back(p[0], p[1], p[2]);
  const CGAL::Delaunay_triangulation_3<Kernel> triangulation(vertices.begin(), vertices.end());
  const double ulp = refinement.complex().rules.ulp();
  int over = 0, all = 0;
  for (auto t = triangulation.finite_cells_begin(); t != triangulation.finite_cells_end(); ++t) {
    std::array<Point3, 4> p;
    double shortest2 = INFINITY;
    for (int i = 0; i < 4; ++i) {
      const auto& q = t->vertex(i)->point();
      p[i] = {{q.x(), q.y(), q.z()}};
      for (int j = 0; j < i; ++j) {
        shortest2 = std::min(shortest2, geometry::SquaredDistance(p[i], p[j]));
      }
    }
    // CGAL breaks ties its own way: tetrahedra of cospherical points may be flat.
    if (geometry::Orientation(p[0], p[1], p[2], p[3]) == 0) continue;
    const double most = rho * (1 + 1e-6 + 100 * ulp / std::sqrt(shortest2));
    const Point3 x = geometry::Circumcenter({p[0], p[1], p[2]}, p[3]);
    const double r2 = geometry::SquaredDistance(x, p[3]);
    over += !(r2 <= most * most * shortest2) && Ratio(p, shortest2) > most;
    ++all;
  }
  EXPECT_EQ(over, 0) << "of " << all;
  EXPECT_GT(all, 1000);
}

INSTANTIATE_TEST_SUITE_P(
    Points, SpaceRefinement,
    testing::Combine(testing::Values(Kind::kUniform, Kind::kClustered, Kind::kGrid,
                                     Kind::kTurnedGrid, Kind::kSphere, Kind::kLineAndCircle,
                                     Kind::kTwoScale),
                     testing::Values(2.0, 1.4)),
    [](const auto& parameter) {
      return std::string(kNames[static_cast<int>(std::get<0>(parameter.param))]) + "Rho" +
             std::to_string(static_cast<int>(100 * std::get<1>(parameter.param)));
    });

// --- Segments -----------------------------------------------------------------------------

// Edges of a grid, turned or not: at right angles, or in one line, where they meet.
struct GridEdges {
  static constexpr int kSide = 4;
  bool turned = false;

  Point3 Turned(double x, double y, double z) const {
    if (!turned) return {{x, y, z}};
    return {{0.1 + 0.8 * x - 0.6 * y, 0.1 + 0.6 * x + 0.8 * y, 0.3 + z}};
  }
  Point3 At(int i) const {
    return Turned(0.25 * (i % kSide), 0.25 * (i / kSide % kSide), 0.25 * (i / 16));
  }
  // Off all edges.
  Point3 AnyBetween(Random& random) const {
    const auto odd = [&] { return (2 * random.Below(24) + 1) / 64.0; };
    return Turned(odd(), odd(), odd());
  }
  // Ends of a random one.
  static std::pair<int, int> Any(Random& random) {
    constexpr int kSteps[] = {1, kSide, kSide * kSide};
    for (;;) {
      const int axis = random.Below(3), step = kSteps[axis];
      const int from = random.Below(kSide * kSide * kSide);
      if (from / step % kSide + 1 < kSide) return {from, from + step};
    }
  }
};

template <class R>
class WithSegments {
 public:
  WithSegments(const MeshOptions& options, const GridEdges& grid,
               typename R::Triangulation* triangulation = nullptr)
      : grid_(grid), refinement_(options, triangulation) {}
  // Adds the missing ones with their ends; removes the present ones.
  void Toggle(const std::pair<int, int>& edge) {
    const auto it = segments_.find(edge);
    if (it != segments_.end()) {
      refinement_.RemoveSegment(it->second);
      segments_.erase(it);
      Leave(edge.first);
      Leave(edge.second);
    } else {
      const VertexIndex a = Use(edge.first), b = Use(edge.second);
      segments_.emplace(edge, refinement_.AddSegment(a, b, 1));
    }
  }
  void Toggle(const Point3& p) {
    const auto it = free_.find(p);
    if (it != free_.end()) {
      refinement_.RemovePoint(it->second);
      free_.erase(it);
    } else {
      free_.emplace(p, refinement_.AddPoint(p, 1));
    }
  }
  void Run() {
    refinement_.Propagate([] { return false; });
    refinement_.TakeChanges([](auto...) {}, [](auto...) {});
  }
  R& refinement() { return refinement_; }
  std::set<Point3> Points() const {
    std::set<Point3> points;
    for (const auto& [p, index] : free_) points.insert(p);
    return points;
  }
  std::set<std::pair<int, int>> Edges() const {
    std::set<std::pair<int, int>> edges;
    for (const auto& [edge, index] : segments_) edges.insert(edge);
    return edges;
  }

 private:
  VertexIndex Use(int i) {
    auto& [vertex, count] = points_[i];
    if (count++ == 0) vertex = refinement_.AddPoint(grid_.At(i), 1);
    return vertex;
  }
  void Leave(int i) {
    auto& [vertex, count] = points_[i];
    if (--count == 0) refinement_.RemovePoint(vertex);
  }

  GridEdges grid_;
  R refinement_;
  std::map<int, std::pair<VertexIndex, int>> points_;
  std::map<std::pair<int, int>, SubsegmentIndex> segments_;
  std::map<Point3, VertexIndex> free_;
};

template <class R>
std::set<std::pair<Point3, Point3>> SubsegmentsOf(const R& refinement) {
  std::set<std::pair<Point3, Point3>> all;
  refinement.elements().ForEachSubsegment(
      [&](const auto& s) { all.emplace(refinement.vertex(s.a).p, refinement.vertex(s.b).p); });
  return all;
}

class SpaceSegments : public testing::TestWithParam<bool> {};

TEST_P(SpaceSegments, AreFromScratchAfterEveryEditAndInTheTriangulation) {
  const char* nightly = std::getenv("DYNMESH_NIGHTLY");
  const int revisions = nightly != nullptr && *nightly != '0' ? 1500 : 15;
  Random random(9);
  const GridEdges grid{GetParam()};
  const MeshOptions options = Options(2);
  WithSegments<Traced> dynamic(options, grid);
  for (int revision = 0; revision < revisions; ++revision) {
    for (int i = 1 + random.Below(4); i > 0; --i) {
      dynamic.Toggle(GridEdges::Any(random));
      const std::set<Point3> points = dynamic.Points();
      dynamic.Toggle(points.size() > 12 && random.OneIn(2) ? *points.begin()
                                                           : grid.AnyBetween(random));
    }
    dynamic.Run();
    WithSegments<Traced> fresh(options, grid);
    delaunay::DelaunayTetrahedralization triangulation;
    WithSegments<Untraced> untraced(options, grid, &triangulation);
    for (const auto& edge : dynamic.Edges()) fresh.Toggle(edge), untraced.Toggle(edge);
    for (const Point3& p : dynamic.Points()) fresh.Toggle(p), untraced.Toggle(p);
    fresh.Run();
    untraced.Run();
    ASSERT_EQ(VerticesOf(dynamic.refinement()), VerticesOf(fresh.refinement())) << revision;
    ASSERT_EQ(SubsegmentsOf(dynamic.refinement()), SubsegmentsOf(fresh.refinement()));
    ASSERT_EQ(VerticesOf(dynamic.refinement()), VerticesOf(untraced.refinement())) << revision;
    ASSERT_EQ(SubsegmentsOf(dynamic.refinement()), SubsegmentsOf(untraced.refinement()));
    std::vector<std::string> problems;
    ASSERT_EQ(Audit(dynamic.refinement(), &problems), Audit(fresh.refinement(), &problems));
    ASSERT_TRUE(problems.empty()) << problems[0];
    // Every subsegment is an edge of the triangulation.
    std::set<std::pair<Point3, Point3>> edges;
    triangulation.ForEachSimplex([&](auto t) {
      for (const auto a : triangulation.vertices(t)) {
        for (const auto b : triangulation.vertices(t)) {
          const Point3 &p = triangulation.position(a), &q = triangulation.position(b);
          if (p < q) edges.emplace(p, q);
        }
      }
    });
    for (const auto& s : SubsegmentsOf(dynamic.refinement())) {
      ASSERT_TRUE(edges.contains(std::minmax(s.first, s.second))) << revision;
    }
  }
  EXPECT_GT(SubsegmentsOf(dynamic.refinement()).size(), dynamic.Edges().size());
}

INSTANTIATE_TEST_SUITE_P(Grid, SpaceSegments, testing::Bool());

// The cost of an edit of one point does not depend on the number of points.
TEST(SpaceRefinementWork, AnEditDoesNotGrowWithTheInput) {
  std::vector<double> executed;
  for (const int n : {300, 3000}) {
    Random random(5);
    Traced refinement(Options(2), nullptr);
    std::set<Point3> points;
    while (static_cast<int>(points.size()) < n) points.insert(RandomPoint(Kind::kUniform, random));
    Fill(refinement, points);
    refinement.engine().ResetCounters();
    for (int i = 0; i < 20; ++i) {
      const VertexIndex v = refinement.AddPoint(RandomPoint(Kind::kUniform, random), 1);
      refinement.Propagate([] { return false; });
      refinement.RemovePoint(v);
      refinement.Propagate([] { return false; });
      refinement.TakeChanges([](auto...) {}, [](auto...) {});
    }
    executed.push_back(static_cast<double>(refinement.engine().counters().executed) / 40);
  }
  EXPECT_LT(executed[0], 250);
  EXPECT_LT(executed[1], 250);
  EXPECT_LT(executed[1], 1.5 * executed[0]);
}

}  // namespace
}  // namespace dynmesh::meshing::space_refinement_test
