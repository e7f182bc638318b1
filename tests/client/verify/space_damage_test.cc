// `verify` must find every kind of damage of a 3D mesh, by the right check.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "client/verify/verify.h"
#include "client/verify/verify_internal.h"
#include "gtest/gtest.h"
#include "tests/client/verify/good_files.h"
#include "tests/client/verify/report_text.h"
#include "tests/core/io/meshes/good_space_mesh.h"

namespace dynmesh::cli::space_damage_test {
namespace {

using io::IndexedMesh;
using testing::kPlate;
using testing::kPole;
using testing::kRim;

std::uint32_t FindVertex(const IndexedMesh& mesh, int dimension, FeatureId owner) {
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const auto& vertex = mesh.vertices[v];
    if (vertex.containing_dimension == dimension && vertex.owner == owner) return v;
  }
  ADD_FAILURE() << "no such vertex";
  return 0;
}

template <class Rows>
auto& FindOwned(Rows& rows, FeatureId owner) {
  return *std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.owner == owner; });
}

// A face of two tetrahedra and of no polygon.
std::array<std::uint32_t, 3> InnerFace(const IndexedMesh& mesh) {
  std::array<std::uint32_t, 3> found = {0, 0, 0};
  ForEachTriangle(CollectFaces(mesh), [&](const Face* face, std::size_t count) {
    const bool listed = std::any_of(mesh.faces.begin(), mesh.faces.end(),
                                    [&](const auto& f) { return f.corners == face->v; });
    if (count == 2 && !listed) found = face->v;
  });
  return found;
}

// Flips two tetrahedra that share a face and form a convex body into three around the edge between
// their apexes: everything else stays valid.
void FlipAFace(IndexedMesh& mesh) {
  bool done = false;
  ForEachTriangle(CollectFaces(mesh), [&](const Face* face, std::size_t count) {
    if (done || count != 2) return;
    const Face& inner = face[0].even ? face[0] : face[1];
    const Face& outer = face[0].even ? face[1] : face[0];
    const auto& [a, b, c] = inner.v;
    const std::uint32_t p = mesh.tetrahedra[inner.tetrahedron][inner.k];
    const std::uint32_t q = mesh.tetrahedra[outer.tetrahedron][outer.k];
    const std::array<IndexedMesh::Tetrahedron, 3> made = {
        {{a, b, p, q}, {b, c, p, q}, {c, a, p, q}}};
    IndexedMesh three;
    three.dimension = 3;
    three.vertices = mesh.vertices;
    for (auto t : made) {
      std::swap(t[2], t[3]);
      three.tetrahedra.push_back(t);
    }
    for (int turn = 0; turn < 2; ++turn) {
      double least = 180;
      for (std::size_t i = 0; i < 3; ++i) {
        const TetrahedronQuality quality = io::MeasureTetrahedron(three, i);
        least = std::isinf(quality.radius_edge) ? 0 : std::min(least, quality.min_angle_deg);
        if (least == 0) break;
      }
      if (least > 1) {
        mesh.tetrahedra[inner.tetrahedron] = three.tetrahedra[0];
        mesh.tetrahedra[outer.tetrahedron] = three.tetrahedra[1];
        mesh.tetrahedra.push_back(three.tetrahedra[2]);
        mesh.edges.push_back({std::min(p, q), std::max(p, q), kNoFeature});
        done = true;
        return;
      }
      for (auto& t : three.tetrahedra) std::swap(t[2], t[3]);
    }
  });
  ASSERT_TRUE(done);
}

struct Damage {
  const char* name;
  std::function<void(GoodFiles&)> apply;
  std::set<std::string> checks;  // those that must fail, and no other (`hash` apart)
};

std::vector<Damage> Damages() {
  return {
      {"vertex moved far",
       [](GoodFiles& g) {
         auto& v = g.files.mesh.vertices[FindVertex(g.files.mesh, 3, kNoFeature)];
         v.x = 7.9, v.y = 0.05, v.z = 7.8;
       },
       {"orientation", "delaunay"}},
      {"vertex not finite",
       [](GoodFiles& g) {
         g.files.mesh.vertices[FindVertex(g.files.mesh, 3, kNoFeature)].z = std::nan("");
       },
       {"vertices"}},
      {"tetrahedron dropped",
       [](GoodFiles& g) {
         const std::uint32_t inner = FindVertex(g.files.mesh, 3, kNoFeature);
         auto& rows = g.files.mesh.tetrahedra;
         rows.erase(std::find_if(rows.begin(), rows.end(), [&](const auto& t) {
           return std::find(t.begin(), t.end(), inner) != t.end();
         }));
       },
       {"box", "faces", "edges"}},
      {"tetrahedron doubled",
       [](GoodFiles& g) { g.files.mesh.tetrahedra.push_back(g.files.mesh.tetrahedra[7]); },
       {"manifold", "box"}},
      {"tetrahedron turned over",
       [](GoodFiles& g) {
         std::swap(g.files.mesh.tetrahedra[7][0], g.files.mesh.tetrahedra[7][1]);
       },
       {"orientation", "manifold", "box"}},
      {"face flipped", [](GoodFiles& g) { FlipAFace(g.files.mesh); }, {"delaunay"}},
      {"vertex in no tetrahedron",
       [](GoodFiles& g) {
         g.files.mesh.vertices.push_back({3.21, 3.21, 3, kNoFeature, 3.21});
       },
       {"vertices"}},
      {"two vertices in one place",
       [](GoodFiles& g) {
         auto& m = g.files.mesh;
         m.vertices.push_back(m.vertices[FindVertex(m, 3, kNoFeature)]);
       },
       {"vertices"}},
      {"border bent inwards",
       [](GoodFiles& g) {
         for (auto& v : g.files.mesh.vertices) {
           if (v.owner == kBoxFeature && v.x == 4 && v.y == 4 && v.z == 0) v.z = 1e-9;
         }
       },
       {"box", "delaunay"}},  // the box's own points are on common spheres
      {"edge listed twice",
       [](GoodFiles& g) { g.files.mesh.edges.push_back(g.files.mesh.edges[3]); },
       {"edges"}},
      {"edge not listed",
       [](GoodFiles& g) {
         auto& edges = g.files.mesh.edges;
         edges.erase(std::find_if(edges.begin(), edges.end(),
                                  [](const auto& e) { return e.owner == kNoFeature; }));
       },
       {"edges"}},
      {"inner edge with the box's marker",
       [](GoodFiles& g) {
         const std::uint32_t inner = FindVertex(g.files.mesh, 3, kNoFeature);
         for (auto& e : g.files.mesh.edges) {
           if (e.a != inner && e.b != inner) continue;
           e.owner = kBoxFeature;
           return;
         }
       },
       {"edges"}},
      {"box vertex without its marker",
       [](GoodFiles& g) {
         auto& v = g.files.mesh.vertices[FindVertex(g.files.mesh, 0, kBoxFeature)];
         v.containing_dimension = 3, v.owner = kNoFeature;
       },
       {"edges"}},
      {"inner vertex with the box's marker",
       [](GoodFiles& g) {
         g.files.mesh.vertices[FindVertex(g.files.mesh, 3, kNoFeature)].owner = kBoxFeature;
       },
       {"edges"}},
      {"no face file",
       [](GoodFiles& g) {
         g.files.has_faces = false;
         g.files.mesh.faces.clear();
       },
       {"faces", "facets"}},
      {"border face not listed",
       [](GoodFiles& g) {
         auto& faces = g.files.mesh.faces;
         faces.erase(std::find_if(faces.begin(), faces.end(),
                                  [](const auto& f) { return f.owner == kBoxFeature; }));
       },
       {"faces"}},
      {"face listed twice",
       [](GoodFiles& g) {
         g.files.mesh.faces.push_back(FindOwned(g.files.mesh.faces, kBoxFeature));
       },
       {"faces"}},
      {"face listed that is none",
       [](GoodFiles& g) {
         const auto last = static_cast<std::uint32_t>(g.files.mesh.vertices.size() - 1);
         g.files.mesh.faces.push_back({{0, 1, last}, kBoxFeature});
       },
       {"faces"}},
      {"inner face with the box's marker",
       [](GoodFiles& g) {
         g.files.mesh.faces.push_back({InnerFace(g.files.mesh), kBoxFeature});
       },
       {"faces"}},
      {"face without a marker",
       [](GoodFiles& g) {
         g.files.mesh.faces.push_back({InnerFace(g.files.mesh), kNoFeature});
       },
       {"faces"}},
      {"subfacet missing",
       [](GoodFiles& g) {
         auto& faces = g.files.mesh.faces;
         faces.erase(std::find_if(faces.begin(), faces.end(),
                                  [](const auto& f) { return f.owner == kPlate; }));
       },
       {"facets"}},
      {"subfacet of no polygon",
       [](GoodFiles& g) { FindOwned(g.files.mesh.faces, kPlate).owner = 777; },
       {"facets"}},
      {"subfacet beside the polygon",
       [](GoodFiles& g) {
         g.files.mesh.faces.push_back({InnerFace(g.files.mesh), kPlate});
       },
       {"facets"}},
      {"border face as a subfacet",
       [](GoodFiles& g) { FindOwned(g.files.mesh.faces, kBoxFeature).owner = kPlate; },
       {"facets"}},
      {"subsegment of a segment without its marker",
       [](GoodFiles& g) { FindOwned(g.files.mesh.edges, kPole).owner = kNoFeature; },
       {"input"}},
      {"edge of the polygon without its marker",
       [](GoodFiles& g) { FindOwned(g.files.mesh.edges, kPlate).owner = kNoFeature; },
       {"input", "facets"}},
      {"edge of the polygon marked as the polygon's, not the segment's",
       [](GoodFiles& g) { FindOwned(g.files.mesh.edges, kRim).owner = kPlate; },
       {"input", "facets"}},
      {"input point without its marker",
       [](GoodFiles& g) { g.files.mesh.vertices[0].containing_dimension = 3; },
       {"input"}},
      {"input point elsewhere by one bit",
       [](GoodFiles& g) {
         for (Feature& f : g.features) {
           if (f.id == 1) f.position[2] = std::nextafter(f.position[2], 10);
         }
       },
       {"input"}},
      {"input segment missing",
       [](GoodFiles& g) { g.features.push_back(Feature::Segment(9999, 1, 2)); },
       {"input"}},
      {"input polygon missing",
       [](GoodFiles& g) {
         g.features.push_back(Feature::Polygon(9999, {{1, 2, 4}}));
       },
       {"input", "facets"}},
      {"polygon that is not there any more",
       [](GoodFiles& g) {
         std::erase_if(g.features, [](const Feature& f) { return f.id == kPlate; });
       },
       {"input", "facets"}},
  };
}

TEST(VerifySpace, FindsEveryKindOfDamageByTheRightCheck) {
  for (const Damage& damage : Damages()) {
    GoodFiles good = MakeGoodFiles(11, 60);
    damage.apply(good);
    const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
    std::set<std::string> failed = FailedChecks(report);
    failed.erase("hash");
    // Flat and inverted tetrahedra are over any rho.
    if (damage.checks.contains("orientation")) failed.erase("quality");
    EXPECT_EQ(failed, damage.checks) << damage.name << "\n" << Describe(report);
  }
}

TEST(VerifySpace, FindsASheetThatIsNotFlat) {
  // The three other sides of a tetrahedron that stands on the plate: the border stays as it is.
  GoodFiles good = MakeGoodFiles(11, 60);
  IndexedMesh& mesh = good.files.mesh;
  auto& face = FindOwned(mesh.faces, kPlate);
  const auto corners = face.corners;
  const auto has = [&](const auto& t, std::uint32_t v) {
    return std::find(t.begin(), t.end(), v) != t.end();
  };
  for (const auto& t : mesh.tetrahedra) {
    if (!std::all_of(corners.begin(), corners.end(), [&](auto v) { return has(t, v); })) continue;
    const std::uint32_t apex = *std::find_if(t.begin(), t.end(), [&](std::uint32_t v) {
      return std::find(corners.begin(), corners.end(), v) == corners.end();
    });
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<std::uint32_t, 3> side = {corners[k], corners[(k + 1) % 3], apex};
      std::sort(side.begin(), side.end());
      if (k == 0) {
        face.corners = side;
      } else {
        mesh.faces.push_back({side, kPlate});
      }
    }
    break;
  }
  const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
  EXPECT_TRUE(FailedChecks(report).contains("facets"));
  EXPECT_NE(Describe(report).find("off its plane"), std::string::npos) << Describe(report);
}

// Where four vertices of a plane askew are nearly on a circle, a tetrahedron lies flat on the
// plate. Two of its sides are subfacets; with the other two the plate has a bubble.
TEST(VerifySpace, CountsOneSideOfWhatLiesFlatOnAPolygon) {
  const std::uint64_t seed = NewSeed();
  int flat = 0;
  for (std::uint64_t i = 0; i < 20; ++i) {
    GoodFiles good = MakeGoodFiles(seed + i, 20);
    IndexedMesh& mesh = good.files.mesh;
    std::set<std::array<std::uint32_t, 3>> sheet;
    std::set<std::uint32_t> on_plate;
    for (const auto& f : mesh.faces) {
      if (f.owner != kPlate) continue;
      sheet.insert(f.corners);
      on_plate.insert(f.corners.begin(), f.corners.end());
    }
    std::set<std::array<std::uint32_t, 3>> other;
    for (const Face& f : CollectFaces(mesh)) {
      const auto& t = mesh.tetrahedra[f.tetrahedron];
      const bool is_flat =
          std::all_of(t.begin(), t.end(), [&](std::uint32_t v) { return on_plate.contains(v); });
      if (is_flat && !sheet.contains(f.v)) other.insert(f.v);
    }
    if (other.empty()) continue;
    ++flat;
    EXPECT_TRUE(VerifyMesh(good.files, kAnyQuality, &good.features).Passed());
    for (const auto& v : other) mesh.faces.push_back({v, kPlate});
    good.files.recorded_hash.reset();
    const VerifyReport report = VerifyMesh(good.files, kAnyQuality, &good.features);
    EXPECT_EQ(FailedChecks(report), std::set<std::string>{"facets"}) << Describe(report);
  }
  EXPECT_GT(flat, 0);
}

// Modulo 2 its border is the polygon's: only the area differs.
TEST(VerifySpace, FindsASheetThatFoldsOverItself) {
  io::MeshFiles files;
  IndexedMesh& mesh = files.mesh;
  mesh.dimension = 3;
  // A triangle 1 2 3 covered by way of a vertex outside.
  mesh.vertices = {{0, 0, 0, 1, 0}, {4, 0, 0, 2, 0}, {0, 4, 0, 3, 0}, {5, 5, 2, 9, 0}};
  mesh.edges = {{0, 1, 9}, {1, 2, 9}, {0, 2, 9}};
  mesh.faces = {{{0, 1, 3}, 9}, {{1, 2, 3}, 9}, {{0, 2, 3}, 9}};
  const std::vector<Feature> features = {Feature::Point(1, 0, 0, 0), Feature::Point(2, 4, 0, 0),
                                         Feature::Point(3, 0, 4, 0),
                                         Feature::Polygon(9, {{1, 2, 3}})};
  VerifyReport report = VerifyMesh(files, kAnyQuality, &features);
  EXPECT_FALSE(FailedChecks(report).contains("input"));
  EXPECT_NE(Describe(report).find("times its area"), std::string::npos) << Describe(report);
  mesh.vertices[3].x = mesh.vertices[3].y = 1;
  report = VerifyMesh(files, kAnyQuality, &features);
  EXPECT_FALSE(FailedChecks(report).contains("facets")) << Describe(report);
}

TEST(VerifySpace, OfAnEmptyFileFails) {
  io::MeshFiles files;
  files.mesh.dimension = 3;
  EXPECT_FALSE(VerifyMesh(files, kAnyQuality, nullptr).Passed());
}

// Any change of one index is detected, even without a recorded hash.
TEST(VerifySpace, FindsEveryChangedCorner) {
  const std::uint64_t seed = NewSeed();
  std::mt19937_64 random(seed);
  const GoodFiles good = MakeGoodFiles(seed, 40);
  const std::size_t n = good.files.mesh.vertices.size();
  for (int round = 0; round < 200; ++round) {
    io::MeshFiles files = good.files;
    files.recorded_hash.reset();
    IndexedMesh& mesh = files.mesh;
    const auto other = static_cast<std::uint32_t>(random() % n);
    const bool of_a_face = round % 2 == 0;
    std::uint32_t& corner = of_a_face
                                ? mesh.faces[random() % mesh.faces.size()].corners[random() % 3]
                                : mesh.tetrahedra[random() % mesh.tetrahedra.size()][random() % 4];
    if (other == corner) continue;
    corner = other;
    for (auto& f : mesh.faces) std::sort(f.corners.begin(), f.corners.end());
    EXPECT_FALSE(VerifyMesh(files, kAnyQuality, &good.features).Passed());
  }
}

// Nor may a vertex be moved: coordinates of input, planes, lines or spheres detect it.
TEST(VerifySpace, FindsEveryMovedVertexThatMatters) {
  const std::uint64_t seed = NewSeed();
  const GoodFiles good = MakeGoodFiles(seed, 40);
  for (std::uint32_t v = 0; v < good.files.mesh.vertices.size(); ++v) {
    if (good.files.mesh.vertices[v].containing_dimension == 3) continue;
    io::MeshFiles files = good.files;
    files.recorded_hash.reset();
    IndexedMesh::Vertex& vertex = files.mesh.vertices[v];
    // By more than rounding, across the feature that it lies on.
    vertex.x += 1e-9, vertex.y += 2e-9, vertex.z -= 3e-9;
    EXPECT_FALSE(VerifyMesh(files, kAnyQuality, &good.features).Passed()) << v;
  }
}

}  // namespace
}  // namespace dynmesh::cli::space_damage_test
