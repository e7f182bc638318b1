// Which node is chosen for a mesh, and until when its owner answers reads.
#include "server/cluster/placement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/base/boot_time.h"
#include "server/cluster/read_lease.h"
#include "tests/support/seed.h"

namespace dynmesh::server::placement_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

std::string Chosen(const std::vector<std::string>& nodes, const std::string& mesh) {
  const auto index = ChooseNode(nodes, mesh);
  return index.has_value() ? nodes[*index] : "";
}

TEST(Placement, NoNodeIsChosenOfNone) { EXPECT_FALSE(ChooseNode({}, "m").has_value()); }

TEST(Placement, TheOrderOfTheNodesDoesNotMatter) {
  std::vector<std::string> nodes = {"a", "b", "c", "d"};
  std::map<std::string, std::string> chosen;
  for (int i = 0; i < 100; ++i) chosen[absl::StrCat("m", i)] = Chosen(nodes, absl::StrCat("m", i));
  while (std::next_permutation(nodes.begin(), nodes.end())) {
    for (const auto& [mesh, node] : chosen) EXPECT_EQ(Chosen(nodes, mesh), node) << mesh;
  }
}

TEST(Placement, OnlyTheMeshesOfANodeThatGoesMove) {
  const std::uint64_t seed = test::NewSeed();
  SCOPED_TRACE(absl::StrCat("seed ", seed));
  std::mt19937 random(seed);
  std::vector<std::string> nodes;
  for (int i = 0; i < 5; ++i) nodes.push_back(absl::StrCat(absl::Hex(random())));
  for (int i = 0; i < 1000; ++i) {
    const std::string mesh = absl::StrCat("mesh-", i), before = Chosen(nodes, mesh);
    for (const std::string& gone : nodes) {
      std::vector<std::string> rest = nodes;
      rest.erase(std::find(rest.begin(), rest.end(), gone));
      if (gone == before) {
        EXPECT_NE(Chosen(rest, mesh), gone);
      } else {
        EXPECT_EQ(Chosen(rest, mesh), before) << mesh << " without " << gone;
      }
    }
  }
}

// With fixed names, so that the counts are fixed, too.
TEST(Placement, NodesGetAboutTheSameNumberOfMeshes) {
  const std::vector<std::string> nodes = {"10.0.0.1:50051", "10.0.0.2:50051", "10.0.0.3:50051"};
  std::map<std::string, int> count;
  for (int i = 0; i < 3000; ++i) ++count[Chosen(nodes, absl::StrCat("site-", i))];
  for (const std::string& node : nodes) {
    EXPECT_GT(count[node], 850) << node;
    EXPECT_LT(count[node], 1150) << node;
  }
}

TEST(Placement, WhereANameEndsMatters) {
  EXPECT_NE(PlacementWeight("ab", "c"), PlacementWeight("a", "bc"));
}

TEST(ReadLease, IsFreshForFourFifthsOfTheTtlAfterTheSending) {
  ReadLease lease(milliseconds(3000));
  EXPECT_FALSE(lease.IsFresh(nanoseconds(0))) << "never renewed";
  lease.Renewed(milliseconds(1000));
  EXPECT_TRUE(lease.IsFresh(milliseconds(3399)));
  EXPECT_FALSE(lease.IsFresh(milliseconds(3400)));
}

TEST(ReadLease, AnOlderRenewalToldLaterChangesNothing) {
  ReadLease lease(milliseconds(3000));
  lease.Renewed(milliseconds(2000));
  lease.Renewed(milliseconds(1000));
  EXPECT_TRUE(lease.IsFresh(milliseconds(4399)));
  EXPECT_FALSE(lease.IsFresh(milliseconds(4400)));
}

TEST(ReadLease, NothingIsFreshAfterItsEnd) {
  ReadLease lease(milliseconds(3000));
  lease.Renewed(milliseconds(1000));
  lease.End();
  EXPECT_FALSE(lease.IsFresh(milliseconds(1001)));
  lease.Renewed(milliseconds(2000));
  EXPECT_FALSE(lease.IsFresh(milliseconds(2001))) << "the answer to a renewal sent before the end";
}

TEST(ReadLease, TheClockGoesForward) {
  const nanoseconds before = BootTime();
  EXPECT_GT(before, nanoseconds(0));
  EXPECT_GE(BootTime(), before);
}

TEST(Placement, TheNextNodesAreThoseOfTheLargestWeightsWithoutTheOwner) {
  const std::vector<std::string> nodes = {"a:1", "b:1", "c:1", "d:1"};
  for (int m = 0; m < 100; ++m) {
    const std::string mesh = "m" + std::to_string(m);
    for (const std::string& owner : nodes) {
      std::vector<std::string> rest = nodes, next;
      std::erase(rest, owner);
      EXPECT_EQ(NextNodes(nodes, owner, mesh, 0), next);
      for (std::size_t count = 1; count <= 3; ++count) {
        // The first of what is left, again and again.
        const std::size_t best = *ChooseNode(rest, mesh);
        next.push_back(rest[best]);
        rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(best));
        EXPECT_EQ(NextNodes(nodes, owner, mesh, count), next);
      }
      EXPECT_EQ(NextNodes(nodes, owner, mesh, 9), next);
    }
    EXPECT_EQ(NextNodes(nodes, "", mesh, 9).size(), 4u);
    EXPECT_TRUE(NextNodes({"a:1"}, "a:1", mesh, 1).empty());
  }
}

}  // namespace
}  // namespace dynmesh::server::placement_test
