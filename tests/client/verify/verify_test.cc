// `verify` must accept every good mesh and find every kind of damage, by the right
// check.
#include "client/verify/verify.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "client/verify/verify_internal.h"
#include "dynmesh/quality.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_mesh.h"
#include "tests/client/verify/report_text.h"
#include "tests/support/seed.h"

namespace dynmesh::cli::verify_test {
namespace {

using testing::GoodMesh;
using testing::MakeGoodMesh;
using testing::MakeGridMesh;

constexpr double kAnyQuality = 1e9;
using io::IndexedMesh;

TEST(Verify, AcceptsGoodMeshes) {
  const std::uint64_t seed = test::NewSeed();
  for (std::uint64_t i = 0; i < 20; ++i) {
    const GoodMesh good = MakeGoodMesh(seed + i, 10 + static_cast<int>(10 * i));
    const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
    EXPECT_TRUE(report.Passed()) << Describe(report);
    EXPECT_EQ(report.checks.size(), 10U);
  }
}

TEST(Verify, AcceptsEitherDiagonalOfACocircularSquare) {
  const GoodMesh good = MakeGridMesh(8);
  const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
  EXPECT_TRUE(report.Passed()) << Describe(report);
}

TEST(Verify, MeasuresAsTheLibraryDoes) {
  const GoodMesh good = MakeGoodMesh(5, 100);
  VerifyReport report = VerifyMesh(good.files, 1.5, nullptr);
  MeshOptions options;
  options.quality = 1.5;
  const QualityReport expected = MeasureQuality(io::ToMesh(good.files.mesh), options);
  EXPECT_NEAR(report.worst_radius_edge / expected.worst_radius_edge, 1, 1e-12);
  EXPECT_NEAR(report.min_angle_deg, expected.min_angle_deg, 1e-9);
  EXPECT_NEAR(report.max_angle_deg, expected.max_angle_deg, 1e-9);
  EXPECT_EQ(report.over_rho, expected.over_rho);
  EXPECT_GT(report.over_rho, 0U);
  EXPECT_EQ(FailedChecks(report), std::set<std::string>{"quality"});
}

// Where things are in a good mesh.

std::uint32_t FindVertex(const IndexedMesh& mesh, int dimension, bool on_box) {
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto& vertex = mesh.vertices[v];
    if (vertex.containing_dimension == dimension && (vertex.owner == kBoxFeature) == on_box) {
      return v;
    }
  }
  ADD_FAILURE() << "no such vertex";
  return 0;
}

IndexedMesh::Edge& FindEdge(IndexedMesh& mesh, const std::function<bool(FeatureId)>& owner) {
  return *std::find_if(mesh.edges.begin(), mesh.edges.end(),
                       [&](const auto& e) { return owner(e.owner); });
}

bool IsSegment(FeatureId owner) { return owner != kNoFeature && owner != kBoxFeature; }
bool IsBox(FeatureId owner) { return owner == kBoxFeature; }
bool IsNone(FeatureId owner) { return owner == kNoFeature; }

double Area(const IndexedMesh& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const auto& p = mesh.vertices[a];
  const auto& q = mesh.vertices[b];
  const auto& r = mesh.vertices[c];
  return (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
}

// Flips one inner edge without owner and with a convex quadrangle to the other diagonal; everything
// else stays valid.
void FlipAnEdge(IndexedMesh& mesh) {
  bool done = false;
  ForEachEdge(CollectSides(mesh), [&](const Side* side, std::size_t count) {
    if (done || count != 2) return;
    const auto row = std::find_if(mesh.edges.begin(), mesh.edges.end(),
                                  [&](const auto& e) { return e.a == side->a && e.b == side->b; });
    if (row->owner != kNoFeature) return;
    auto& s = mesh.triangles[side[0].triangle];
    auto& t = mesh.triangles[side[1].triangle];
    const std::uint32_t p = s[side[0].k];  // the edge in s runs from p to q
    const std::uint32_t q = s[(side[0].k + 1U) % 3];
    const std::uint32_t r = s[(side[0].k + 2U) % 3];
    const std::uint32_t o = t[(side[1].k + 2U) % 3];  // o and r are the apexes on both sides
    if (Area(mesh, o, q, r) < 0.01 || Area(mesh, p, o, r) < 0.01) return;
    s = {o, q, r};
    t = {p, o, r};
    row->a = std::min(o, r);
    row->b = std::max(o, r);
    done = true;
  });
  ASSERT_TRUE(done);
}

struct Damage {
  const char* name;
  std::function<void(GoodMesh&)> apply;
  std::set<std::string> checks;  // those that must fail, and no other (`hash` apart)
};

std::vector<Damage> Damages() {
  return {
      {"vertex moved far",
       [](GoodMesh& g) {
         auto& v = g.files.mesh.vertices[FindVertex(g.files.mesh, 2, false)];
         v.x = 5.9, v.y = 0.05;
       },
       {"orientation", "delaunay"}},
      {"vertex not finite",
       [](GoodMesh& g) {
         g.files.mesh.vertices[FindVertex(g.files.mesh, 2, false)].x = std::nan("");
       },
       {"vertices"}},
      {"triangle dropped",
       [](GoodMesh& g) { g.files.mesh.triangles.erase(g.files.mesh.triangles.begin() + 7); },
       {"manifold", "box", "edges"}},
      {"triangle doubled",
       [](GoodMesh& g) { g.files.mesh.triangles.push_back(g.files.mesh.triangles[7]); },
       {"manifold"}},
      {"triangle turned over",
       [](GoodMesh& g) { std::swap(g.files.mesh.triangles[7][0], g.files.mesh.triangles[7][1]); },
       {"orientation", "manifold"}},
      {"edge flipped", [](GoodMesh& g) { FlipAnEdge(g.files.mesh); }, {"delaunay"}},
      {"vertex in no triangle",
       [](GoodMesh& g) {
         g.files.mesh.vertices.push_back({3.21, 3.21, 2, kNoFeature});
       },
       {"vertices", "manifold"}},
      {"two vertices in one place",
       [](GoodMesh& g) {
         auto& m = g.files.mesh;
         m.vertices.push_back(m.vertices[FindVertex(m, 2, false)]);
       },
       {"vertices", "manifold"}},
      {"border bent inwards",
       [](GoodMesh& g) {
         auto& m = g.files.mesh;
         auto& v = m.vertices[FindVertex(m, 1, true)];  // in the middle of a side
         if (v.x == 0)
           v.x = 1e-9;
         else if (v.x == 6)
           v.x = 6 - 1e-9;
         else if (v.y == 0)
           v.y = 1e-9;
         else
           v.y = 6 - 1e-9;
       },
       {"box"}},
      {"edge listed twice",
       [](GoodMesh& g) { g.files.mesh.edges.push_back(g.files.mesh.edges[3]); },
       {"edges"}},
      {"edge not listed",
       [](GoodMesh& g) {
         auto& edges = g.files.mesh.edges;
         edges.erase(std::find_if(edges.begin(), edges.end(),
                                  [](const auto& e) { return IsNone(e.owner); }));
       },
       {"edges"}},
      {"edge listed that is none",
       [](GoodMesh& g) {
         const auto last = static_cast<std::uint32_t>(g.files.mesh.vertices.size() - 1);
         g.files.mesh.edges.push_back({FindVertex(g.files.mesh, 0, true), last, kNoFeature});
       },
       {"edges"}},
      {"no edge file",
       [](GoodMesh& g) {
         g.files.has_edges = false;
         g.files.mesh.edges.clear();
       },
       {"edges", "input"}},
      {"box edge without its marker",
       [](GoodMesh& g) { FindEdge(g.files.mesh, IsBox).owner = kNoFeature; },
       {"edges"}},
      {"inner edge with the box's marker",
       [](GoodMesh& g) { FindEdge(g.files.mesh, IsNone).owner = kBoxFeature; },
       {"edges"}},
      {"box vertex without its marker",
       [](GoodMesh& g) {
         g.files.mesh.vertices[FindVertex(g.files.mesh, 0, true)] = {
             g.files.mesh.vertices[FindVertex(g.files.mesh, 0, true)].x,
             g.files.mesh.vertices[FindVertex(g.files.mesh, 0, true)].y, 2, kNoFeature};
       },
       {"edges"}},
      {"inner vertex with the box's marker",
       [](GoodMesh& g) {
         g.files.mesh.vertices[FindVertex(g.files.mesh, 2, false)].owner = kBoxFeature;
       },
       {"edges"}},
      {"segment broken",
       [](GoodMesh& g) { FindEdge(g.files.mesh, IsSegment).owner = kNoFeature; },
       {"input"}},
      {"subsegment of a segment marked as another's",
       [](GoodMesh& g) {
         auto& e = FindEdge(g.files.mesh, IsSegment);
         e.owner = e.owner == g.features.back().id ? e.owner - 1 : g.features.back().id;
       },
       {"input"}},
      {"edge marked with no segment's id",
       [](GoodMesh& g) { FindEdge(g.files.mesh, IsNone).owner = 777; },
       {"input"}},
      {"edge beside a segment marked too",
       [](GoodMesh& g) { FindEdge(g.files.mesh, IsNone).owner = g.features.back().id; },
       {"input"}},
      {"input point without its marker",
       [](GoodMesh& g) { g.files.mesh.vertices[0].containing_dimension = 2; },
       {"input"}},
      {"input point with another's marker",
       [](GoodMesh& g) { g.files.mesh.vertices[0].owner = 2; },
       {"input"}},
      {"free vertex marked as input",
       [](GoodMesh& g) {
         auto& v = g.files.mesh.vertices[FindVertex(g.files.mesh, 2, false)];
         v.containing_dimension = 0, v.owner = 777;
       },
       {"input"}},
      {"input point missing",
       [](GoodMesh& g) { g.features.push_back(Feature::Point(888, 3.3, 3.3)); },
       {"input"}},
      {"input point elsewhere by one bit",
       [](GoodMesh& g) {
         double& x = g.features[4].position[0];
         x = std::nextafter(x, 10);
       },
       {"input"}},
      {"input segment missing",
       [](GoodMesh& g) { g.features.push_back(Feature::Segment(999, 4, 5)); },
       {"input"}},
  };
}

TEST(Verify, FindsEveryKindOfDamageByTheRightCheck) {
  for (const Damage& damage : Damages()) {
    GoodMesh mesh = MakeGoodMesh(11, 60);
    const bool features_only = [&] {
      const MeshHash before = io::ToMesh(mesh.files.mesh).hash;
      damage.apply(mesh);
      return io::ToMesh(mesh.files.mesh).hash == before;
    }();
    const VerifyReport report = VerifyMesh(mesh.files, kAnyQuality, &mesh.features);
    std::set<std::string> failed = FailedChecks(report);
    failed.erase("hash");
    // Flat and clockwise triangles are over any rho.
    if (damage.checks.contains("orientation")) failed.erase("quality");
    EXPECT_EQ(failed, damage.checks) << damage.name << "\n" << Describe(report);
    // The hash detects any change of the mesh.
    if (report.checks.size() > 1) {
      const bool hash_failed = FailedChecks(report).contains("hash");
      EXPECT_EQ(hash_failed, !features_only) << damage.name;
    }
  }
}

TEST(Verify, FindsAChainThatIsNotStraight) {
  GoodMesh mesh = MakeGoodMesh(11, 60);
  IndexedMesh& m = mesh.files.mesh;
  // Takes the segment's first subsegment the long way round, over the third corner.
  const IndexedMesh::Edge subsegment = FindEdge(m, IsSegment);
  const auto t = std::find_if(m.triangles.begin(), m.triangles.end(), [&](const auto& c) {
    const auto has = [&](std::uint32_t v) { return std::find(c.begin(), c.end(), v) != c.end(); };
    return has(subsegment.a) && has(subsegment.b);
  });
  for (IndexedMesh::Edge& e : m.edges) {
    const auto in = [&](std::uint32_t v) { return std::find(t->begin(), t->end(), v) != t->end(); };
    if (!in(e.a) || !in(e.b)) continue;
    e.owner = e == subsegment ? kNoFeature : subsegment.owner;
  }
  const VerifyReport report = VerifyMesh(mesh.files, kAnyQuality, &mesh.features);
  EXPECT_TRUE(FailedChecks(report).contains("input"));
  EXPECT_NE(Describe(report).find("not straight"), std::string::npos) << Describe(report);
}

TEST(Verify, FindsAVertexThatTwoFansShare) {
  // Two triangles that meet in one vertex only.
  io::MeshFiles files;
  files.mesh.vertices = {{0, 0, 2, 0}, {1, 0, 2, 0}, {1, 1, 2, 0}, {-1, 0, 2, 0}, {-1, -1, 2, 0}};
  files.mesh.triangles = {{0, 1, 2}, {0, 3, 4}};
  const VerifyReport report = VerifyMesh(files, kAnyQuality, nullptr);
  EXPECT_NE(Describe(report).find("vertex 1 has triangles that do not form one fan"),
            std::string::npos)
      << Describe(report);
}

TEST(Verify, OfAnEmptyFileFails) {
  const VerifyReport report = VerifyMesh(io::MeshFiles(), kAnyQuality, nullptr);
  EXPECT_FALSE(report.Passed());
}

TEST(Slack, IsThatOfThePowerOfTwoBelowForAllLengths) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Slack(0, 1), 0);
  EXPECT_EQ(Slack(2, 0.5), 2e-9 + 8 * 0.5 / 2);
  EXPECT_EQ(Slack(2.5, 0.5), 2e-9 + 8 * 0.5 / 2);
  EXPECT_EQ(Slack(3, 0.5), 2e-9 + 8 * 0.5 / (2 * std::numbers::sqrt2));
  EXPECT_EQ(Slack(std::nextafter(4, 0), 0.5), Slack(3, 0.5));
  EXPECT_EQ(Slack(std::numeric_limits<double>::denorm_min(), 0), 2e-9);
  EXPECT_EQ(Slack(std::numeric_limits<double>::max(), 0), 2e-9);
  EXPECT_EQ(Slack(kInfinity, kInfinity), 0);
}

// Any change of one index is detected by topology or geometry, even without a recorded hash.
TEST(Verify, FindsEveryChangedCorner) {
  const std::uint64_t seed = test::NewSeed();
  std::mt19937_64 random(seed);
  const GoodMesh good = MakeGoodMesh(seed, 40);
  for (int round = 0; round < 300; ++round) {
    io::MeshFiles files = good.files;
    files.recorded_hash.reset();
    auto& corner = files.mesh.triangles[random() % files.mesh.triangles.size()][random() % 3];
    const auto other = static_cast<std::uint32_t>(random() % files.mesh.vertices.size());
    if (other == corner) continue;
    corner = other;
    EXPECT_FALSE(VerifyMesh(files, kAnyQuality, &good.features).Passed());
  }
}

}  // namespace
}  // namespace dynmesh::cli::verify_test
