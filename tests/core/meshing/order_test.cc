// The order of operations within an epoch: strict and total, and a function of what items are.
#include "core/meshing/order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <tuple>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::order_test {
namespace {

constexpr std::uint64_t kSeed = 20261128;

template <int D>
struct Scene {
  struct Operation {
    sac::Kind kind;
    sac::Item item;
  };

  // With some of the points as slivers' corners, if 3D. `reversed`: other indices.
  Scene(std::vector<geometry::Point<D>> points, bool reversed) : lone(Sharp()) {
    if (reversed) std::ranges::reverse(points);
    std::vector<VertexIndex> all;
    for (const auto& p : points) all.push_back(lone.Add(p));
    std::sort(all.begin(), all.end(), [&](VertexIndex u, VertexIndex v) {
      return lone.complex.vertex(u).p < lone.complex.vertex(v).p;
    });
    for (std::size_t n = 0; n + 3 < all.size(); ++n) {
      const std::size_t i = reversed ? all.size() - 4 - n : n;
      for (const sac::Kind kind : {kNearest, kComplete}) operations.push_back({kind, all[i]});
      for (const std::size_t j : {i + 1, i + 3}) {
        const auto s = lone.AddSubsegment(all[i], all[j]);
        for (const sac::Kind kind : {kCheck, kSplit, kRecheck, kPresplit}) {
          operations.push_back({kind, s});
        }
      }
    }
    if constexpr (D == 3) {
      base = lone.TriangulationAt(1);
      lone.complex.slivers.Begin(
          base, false, [](auto, auto) { return false; }, [](const auto&) { return false; },
          [] { return false; });
      lone.complex.slivers.TakeChanges(
          [&](SliverIndex i) {
            operations.push_back({kCure, i});
          },
          [](SliverIndex) {});
    }
  }
  static MeshOptions Sharp() {
    MeshOptions options = LoneComplex<D>::Options();
    if (D == 3) options.min_dihedral = 20;
    return options;
  }
  bool IsBefore(const Operation& a, const Operation& b) const {
    return Before(lone.complex, a.kind, a.item, b.kind, b.item);
  }
  bool IsEarlier(const Operation& a, const Operation& b) const {
    const auto pa = Priority(lone.complex, a.kind, a.item),
               pb = Priority(lone.complex, b.kind, b.item);
    return pa != pb ? pa < pb : IsBefore(a, b);
  }
  // What it is.
  std::tuple<sac::Kind, std::uint64_t, std::vector<geometry::Point<D>>> Identity(
      const Operation& o) const {
    std::vector<VertexIndex> v = {o.item};
    if (o.kind > kComplete && o.kind != kCure) {
      const Subsegment<D>& s = lone.complex.subsegment(o.item);
      v = {s.a, s.b};
    } else if (o.kind == kCure) {
      const auto& corners = lone.complex.slivers[o.item].v;
      v.assign(corners.begin(), corners.end());
    }
    std::vector<geometry::Point<D>> places;
    for (const VertexIndex i : v) places.push_back(lone.complex.vertex(i).p);
    return {o.kind, Priority(lone.complex, o.kind, o.item), places};
  }

  LoneComplex<D> lone;
  TriangulationOf<D> base;
  std::vector<Operation> operations;
};

template <class Operations, class Less>
void ExpectStrictAndTotal(Operations operations, Less less) {
  std::ranges::sort(operations, less);
  for (std::size_t i = 0; i < operations.size(); ++i) {
    for (std::size_t j = 0; j < operations.size(); ++j) {
      ASSERT_EQ(less(operations[i], operations[j]), i < j) << i << " " << j;
    }
  }
}

template <int D>
void ExpectAnOrder(Layout layout) {
  SCOPED_TRACE("seed " + std::to_string(kSeed) + ", layout " +
               std::to_string(static_cast<int>(layout)));
  test::Random random(kSeed);
  const auto points = DistinctPlaces<D>(layout, 40, random);
  const Scene<D> scene(points, false), other(points, true);
  ExpectStrictAndTotal(scene.operations,
                       [&](const auto& a, const auto& b) { return scene.IsBefore(a, b); });
  ExpectStrictAndTotal(scene.operations,
                       [&](const auto& a, const auto& b) { return scene.IsEarlier(a, b); });
  for (const bool by_priority : {false, true}) {
    const auto in_order = [&](const Scene<D>& of) {
      auto sorted = of.operations;
      std::ranges::sort(sorted, [&](const auto& a, const auto& b) {
        return by_priority ? of.IsEarlier(a, b) : of.IsBefore(a, b);
      });
      std::vector<decltype(of.Identity(sorted[0]))> identities;
      for (const auto& o : sorted) identities.push_back(of.Identity(o));
      return identities;
    };
    EXPECT_EQ(in_order(scene), in_order(other));
  }
  if (D == 3 && layout == Layout::kRandom) {
    EXPECT_TRUE(std::ranges::any_of(scene.operations, [](auto& o) { return o.kind == kCure; }));
  }
}

TEST(Order, IsStrictAndTotalAndIndependentOfIndices) {
  for (const Layout layout : kLayouts) {
    ExpectAnOrder<2>(layout);
    ExpectAnOrder<3>(layout);
  }
}

TEST(Order, WorkOfAnEarlierBucketComesNowOrInTheNextRound) {
  LoneComplex<2> lone;
  const VertexIndex v = lone.Add({{0.2, 0.3}}), x = lone.Add({{0.7, 0.1}});
  const auto& complex = lone.complex;
  const sac::Epoch now = MakeEpoch(100, 3, kQualityStep);
  EXPECT_EQ(NoEarlierThan(complex, now, v, x, 101), MakeEpoch(101, 0, kQualityStep));
  for (const auto& [from, to] : {std::pair(v, x), {x, v}}) {
    const bool later = Priority(complex, kComplete, from) < Priority(complex, kComplete, to);
    for (const int own : {7, 100}) {
      EXPECT_EQ(NoEarlierThan(complex, now, from, to, own),
                later ? now : MakeEpoch(100, 4, kQualityStep));
    }
  }
  auto context = lone.At(5, v, now);
  RequestNoEarlierThanNow(complex, context, x, 250);
  EXPECT_EQ(context.requests,
            (std::vector<test::Requested>{{kComplete, x, MakeEpoch(250, 0, kQualityStep)}}));
}

}  // namespace
}  // namespace dynmesh::meshing::order_test
