// The judge of quadtrees accepts those of the library, and finds every fault.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "client/verify/verify_quadtree.h"
#include "dynmesh/dynamic_mesh.h"

namespace dynmesh::cli {
namespace {

MeshOptions Options(int dimension) {
  MeshOptions options;
  options.dimension = dimension;
  options.quality = DefaultQuality(dimension);
  options.box = {{-1, 3, 100}, {4, 5, 101}};
  options.kind = MeshKind::kQuadtree;
  return options;
}

std::vector<Feature> Features(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(0, 1);
  std::vector<Feature> features;
  for (FeatureId id = 1; id <= 30; ++id) {
    features.push_back(
        Feature::Point(id, 5 * any(random) - 1, 3 + 2 * any(random), 100 + any(random)));
  }
  features.push_back(Feature::Segment(31, 1, 2));
  return features;
}

io::LeafList Good(const std::vector<Feature>& features, int dimension) {
  const MeshOptions options = Options(dimension);
  return *io::LeavesOf(*BuildMesh(features, options), options);
}

// The checks that fail.
std::string Failed(const io::LeafList& list, const std::vector<Feature>* features) {
  std::string failed;
  for (const VerifyCheck& check : VerifyQuadtree(list, features).checks) {
    if (check.failures > 0) failed += check.name + " ";
  }
  return failed;
}

TEST(VerifyQuadtree, AcceptsThoseOfTheLibrary) {
  for (const int dimension : {2, 3}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      SCOPED_TRACE(seed);
      const std::vector<Feature> features = Features(seed);
      const MeshOptions options = Options(dimension);
      const Mesh mesh = *BuildMesh(features, options);
      const QuadtreeReport report = VerifyQuadtree(*io::LeavesOf(mesh, options), &features);
      EXPECT_TRUE(report.Passed());
      EXPECT_EQ(report.checks.size(), 4u);
      EXPECT_EQ(report.hash, mesh.hash);
      EXPECT_EQ(report.leaves, mesh.vertices.size());
      EXPECT_GT(report.greatest_ratio, report.least_ratio);
    }
  }
}

// Splits leaf `i`.
void Split(io::LeafList& list, std::size_t i) {
  io::LeafList::Leaf parent = list.leaves[i];
  list.leaves.erase(list.leaves.begin() + static_cast<std::ptrdiff_t>(i));
  for (int which = 0; which < 1 << list.dimension; ++which) {
    io::LeafList::Leaf child = parent;
    ++child.cell.level;
    child.cell.side /= 2;
    for (int k = 0; k < list.dimension; ++k) {
      child.centre[static_cast<std::size_t>(k)] +=
          ((which >> k & 1) != 0 ? 0.25 : -0.25) * parent.cell.side;
    }
    list.leaves.push_back(child);
  }
}

TEST(VerifyQuadtree, FindsEveryFault) {
  for (const int dimension : {2, 3}) {
    const std::vector<Feature> features = Features(7);
    const io::LeafList good = Good(features, dimension);
    ASSERT_EQ(Failed(good, &features), "");
    const auto expect = [&](const char* checks, const std::function<void(io::LeafList&)>& spoil) {
      io::LeafList list = good;
      spoil(list);
      EXPECT_EQ(Failed(list, nullptr), checks) << dimension;
    };
    expect("cells ", [](auto& l) { l.leaves.clear(); });
    expect("cells ", [](auto& l) { l.leaves[7].centre[0] += 0.25 * l.leaves[7].cell.side; });
    expect("cells ", [](auto& l) { l.leaves[7].cell.side *= 2; });
    expect("cells ", [](auto& l) { ++l.leaves[7].cell.level; });
    expect("cover ", [](auto& l) { l.leaves.erase(l.leaves.begin() + 9); });
    expect("cover ", [](auto& l) { l.leaves.push_back(l.leaves[3]); });
    expect("cover ", [](auto& l) {
      const auto parent = l.leaves[3];
      Split(l, 3);
      l.leaves.push_back(parent);
    });
    // A coarse leaf, split twice.
    expect("balance ", [](auto& l) {
      Split(l, 0);
      Split(l, l.leaves.size() - 1);
    });
  }
}

TEST(VerifyQuadtree, FindsLeavesThatDoNotFollowTheInput) {
  for (const int dimension : {2, 3}) {
    std::vector<Feature> features = Features(7);
    io::LeafList list = Good(features, dimension);
    // Finer than needed, by three levels everywhere.
    io::LeafList fine = list;
    for (int round = 0; round < (dimension == 2 ? 4 : 3); ++round) {
      io::LeafList next;
      next.dimension = dimension;
      for (const auto& leaf : fine.leaves) {
        io::LeafList one;
        one.dimension = dimension;
        one.leaves = {leaf};
        Split(one, 0);
        next.leaves.insert(next.leaves.end(), one.leaves.begin(), one.leaves.end());
      }
      fine = next;
    }
    EXPECT_EQ(Failed(fine, &features), "lfs ");
    // Coarser than needed: a near pair that the leaves do not know.
    const auto p = features[4].position;
    features.push_back(Feature::Point(77, p[0] + 1e-6, p[1], p[2]));
    EXPECT_EQ(Failed(list, &features), "lfs ");
  }
}

}  // namespace
}  // namespace dynmesh::cli
