#include "client/cleaning/contact_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <set>
#include <vector>

#include "tests/client/cleaning/surface_oracle.h"
#include "tests/client/cleaning/surface_soups.h"

namespace dynmesh::cleaning::contact_index_test {
namespace {

constexpr std::uint64_t kSeed = 23;

// Corners on a lattice: many triangles touch, overlap, and share corners.
TEST(ContactIndex, ContactsAreThoseOfExactIntersections) {
  std::cout << "seed " << kSeed << "\n";
  SoupMaker maker(kSeed);
  std::vector<Point3> points;
  for (int x = 0; x < 3; ++x) {
    for (int y = 0; y < 3; ++y) {
      for (int z = 0; z < 2; ++z) points.push_back({double(x), double(y), double(z)});
    }
  }
  const auto element = [&](int size) {
    std::set<Node> nodes;
    while (static_cast<int>(nodes.size()) < size) {
      nodes.insert(static_cast<Node>(maker.Integer(0, static_cast<int>(points.size()) - 1)));
    }
    ContactElement made;
    made.size = size;
    std::copy(nodes.begin(), nodes.end(), made.v.begin());
    return made;
  };
  const auto corners = [&](const ContactElement& e) {
    return std::array{points[e.v[0]], points[e.v[1]], points[e.v[2]]};
  };
  std::array<int, 2> seen{};
  for (int i = 0; i < 20000; ++i) {
    const ContactElement face = element(3);
    PlainSurface alone;
    alone.triangles = {corners(face)};
    if (!FaultOf(alone).empty()) continue;  // without area
    const ContactElement other = element(maker.Integer(2, 3));
    PlainSurface both = alone;
    if (other.size == 3) {
      PlainSurface second;
      second.triangles = {corners(other)};
      if (!FaultOf(second).empty()) continue;
      both.triangles.push_back(corners(other));
    } else {
      both.segments.push_back({points[other.v[0]], points[other.v[1]]});
    }
    const bool meets = !FaultOf(both).empty();
    ++seen[meets ? 1 : 0];
    ASSERT_EQ(HasContact(points, face, other, 1e-9), meets)
        << i << ": " << other.size << ": " << FaultOf(both);
  }
  EXPECT_GT(seen[0], 1000);
  EXPECT_GT(seen[1], 1000);
}

TEST(ContactIndex, WhatIsNearerThanTheDistanceIsAContact) {
  const std::vector<Point3> points = {{0, 0, 0},   {4, 0, 0},   {0, 4, 0}, {1, 1, 0.1},
                                      {2, 1, 0.1}, {1, 2, 0.1}, {5, 5, 5}};
  const ContactElement face = {{0, 1, 2}, 3}, above = {{3, 4, 5}, 3};
  EXPECT_TRUE(HasContact(points, face, above, 0.11));
  EXPECT_FALSE(HasContact(points, face, above, 0.09));
  EXPECT_TRUE(HasContact(points, face, {{3, 4, 0}, 2}, 0.11));
  EXPECT_FALSE(HasContact(points, face, {{3, 4, 0}, 2}, 0.09));
  EXPECT_TRUE(HasContact(points, face, {{3, 0, 0}, 1}, 0.11));
  EXPECT_FALSE(HasContact(points, face, {{3, 0, 0}, 1}, 0.09));
  // With a common corner: what is opposite to it.
  EXPECT_TRUE(HasContact(points, face, {{0, 3, 4}, 3}, 0.11));
  EXPECT_FALSE(HasContact(points, face, {{0, 3, 4}, 3}, 0.09));
  // The parts of a face, and itself.
  EXPECT_FALSE(HasContact(points, face, {{0, 1, 0}, 2}, 0.1));
  EXPECT_FALSE(HasContact(points, face, {{1, 0, 0}, 1}, 0.1));
  EXPECT_TRUE(HasContact(points, face, face, 0.1));
  ContactIndex index(points, 0.11);
  index.Insert(7, above);
  const auto none = [](std::uint32_t) { return false; };
  EXPECT_TRUE(index.HasContacts(std::vector{face}, none));
  EXPECT_FALSE(index.HasContacts(std::vector{face}, [](std::uint32_t id) { return id == 7; }));
  EXPECT_FALSE(index.HasContacts({}, none));
  // The corner 3 is in a tetrahedron, the corner 6 is not.
  using Tetrahedra = std::vector<std::array<Node, 4>>;
  EXPECT_TRUE(index.HasCornersIn(Tetrahedra{{0, 1, 2, 6}}, none));
  EXPECT_FALSE(
      index.HasCornersIn(Tetrahedra{{0, 1, 2, 6}}, [](std::uint32_t id) { return id == 7; }));
  EXPECT_FALSE(index.HasCornersIn(Tetrahedra{{3, 4, 5, 0}}, none));  // its own corners
  EXPECT_FALSE(index.HasCornersIn(Tetrahedra{{0, 1, 2, 2}}, none));  // no volume
  index.Remove(7, above);
  EXPECT_FALSE(index.HasContacts(std::vector{face}, none));
}

}  // namespace
}  // namespace dynmesh::cleaning::contact_index_test
