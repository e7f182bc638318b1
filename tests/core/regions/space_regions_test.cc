// The closed surfaces around each tetrahedron, against counting crossings in exact numbers; the
// same from scratch and in the diffs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/error.h"
#include "dynmesh/slot_mesh.h"
#include "tests/core/regions/space_regions_oracle.h"
#include "tests/support/workload.h"

namespace dynmesh::space_regions_test {
namespace {

using testing::operator+;
using testing::Box;
using testing::Difference;
using testing::FacesOf;
using testing::FindWrongRegion;
using testing::Place;
using testing::RegionsOf;
using testing::Solid;
using testing::Space;

TEST(SpaceRegions, AreThoseOfBoxesInBoxesAndBesideThem) {
  std::size_t counted = 0;
  for (const double turn : {0.0, 0.3, 0.7}) {
    SCOPED_TRACE("turn " + std::to_string(turn));
    const Solid a = Box(1, 1000, {0.6, 0.6, 0.6}, 0.2, turn, 2);
    const Solid b = Box(101, 900, {0.6, 0.6, 0.6}, 0.1, 1.4 * turn);
    const Solid c = Box(201, 1200, {0.61, 0.6, 0.59}, 0.04, -turn);
    const Solid d = Box(301, 1300, {0.15, 0.15, 0.15}, 0.05, turn);
    // A plate between two of them encloses nothing.
    Solid plate = Box(401, 1400, {0.6, 0.45, 0.6}, 0.02, turn);
    plate.corners.resize(4), plate.faces.resize(1);
    const std::vector<Feature> features = a.All() + b.All() + c.All() + d.All() + plate.All();
    const auto mesh = BuildMesh(features, Space());
    ASSERT_TRUE(mesh.ok()) << mesh.status();
    EXPECT_EQ(FindWrongRegion(
                  *mesh, features,
                  {{1000, FacesOf(a)}, {900, FacesOf(b)}, {1200, FacesOf(c)}, {1300, FacesOf(d)}},
                  &counted),
              "");
    const FeatureId two[] = {900, 1000}, three[] = {900, 1000, 1200};
    EXPECT_EQ(RegionsOf(*mesh),
              (std::set<RegionId>{0, 1000, 1300, RegionIdOf(two), RegionIdOf(three)}));
    EXPECT_EQ(mesh->region_sets.size(), 2u);
    // The plate refines the mesh, but makes no regions.
    const auto dynamic = *DynamicMesh::Create(Space());
    ASSERT_TRUE(dynamic->Apply(AddAll(plate.All() + c.All())).ok());
    ASSERT_TRUE(dynamic->Apply(AddAll(d.All() + a.All() + b.All())).ok());
    EXPECT_EQ(Difference(dynamic->Snapshot(), *mesh), "");
    EXPECT_TRUE(dynamic->Audit().problems.empty());
  }
  EXPECT_GT(counted, 5000u);
}

// Adding or removing a face changes only the mesh, until the last one.
TEST(SpaceRegions, ComeWithTheLastFaceAndGoWithTheFirst) {
  const Solid box = Box(1, 1000, {0.5, 0.5, 0.5}, 0.2, 0.4);
  const auto mesh = *DynamicMesh::Create(Space());
  ASSERT_TRUE(mesh->Apply(AddAll(box.Points())).ok());
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_EQ(RegionsOf(mesh->Snapshot()), std::set<RegionId>{0}) << i << " faces";
    ASSERT_TRUE(mesh->Apply({Edit::Add(box.Face(5 - i))}).ok());
  }
  const Mesh whole = mesh->Snapshot();
  EXPECT_EQ(RegionsOf(whole), (std::set<RegionId>{0, 1000}));
  EXPECT_EQ(FindWrongRegion(whole, mesh->Features(), {{1000, FacesOf(box)}}), "");
  // Another polygon of lesser id replaces a face: the surface gets its id.
  Feature other = box.Face(3);
  other.id = 70;
  const auto renamed = mesh->Apply({Edit::Remove(1003), Edit::Add(other)});
  ASSERT_TRUE(renamed.ok()) << renamed.status();
  EXPECT_EQ(RegionsOf(mesh->Snapshot()), (std::set<RegionId>{0, 70}));
  EXPECT_TRUE(renamed->added_simplices == renamed->removed_simplices);
  ASSERT_TRUE(mesh->Apply({Edit::Remove(70), Edit::Add(box.Face(3))}).ok());
  EXPECT_EQ(Difference(mesh->Snapshot(), whole), "");
  const auto removed = mesh->Apply({Edit::Remove(1002)});
  ASSERT_TRUE(removed.ok());
  EXPECT_EQ(RegionsOf(mesh->Snapshot()), std::set<RegionId>{0});
}

// The points nearest to the changed walls are inside: their change must be computed.
TEST(SpaceRegions, OfABoxFullOfPointsFollowItsFaces) {
  constexpr std::uint64_t kSeed = 8;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  const Solid box = Box(1, 1000, {0.5, 0.5, 0.5}, 0.2, 0.4);
  const auto mesh = *DynamicMesh::Create(Space());
  EditBatch batch = AddAll(box.All());
  for (FeatureId id = 100; id < 400; ++id) {
    Place p;
    for (double& c : p) c = 0.39 + 0.22 * random.Unit();
    batch.push_back(Edit::Add(Feature::Point(id, p[0], p[1], p[2])));
  }
  ASSERT_TRUE(mesh->Apply(batch).ok());
  const Mesh whole = mesh->Snapshot();
  for (std::size_t i = 0; i < 6; ++i) {
    ASSERT_TRUE(mesh->Apply({Edit::Remove(1000 + i)}).ok());
    EXPECT_EQ(RegionsOf(mesh->Snapshot()), std::set<RegionId>{0});
    ASSERT_TRUE(mesh->Apply({Edit::Add(box.Face(i))}).ok());
    EXPECT_EQ(Difference(mesh->Snapshot(), whole), "");
  }
}

// One surface each, whatever they share.
TEST(SpaceRegions, OfBoxesThatShareAWallOrAnEdge) {
  const Solid two = Box(1, 1000, {0.5, 0.5, 0.5}, 0.2, 0.4, 2);
  std::vector<Feature> features = two.All();
  features.push_back(Feature::Polygon(2000, {{5, 6, 7, 8}}));  // the wall
  const auto walled = BuildMesh(features, Space());
  ASSERT_TRUE(walled.ok()) << walled.status();
  EXPECT_EQ(RegionsOf(*walled), (std::set<RegionId>{0, 1000, 1001}));
  EXPECT_EQ(FindWrongRegion(*walled, features,
                            {{1000, {1000, 1002, 1003, 1004, 1005, 2000}},
                             {1001, {1001, 1006, 1007, 1008, 1009, 2000}}}),
            "");
  // Two cubes with edge 4 8 in common.
  features.clear();
  const auto add = [&](FeatureId id, double x, double y) {
    features.push_back(Feature::Point(id, 0.4 + 0.2 * x, 0.4 + 0.2 * y, 0.4));
    features.push_back(Feature::Point(id + 10, 0.4 + 0.2 * x, 0.4 + 0.2 * y, 0.6));
  };
  add(1, 0, 0), add(2, 1, 0), add(3, 1, 1), add(4, 0, 1);
  add(5, 2, 1), add(6, 2, 2), add(7, 1, 2);
  std::map<FeatureId, std::set<FeatureId>> faces;
  const auto cube = [&](FeatureId id, const std::array<FeatureId, 4>& v) {
    features.push_back(Feature::Polygon(id, {{v[0], v[1], v[2], v[3]}}));
    features.push_back(Feature::Polygon(id + 1, {{v[0] + 10, v[1] + 10, v[2] + 10, v[3] + 10}}));
    for (std::size_t k = 0; k < 4; ++k) {
      const FeatureId p = v[k], q = v[(k + 1) % 4];
      features.push_back(Feature::Polygon(id + 2 + k, {{p, q, q + 10, p + 10}}));
    }
    for (FeatureId k = 0; k < 6; ++k) faces[id].insert(id + k);
  };
  cube(100, {1, 2, 3, 4});
  cube(200, {3, 5, 6, 7});
  const auto mesh = BuildMesh(features, Space());
  ASSERT_TRUE(mesh.ok()) << mesh.status();
  EXPECT_EQ(FindWrongRegion(*mesh, features, faces), "");
  EXPECT_EQ(RegionsOf(*mesh), (std::set<RegionId>{0, 100, 200}));
}

// Two boxes beside each other under one lid of two rings: no closed surface, as the lid is
// disconnected. With a lid for each there are two.
TEST(SpaceRegions, OfBoxesUnderOneLid) {
  const Solid left = Box(1, 1000, {0.25, 0.5, 0.5}, 0.1, 0),
              right = Box(21, 2000, {0.75, 0.5, 0.5}, 0.1, 0);
  const auto up = [](const Solid& box) {  // the face at the top
    for (std::size_t i = 0; i < box.faces.size(); ++i) {
      if (std::ranges::all_of(box.faces[i], [&](int c) { return box.corners[c][2] > 0.5; }))
        return i;
    }
    return box.faces.size();
  };
  const Feature lid_left = left.Face(up(left)), lid_right = right.Face(up(right));
  std::vector<Feature> features = left.All() + right.All();
  std::erase_if(features,
                [&](const Feature& f) { return f.id == lid_left.id || f.id == lid_right.id; });
  const Feature lid = Feature::Polygon(500, {lid_left.rings[0], lid_right.rings[0]});
  const auto mesh = *DynamicMesh::Create(Space());
  const auto made = mesh->Apply(AddAll(features + std::vector<Feature>{lid}));
  ASSERT_TRUE(made.ok()) << made.status();
  for (int i = 0; i < 2; ++i) {
    const auto under_one = BuildMesh(features + std::vector<Feature>{lid}, Space());
    ASSERT_TRUE(under_one.ok()) << under_one.status();
    EXPECT_EQ(RegionsOf(*under_one), (std::set<RegionId>{0}));
    EXPECT_EQ(mesh->hash(), under_one->hash);
    ASSERT_TRUE(mesh->Apply({Edit::Remove(500), Edit::Add(lid_left), Edit::Add(lid_right)}).ok());
    const auto each = BuildMesh(features + std::vector<Feature>{lid_left, lid_right}, Space());
    EXPECT_EQ(RegionsOf(*each), (std::set<RegionId>{0, 1000, 2000}));
    EXPECT_EQ(mesh->hash(), each->hash);
    ASSERT_TRUE(
        mesh->Apply({Edit::Remove(lid_left.id), Edit::Remove(lid_right.id), Edit::Add(lid)}).ok());
  }
}

// A box among others that moves affects neither simplices beyond its neighbours nor the vertices at
// the border of the domain, which have large balls.
TEST(SpaceRegions, AMoveCostsWhatIsNearIt) {
  std::vector<std::uint64_t> executed;
  for (const int n : {3, 5}) {
    std::vector<Feature> features;
    const double spacing = 0.6 / n;
    FeatureId id = 1;
    for (int i = 0; i < n * n * n; ++i) {
      const Place at = {0.2 + spacing * (0.5 + i % n), 0.2 + spacing * (0.5 + i / n % n),
                        0.2 + spacing * (0.5 + i / (n * n))};
      features = features + Box(id, 100'000 + id, at, spacing / 4, 0).All();
      id += 10;
    }
    const FeatureId moved = 10 * (n * n * n / 2) + 1;
    const auto corner = *std::ranges::find(features, moved, &Feature::id);
    const auto mesh = *DynamicMesh::Create(Space());
    ASSERT_TRUE(mesh->Apply(AddAll(features)).ok());
    const auto diff = mesh->Apply({Edit::Set(Feature::Point(
        moved, corner.position[0] - 0.01 * spacing, corner.position[1], corner.position[2]))});
    ASSERT_FALSE(diff.ok()) << "three faces would be bent";
    EditBatch batch;
    for (FeatureId p = moved; p < moved + 8; ++p) {
      const auto& f = *std::ranges::find(features, p, &Feature::id);
      batch.push_back(Edit::Set(
          Feature::Point(p, f.position[0] + 0.05 * spacing, f.position[1], f.position[2])));
    }
    const auto shifted = mesh->Apply(batch);
    ASSERT_TRUE(shifted.ok()) << shifted.status();
    executed.push_back(shifted->work.executed);
  }
  // The border of the domain alone has some 800.
  for (const std::uint64_t operations : executed) EXPECT_LT(operations, 250u);
}

// Walls are added and removed, one of them between the rooms, and both rooms move.
TEST(SpaceRegions, OfTwoRoomsFollowTheirWalls) {
  std::size_t both = 0, one = 0;
  for (const FeatureId between : {FeatureId{2000}, FeatureId{70}}) {
    SCOPED_TRACE("wall " + std::to_string(between));
    test::Random random(between);
    Solid rooms = Box(1, 1000, {0.5, 0.5, 0.5}, 0.2, 0.4, 2);
    const std::set<FeatureId> of_a = {1000, 1002, 1003, 1004, 1005, between};
    const std::set<FeatureId> of_b = {1001, 1006, 1007, 1008, 1009, between};
    std::map<FeatureId, Feature> walls;
    for (std::size_t i = 0; i < rooms.faces.size(); ++i) walls[1000 + i] = rooms.Face(i);
    walls[between] = Feature::Polygon(between, {{5, 6, 7, 8}});
    const auto mesh = *DynamicMesh::Create(Space());
    ASSERT_TRUE(mesh->Apply(AddAll(rooms.Points())).ok());
    auto replica = *SlotMesh::FromMesh(mesh->Snapshot());
    std::set<FeatureId> present;
    for (int revision = 0; revision < 40; ++revision) {
      SCOPED_TRACE("revision " + std::to_string(revision));
      EditBatch batch;
      const int what = random.Below(4);
      for (const auto& [id, wall] : walls) {
        const bool there = present.contains(id);
        if (what == 0 && !there) batch.push_back(Edit::Add(wall));  // all
        if (what == 1 && random.OneIn(10)) {
          batch.push_back(there ? Edit::Remove(id) : Edit::Add(wall));
        }
        if (what == 2 && id == between) {
          batch.push_back(there ? Edit::Remove(id) : Edit::Add(wall));
        }
      }
      for (const Edit& edit : batch) {
        const FeatureId id = edit.feature.id;
        if (!present.erase(id)) present.insert(id);
      }
      if (what == 3) {
        for (Place& p : rooms.corners) {
          for (double& c : p) c = 1 - c;  // through its middle: A is where B was
        }
        for (const Feature& f : rooms.Points()) {
          batch.push_back(Edit::Move(f.id, f.position[0], f.position[1], f.position[2]));
        }
      }
      const auto diff = mesh->Apply(batch);
      ASSERT_TRUE(diff.ok()) << diff.status();
      const auto is_closed = [&](const std::set<FeatureId>& faces) {
        return std::includes(present.begin(), present.end(), faces.begin(), faces.end());
      };
      std::set<FeatureId> around = of_a;
      around.insert(of_b.begin(), of_b.end());
      around.erase(between);
      std::map<FeatureId, std::set<FeatureId>> surfaces;
      if (is_closed(of_a) && is_closed(of_b)) {
        surfaces[1000] = of_a;
        surfaces[std::min(FeatureId{1001}, between)] = of_b;
        ++both;
      } else if (is_closed(of_a) || is_closed(of_b) || is_closed(around)) {
        const auto& faces = is_closed(of_a) ? of_a : is_closed(of_b) ? of_b : around;
        surfaces[*faces.begin()] = faces;
        ++one;
      }
      const Mesh whole = mesh->Snapshot();
      ASSERT_EQ(RegionsOf(whole).size(), 1 + surfaces.size());
      ASSERT_EQ(FindWrongRegion(whole, mesh->Features(), surfaces), "");
      if (!batch.empty()) {
        ASSERT_EQ(replica.Apply(*diff), absl::OkStatus());
      }
      ASSERT_EQ(Difference(replica.ToMesh(), whole), "");
      ASSERT_EQ(Difference(*BuildMesh(mesh->Features(), Space()), whole), "");
      ASSERT_EQ(mesh->Audit().problems, std::vector<std::string>{});
    }
  }
  EXPECT_GT(both, 10u);
  EXPECT_GT(one, 5u);
}

// Unchanged simplices keep their label, and are not reported.
TEST(SpaceRegions, AnEditThatTouchesNoPolygonReportsOnlyWhatIsNew) {
  const Solid box = Box(1, 1000, {0.6, 0.6, 0.6}, 0.2, 0.4);
  const auto mesh = *DynamicMesh::Create(Space());
  ASSERT_TRUE(mesh->Apply(AddAll(box.All())).ok());
  for (const double x : {0.1, 0.35, 0.6}) {
    const auto diff = mesh->Apply({Edit::Add(Feature::Point(3000, x, 0.61, 0.59))});
    ASSERT_TRUE(diff.ok()) << diff.status();
    std::set<std::array<VertexId, 4>> gone;
    for (std::size_t t = 0; t < diff->removed_simplex_count(); ++t) {
      const VertexId* v = &diff->removed_simplices[4 * t];
      gone.insert({v[0], v[1], v[2], v[3]});
    }
    for (std::size_t t = 0; t < diff->added_simplex_count(); ++t) {
      const VertexId* v = &diff->added_simplices[4 * t];
      ASSERT_FALSE(gone.contains({v[0], v[1], v[2], v[3]}));
    }
    ASSERT_EQ(FindWrongRegion(mesh->Snapshot(), mesh->Features(), {{1000, FacesOf(box)}}), "");
    ASSERT_TRUE(mesh->Apply({Edit::Remove(3000)}).ok());
  }
}

// A box jumps over a part of the mesh, and out of another box: all labels follow.
TEST(SpaceRegions, FollowRandomScripts) {
  std::size_t counted = 0, revisions = 0, labelled = 0;
  const std::uint64_t seeds = std::getenv("DYNMESH_NIGHTLY") != nullptr ? 60 : 4;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    test::Random random(seed);
    const double turn = seed % 3 == 0 ? 0 : 0.2 * static_cast<double>(seed);
    std::vector<Solid> solids = {
        Box(1, 1000, {0.55, 0.55, 0.55}, 0.22, turn, seed % 2 == 0 ? 2 : 1),
        Box(101, 900, {0.55, 0.55, 0.55}, 0.1, 0.5 + turn),
        Box(201, 1200, {0.55, 0.55, 0.55}, 0.04, -turn),
        Box(301, 1300, {0.15, 0.15, 0.15}, 0.03, 0.9 - turn),
    };
    const auto mesh = *DynamicMesh::Create(Space());
    EditBatch all;
    for (const Solid& solid : solids) {
      for (const Feature& f : solid.All()) all.push_back(Edit::Add(f));
    }
    ASSERT_TRUE(mesh->Apply(all).ok());
    auto replica = *SlotMesh::FromMesh(mesh->Snapshot());
    std::set<FeatureId> present;  // faces
    for (const Solid& solid : solids) present.merge(FacesOf(solid));
    FeatureId next = 5000;
    for (int revision = 0; revision < 25; ++revision) {
      SCOPED_TRACE("revision " + std::to_string(revision));
      EditBatch batch;
      std::set<FeatureId> after = present;
      std::vector<Solid> moved = solids;
      const auto which = static_cast<std::size_t>(random.Below(4));
      Solid& solid = moved[which];
      const auto toggle = [&](std::size_t face) {
        if (after.erase(solid.polygon + face) > 0) {
          batch.push_back(Edit::Remove(solid.polygon + face));
        } else {
          after.insert(solid.polygon + face);
          batch.push_back(Edit::Add(solid.Face(face)));
        }
      };
      switch (random.Below(4)) {
        case 0:
          toggle(static_cast<std::size_t>(random.Below(static_cast<int>(solid.faces.size()))));
          break;
        case 1:  // closes it, or takes all away
          for (std::size_t i = 0; i < solid.faces.size(); ++i) {
            const bool closed = std::includes(present.begin(), present.end(),
                                              FacesOf(solid).begin(), FacesOf(solid).end());
            if (closed || !present.contains(solid.polygon + i)) toggle(i);
          }
          break;
        case 2: {  // jumps
          if (which < 2) break;
          Place by;
          for (std::size_t k = 0; k < 3; ++k) {
            const double to = random.OneIn(2) ? 0.55 : 0.1 + 0.8 * random.Unit();
            by[k] = to - (solid.corners[0][k] + solid.corners[6][k]) / 2;
          }
          for (Place& p : solid.corners) {
            for (std::size_t k = 0; k < 3; ++k) p[k] += by[k];
          }
          for (const Feature& f : solid.Points()) {
            batch.push_back(Edit::Move(f.id, f.position[0], f.position[1], f.position[2]));
          }
          break;
        }
        default: {
          const double x = random.Unit(), y = random.Unit();
          batch.push_back(Edit::Add(Feature::Point(next++, x, y, random.Unit())));
        }
      }
      const auto diff = mesh->Apply(batch);
      if (!diff.ok()) continue;
      if (!batch.empty()) ++revisions;
      solids = moved;
      present = after;
      std::map<FeatureId, std::set<FeatureId>> surfaces;
      for (const Solid& s : solids) {
        const std::set<FeatureId> faces = FacesOf(s);
        if (std::includes(present.begin(), present.end(), faces.begin(), faces.end())) {
          surfaces[s.polygon] = faces;
        }
      }
      const Mesh whole = mesh->Snapshot();
      labelled += RegionsOf(whole).size() - 1;
      ASSERT_EQ(FindWrongRegion(whole, mesh->Features(), surfaces, &counted), "");
      if (!batch.empty()) {
        ASSERT_EQ(replica.Apply(*diff), absl::OkStatus());
      }
      ASSERT_EQ(Difference(replica.ToMesh(), whole), "");
      ASSERT_EQ(Difference(*BuildMesh(mesh->Features(), Space()), whole), "");
      ASSERT_EQ(mesh->Audit().problems, std::vector<std::string>{});
    }
  }
  std::printf("%zu revisions, %zu tetrahedra\n", revisions, counted);
  EXPECT_GT(revisions, 50u);
  EXPECT_GT(labelled, 80u);
}

}  // namespace
}  // namespace dynmesh::space_regions_test
