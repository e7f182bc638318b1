// Slots over histories of real edits: they are stable, patches list the removed and added ones,
// neighbours equal those of a new mesh.
#include <map>
#include <set>

#include "core/mesh_data/diff_meshes.h"
#include "tests/core/geometry/random_points.h"
#include "tests/core/transfer/field_lab.h"

namespace dynmesh {
namespace {

using testing::Index;
using testing::IsLive;

using Key = std::vector<VertexId>;

Key KeyOf(const SlotMesh& mesh, std::size_t cell) {
  Key key;
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  for (std::size_t k = 0; k < width; ++k) {
    key.push_back(mesh.ids()[Index(mesh.cells()[cell * width + k])]);
  }
  return key;
}

std::map<VertexId, Slot> VerticesOf(const SlotMesh& mesh) {
  std::map<VertexId, Slot> slots;
  for (std::size_t v = 0; v < mesh.ids().size(); ++v) {
    if (mesh.ids()[v] != 0) slots[mesh.ids()[v]] = static_cast<Slot>(v);
  }
  return slots;
}

std::map<Key, Slot> SimplicesOf(const SlotMesh& mesh) {
  std::map<Key, Slot> slots;
  for (std::size_t c = 0; c < mesh.regions().size(); ++c) {
    if (IsLive(mesh, c)) slots[KeyOf(mesh, c)] = static_cast<Slot>(c);
  }
  return slots;
}

// Of each simplex, by ids, those across its faces.
std::map<Key, std::vector<Key>> NeighboursOf(const SlotMesh& mesh) {
  std::map<Key, std::vector<Key>> all;
  const auto width = static_cast<std::size_t>(mesh.dimension() + 1);
  for (const auto& [key, slot] : SimplicesOf(mesh)) {
    for (std::size_t k = 0; k < width; ++k) {
      const Slot other = mesh.neighbours()[Index(slot) * width + k];
      all[key].push_back(other == kNoSlot ? Key() : KeyOf(mesh, Index(other)));
    }
  }
  return all;
}

// Expects that common vertices and simplices keep their slots, and that the patch has the rest.
template <class T>
void ExpectPatch(const std::map<T, Slot>& before, const std::map<T, Slot>& after,
                 const std::vector<Slot>& removed, const std::vector<Slot>& added) {
  std::vector<Slot> gone, come;
  std::set<Slot> once_used;
  for (const auto& [key, slot] : before) {
    once_used.insert(slot);
    const auto it = after.find(key);
    if (it == after.end()) {
      gone.push_back(slot);
    } else {
      EXPECT_EQ(it->second, slot);
    }
  }
  for (const auto& [key, slot] : after) {
    if (before.contains(key)) continue;
    come.push_back(slot);
    EXPECT_FALSE(once_used.contains(slot)) << "a slot of the old mesh is filled at once";
  }
  EXPECT_EQ(removed, gone);  // both in the order of ids
  EXPECT_EQ(added, come);
}

class SlotsOf : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Dimension, SlotsOf, ::testing::Values(2, 3),
                         [](const auto& of) { return std::to_string(of.param) + "D"; });

TEST_P(SlotsOf, StayAndPatchesSayTheRest) {
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0.05, 0.95);
  MeshOptions options = testing::UnitBox(dimension);
  options.quality = DefaultQuality(dimension);
  auto mesh = std::move(DynamicMesh::Create(options)).value();
  SlotMesh slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  std::set<FeatureId> live;
  FeatureId next = 1;
  std::size_t most_vertices = 0;
  for (int step = 0; step < (dimension == 2 ? 200 : 60); ++step) {
    const auto vertices = VerticesOf(slots);
    const auto simplices = SimplicesOf(slots);
    const std::uint64_t from = slots.revision();
    const int diffs = 1 + static_cast<int>(random() % 3);
    for (int d = 0; d < diffs; ++d) {
      EditBatch batch;
      for (int k = 0; k < 3; ++k) {
        if (live.size() > 20 && random() % 2 == 0) {
          batch.push_back(Edit::Remove(*live.begin()));
          live.erase(live.begin());
        } else {
          batch.push_back(
              Edit::Add(Feature::Point(next, draw(random), draw(random), draw(random))));
          live.insert(next++);
        }
      }
      const auto diff = mesh->Apply(batch);
      ASSERT_TRUE(diff.ok()) << diff.status();
      ASSERT_TRUE((d == 0 ? slots.Apply(*diff) : slots.Extend(*diff)).ok());
    }
    const MeshPatch& patch = slots.patch();
    EXPECT_EQ(patch.from_revision, from);
    EXPECT_EQ(patch.to_revision, mesh->revision());
    ExpectPatch(vertices, VerticesOf(slots), patch.removed_vertices, patch.added_vertices);
    ExpectPatch(simplices, SimplicesOf(slots), patch.removed_simplices, patch.added_simplices);
    const SlotMesh fresh = SlotMesh::FromMesh(mesh->Snapshot()).value();
    ASSERT_EQ(NeighboursOf(slots), NeighboursOf(fresh));
    ASSERT_EQ(slots.hash(), mesh->hash());
    most_vertices = std::max(most_vertices, vertices.size());
    const CompactNumbering compact = slots.Compact();
    ASSERT_EQ(compact.vertex_slots.size(), slots.vertex_count());
    ASSERT_EQ(compact.simplex_slots.size(), slots.simplex_count());
    for (std::size_t v = 0; v < compact.vertex_slots.size(); ++v) {
      ASSERT_EQ(compact.vertex_numbers[Index(compact.vertex_slots[v])], static_cast<int>(v));
    }
    for (std::size_t c = 0; c < compact.simplex_slots.size(); ++c) {
      ASSERT_EQ(compact.simplex_numbers[Index(compact.simplex_slots[c])], static_cast<int>(c));
    }
  }
  // Freed slots are filled again.
  EXPECT_LE(slots.ids().size(), 2 * most_vertices);
}

// Elements removed and added again within one patch keep their slot, whatever happened in between.
TEST_P(SlotsOf, ComeBackWithinAPatch) {
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0.05, 0.95);
  auto mesh = std::move(DynamicMesh::Create(testing::UnitBox(dimension))).value();
  EditBatch batch;
  for (FeatureId id = 1; id <= 40; ++id) {
    batch.push_back(Edit::Add(Feature::Point(id, draw(random), draw(random), draw(random))));
  }
  ASSERT_TRUE(mesh->Apply(batch).ok());
  SlotMesh slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  const auto vertices = VerticesOf(slots);
  const auto simplices = SimplicesOf(slots);
  for (FeatureId id = 1; id <= 20; ++id) {
    const auto gone = mesh->Apply({Edit::Remove(id)});
    ASSERT_TRUE(gone.ok());
    ASSERT_TRUE((id == 1 ? slots.Apply(*gone) : slots.Extend(*gone)).ok());
  }
  for (FeatureId id = 20; id >= 1; --id) {
    const auto come = mesh->Apply({batch[id - 1]});
    ASSERT_TRUE(come.ok());
    ASSERT_TRUE(slots.Extend(*come).ok());
  }
  EXPECT_EQ(VerticesOf(slots), vertices);
  EXPECT_EQ(SimplicesOf(slots), simplices);
  EXPECT_TRUE(slots.patch().empty());
}

// A snapshot of a mesh with features of all kinds is the mesh, and what was shared of a column
// stays as it was when the column moves.
TEST_P(SlotsOf, ShareColumnsThatOutliveTheirGrowth) {
  const int dimension = GetParam();
  std::mt19937_64 random(geometry::testing::NewSeed());
  std::uniform_real_distribution<double> draw(0.05, 0.95);
  auto mesh = std::move(DynamicMesh::Create(testing::UnitBox(dimension))).value();
  SlotMesh slots = SlotMesh::FromMesh(mesh->Snapshot()).value();
  const auto shared = slots.points().share();
  const std::vector<double> before(shared.get(), shared.get() + slots.points().size());
  EditBatch batch;
  for (FeatureId id = 1; id <= 200; ++id) {
    batch.push_back(Edit::Add(Feature::Point(id, draw(random), draw(random), draw(random))));
  }
  const auto diff = mesh->Apply(batch);
  ASSERT_TRUE(diff.ok() && slots.Apply(*diff).ok());
  EXPECT_NE(slots.points().data(), shared.get());
  EXPECT_TRUE(std::equal(before.begin(), before.end(), shared.get()));
  const SlotMesh copy = slots;
  EXPECT_EQ(copy.hash(), slots.hash());
  for (const auto& [key, slot] : SimplicesOf(slots)) EXPECT_EQ(copy.FindSimplexSlot(key), slot);
}

}  // namespace
}  // namespace dynmesh
