// Subfacets that follow a triangulation, against examining all its faces after every change.
#include "core/dynamic_mesh/subfacet_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::subfacet_table_test {
namespace {

using Face = SubfacetTable::Face;
using Slot = SubfacetTable::Slot;
using Tetrahedron = SubfacetTable::Tetrahedron;
using Vertex = SubfacetTable::Vertex;
using geometry::Point3;
using meshing::kNil;

// A plane of squares across a cube, each square part of a facet or of none. Points are added and
// removed, in the middle of squares and off the plane, none so near that a square is not made of
// faces.
class Plane {
 public:
  static constexpr int kSide = 6;  // squares

  Plane() {
    mesh_.Reset({{-3, -3, -3}}, {{9, 9, 9}}, {0, 1, 2, 3, 4, 5, 6, 7});
    for (int i = 0; i <= kSide; ++i) {
      for (int j = 0; j <= kSide; ++j) {
        mesh_.Insert(Grid(i, j), {{i * 1.0, j * 1.0, 3.0}}, 0);
      }
    }
    for (int i = 0; i < kSide; ++i) {
      for (int j = 0; j < kSide; ++j) spots_.push_back({{i + 0.5, j + 0.5, 3.0}});
    }
    test::Random random(4);
    for (int i = 0; i < 60; ++i) {
      const double x = 9 * random.Unit() - 2, y = 9 * random.Unit() - 2;
      spots_.push_back(
          {{x, y, random.OneIn(2) ? 4.1 + 4 * random.Unit() : 1.9 - 4 * random.Unit()}});
    }
  }

  delaunay::DelaunayTetrahedralization& mesh() { return mesh_; }
  static Vertex Grid(int i, int j) { return static_cast<Vertex>(8 + i * (kSide + 1) + j); }

  void ToggleSpot(test::Random& random) {
    const auto i = static_cast<Vertex>(random.Below(static_cast<int>(spots_.size())));
    const Vertex v = 100 + i;
    if (mesh_.Contains(v)) {
      mesh_.Remove(v);
    } else {
      mesh_.Insert(v, spots_[i], 0);
    }
  }

  // A square of squares, some with a hole.
  void SetFacet(Slot slot, int i0, int j0, int side, bool hole) {
    for (int i = i0; i < i0 + side; ++i) {
      for (int j = j0; j < j0 + side; ++j) {
        if (hole && i == i0 + 1 && j == j0 + 1) continue;
        squares_[{i, j}] = slot;
      }
    }
  }
  void DropFacet(Slot slot) {
    std::erase_if(squares_, [&](const auto& square) { return square.second == slot; });
  }
  // Of a square of squares and its hole.
  static std::vector<Vertex> CornersOf(int i0, int j0, int side) {
    return {Grid(i0, j0), Grid(i0 + side, j0), Grid(i0 + side, j0 + side), Grid(i0, j0 + side)};
  }

  // Seen from above.
  Slot FacetOf(Vertex a, Vertex b, Vertex c, Vertex d) const {
    if (!(mesh_.position(d)[2] > 3)) return kNil;
    double x = 0, y = 0;
    for (const Vertex v : {a, b, c}) {
      const Point3& p = mesh_.position(v);
      if (p[2] != 3) return kNil;
      x += p[0] / 3, y += p[1] / 3;
    }
    const auto it =
        squares_.find({static_cast<int>(std::floor(x)), static_cast<int>(std::floor(y))});
    return it == squares_.end() ? kNil : it->second;
  }
  std::set<Tetrahedron> Tetrahedra() const {
    std::set<Tetrahedron> all;
    mesh_.ForEachSimplex([&](auto t) { all.insert(mesh_.vertices(t)); });
    return all;
  }

 private:
  delaunay::DelaunayTetrahedralization mesh_;
  std::vector<Point3> spots_;
  std::map<std::pair<int, int>, Slot> squares_;
};

// All faces that lie on facets.
std::map<Face, Slot> Subfacets(const Plane& plane) {
  std::map<Face, Slot> all;
  for (const Tetrahedron& t : plane.Tetrahedra()) {
    for (std::size_t skip = 0; skip < 4; ++skip) {
      Face face;
      for (std::size_t i = 0, k = 0; i < 4; ++i) {
        if (i != skip) face[k++] = t[i];
      }
      std::sort(face.begin(), face.end());
      const Slot slot = plane.FacetOf(face[0], face[1], face[2], t[skip]);
      if (slot != kNil) all[face] = slot;
    }
  }
  return all;
}

std::map<Face, Slot> Kept(const SubfacetTable& table) {
  std::map<Face, Slot> all;
  table.ForEach([&](const Face& face, Slot slot) { all[face] = slot; });
  return all;
}

TEST(SubfacetTable, IsWhatAllFacesSayAfterEveryChange) {
  constexpr std::uint64_t kSeed = 31;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  Plane plane;
  SubfacetTable table;
  const auto facet_of = [&](Vertex a, Vertex b, Vertex c, Vertex d) {
    return plane.FacetOf(a, b, c, d);
  };
  // Two places for facets: one with a hole beside one without.
  std::array<std::optional<Slot>, 2> there;
  Slot next = 1;
  std::size_t most = 0, changed = 0, stayed = 0;
  for (int revision = 0; revision < 400; ++revision) {
    const std::set<Tetrahedron> before = plane.Tetrahedra();
    const std::map<Face, Slot> had = Kept(table);
    table.ClearChanges();
    for (int k = random.Below(4); k > 0; --k) plane.ToggleSpot(random);
    std::vector<std::pair<Slot, int>> fresh;
    for (int k = 0; k < 2; ++k) {
      auto& slot = there[static_cast<std::size_t>(k)];
      if (!random.OneIn(4)) continue;
      const bool again = random.OneIn(2);  // the same facet in a new slot
      const bool was = slot.has_value();
      if (was) {
        plane.DropFacet(*slot);
        table.RemoveFacet(*slot);
        slot.reset();
      }
      if (was && !again) continue;
      slot = next++;
      plane.SetFacet(*slot, k == 0 ? 0 : 3, k == 0 ? 0 : 2, 3, k == 0);
      fresh.emplace_back(*slot, k);
    }
    const std::set<Tetrahedron> after = plane.Tetrahedra();
    for (const Tetrahedron& t : before) {
      if (!after.contains(t)) table.Remove(t);
    }
    for (const Tetrahedron& t : after) {
      if (!before.contains(t)) table.Add(t, facet_of);
    }
    for (const auto& [slot, k] : fresh) {
      table.AddFacet(slot, Plane::CornersOf(k == 0 ? 0 : 3, k == 0 ? 0 : 2, 3), plane.mesh(),
                     facet_of);
    }
    const std::map<Face, Slot> now = Subfacets(plane);
    ASSERT_EQ(Kept(table), now) << "revision " << revision;
    ASSERT_EQ(table.size(), now.size());
    // The old ones, minus the removed ones, plus the added ones.
    std::map<std::pair<Face, Slot>, int> sum;
    for (const auto& row : had) ++sum[row];
    for (const auto& [face, slot] : table.gone()) --sum[{face, slot}];
    for (const auto& [face, slot] : table.come()) ++sum[{face, slot}];
    for (const auto& row : now) --sum[row];
    for (const auto& [row, count] : sum) ASSERT_EQ(count, 0) << "revision " << revision;
    most = std::max(most, now.size());
    changed += !table.come().empty();
    stayed += table.come().size() < now.size();
  }
  EXPECT_GT(most, 40u);
  EXPECT_GT(changed, 100u);
  EXPECT_GT(stayed, 100u) << "nothing is told of what has not changed";
}

}  // namespace
}  // namespace dynmesh::subfacet_table_test
