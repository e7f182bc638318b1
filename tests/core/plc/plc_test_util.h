// Helpers for the tests of core/plc.
#ifndef DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_
#define DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_

#include <gtest/gtest.h>

#include <sstream>
#include <string>

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

inline Edit AddPoint(FeatureId id, double x, double y) {
  return Edit::Add(Feature::Point(id, x, y));
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

// Checks and commits; the batch must be legal.
inline Delta<2> Apply(Plc2& plc, const EditBatch& batch) {
  absl::StatusOr<Delta<2>> delta = plc.Check(batch);
  EXPECT_TRUE(delta.ok()) << delta.status();
  if (!delta.ok()) return {};
  plc.Commit(*delta);
  return *delta;
}

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_PLC_TEST_UTIL_H_
