// Expects two diffs to be the same rows in the same order, column by column.
#ifndef DYNMESH_TESTS_SUPPORT_SAME_DIFF_H_
#define DYNMESH_TESTS_SUPPORT_SAME_DIFF_H_

#include <gtest/gtest.h>

#include "dynmesh/mesh.h"

namespace dynmesh::test {

inline void ExpectSameRows(const MeshDiff& a, const MeshDiff& b) {
  EXPECT_EQ(a.removed_vertices, b.removed_vertices);
  EXPECT_EQ(a.removed_simplices, b.removed_simplices);
  EXPECT_EQ(a.removed_regions, b.removed_regions);
  EXPECT_EQ(a.removed_subsegments, b.removed_subsegments);
  EXPECT_EQ(a.removed_subfacets, b.removed_subfacets);
  EXPECT_EQ(a.added_vertices, b.added_vertices);
  EXPECT_EQ(a.added_simplices, b.added_simplices);
  EXPECT_EQ(a.added_regions, b.added_regions);
  EXPECT_EQ(a.region_sets, b.region_sets);
  EXPECT_EQ(a.added_subsegments, b.added_subsegments);
  EXPECT_EQ(a.added_subfacets, b.added_subfacets);
  EXPECT_EQ(a.labels, b.labels);
}

inline void ExpectSameRows(const Mesh& a, const Mesh& b) {
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.simplices, b.simplices);
  EXPECT_EQ(a.regions, b.regions);
  EXPECT_EQ(a.region_sets, b.region_sets);
  EXPECT_EQ(a.subsegments, b.subsegments);
  EXPECT_EQ(a.subfacets, b.subfacets);
  EXPECT_EQ(a.labels, b.labels);
}

// With its rows in canonical order.
inline Mesh Sorted(Mesh mesh) {
  Canonicalize(mesh);
  return mesh;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_SAME_DIFF_H_
