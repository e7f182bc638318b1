// Indices of elements, and what is reported as come or gone.
#include "core/meshing/element_store.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/workload.h"

namespace dynmesh::meshing::element_store_test {
namespace {

using Change = std::tuple<std::uint32_t, bool, bool>;  // index, is, was

std::vector<Change> TakeVertices(ElementStore<2>& store) {
  std::vector<Change> changes;
  store.TakeChanges([&](VertexIndex v, bool is, bool was) { changes.emplace_back(v, is, was); },
                    [](SubsegmentIndex, bool, bool) {});
  return changes;
}

TEST(ElementStore, AnIndexIsFreeOnlyAfterChangesAreTaken) {
  ElementStore<2> store;
  const VertexIndex a = store.NewVertex(), b = store.NewVertex();
  store.ReleaseVertex(a);
  EXPECT_FALSE(store.has_free_vertices());
  EXPECT_EQ(store.NewVertex(), b + 1);
  store.vertex(a).p = {{3, 4}};
  TakeVertices(store);
  EXPECT_TRUE(store.has_free_vertices());
  EXPECT_EQ(store.NewVertex(), a);
  EXPECT_EQ(store.vertex(a).p, geometry::Point2{}) << "a new element is a default one";
  EXPECT_FALSE(store.has_free_vertices());
  EXPECT_EQ(store.vertex_end(), 3u);

  const SubsegmentIndex s = store.NewSubsegment();
  store.ReleaseSubsegment(s);
  EXPECT_EQ(store.NewSubsegment(), s + 1);
  TakeVertices(store);
  EXPECT_EQ(store.NewSubsegment(), s);
}

TEST(ElementStore, ReportsWhatIsAndWhatWas) {
  ElementStore<2> store;
  const VertexIndex stays = store.NewVertex(), goes = store.NewVertex();
  store.SetPresent(stays, true);
  store.SetPresent(goes, true);
  EXPECT_EQ(TakeVertices(store), (std::vector<Change>{{stays, true, false}, {goes, true, false}}));
  EXPECT_EQ(TakeVertices(store), std::vector<Change>());
  const VertexIndex brief = store.NewVertex();
  store.SetPresent(goes, false);
  store.SetPresent(brief, true);
  store.SetPresent(brief, false);
  EXPECT_EQ(TakeVertices(store), (std::vector<Change>{{goes, false, true}, {brief, false, false}}));
  store.SetPresent(stays, false);
  store.SetPresent(stays, true);
  EXPECT_EQ(TakeVertices(store), (std::vector<Change>{{stays, true, true}}));
}

TEST(ElementStore, ASubsegmentIsInTheMeshFromItsExposureToItsDeath) {
  ElementStore<3> store;
  const SubsegmentIndex s = store.NewSubsegment();
  std::vector<Change> changes;
  const auto take = [&] {
    changes.clear();
    store.TakeChanges(
        [](VertexIndex, bool, bool) {},
        [&](SubsegmentIndex i, bool is, bool was) { changes.emplace_back(i, is, was); });
    return changes;
  };
  store.MarkSubsegmentChanged(s);
  EXPECT_EQ(take(), (std::vector<Change>{{s, false, false}}));
  store.subsegment(s).exposed = 7;
  store.MarkSubsegmentChanged(s);
  store.MarkSubsegmentChanged(s);
  EXPECT_EQ(take(), (std::vector<Change>{{s, true, false}}));
  store.subsegment(s).death = 9;
  store.MarkSubsegmentChanged(s);
  int taken = 0, present = 0;
  store.ForEachTakenSubsegment([&](const auto&) { ++taken; });
  store.ForEachSubsegment([&](const auto&) { ++present; });
  EXPECT_EQ(taken, 1);
  EXPECT_EQ(present, 0);
  EXPECT_EQ(take(), (std::vector<Change>{{s, false, true}}));
}

// Against a model: no index is in use twice, and reports add up.
TEST(ElementStore, RandomEditsAddUp) {
  constexpr std::uint64_t kSeed = 17;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  test::Random random(kSeed);
  ElementStore<2> store;
  std::map<VertexIndex, bool> used;  // is it present?
  std::set<VertexIndex> reported;
  for (int step = 0; step < 5000; ++step) {
    const auto any = [&] {
      return std::next(used.begin(), random.Below(static_cast<int>(used.size())));
    };
    switch (random.Below(used.size() < 40 ? 4 : 5)) {
      case 0:
      case 1: {
        const VertexIndex v = store.NewVertex();
        ASSERT_TRUE(used.emplace(v, false).second);
        break;
      }
      case 2: {
        if (used.empty()) break;
        const auto it = any();
        it->second = !it->second;
        store.SetPresent(it->first, it->second);
        break;
      }
      case 3: {
        if (!random.OneIn(5)) break;
        for (const auto& [v, is, was] : TakeVertices(store)) {
          ASSERT_EQ(was, reported.contains(v));
          is ? (void)reported.insert(v) : (void)reported.erase(v);
        }
        std::set<VertexIndex> present;
        store.ForEachVertex([&](VertexIndex v, const auto&) { present.insert(v); });
        ASSERT_EQ(present, reported);
        ASSERT_EQ(store.vertex_count(), present.size());
        break;
      }
      default: {
        const auto it = any();
        if (it->second) store.SetPresent(it->first, false);
        store.ReleaseVertex(it->first);
        used.erase(it);
      }
    }
  }
}

}  // namespace
}  // namespace dynmesh::meshing::element_store_test
