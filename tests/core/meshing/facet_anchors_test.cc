// Anchors of one facet: the same whether it comes last or its surroundings do, and what deciding
// them looks at.
#include "core/meshing/facet_anchors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <iostream>
#include <numbers>
#include <set>
#include <vector>

#include "tests/core/meshing/lone_complex.h"

namespace dynmesh::meshing::facet_anchors_test {
namespace {

using geometry::Point3;

constexpr FeatureSlot kFacet = 77;

// A disc of n edges, and m x m points over it, half as high as they are apart from each other.
class Disc {
 public:
  void AddFacet(int n) {
    std::vector<VertexIndex> corners;
    for (int i = 0; i < n; ++i) {
      const double t = 2 * std::numbers::pi * i / n;
      corners.push_back(lone_.Add({{0.5 + 0.4 * std::cos(t), 0.5 + 0.4 * std::sin(t), 0.5}}));
    }
    for (std::size_t i = 0; i < corners.size(); ++i) {
      lone_.input.AddSegment(corners[i], corners[(i + 1) % corners.size()], kFacet);
    }
    lone_.input.AddFacet(std::vector<std::vector<VertexIndex>>{corners}, kFacet);
  }
  void AddPoints(int m) {
    for (int i = 0; i < m; ++i) {
      for (int j = 0; j < m; ++j) {
        lone_.Add({{0.3 + 0.4 * (i + 0.1) / m, 0.3 + 0.4 * (j + 0.2) / m, 0.5 + 0.2 / m}});
      }
    }
  }
  void Update() {
    lone_.input.changes().sizes.Begin();
    EXPECT_TRUE(anchors_.Update([] { return false; }));
    auto& changes = lone_.input.changes();
    changes.sizes.Clear();
    changes.new_facets.clear();
    changes.features.clear();
    changes.facets.clear();
  }
  std::set<Point3> Anchors() const {
    std::set<Point3> anchors;
    lone_.complex.elements.ForEachVertex([&](VertexIndex, const Vertex<3>& v) {
      if (v.dimension == 2) anchors.insert(v.p);
    });
    return anchors;
  }
  const auto& anchors() const { return anchors_; }

 private:
  LoneComplex<3> lone_;
  FacetAnchors<3, test::RecordingEngine> anchors_{lone_.complex, lone_.input};
};

TEST(FacetAnchors, AreThoseOfChangesOneByOne) {
  Disc last, first;
  last.AddPoints(6);
  last.AddFacet(48);
  last.Update();
  first.AddFacet(48);
  first.Update();
  EXPECT_TRUE(first.Anchors().empty());
  first.AddPoints(6);
  first.Update();
  EXPECT_GT(last.Anchors().size(), 20u);
  EXPECT_EQ(last.Anchors(), first.Anchors());
}

// The facet has four times as many edges and points, and anchors as many.
TEST(FacetAnchors, OfANewFacetLookAtWhatIsNear) {
  std::vector<double> looked_at;
  for (const int m : {8, 16, 32}) {
    Disc disc;
    disc.AddPoints(m);
    disc.AddFacet(4 * m);
    disc.Update();
    const auto decided = static_cast<double>(disc.anchors().decided());
    looked_at.push_back(static_cast<double>(disc.anchors().looked_at()) / decided);
    std::cout << m * m << " points: " << disc.Anchors().size() << " anchors of " << decided
              << " points decided, " << looked_at.back() << " looked at for each\n";
    EXPECT_GT(disc.Anchors().size(), static_cast<std::size_t>(m * m / 4));
  }
  EXPECT_LT(looked_at[2], 1.5 * looked_at[0]);
}

}  // namespace
}  // namespace dynmesh::meshing::facet_anchors_test
