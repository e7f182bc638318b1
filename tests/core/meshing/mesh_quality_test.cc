// Whole meshes, judged by exact arithmetic: every kind of input, every quality.
// Delaunay, cover of the domain, input kept, circumradius to shortest edge. CGAL is the
// oracle: predicates, rationals and its own triangulation of the vertices.
#include <CGAL/Exact_rational.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/rounding.h"
#include "dynmesh/dynamic_mesh.h"
#include "tests/core/delaunay/delaunay_oracle.h"
#include "tests/support/asked.h"
#include "tests/support/workload.h"

namespace dynmesh::mesh_quality_test {
namespace {

using Exact = CGAL::Exact_rational;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalPoint = Kernel::Point_2;
using geometry::Point2;
using test::Distribution;
using test::kAsked;

CgalPoint ToCgal(const Point2& p) { return {p[0], p[1]}; }

// Twice the signed area.
Exact ExactCross(const Point2& a, const Point2& b, const Point2& c) {
  return (Exact(b[0]) - a[0]) * (Exact(c[1]) - a[1]) - (Exact(b[1]) - a[1]) * (Exact(c[0]) - a[0]);
}

Exact Squared(const Point2& a, const Point2& b) {
  const Exact x = Exact(a[0]) - b[0], y = Exact(a[1]) - b[1];
  return x * x + y * y;
}

using Edge = std::pair<VertexId, VertexId>;  // the lesser first
Edge EdgeOf(VertexId a, VertexId b) { return {std::min(a, b), std::max(a, b)}; }

// A mesh by ids.
struct Judged {
  Judged(const Mesh& m, const MeshOptions& o) : mesh(m), options(o), domain(DomainBox(o)) {
    for (std::size_t i = 0; i < m.vertices.size(); ++i) {
      at[m.vertices.ids[i]] = {{m.vertices.coordinates[2 * i], m.vertices.coordinates[2 * i + 1]}};
    }
    for (std::size_t i = 0; i < m.simplices.size(); i += 3) {
      triangles.push_back({m.simplices[i], m.simplices[i + 1], m.simplices[i + 2]});
      for (int k = 0; k < 3; ++k) {
        const auto& t = triangles.back();
        apexes[EdgeOf(t[k], t[(k + 1) % 3])].push_back(t[(k + 2) % 3]);
      }
    }
  }
  double slack(double e2) const { return QualitySlackAt(std::ilogb(e2), UlpOf(domain, 2)); }
  bool OnOneSideOfTheDomain(const Point2& a, const Point2& b) const {
    for (int k = 0; k < 2; ++k) {
      if (a[k] == b[k] && (a[k] == domain.lo[k] || a[k] == domain.hi[k])) return true;
    }
    return false;
  }

  const Mesh& mesh;
  const MeshOptions& options;
  Box domain;
  std::map<VertexId, Point2> at;
  std::vector<std::array<VertexId, 3>> triangles;
  std::map<Edge, std::vector<VertexId>> apexes;
};

// Each edge is locally Delaunay, inner ones have two triangles; together with the area
// that is the Delaunay triangulation. And CGAL makes as many triangles of the vertices.
void CheckDelaunay(const Judged& j) {
  std::set<Point2> places;
  std::vector<Point2> points;
  for (const auto& [id, p] : j.at) {
    ASSERT_TRUE(places.insert(p).second) << "two vertices at one place";
    points.push_back(p);
  }
  ASSERT_EQ(places.size(), j.mesh.vertices.size()) << "an id stands twice";
  Exact area = 0;
  for (const auto& t : j.triangles) {
    const Exact cross = ExactCross(j.at.at(t[0]), j.at.at(t[1]), j.at.at(t[2]));
    ASSERT_GT(cross, 0) << "not counter-clockwise";
    area += cross;
  }
  const auto& [lo, hi] = j.domain;
  ASSERT_EQ(area, 2 * (Exact(hi[0]) - lo[0]) * (Exact(hi[1]) - lo[1])) << "covers the domain";
  for (const auto& [edge, apexes] : j.apexes) {
    const Point2 &a = j.at.at(edge.first), &b = j.at.at(edge.second);
    ASSERT_LE(apexes.size(), 2u);
    if (apexes.size() == 1) {
      ASSERT_TRUE(j.OnOneSideOfTheDomain(a, b)) << "a border inside the domain";
      continue;
    }
    Point2 p = j.at.at(apexes[0]), q = j.at.at(apexes[1]);
    if (CGAL::orientation(ToCgal(a), ToCgal(b), ToCgal(p)) != CGAL::LEFT_TURN) std::swap(p, q);
    ASSERT_NE(CGAL::side_of_oriented_circle(ToCgal(a), ToCgal(b), ToCgal(p), ToCgal(q)),
              CGAL::ON_POSITIVE_SIDE)
        << "a vertex in a circumcircle";
  }
  const delaunay::testing::TriangleSet by_cgal = delaunay::testing::CgalDelaunay(points);
  ASSERT_EQ(by_cgal.size(), j.triangles.size());
}

// A segment that the mesh has to keep: a feature, or an edge of polygons.
struct Joint {
  FeatureId owner;
  std::array<FeatureId, 2> ends;
};

// An edge of several polygons belongs to the one of least id, unless a segment feature has
// the same ends.
std::vector<Joint> JointsOf(const std::vector<Feature>& features) {
  std::map<std::pair<FeatureId, FeatureId>, FeatureId> owners;
  for (const FeatureKind kind : {FeatureKind::kSegment, FeatureKind::kPolygon}) {
    std::map<std::pair<FeatureId, FeatureId>, FeatureId> these;
    for (const Feature& f : features) {
      if (f.kind != kind) continue;
      const auto join = [&](FeatureId p, FeatureId q) {
        const auto [it, is_new] = these.try_emplace(std::minmax(p, q), f.id);
        it->second = std::min(it->second, f.id);
      };
      if (kind == FeatureKind::kSegment) join(f.ends[0], f.ends[1]);
      for (const auto& ring : f.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) join(ring[i], ring[(i + 1) % ring.size()]);
      }
    }
    owners.insert(these.begin(), these.end());
  }
  std::vector<Joint> joints;
  for (const auto& [ends, owner] : owners) joints.push_back({owner, {ends.first, ends.second}});
  return joints;
}

// Points are vertices of their own; a segment is a chain of subsegments, each an edge,
// from end to end, off the line by rounding only.
void CheckInputIsKept(const Judged& j, const std::vector<Feature>& features) {
  std::map<Point2, std::size_t> row_at;
  for (std::size_t i = 0; i < j.mesh.vertices.size(); ++i) {
    row_at[j.at.at(j.mesh.vertices.ids[i])] = i;
  }
  std::map<FeatureId, std::vector<Edge>> subsegments;
  for (std::size_t i = 0; i < j.mesh.subsegments.size(); ++i) {
    const Edge e = {j.mesh.subsegments.ends[2 * i], j.mesh.subsegments.ends[2 * i + 1]};
    ASSERT_TRUE(j.apexes.contains(e)) << "a subsegment is no edge";
    subsegments[j.mesh.subsegments.owners[i]].push_back(e);
  }
  std::map<FeatureId, Point2> place;
  for (const Feature& f : features) {
    if (f.kind != FeatureKind::kPoint) continue;
    place[f.id] = {{f.position[0], f.position[1]}};
    const auto row = row_at.find(place[f.id]);
    ASSERT_NE(row, row_at.end()) << "point " << f.id << " is no vertex";
    ASSERT_EQ(j.mesh.vertices.owners[row->second], f.id);
    ASSERT_EQ(j.mesh.vertices.containing_dimensions[row->second], 0);
  }
  const double ulp = UlpOf(j.domain, 2);
  std::map<FeatureId, std::size_t> subsegments_met;
  for (const Joint& f : JointsOf(features)) {
    const Point2 &p = place.at(f.ends[0]), &q = place.at(f.ends[1]);
    std::map<VertexId, std::vector<VertexId>> beside;
    for (const auto& [a, b] : subsegments[f.owner]) {
      // A polygon has other edges: only what lies along this one.
      const auto is_along = [&](VertexId v) {
        const Point2& x = j.at.at(v);
        const double cross = CGAL::to_double(ExactCross(p, q, x));
        return std::fabs(cross) <= 8 * ulp * std::sqrt(CGAL::to_double(Squared(p, q))) &&
               Squared(x, p) <= Squared(p, q) && Squared(x, q) <= Squared(p, q);
      };
      if (is_along(a) && is_along(b)) beside[a].push_back(b), beside[b].push_back(a);
    }
    // Walk from p: every subsegment once, ever nearer to q, which is the end.
    VertexId v = j.mesh.vertices.ids[row_at.at(p)], before = 0;
    const VertexId end = j.mesh.vertices.ids[row_at.at(q)];
    std::size_t steps = 0;
    while (v != end) {
      const std::vector<VertexId>& next = beside[v];
      ASSERT_EQ(next.size(), before == 0 ? 1u : 2u) << "segment of " << f.owner << " is no chain";
      const VertexId w = next[0] == before ? next.back() : next[0];
      ASSERT_LT(Squared(j.at.at(w), q), Squared(j.at.at(v), q)) << "goes back";
      before = std::exchange(v, w);
      ++steps;
      const double off =
          CGAL::to_double(ExactCross(p, q, j.at.at(v))) / std::sqrt(CGAL::to_double(Squared(p, q)));
      ASSERT_LE(std::fabs(off), 8 * ulp) << "segment of " << f.owner << " bends";
    }
    subsegments_met[f.owner] += steps;
  }
  for (const auto& [owner, edges] : subsegments) {
    if (owner == kBoxFeature) continue;
    ASSERT_EQ(subsegments_met[owner], edges.size())
        << "feature " << owner << " has other subsegments";
  }
  ASSERT_EQ(subsegments.size(), subsegments_met.size() + 1)
      << "those of the features and of the box";
}

// Edges as short as a small angle of the input makes them: between two segments that leave
// a common point less than 60 degrees apart, their ends equally far from it.
std::set<Edge> FindSeditious(const Judged& j, const std::vector<Feature>& features) {
  std::map<FeatureId, Point2> place;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) place[f.id] = {{f.position[0], f.position[1]}};
  }
  const std::vector<Joint> joints = JointsOf(features);
  std::map<FeatureId, std::vector<std::size_t>> joints_of;
  for (std::size_t i = 0; i < joints.size(); ++i) joints_of[joints[i].owner].push_back(i);
  // The owner's segment with the vertex on its line.
  const auto joint_at = [&](FeatureId owner, const Point2& x) {
    const auto off = [&](std::size_t i) {
      const Point2 &p = place[joints[i].ends[0]], &q = place[joints[i].ends[1]];
      const double length2 = CGAL::to_double(Squared(p, q));
      const double t = std::clamp(
          ((x[0] - p[0]) * (q[0] - p[0]) + (x[1] - p[1]) * (q[1] - p[1])) / length2, 0.0, 1.0);
      return std::hypot(p[0] + t * (q[0] - p[0]) - x[0], p[1] + t * (q[1] - p[1]) - x[1]);
    };
    const auto& its = joints_of[owner];
    return *std::min_element(its.begin(), its.end(),
                             [&](std::size_t a, std::size_t b) { return off(a) < off(b); });
  };
  std::map<VertexId, std::size_t> segment_of;
  for (std::size_t i = 0; i < j.mesh.vertices.size(); ++i) {
    const FeatureId owner = j.mesh.vertices.owners[i];
    if (j.mesh.vertices.containing_dimensions[i] == 1 && joints_of.contains(owner)) {
      segment_of[j.mesh.vertices.ids[i]] = joint_at(owner, j.at.at(j.mesh.vertices.ids[i]));
    }
  }
  const double ulp = UlpOf(j.domain, 2);
  const auto distance = [](const Point2& a, const Point2& b) {
    return std::hypot(a[0] - b[0], a[1] - b[1]);
  };
  std::set<Edge> seditious;
  for (const auto& [edge, apexes] : j.apexes) {
    const auto s = segment_of.find(edge.first), t = segment_of.find(edge.second);
    if (s == segment_of.end() || t == segment_of.end() || s->second == t->second) continue;
    const Point2 &p = j.at.at(edge.first), &q = j.at.at(edge.second);
    const auto &of_s = joints[s->second].ends, &of_t = joints[t->second].ends;
    for (const FeatureId apex : of_s) {
      if (apex != of_t[0] && apex != of_t[1]) continue;
      const double dp = distance(place[apex], p), dq = distance(place[apex], q);
      const double chord = distance(p, q) / std::max(dp, dq);
      if (std::fabs(dp - dq) <= 8 * ulp && chord < 1) seditious.insert(edge);
    }
  }
  return seditious;
}

// No triangle over rho (1+h), exactly, measured by its shortest edge that is not seditious.
void CheckRadiusEdge(const Judged& j, const std::set<Edge>& seditious) {
  for (const auto& t : j.triangles) {
    Exact product = 1, shortest = 0;
    for (int k = 0; k < 3; ++k) {
      const VertexId a = t[k], b = t[(k + 1) % 3];
      const Exact e2 = Squared(j.at.at(a), j.at.at(b));
      product *= e2;
      if (seditious.contains(EdgeOf(a, b))) continue;
      if (shortest == 0 || e2 < shortest) shortest = e2;
    }
    if (shortest == 0) continue;
    const Exact cross = ExactCross(j.at.at(t[0]), j.at.at(t[1]), j.at.at(t[2]));
    // R^2 = product / (2 cross)^2.
    const Exact bound = Exact(j.options.quality) * (1 + Exact(j.slack(CGAL::to_double(shortest))));
    // The test itself rounds: some 2^-50, far below h.
    ASSERT_LE(product, shortest * bound * bound * 4 * cross * cross * (1 + Exact(0x1p-48)))
        << "rho " << std::sqrt(CGAL::to_double(product / (shortest * 4 * cross * cross)));
  }
}

// The thesis's: no corner of a vertex's Voronoi cell farther than rho (1+h) NN. The
// centre that refinement tests is rounded, so that flat triangles have more slack.
void CheckVoronoiAspect(const Judged& j, const std::set<Edge>& seditious) {
  std::map<VertexId, Exact> nn2, far2;
  for (const auto& [edge, apexes] : j.apexes) {
    if (seditious.contains(edge)) continue;
    const Exact e2 = Squared(j.at.at(edge.first), j.at.at(edge.second));
    for (const VertexId v : {edge.first, edge.second}) {
      const auto [it, fresh] = nn2.try_emplace(v, e2);
      if (!fresh) it->second = std::min(it->second, e2);
    }
  }
  for (const auto& t : j.triangles) {
    const Point2 &a = j.at.at(t[0]), &b = j.at.at(t[1]), &c = j.at.at(t[2]);
    const Exact cross = ExactCross(a, b, c);
    const Exact r2 = Squared(a, b) * Squared(b, c) * Squared(c, a) / (4 * cross * cross);
    for (const VertexId v : t) {
      const Exact bound =
          Exact(j.options.quality) * (1 + Exact(j.slack(CGAL::to_double(nn2.at(v)))) + Exact(1e-9));
      ASSERT_LE(r2, bound * bound * nn2.at(v))
          << "at " << j.at.at(v)[0] << " " << j.at.at(v)[1] << ": "
          << std::sqrt(CGAL::to_double(r2 / nn2.at(v)));
    }
  }
}

// True if the triangle meets the region of a sizing feature, by more than rounding.
bool Meets(const std::array<Point2, 3>& t, const Feature& size) {
  const Point2 lo{{size.position[0], size.position[1]}};
  const bool is_box = size.sizing.shape == SizeShape::kBox;
  const Point2 hi = is_box ? Point2{{size.sizing.hi[0], size.sizing.hi[1]}} : lo;
  // Discs and points: the distance from their centre.
  const double radius = size.sizing.shape == SizeShape::kDisc ? size.sizing.radius : 0;
  bool inside = true;
  double distance = INFINITY;
  // Boxes: no line through an edge or along an axis parts the two.
  bool parted = false;
  for (int k = 0; k < 2; ++k) {
    parted |= std::max({t[0][k], t[1][k], t[2][k]}) < lo[k] ||
              std::min({t[0][k], t[1][k], t[2][k]}) > hi[k];
  }
  for (int i = 0; i < 3; ++i) {
    const Point2 &a = t[i], &b = t[(i + 1) % 3];
    const double ex = b[0] - a[0], ey = b[1] - a[1];
    const auto side = [&](double x, double y) { return ex * (y - a[1]) - ey * (x - a[0]); };
    parted |= std::max({side(lo[0], lo[1]), side(hi[0], lo[1]), side(lo[0], hi[1]),
                        side(hi[0], hi[1])}) < 1e-15;
    inside &= side(lo[0], lo[1]) > 1e-15;
    const double along = ((lo[0] - a[0]) * ex + (lo[1] - a[1]) * ey) / (ex * ex + ey * ey);
    const double s = std::clamp(along, 0.0, 1.0);
    distance = std::min(distance, std::hypot(a[0] + s * ex - lo[0], a[1] + s * ey - lo[1]));
  }
  return is_box ? !parted : inside || distance < radius * (1 - 1e-9);
}

// The same for a polygon given by its rings.
bool MeetsPolygon(const std::array<Point2, 3>& t, const std::vector<std::vector<Point2>>& rings) {
  const auto turn = [](const Point2& a, const Point2& b, const Point2& c) {
    const double x = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return std::fabs(x) < 1e-14 ? 0 : x > 0 ? 1 : -1;
  };
  bool corner_inside = false, crosses = false, holds_corner = false;
  std::array<int, 3> crossed = {0, 0, 0};  // edges to the right of each corner
  std::array<bool, 3> near = {};
  for (const auto& ring : rings) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Point2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      bool inside = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const Point2 &p = t[k], &q = t[(k + 1) % 3];
        crosses |= turn(p, q, a) * turn(p, q, b) < 0 && turn(a, b, p) * turn(a, b, q) < 0;
        inside &= turn(p, q, a) > 0;
        if ((a[1] > p[1]) == (b[1] > p[1])) continue;
        near[k] = near[k] || turn(a, b, p) == 0;
        crossed[k] += a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]) > p[0];
      }
      holds_corner |= inside;
    }
  }
  for (std::size_t k = 0; k < 3; ++k) corner_inside |= !near[k] && crossed[k] % 2 == 1;
  return crosses || holds_corner || corner_inside;
}

// The same for a capsule: its polyline is nearer than the radius to a corner or an edge, or in it.
bool MeetsCapsule(const std::array<Point2, 3>& t, const Sizing& sizing) {
  const auto distance = [](const Point2& x, const Point2& a, const Point2& b) {
    const double ex = b[0] - a[0], ey = b[1] - a[1];
    const double along = ((x[0] - a[0]) * ex + (x[1] - a[1]) * ey) / (ex * ex + ey * ey);
    const double s = std::clamp(along, 0.0, 1.0);
    return std::hypot(a[0] + s * ex - x[0], a[1] + s * ey - x[1]);
  };
  const auto turn = [](const Point2& a, const Point2& b, const Point2& c) {
    const double x = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    return std::fabs(x) < 1e-14 ? 0 : x > 0 ? 1 : -1;
  };
  for (std::size_t i = 1; i < sizing.path.size(); ++i) {
    const Point2 p{{sizing.path[i - 1][0], sizing.path[i - 1][1]}};
    const Point2 q{{sizing.path[i][0], sizing.path[i][1]}};
    double nearest = INFINITY;
    bool inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const Point2 &a = t[k], &b = t[(k + 1) % 3];
      nearest = std::min({nearest, distance(a, p, q), distance(p, a, b), distance(q, a, b)});
      if (turn(a, b, p) * turn(a, b, q) < 0 && turn(p, q, a) * turn(p, q, b) < 0) return true;
      inside &= turn(a, b, p) > 0;
    }
    if (inside || nearest < sizing.radius * (1 - 1e-9)) return true;
  }
  return false;
}

// No edge of a triangle that meets a region is longer than sqrt 2 times its target.
void CheckSizes(const Judged& j, const std::vector<Feature>& features) {
  std::map<FeatureId, Point2> place;
  for (const Feature& f : features) {
    if (f.kind == FeatureKind::kPoint) place[f.id] = {{f.position[0], f.position[1]}};
  }
  for (const Feature& size : features) {
    if (size.kind != FeatureKind::kSize) continue;
    std::vector<std::vector<Point2>> rings;
    for (const auto& ring : size.rings) {
      rings.emplace_back();
      for (const FeatureId point : ring) rings.back().push_back(place.at(point));
    }
    std::size_t met = 0;
    for (const auto& t : j.triangles) {
      const std::array<Point2, 3> corners = {j.at.at(t[0]), j.at.at(t[1]), j.at.at(t[2])};
      const bool meets = size.sizing.shape == SizeShape::kCapsule
                             ? MeetsCapsule(corners, size.sizing)
                         : rings.empty() ? Meets(corners, size)
                                         : MeetsPolygon(corners, rings);
      if (!meets) continue;
      ++met;
      for (int i = 0; i < 3; ++i) {
        const double length = std::sqrt(CGAL::to_double(Squared(corners[i], corners[(i + 1) % 3])));
        ASSERT_LE(length, std::numbers::sqrt2 * size.sizing.target * (1 + 1e-9))
            << "size " << size.id;
      }
    }
    ASSERT_GT(met, 0u) << "size " << size.id;
  }
}

class MeshQuality : public testing::TestWithParam<std::tuple<Distribution, int>> {};

TEST_P(MeshQuality, IsADelaunayMeshOfTheInputWithTheQualityAskedFor) {
  const auto [distribution, asked] = GetParam();
  MeshOptions options;
  options.quality = kAsked[asked].quality;
  options.criterion = kAsked[asked].criterion;
  options.limits.max_vertices = 100'000;
  const std::uint64_t seed = 300;
  SCOPED_TRACE("seed " + std::to_string(seed));
  const std::vector<Feature> features = test::MakeFeatures(distribution, 300, seed);
  const absl::StatusOr<Mesh> mesh = BuildMesh(features, options);
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(ComputeHash(*mesh), mesh->hash);
  const Judged judged(*mesh, options);
  ASSERT_NO_FATAL_FAILURE(CheckDelaunay(judged));
  ASSERT_NO_FATAL_FAILURE(CheckInputIsKept(judged, features));
  const std::set<Edge> seditious = FindSeditious(judged, features);
  EXPECT_TRUE(HasSegments(distribution) || seditious.empty());
  ASSERT_NO_FATAL_FAILURE(CheckRadiusEdge(judged, seditious));
  ASSERT_NO_FATAL_FAILURE(CheckSizes(judged, features));
  if (options.criterion == Criterion::kThesis) {
    ASSERT_NO_FATAL_FAILURE(CheckVoronoiAspect(judged, seditious));
  }
}

std::string NameOfCase(const testing::TestParamInfo<std::tuple<Distribution, int>>& its) {
  return NameOf(std::get<0>(its.param)) + kAsked[std::get<1>(its.param)].name;
}

INSTANTIATE_TEST_SUITE_P(All, MeshQuality,
                         testing::Combine(testing::ValuesIn(test::kAllDistributions),
                                          testing::Range(0, test::kAskedCount)),
                         NameOfCase);

}  // namespace
}  // namespace dynmesh::mesh_quality_test
