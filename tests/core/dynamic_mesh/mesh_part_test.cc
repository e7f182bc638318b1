// A part that follows edits is the part of the mesh that there is: after each, it is compared with
// one made anew, and that with the rows of the mesh.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "core/mesh_data/region_filter.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/part.h"
#include "tests/core/dynamic_mesh/part_shadows.h"
#include "tests/support/seed.h"

namespace dynmesh::mesh_part_test {
namespace {

// The part's content by slots: what does not depend on its numbers.
struct Content {
  std::map<Slot, std::vector<double>> points;
  std::map<Slot, std::pair<std::vector<Slot>, RegionId>> cells;
  // Corners in order at the border, else ascending; owner; cells.
  std::set<std::tuple<std::vector<Slot>, FeatureId, Slot, Slot>> facets;
  friend bool operator==(const Content&, const Content&) = default;
};

Content ContentOf(const MeshPart& part) {
  Content content;
  const auto d = static_cast<std::size_t>(part.dimension());
  const std::size_t vertices = part.vertex_slots().size();
  EXPECT_EQ(part.points().size(), vertices * d);
  const auto slot_of = [&](std::int32_t number) {
    EXPECT_LT(static_cast<std::size_t>(number), vertices);
    return part.vertex_slots()[static_cast<std::size_t>(number)];
  };
  for (std::size_t i = 0; i < vertices; ++i) {
    const Slot slot = part.vertex_slots()[i];
    EXPECT_EQ(part.vertex_numbers()[static_cast<std::size_t>(slot)], static_cast<std::int32_t>(i));
    content.points[slot].assign(part.points().data() + i * d, part.points().data() + (i + 1) * d);
  }
  EXPECT_EQ(content.points.size(), vertices);
  const std::size_t cells = part.cell_slots().size();
  for (std::size_t i = 0; i < cells; ++i) {
    const Slot slot = part.cell_slots()[i];
    EXPECT_EQ(part.cell_numbers()[static_cast<std::size_t>(slot)], static_cast<std::int32_t>(i));
    auto& [corners, region] = content.cells[slot];
    for (std::size_t k = 0; k <= d; ++k) corners.push_back(slot_of(part.cells()[i * (d + 1) + k]));
    region = part.cell_regions()[i];
  }
  EXPECT_EQ(content.cells.size(), cells);
  const std::size_t facets = part.facet_owners().size();
  for (std::size_t i = 0; i < facets; ++i) {
    std::vector<Slot> corners;
    for (std::size_t k = 0; k < d; ++k) corners.push_back(slot_of(part.facets()[i * d + k]));
    Slot a = part.facet_cells()[2 * i], b = part.facet_cells()[2 * i + 1];
    if (b == kNoSlot) {
      std::ranges::rotate(corners, std::ranges::min_element(corners));
    } else {
      if (a > b) std::swap(a, b);
      std::ranges::sort(corners);
    }
    EXPECT_TRUE(content.facets.emplace(corners, part.facet_owners()[i], a, b).second);
  }
  const auto count = [](const SlotColumn<std::int32_t>& numbers) {
    return std::ranges::count_if(numbers.span(), [](std::int32_t n) { return n >= 0; });
  };
  EXPECT_EQ(static_cast<std::size_t>(count(part.vertex_numbers())), vertices);
  EXPECT_EQ(static_cast<std::size_t>(count(part.cell_numbers())), cells);
  return content;
}

// By the rows of the mesh, slowly.
Content Expected(const SlotMesh& mesh, const mesh_data::RegionChoice& choice) {
  Content content;
  const auto d = static_cast<std::size_t>(mesh.dimension());
  const std::vector<RegionSet> sets = mesh.region_sets();
  mesh_data::RegionFilter filter(choice, sets);
  std::map<std::vector<Slot>, FeatureId> owners;
  const auto take = [&](const SlotColumn<Slot>& rows, const SlotColumn<FeatureId>& of) {
    for (std::size_t i = 0; i < of.size(); ++i) {
      if (rows[i * d] == kNoSlot) continue;
      std::vector<Slot> key(rows.data() + i * d, rows.data() + (i + 1) * d);
      std::ranges::sort(key);
      owners[key] = of[i];
    }
  };
  d == 2 ? take(mesh.subsegments(), mesh.subsegment_owners())
         : take(mesh.subfacets(), mesh.subfacet_owners());
  std::map<std::vector<Slot>, std::vector<std::pair<Slot, std::vector<Slot>>>> faces;
  for (std::size_t i = 0; i * (d + 1) < mesh.cells().size(); ++i) {
    const Slot* const corners = mesh.cells().data() + i * (d + 1);
    if (corners[0] == kNoSlot || !filter.Has(mesh.regions()[i])) continue;
    const auto slot = static_cast<Slot>(i);
    content.cells[slot] = {{corners, corners + d + 1}, mesh.regions()[i]};
    for (std::size_t k = 0; k <= d; ++k) {
      const double* const p = mesh.points().data() + static_cast<std::size_t>(corners[k]) * d;
      content.points[corners[k]].assign(p, p + d);
      // Outwards: without corner k, with an odd permutation where k is odd (3D) or not at all (2D).
      std::vector<Slot> face;
      for (std::size_t j = 1; j <= d; ++j) face.push_back(corners[(k + j) % (d + 1)]);
      if (d == 3 && k % 2 == 1) std::swap(face[0], face[1]);
      std::vector<Slot> key = face;
      std::ranges::sort(key);
      faces[key].emplace_back(slot, face);
    }
  }
  for (const auto& [key, sides] : faces) {
    const auto owner = owners.find(key);
    if (sides.size() == 2) {
      if (owner == owners.end()) continue;
      content.facets.emplace(key, owner->second, std::min(sides[0].first, sides[1].first),
                             std::max(sides[0].first, sides[1].first));
    } else {
      std::vector<Slot> corners = sides[0].second;
      std::ranges::rotate(corners, std::ranges::min_element(corners));
      content.facets.emplace(corners, owner == owners.end() ? kNoFeature : owner->second,
                             sides[0].first, kNoSlot);
    }
  }
  return content;
}

// Squares, in 3D boxes, in the cells of a grid, some with a smaller one inside; points and segments
// at random. Ids: 1000 times the grid's cell and the level.
class Edits {
 public:
  Edits(int dimension, std::uint64_t seed) : dimension_(dimension), random_(seed) {}

  EditBatch Next() {
    EditBatch batch;
    for (int i = static_cast<int>(random_() % 3); i >= 0; --i) {
      switch (random_() % 4) {
        case 0:
        case 1:
          Toggle(batch, 1 + random_() % (dimension_ == 2 ? 9 : 8), random_() % 2);
          break;
        case 2:
          for (int k = 0; k < 5; ++k) AddPoint(batch);
          break;
        default:
          RemovePoint(batch);
      }
    }
    return batch;
  }

  std::mt19937_64& random() { return random_; }

 private:
  double Unit() { return std::uniform_real_distribution<double>(0, 1)(random_); }

  void Toggle(EditBatch& batch, FeatureId cell, FeatureId level) {
    const FeatureId first = cell * 1000 + level * 100;
    if (const auto it = shapes_.find(first); it != shapes_.end()) {
      for (auto id = it->second.rbegin(); id != it->second.rend(); ++id) {
        batch.push_back(Edit::Remove(*id));
      }
      shapes_.erase(it);
      return;
    }
    std::vector<FeatureId>& ids = shapes_[first];
    const auto add = [&](const Feature& f) {
      batch.push_back(Edit::Add(f));
      ids.push_back(f.id);
    };
    const int side = dimension_ == 2 ? 3 : 2;
    const double step = 1.0 / side, margin = (level == 0 ? 0.15 : 0.35) * step;
    std::array<double, 3> lo = {}, hi = {};
    FeatureId rest = cell - 1;
    for (std::size_t k = 0; k < 3; ++k) {
      lo[k] = step * static_cast<double>(rest % static_cast<FeatureId>(side)) + margin;
      hi[k] = lo[k] + step - 2 * margin;
      rest /= static_cast<FeatureId>(side);
    }
    if (dimension_ == 2) {
      add(Feature::Point(first + 1, lo[0], lo[1]));
      add(Feature::Point(first + 2, hi[0], lo[1]));
      add(Feature::Point(first + 3, hi[0], hi[1]));
      add(Feature::Point(first + 4, lo[0], hi[1]));
      add(Feature::Polygon(first, {{first + 1, first + 2, first + 3, first + 4}}));
      // A diagonal, as a wall of its own.
      if (level == 1) add(Feature::Segment(first + 5, first + 1, first + 3));
      return;
    }
    for (FeatureId i = 0; i < 8; ++i) {
      add(Feature::Point(first + 10 + i, i & 1 ? hi[0] : lo[0], i & 2 ? hi[1] : lo[1],
                         i & 4 ? hi[2] : lo[2]));
    }
    const FeatureId sides[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};
    for (FeatureId i = 0; i < 6; ++i) {
      std::vector<FeatureId> ring;
      for (const FeatureId corner : sides[i]) ring.push_back(first + 10 + corner);
      add(Feature::Polygon(first + i, {ring}));
    }
  }

  void AddPoint(EditBatch& batch) {
    const FeatureId id = ++last_point_;
    batch.push_back(Edit::Add(dimension_ == 2 ? Feature::Point(id, Unit(), Unit())
                                              : Feature::Point(id, Unit(), Unit(), Unit())));
    points_.push_back(id);
  }

  void RemovePoint(EditBatch& batch) {
    if (points_.empty()) return;
    const std::size_t at = random_() % points_.size();
    batch.push_back(Edit::Remove(points_[at]));
    points_.erase(points_.begin() + static_cast<std::ptrdiff_t>(at));
  }

  const int dimension_;
  std::mt19937_64 random_;
  std::map<FeatureId, std::vector<FeatureId>> shapes_;
  std::vector<FeatureId> points_;
  FeatureId last_point_ = 100'000;
};

MeshOptions OptionsOf(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = dimension == 2 ? 1.5 : 2.5;
  options.min_dihedral = 0;
  return options;
}

class MeshPartTest : public testing::TestWithParam<int> {};

TEST_P(MeshPartTest, AfterEachEditIsThatOfTheMesh) {
  const int dimension = GetParam();
  const std::uint64_t seed = test::NewSeed();
  std::cout << "seed " << seed << "\n";
  Edits edits(dimension, seed);
  const auto mesher = *DynamicMesh::Create(OptionsOf(dimension));
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  const PartChoice all = {.inside = true},
                   some = {.polygons = {1000, 2000, 3000, 5000}, .without = {2100}},
                   named = {.names = {"cavity"}};
  std::vector<MeshPart> parts = {{mesh, all}, {mesh, some}, {mesh, named}};
  std::vector<test::PartShadows> shadows(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) shadows[p].Follow(parts[p]);
  std::size_t most = 0;
  const int revisions = dimension == 2 ? 150 : 50;
  for (int i = 0; i < revisions; ++i) {
    std::vector<MeshDiff> diffs;
    for (int k = static_cast<int>(edits.random()() % 2); k >= 0; --k) {
      EditBatch batch = edits.Next();
      if (i % 7 == 3) {
        // Of a name that comes and goes.
        const bool is_on = i % 2 == 0;
        batch.push_back(Edit::SetLabel(1000, {is_on ? 1 : 0, is_on ? "cavity" : ""}));
      }
      auto diff = mesher->Apply(batch);
      if (!diff.ok()) continue;  // no polygon to be named, or two points in one place
      ASSERT_TRUE((diffs.empty() ? mesh.Apply(*diff) : mesh.Extend(*diff)).ok());
      diffs.push_back(*std::move(diff));
    }
    if (diffs.empty()) continue;
    std::vector<const MeshDiff*> pointers;
    for (const MeshDiff& diff : diffs) pointers.push_back(&diff);
    std::vector<mesh_data::RegionChoice> choices(3);
    choices[0].in_any = true;
    choices[1] = {{1000, 2000, 3000, 5000}, false, {2100}};
    for (const LabelOfFeature& of : mesh.labels()) {
      if (of.label.name == "cavity") choices[2].in.push_back(of.id);
    }
    for (std::size_t p = 0; p < parts.size(); ++p) {
      const absl::Status status = parts[p].Update(mesh, pointers);
      ASSERT_TRUE(status.ok()) << status;
      EXPECT_EQ(parts[p].revision(), mesh.revision());
      shadows[p].Follow(parts[p]);
      const Content content = ContentOf(parts[p]);
      const bool is_nothing = p == 2 && choices[2].in.empty();
      ASSERT_TRUE(content == (is_nothing ? Content() : Expected(mesh, choices[p])))
          << "part " << p << " at step " << i;
      most = std::max(most, content.cells.size());
    }
    ASSERT_TRUE(ContentOf(MeshPart(mesh, some)) == Expected(mesh, choices[1]));
    for (const MeshPart& part : parts) {
      const Mesh own = *part.ToMesh(mesh);
      EXPECT_EQ(own.simplex_count(), part.cell_slots().size());
      EXPECT_EQ(own.vertices.size(), part.vertex_slots().size());
      EXPECT_EQ(own.hash, ComputeHash(own));
    }
    EXPECT_FALSE(parts[0].changes().is_all);
  }
  EXPECT_GT(most, 20U);
}

INSTANTIATE_TEST_SUITE_P(Dimensions, MeshPartTest, testing::Values(2, 3));

TEST(MeshPart, AnUpdateThatDoesNotFollowIsRefusedAndChangesNothing) {
  Edits edits(2, 5);
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  MeshPart part(mesh, {.inside = true});
  const MeshDiff first = *mesher->Apply(edits.Next()), second = *mesher->Apply(edits.Next());
  const MeshDiff* const only_first[] = {&first};
  const MeshDiff* const only_second[] = {&second};
  ASSERT_TRUE(mesh.Apply(first).ok());
  EXPECT_EQ(part.Update(mesh, only_second).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_EQ(part.revision(), 0U);
  EXPECT_EQ(part.ToMesh(mesh).status().code(), absl::StatusCode::kFailedPrecondition);
  MeshPart behind = part;
  EXPECT_TRUE(part.Update(mesh, only_first).ok());
  ASSERT_TRUE(mesh.Apply(second).ok());
  EXPECT_EQ(behind.Update(mesh, only_second).code(), absl::StatusCode::kFailedPrecondition);
  EXPECT_TRUE(part.Update(mesh, only_second).ok());
}

// The rows that did not change are not written: what a solver keeps beside them stays right.
TEST(MeshPart, AnEditElsewhereWritesNothing) {
  const auto mesher = *DynamicMesh::Create(OptionsOf(2));
  EditBatch batch = AddAll(std::vector<Feature>{
      Feature::Point(1, 0.1, 0.1), Feature::Point(2, 0.3, 0.1), Feature::Point(3, 0.3, 0.3),
      Feature::Point(4, 0.1, 0.3), Feature::Polygon(5, {{1, 2, 3, 4}}),
      Feature::SizeDisc(6, 0.2, 0.2, 0.2, 0.02)});
  SlotMesh mesh = *SlotMesh::FromMesh(mesher->Snapshot());
  const MeshDiff first = *mesher->Apply(batch);
  ASSERT_TRUE(mesh.Apply(first).ok());
  MeshPart part(mesh, {.inside = true});
  EXPECT_TRUE(part.changes().is_all);
  EXPECT_GT(part.cell_slots().size(), 100U);
  const MeshDiff second = *mesher->Apply(AddAll(std::vector<Feature>{Feature::Point(7, 0.9, 0.9)}));
  ASSERT_TRUE(mesh.Apply(second).ok());
  const MeshDiff* const diffs[] = {&second};
  ASSERT_TRUE(part.Update(mesh, diffs).ok());
  const MeshPart::Changes& changes = part.changes();
  EXPECT_FALSE(changes.is_all);
  EXPECT_TRUE(changes.vertices.empty() && changes.cells.empty() && changes.facets.empty());
  EXPECT_TRUE(changes.vertex_slots.empty() && changes.cell_slots.empty());
}

}  // namespace
}  // namespace dynmesh::mesh_part_test
