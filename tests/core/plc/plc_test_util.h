// Helpers for the tests of core/plc: edits, small solids, scripts of edits.
#ifndef DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_
#define DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_

#include <gtest/gtest.h>

#include <array>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::plc {

inline MeshOptions Square(double lo, double hi) {
  MeshOptions options;
  options.box.lo = {lo, lo, 0};
  options.box.hi = {hi, hi, 0};
  return options;
}

inline MeshOptions Cube(double lo, double hi) {
  MeshOptions options;
  options.dimension = 3;
  options.box = {{lo, lo, lo}, {hi, hi, hi}};
  return options;
}

inline Edit AddPoint(FeatureId id, double x, double y) {
  return Edit::Add(Feature::Point(id, x, y));
}
inline Edit AddPoint3(FeatureId id, double x, double y, double z) {
  return Edit::Add(Feature::Point(id, x, y, z));
}
inline Edit AddPolygon(FeatureId id, Rings rings) {
  return Edit::Add(Feature::Polygon(id, std::move(rings)));
}
inline Edit AddSegment(FeatureId id, FeatureId p, FeatureId q) {
  return Edit::Add(Feature::Segment(id, p, q));
}
inline Edit SetPoint(FeatureId id, double x, double y) {
  return Edit::Set(Feature::Point(id, x, y));
}
inline Edit SetSegment(FeatureId id, FeatureId p, FeatureId q) {
  return Edit::Set(Feature::Segment(id, p, q));
}

// In the grammar of edit scripts, to repeat a failure with.
inline std::string ScriptOf(const EditBatch& batch) {
  std::ostringstream out;
  out.precision(17);
  for (const Edit& edit : batch) {
    const Feature& f = edit.feature;
    switch (edit.action) {
      case Edit::Action::kAdd:
        out << "add ";
        break;
      case Edit::Action::kSet:
        out << "set ";
        break;
      case Edit::Action::kRemove:
        out << "remove " << f.id << "\n";
        continue;
      case Edit::Action::kMove:
        out << "move ";
        break;
      case Edit::Action::kSetLabel:
        out << "marker " << f.id << " " << f.label->marker << "\n";
        continue;
    }
    if (edit.action == Edit::Action::kMove || f.kind == FeatureKind::kPoint) {
      out << "point " << f.id << " " << f.position[0] << " " << f.position[1];
      if (f.position[2] != 0) out << " " << f.position[2];
      out << "\n";
    } else if (f.kind == FeatureKind::kPolygon) {
      out << "polygon " << f.id;
      for (const auto& ring : f.rings) {
        if (&ring != &f.rings.front()) out << " /";
        for (const FeatureId point : ring) out << " " << point;
      }
      out << "\n";
    } else {
      out << "segment " << f.id << " " << f.ends[0] << " " << f.ends[1] << "\n";
    }
  }
  out << "commit\n";
  return out.str();
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

// Checks and commits; the batch must be legal.
template <int D>
Delta<D> Apply(Plc<D>& plc, const EditBatch& batch) {
  absl::StatusOr<Delta<D>> delta = plc.Check(batch);
  EXPECT_TRUE(delta.ok()) << delta.status();
  if (!delta.ok()) return {};
  plc.Apply(*delta);
  return *delta;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_
