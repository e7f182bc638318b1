// Facets in 3D: after every edit refinement equals a run from scratch, in vertices, subsegments and
// complete trace, whether neighbourhoods are found locally or read off a triangulation. The
// triangulation of the vertices covers each facet once, and no tetrahedron is over rho.
//
// Facets are faces of a grid, at right angles or in one plane where they meet, and frames between
// its planes, not convex and with a hole. DYNMESH_NIGHTLY=1 runs long scripts.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/delaunay/delaunay_tetrahedralization.h"
#include "core/geometry/circumball.h"
#include "core/geometry/constructions.h"
#include "core/meshing/facet_membership.h"
#include "core/meshing/refinement.h"
#include "core/meshing/trace_audit.h"
#include "tests/support/workload.h"

namespace dynmesh::meshing::space_facets_test {
namespace {

using geometry::Point3;
using Traced = Refinement<3, sac::Engine>;
using Untraced = Refinement<3, sac::UntracedEngine>;
using test::Random;

enum class Place { kStraight, kTurned, kSkew };

Point3 Placed(Place place, double x, double y, double z) {
  switch (place) {
    case Place::kStraight:
      return {{x, y, z}};
    case Place::kTurned:  // about an axis, by 3-4-5
      return {{0.1 + 0.8 * x - 0.6 * y, 0.1 + 0.6 * x + 0.8 * y, 0.3 + z}};
    case Place::kSkew: {  // about (1, 2, 3): no coordinate is round
      const double u = 0.958526740 * x - 0.230562791 * y + 0.167532947 * z;
      const double v = 0.243323794 * x + 0.968097492 * y - 0.059839593 * z;
      const double w = -0.148391443 * x + 0.098122602 * y + 0.984048746 * z;
      return {{u + 0.2, v, w + 0.1}};
    }
  }
  return {};
}

// A polygon: rings of places.
using Shape = std::vector<std::vector<Point3>>;

class Shapes {
 public:
  explicit Shapes(Place place) : place_(place) {}

  Shape Any(Random& random) const {
    return random.OneIn(6) ? Frame(random.Below(3)) : Face(random);
  }
  // Off all planes of shapes.
  Point3 AnyBetween(Random& random) const {
    const auto odd = [&] { return (2 * random.Below(12) + 1) / 32.0 + 1.0 / 128; };
    return Placed(place_, odd(), odd(), odd());
  }

 private:
  static constexpr double kStep = 0.25;

  Shape Face(Random& random) const {
    const int axis = random.Below(3);
    std::array<int, 3> from;
    for (int k = 0; k < 3; ++k) from[k] = random.Below(k == axis ? 4 : 3);
    std::vector<Point3> ring;
    for (const auto& [i, j] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      std::array<int, 3> at = from;
      at[(axis + 1) % 3] += i;
      at[(axis + 2) % 3] += j;
      ring.push_back(Placed(place_, kStep * at[0], kStep * at[1], kStep * at[2]));
    }
    return {ring};
  }
  // An L with a hole, half-way between two planes, free of the grid.
  Shape Frame(int layer) const {
    const double z = kStep * (layer + 0.5);
    const auto ring = [&](std::vector<std::array<double, 2>> corners) {
      std::vector<Point3> places;
      for (const auto& [x, y] : corners) places.push_back(Placed(place_, 0.8 + x, y, z));
      return places;
    };
    return {ring({{0, 0}, {0.4, 0}, {0.4, 0.2}, {0.2, 0.2}, {0.2, 0.4}, {0, 0.4}}),
            ring({{0.05, 0.05}, {0.15, 0.05}, {0.15, 0.15}, {0.05, 0.15}})};
  }

  Place place_;
};

MeshOptions Options() {
  MeshOptions options;
  options.dimension = 3;
  options.quality = 2;
  options.box.hi = {1.25, 1.25, 1.25};
  return options;
}

// A refinement with features identified by their positions; common edges and corners of facets
// exist once.
template <class R>
class Complex {
 public:
  explicit Complex(R& refinement) : refinement_(refinement) {}

  void Toggle(const Shape& shape) {
    const auto it = facets_.find(shape);
    if (it == facets_.end()) {
      std::vector<std::vector<VertexIndex>> rings;
      for (const auto& ring : shape) {
        auto& corners = rings.emplace_back();
        for (const Point3& p : ring) corners.push_back(Use(p));
      }
      ForEachEdge(shape, [&](const Point3& p, const Point3& q) {
        auto& edge = edges_[std::minmax(p, q)];
        if (edge.second++ > 0) return;
        edge.first =
            refinement_.AddSegment(points_.at(p).first, points_.at(q).first, next_feature_++);
      });
      facets_[shape] = refinement_.AddFacet(rings, next_feature_++);
    } else {
      refinement_.RemoveFacet(it->second);
      ForEachEdge(shape, [&](const Point3& p, const Point3& q) {
        const auto edge = edges_.find(std::minmax(p, q));
        if (--edge->second.second > 0) return;
        refinement_.RemoveSegment(edge->second.first);
        edges_.erase(edge);
      });
      for (const auto& ring : shape) {
        for (const Point3& p : ring) Leave(p);
      }
      facets_.erase(it);
    }
  }
  void Toggle(const Point3& p) {
    if (!free_.insert(p).second) {
      Leave(p);
      free_.erase(p);
    } else {
      Use(p);
    }
  }
  void Run() {
    ASSERT_TRUE(refinement_.Propagate([] { return false; }));
    ASSERT_FALSE(refinement_.hit_depth_limit());
    refinement_.TakeChanges([](auto...) {}, [](auto...) {});
  }
  template <class Other>
  void AddAllOf(const Other& other) {
    for (const auto& [shape, index] : other.facets()) Toggle(shape);
    for (const Point3& p : other.free()) Toggle(p);
  }

  const std::map<Shape, FacetIndex>& facets() const { return facets_; }
  const std::set<Point3>& free() const { return free_; }

 private:
  template <class F>
  static void ForEachEdge(const Shape& shape, F f) {
    for (const auto& ring : shape) {
      for (std::size_t i = 0; i < ring.size(); ++i) f(ring[i], ring[(i + 1) % ring.size()]);
    }
  }
  VertexIndex Use(const Point3& p) {
    auto& [vertex, count] = points_[p];
    if (count++ == 0) vertex = refinement_.AddPoint(p, next_feature_++);
    return vertex;
  }
  void Leave(const Point3& p) {
    const auto it = points_.find(p);
    if (--it->second.second > 0) return;
    refinement_.RemovePoint(it->second.first);
    points_.erase(it);
  }

  R& refinement_;
  FeatureSlot next_feature_ = 1;
  std::map<Point3, std::pair<VertexIndex, int>> points_;
  std::map<std::pair<Point3, Point3>, std::pair<SubsegmentIndex, int>> edges_;
  std::map<Shape, FacetIndex> facets_;
  std::set<Point3> free_;
};

template <class R>
std::vector<std::pair<Point3, int>> VerticesOf(const R& refinement) {
  std::vector<std::pair<Point3, int>> vertices;
  refinement.elements().ForEachVertex(
      [&](VertexIndex, const auto& v) { vertices.emplace_back(v.p, v.dimension); });
  std::sort(vertices.begin(), vertices.end());
  return vertices;
}

double AreaOf(const std::vector<Point3>& ring) {
  geometry::Vector3 sum = {0, 0, 0};
  for (std::size_t i = 1; i + 1 < ring.size(); ++i) {
    const auto c = geometry::Cross(geometry::Difference(ring[i].c, ring[0].c),
                                   geometry::Difference(ring[i + 1].c, ring[0].c));
    for (int k = 0; k < 3; ++k) sum[k] += c[k];
  }
  return std::sqrt(geometry::Dot(sum, sum)) / 2;
}

// The mesh: no tetrahedron over rho, every facet covered once.
void ExpectGoodMesh(const Complex<Traced>& complex, const Traced& refinement) {
  delaunay::DelaunayTetrahedralization triangulation;
  std::vector<VertexIndex> ids;
  std::vector<Point3> places;
  triangulation.Reset(refinement.complex().rules.lo(), refinement.complex().rules.hi(),
                      {0, 1, 2, 3, 4, 5, 6, 7});
  refinement.elements().ForEachVertex([&](VertexIndex v, const auto& vertex) {
    if (v < 8) return;
    ids.push_back(v);
    places.push_back(vertex.p);
  });
  triangulation.InsertAll(ids, places);
  std::map<FacetIndex, double> area;
  int over = 0;
  triangulation.ForEachSimplex([&](auto t) {
    const auto& v = triangulation.vertices(t);
    const auto at = [&](int i) { return refinement.vertex(v[i % 4]).p; };
    double shortest2 = INFINITY;
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < i; ++j) {
        shortest2 = std::min(shortest2, geometry::SquaredDistance(at(i), at(j)));
      }
      const FacetIndex facet = meshing::FacetOf(refinement.complex(), v[(i + 1) % 4],
                                                v[(i + 2) % 4], v[(i + 3) % 4], v[i]);
      if (facet != kNil) area[facet] += AreaOf({at(i + 1), at(i + 2), at(i + 3)});
    }
    over += geometry::ExactCircumball(at(0), at(1), at(2), at(3)).r2 > 4 * (1 + 1e-6) * shortest2;
  });
  EXPECT_EQ(over, 0);
  for (const auto& [shape, index] : complex.facets()) {
    const double wanted = AreaOf(shape[0]) - (shape.size() > 1 ? AreaOf(shape[1]) : 0);
    EXPECT_NEAR(area[index], wanted, 1e-9);
  }
}

class SpaceFacets : public testing::TestWithParam<Place> {};

TEST_P(SpaceFacets, AreFromScratchAfterEveryEditAndCovered) {
  const char* nightly = std::getenv("DYNMESH_NIGHTLY");
  const int revisions = nightly != nullptr && *nightly != '0' ? 1500 : 20;
  constexpr std::uint64_t kSeed = 31;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Random random(kSeed);
  const Shapes shapes(GetParam());
  const MeshOptions options = Options();
  Traced traced(options, nullptr);
  Complex dynamic(traced);
  for (int revision = 0; revision < revisions; ++revision) {
    SCOPED_TRACE("revision " + std::to_string(revision));
    for (int i = 1 + random.Below(5); i > 0; --i) {
      dynamic.Toggle(dynamic.facets().size() > 25 && random.OneIn(2)
                         ? Shape(dynamic.facets().begin()->first)
                         : shapes.Any(random));
      dynamic.Toggle(dynamic.free().size() > 8 && random.OneIn(2) ? Point3(*dynamic.free().begin())
                                                                  : shapes.AnyBetween(random));
    }
    dynamic.Run();
    Traced fresh_refinement(options, nullptr);
    Complex fresh(fresh_refinement);
    fresh.AddAllOf(dynamic);
    fresh.Run();
    delaunay::DelaunayTetrahedralization triangulation;
    Untraced untraced_refinement(options, &triangulation);
    Complex untraced(untraced_refinement);
    untraced.AddAllOf(dynamic);
    untraced.Run();
    delaunay::DelaunayTetrahedralization whole;
    Traced read_off_refinement(options, &whole);
    Complex read_off(read_off_refinement);
    read_off.AddAllOf(dynamic);
    read_off.Run();
    ASSERT_EQ(VerticesOf(traced), VerticesOf(fresh_refinement));
    ASSERT_EQ(VerticesOf(traced), VerticesOf(untraced_refinement));
    std::vector<std::string> problems;
    const auto trace = Audit(traced, &problems);
    ASSERT_EQ(trace, Audit(fresh_refinement, &problems));
    ASSERT_EQ(trace, Audit(read_off_refinement, &problems));
    ASSERT_TRUE(problems.empty()) << problems[0];
    if (revision % 5 == 4) ExpectGoodMesh(dynamic, traced);
    if (testing::Test::HasFailure()) return;
  }
}

std::string NameOf(const testing::TestParamInfo<Place>& info) {
  constexpr const char* kNames[] = {"Straight", "Turned", "Skew"};
  return kNames[static_cast<int>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Grids, SpaceFacets,
                         testing::Values(Place::kStraight, Place::kTurned, Place::kSkew), NameOf);

// The corners of an octahedron, four of them a facet's: all six lie on one ball. However ties are
// broken, the facet is covered.
TEST(SpaceFacets, AreCoveredWhereTheFarSideIsEquallyNear) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto corner = [&](int k, double at) {
      Point3 p = {{0.5, 0.5, 0.5}};
      p[(axis + k) % 3] += at;
      return p;
    };
    Traced refinement(Options(), nullptr);
    Complex complex(refinement);
    complex.Toggle(Shape{{corner(1, 0.25), corner(2, 0.25), corner(1, -0.25), corner(2, -0.25)}});
    complex.Toggle(corner(0, 0.25));
    complex.Toggle(corner(0, -0.25));
    complex.Run();
    ExpectGoodMesh(complex, refinement);
  }
}

// Two narrow strips, one above the other and across it. Their edges are split often, and each part
// of one spans tetrahedra with each part of the other.
TEST(SpaceFacets, BetweenEdgesThatAreSplitOftenTheTriangulationIsLeft) {
  const auto add_strips = [](auto& complex) {
    constexpr double kLow = 0.1, kHigh = 1.1, kMiddle = 0.6, kWidth = 1.0 / 512;
    complex.Toggle(Shape{{{{kLow, kMiddle, 0.4}},
                          {{kHigh, kMiddle, 0.4}},
                          {{kHigh, kMiddle + kWidth, 0.4}},
                          {{kLow, kMiddle + kWidth, 0.4}}}});
    complex.Toggle(Shape{{{{kMiddle, kLow, 0.7}},
                          {{kMiddle, kHigh, 0.7}},
                          {{kMiddle + kWidth, kHigh, 0.7}},
                          {{kMiddle + kWidth, kLow, 0.7}}}});
  };
  Traced traced(Options(), nullptr);
  Complex local(traced);
  add_strips(local);
  local.Run();

  delaunay::DelaunayTetrahedralization triangulation;
  Untraced untraced(Options(), &triangulation);
  Complex read_off(untraced);
  add_strips(read_off);
  std::size_t most = 0;  // tetrahedra beyond 16 to a vertex
  ASSERT_TRUE(untraced.Propagate([&] {
    const std::size_t usual = 16 * triangulation.vertex_count();
    most = std::max(most, std::max(triangulation.simplex_count(), usual) - usual);
    return false;
  }));
  EXPECT_EQ(VerticesOf(traced), VerticesOf(untraced));
  EXPECT_LT(most, 12'000u);
}

}  // namespace
}  // namespace dynmesh::meshing::space_facets_test
