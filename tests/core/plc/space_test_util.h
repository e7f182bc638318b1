// Small solids for the 3D tests of core/plc.
#ifndef DYNMESH_TESTS_CORE_PLC_SPACE_TEST_UTIL_H_
#define DYNMESH_TESTS_CORE_PLC_SPACE_TEST_UTIL_H_

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

inline MeshOptions Cube(double lo, double hi) {
  MeshOptions options;
  options.dimension = 3;
  options.box = {{lo, lo, lo}, {hi, hi, hi}};
  return options;
}

inline Edit AddPoint3(FeatureId id, double x, double y, double z) {
  return Edit::Add(Feature::Point(id, x, y, z));
}
inline Edit AddPolygon(FeatureId id, Rings rings) {
  return Edit::Add(Feature::Polygon(id, std::move(rings)));
}

inline EditBatch operator+(EditBatch a, const EditBatch& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

// The corners of a box, ids from `first` on: bit i of the number says whether it is at hi in i.
inline EditBatch Corners(FeatureId first, std::array<double, 3> lo, std::array<double, 3> hi) {
  EditBatch batch;
  for (FeatureId c = 0; c < 8; ++c) {
    batch.push_back(
        AddPoint3(first + c, (c & 1 ? hi : lo)[0], (c & 2 ? hi : lo)[1], (c & 4 ? hi : lo)[2]));
  }
  return batch;
}
// Its faces: -x, +x, -y, +y, -z, +z.
inline std::vector<std::vector<FeatureId>> Faces(FeatureId first) {
  std::vector<std::vector<FeatureId>> faces = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                               {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
  for (auto& face : faces) {
    for (FeatureId& id : face) id += first;
  }
  return faces;
}
inline EditBatch BoxOf(FeatureId first, FeatureId polygon, std::array<double, 3> lo,
                       std::array<double, 3> hi) {
  EditBatch batch = Corners(first, lo, hi);
  for (const auto& face : Faces(first)) batch.push_back(AddPolygon(polygon++, {face}));
  return batch;
}

inline Delta<3> Apply(Plc3& plc, const EditBatch& batch) {
  absl::StatusOr<Delta<3>> delta = plc.Check(batch);
  EXPECT_TRUE(delta.ok()) << delta.status();
  if (!delta.ok()) return {};
  plc.Commit(*delta);
  return *delta;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_SPACE_TEST_UTIL_H_
