// Ids and coordinates chosen by a client for their hashes. After every edit, in any order, the mesh
// equals one from scratch and a replica has it; or the edit is refused, and then also from scratch,
// with the same message.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "dynmesh/error.h"
#include "tests/differential/differential.h"
#include "tests/support/crafted.h"
#include "tests/support/polygon_script.h"

namespace dynmesh::test::crafted_ids_test {
namespace {

// What a mesh of these makes of them.
template <int D>
absl::Status StatusFromScratch(const std::vector<Feature>& features, const MeshOptions& options,
                               const LiveMeshTuning& tuning) {
  LiveMesh<D> fresh(options, tuning);
  return fresh.Apply(AddAll(features), ApplyOptions{}).status();
}

// A mesh with some groups of features, each added or removed as a whole.
template <int D>
class Toggled {
 public:
  Toggled(std::vector<std::vector<Feature>> groups, const LiveMeshTuning& tuning)
      : groups_(std::move(groups)),
        tuning_(tuning),
        mesh_(DefaultsIn<D>(), tuning),
        replica_(mesh_) {}

  bool IsPresent(std::size_t group) const { return present_.contains(group); }
  const std::set<std::size_t>& present() const { return present_; }

  // Toggles these at once. Empty if that is as from scratch; `*refused` says whether it was
  // refused.
  std::string Toggle(const std::set<std::size_t>& groups, bool* refused) {
    EditBatch batch;
    std::set<std::size_t> after = present_;
    for (const std::size_t g : groups) {
      if (after.erase(g) == 0) continue;
      for (const Feature& f : groups_[g]) batch.push_back(Edit::Remove(f.id));
    }
    for (const std::size_t g : groups) {
      if (present_.contains(g)) continue;
      after.insert(g);
      for (const Feature& f : groups_[g]) batch.push_back(Edit::Add(f));
    }
    const MeshHash before = mesh_.hash();
    const auto diff = mesh_.Apply(batch, ApplyOptions{});
    *refused = !diff.ok();
    if (diff.ok()) {
      present_ = after;
      if (const Difference d = replica_.Follow(*diff, mesh_); d.found) return "replica: " + d.what;
    } else {
      if (!(mesh_.hash() == before)) return "a refused batch changed the mesh";
      const auto detail = GetErrorDetail(diff.status());
      if (!detail || detail->reason != reason::kIdCollision) return diff.status().ToString();
      std::vector<Feature> all;
      for (const std::size_t g : after) all.insert(all.end(), groups_[g].begin(), groups_[g].end());
      const absl::Status same[] = {StatusFromScratch<D>(all, mesh_.options(), tuning_),
                                   BuildMesh(all, mesh_.options()).status()};
      for (const absl::Status& status : same) {
        if (!(status == diff.status())) {
          return diff.status().ToString() + " but from scratch " + status.ToString();
        }
      }
    }
    const Difference d = CompareWithScratch(mesh_, groups.size() % 2 == 0);
    return d.found ? d.what : "";
  }

 private:
  const std::vector<std::vector<Feature>> groups_;
  const LiveMeshTuning tuning_;
  LiveMesh<D> mesh_;
  Replica replica_;
  std::set<std::size_t> present_;
};

// Toggles one to three groups at a time, at first all but the last. A batch is to be refused if and
// only if one of `clashes` would be there as a whole.
template <int D>
void RunToggles(const std::vector<std::vector<Feature>>& groups,
                const std::vector<std::set<std::size_t>>& clashes, std::uint64_t seed, int steps) {
  for (const bool propagate : {true, false}) {
    SCOPED_TRACE("seed " + std::to_string(seed) + (propagate ? ", propagated" : ", as it comes"));
    Random random(seed);
    LiveMeshTuning tuning = AlwaysPropagate();
    if (!propagate) tuning.rebuild.at_least = 6;
    Toggled<D> mesh(groups, tuning);
    int refusals = 0;
    for (int step = 0; step < steps; ++step) {
      std::set<std::size_t> chosen;
      for (std::size_t g = 0; step == 0 && g + 1 < groups.size(); ++g) chosen.insert(g);
      if (step == 1) chosen = {groups.size() - 1};
      for (int k = random.Below(3); step > 1 && k >= 0; --k) {
        chosen.insert(static_cast<std::size_t>(random.Below(static_cast<int>(groups.size()))));
      }
      std::set<std::size_t> after;
      std::ranges::set_symmetric_difference(mesh.present(), chosen,
                                            std::inserter(after, after.end()));
      const bool clash = std::ranges::any_of(
          clashes, [&](const auto& c) { return std::ranges::includes(after, c); });
      bool refused = false;
      ASSERT_EQ(mesh.Toggle(chosen, &refused), "") << "step " << step;
      ASSERT_EQ(refused, clash) << "step " << step;
      refusals += refused;
    }
    EXPECT_GT(refusals, clashes.empty() ? -1 : 0);
  }
}

// A square about (x, y), its corners from `first` on; and a polygon that it bounds.
std::vector<Feature> SquareCorners(FeatureId first, double x, double y, double half) {
  return {Feature::Point(first, x - half, y - half), Feature::Point(first + 1, x + half, y - half),
          Feature::Point(first + 2, x + half, y + half),
          Feature::Point(first + 3, x - half, y + half)};
}
Feature SquareOf(FeatureId id, FeatureId first) {
  return Feature::Polygon(id, {{first, first + 1, first + 2, first + 3}});
}
std::vector<Feature> Square(FeatureId id, FeatureId first, double x, double y, double half) {
  auto features = SquareCorners(first, x, y, half);
  features.push_back(SquareOf(id, first));
  return features;
}

// {1, 2} and another pair of polygons have the same id.
const std::vector<FeatureId>& Other() {
  static const std::vector<FeatureId> other =
      AnyPairOfRegionId(RegionIdOf(std::vector<FeatureId>{1, 2}), 3);
  return other;
}

TEST(CraftedIds, AreMade) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t word = random();
    ASSERT_EQ(Mix(Unmix(word)), word);
  }
  EXPECT_EQ(RegionIdOf(Other()), RegionIdOf(std::vector<FeatureId>{1, 2}));
  for (const RegionId id : {~RegionId{0}, ~RegionId{0} - 1}) {
    EXPECT_EQ(RegionIdOf(AnyPairOfRegionId(id, 1)), id);
  }
}

TEST(CraftedIds, TwoSetsOfPolygonsWithOneIdAreRefusedWhereverTheyAre) {
  const auto& other = Other();
  RunToggles<2>({Square(1, 101, 0.25, 0.25, 0.1), Square(2, 201, 0.25, 0.25, 0.05),
                 Square(other[0], 301, 0.7, 0.7, 0.11), Square(other[1], 401, 0.72, 0.7, 0.05)},
                {{0, 1, 2, 3}}, 5, 60);
}

// In one batch or after a while the id of a triangle's region stays and its polygons do not.
TEST(CraftedIds, ASetMayFollowAnotherWithItsId) {
  const auto& other = Other();
  std::vector<std::vector<Feature>> groups = {SquareCorners(101, 0.5, 0.5, 0.2)};
  for (const FeatureId id : {FeatureId{1}, FeatureId{2}, other[0], other[1]}) {
    groups.push_back({SquareOf(id, 101)});
  }
  LiveMeshTuning rebuild;
  rebuild.rebuild.at_least = 0;
  rebuild.rebuild.features = -1;
  for (const LiveMeshTuning& tuning : {AlwaysPropagate(), rebuild}) {
    Toggled<2> mesh(groups, tuning);
    bool refused = false;
    ASSERT_EQ(mesh.Toggle({0, 1, 2}, &refused), "");
    for (int step = 0; step < 3; ++step) {
      ASSERT_EQ(mesh.Toggle({1, 2, 3, 4}, &refused), "");  // at once
      ASSERT_FALSE(refused);
    }
    for (const std::size_t group : {3, 4, 1, 2, 1, 2, 3, 4}) {  // one after the other
      ASSERT_EQ(mesh.Toggle({group}, &refused), "");
      ASSERT_FALSE(refused);
    }
  }
}

// Walls have owners, too, and three sets may agree. Ids used for something else count as taken.
TEST(CraftedIds, SetsAtAnEdgeAndReservedIdsAreRefused) {
  const RegionId id = RegionIdOf(std::vector<FeatureId>{1, 2});
  const auto& other = Other();
  const auto third = AnyPairOfRegionId(id, other[0] + 1);
  const auto reserved = AnyPairOfRegionId(~RegionId{0}, 1000);
  const auto too_many = AnyPairOfRegionId(~RegionId{0} - 1, 2000);
  // Two polygons beside each other that share an edge, so that {1, 2} is only at that edge.
  std::vector<Feature> beside = SquareCorners(101, 0.2, 0.2, 0.1);
  beside.push_back(Feature::Point(105, 0.5, 0.1));
  beside.push_back(Feature::Point(106, 0.5, 0.3));
  beside.push_back(SquareOf(1, 101));
  beside.push_back(Feature::Polygon(2, {{102, 105, 106, 103}}));
  const auto pair = [](const std::vector<FeatureId>& ids, FeatureId first, double x, double y) {
    std::vector<Feature> features = Square(ids[0], first, x, y, 0.08);
    features.push_back(SquareOf(ids[1], first));
    return features;
  };
  RunToggles<2>({beside, pair(other, 201, 0.7, 0.2), pair(third, 301, 0.2, 0.7),
                 pair(reserved, 401, 0.7, 0.7), pair(too_many, 501, 0.5, 0.5)},
                {{0, 1}, {0, 2}, {1, 2}, {3}, {4}}, 6, 40);
}

// Boxes in boxes: a closed surface goes by the least id of its polygons.
TEST(CraftedIds, TwoSetsOfSurfacesWithOneIdAreRefused) {
  const auto& other = Other();
  const auto box = [](FeatureId least, FeatureId first, double x, double size) {
    const Solid solid = MakeCuboid(0.5, 0.5, 0.5);
    std::vector<Feature> features;
    for (std::size_t i = 0; i < solid.corners.size(); ++i) {
      const auto& c = solid.corners[i];
      features.push_back(
          Feature::Point(first + i, x + size * c[0], 0.5 + size * c[1], 0.5 + size * c[2]));
    }
    for (std::size_t f = 0; f < solid.faces.size(); ++f) {
      Rings rings = solid.faces[f][0];
      for (FeatureId& corner : rings[0]) corner += first;
      // The others' ids are greater and do not matter.
      features.push_back(Feature::Polygon(f == 0 ? least : kLastPolygonId - first - f, rings));
    }
    return features;
  };
  RunToggles<3>({box(1, 101, 0.25, 0.3), box(2, 201, 0.25, 0.1), box(other[0], 301, 0.75, 0.3),
                 box(other[1], 401, 0.75, 0.12)},
                {{0, 1, 2, 3}}, 7, 12);
}

TEST(CraftedIds, AVertexWithAnothersSaltedIdIsRefused) {
  std::mt19937_64 random(3);
  const auto at = [&](std::uint64_t salt, VertexId id) {
    return PlaceOfHash<2>(
        KeyOfVertexIds(salt), [&] { return id; }, random);
  };
  std::array<double, 2> p = at(0, 123456789), q = at(0, 123456789);
  if (q < p) std::swap(p, q);  // so that q is salted
  const VertexId salted = VertexIdAt(q.data(), 2, 1);
  const std::array<double, 2> r = at(0, salted), s = at(0, salted);
  ASSERT_EQ(VertexIdAt(p.data(), 2), VertexIdAt(q.data(), 2));
  ASSERT_EQ(VertexIdAt(r.data(), 2), salted);
  const auto point = [](FeatureId id, const std::array<double, 2>& c) {
    return std::vector<Feature>{Feature::Point(id, c[0], c[1])};
  };
  RunToggles<2>({point(1, p), point(2, q), point(3, r), point(4, s)}, {{0, 1, 2}, {0, 1, 3}}, 8,
                60);
}

TEST(CraftedIds, TwoSaltedVerticesWithOneIdAreRefusedInSpace) {
  std::mt19937_64 random(4);
  const auto at = [&](std::uint64_t salt, VertexId id) {
    return PlaceOfHash<3>(
        KeyOfVertexIds(salt), [&] { return id; }, random);
  };
  // q and t each come second in their group, and are one with salt 1.
  const std::array<double, 3> q = at(1, 42), t = at(1, 42);
  const auto before = [&](const std::array<double, 3>& c) {
    std::array<double, 3> p;
    do {
      p = at(0, VertexIdAt(c.data(), 3));
    } while (!(p < c));
    return p;
  };
  const std::array<double, 3> p = before(q), s = before(t);
  const auto point = [](FeatureId id, const std::array<double, 3>& c) {
    return std::vector<Feature>{Feature::Point(id, c[0], c[1], c[2])};
  };
  RunToggles<3>({point(1, p), point(2, q), point(3, s), point(4, t)}, {{0, 1, 2, 3}}, 9, 25);
}

}  // namespace
}  // namespace dynmesh::test::crafted_ids_test
