// Refusals of sizing features.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "tests/core/plc/plc_refusals.h"

namespace dynmesh::plc::size_refusals_test {
namespace {

TEST_F(PlcRefusals, Sizes) {
  const auto refused = [&](const Feature& size, const char* reason) {
    ExpectRefused({AddPoint(40, 0.1, 0.1), Edit::Add(size)}, Code::kInvalidArgument, reason, {30},
                  1);
  };
  ExpectAccepted({Edit::Add(Feature::SizeAt(30, 0, 1, 0.1))});
  ExpectAccepted({Edit::Add(Feature::SizeDisc(30, 0.5, 0.5, 10, 100))});
  ExpectAccepted({Edit::Add(Feature::SizeDisc(30, 0.5, 0.5, 0, 0x1p-35))});
  ExpectAccepted({Edit::Add(Feature::SizeBox(30, -5, -5, 0, 0, 0.5))});
  ExpectAccepted({Edit::Add(Feature::SizeBox(30, 0.5, 0.5, 0.5, 7, 0.5))});
  for (const double bad : {kInf, -kInf, kNan}) {
    refused(Feature::SizeAt(30, bad, 0.5, 0.1), reason::kNotFinite);
    refused(Feature::SizeAt(30, 0.5, bad, 0.1), reason::kNotFinite);
    refused(Feature::SizeAt(30, 0.5, 0.5, bad), reason::kNotFinite);
    refused(Feature::SizeDisc(30, 0.5, 0.5, bad, 0.1), reason::kNotFinite);
    refused(Feature::SizeBox(30, 0.5, 0.5, bad, 1, 0.1), reason::kNotFinite);
    refused(Feature::SizeBox(30, 0.5, 0.5, 1, bad, 0.1), reason::kNotFinite);
  }
  refused(Feature::SizeAt(30, 1 + kUlp, 0.5, 0.1), reason::kOutsideBox);
  refused(Feature::SizeDisc(30, 0.5, -0.1, 0.5, 0.1), reason::kOutsideBox);
  refused(Feature::SizeBox(30, 1.5, 0, 2, 1, 0.1), reason::kOutsideBox);
  refused(Feature::SizeBox(30, 0.5, 0.5, 0.4, 1, 0.1), reason::kBadSize);
  refused(Feature::SizeDisc(30, 0.5, 0.5, -0.1, 0.1), reason::kBadSize);
  refused(Feature::SizeAt(30, 0.5, 0.5, 0), reason::kBadSize);
  refused(Feature::SizeAt(30, 0.5, 0.5, -1), reason::kBadSize);
  refused(Feature::SizeAt(30, 0.5, 0.5, 0x1p-36), reason::kBadSize);
  Feature odd = Feature::SizeAt(30, 0.5, 0.5, 0.1);
  odd.sizing.shape = static_cast<SizeShape>(9);
  refused(odd, reason::kBadSize);
  // Only a point can move or be an end.
  ExpectRefused({Edit::Add(Feature::SizeAt(30, 0.5, 0.5, 0.1)), Edit::Move(30, 0.1, 0.1)},
                Code::kInvalidArgument, reason::kWrongKind, {30}, 1);
  ExpectRefused({Edit::Add(Feature::SizeAt(30, 0.5, 0.5, 0.1)), AddSegment(31, 5, 30)},
                Code::kFailedPrecondition, reason::kUnknownEnd, {31, 30}, 1);
}

TEST_F(PlcRefusals, Capsules) {
  const auto refused = [&](const Path& path, double radius, double target, const char* reason,
                           const std::string& words) {
    const EditBatch batch = {AddPoint(40, 0.1, 0.1),
                             Edit::Add(Feature::SizeCapsule(30, path, radius, target))};
    ExpectRefused(batch, Code::kInvalidArgument, reason, {30}, 1);
    const std::string message(plc_.Check(batch).status().message());
    EXPECT_NE(message.find(words), std::string::npos) << message;
  };
  const auto accepted = [&](const Path& path, double radius, double target) {
    ExpectAccepted({Edit::Add(Feature::SizeCapsule(30, path, radius, target))});
  };
  const Path line = {{0.1, 0.2}, {0.9, 0.8}};
  accepted(line, 0.1, 0.1);
  accepted({{0.1, 0.2}, {0.1 + 0x1p-20, 0.2}}, 1e-300, 0x1p-35);  // as thin and fine as any
  accepted(line, 0, 0.1);
  accepted(line, 1.5, 100);  // more than the box's diagonal
  accepted(line, 1e308, 100);
  accepted({{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}, 0.1, 0.1);          // closed, on the box
  accepted({{0.1, 0.1}, {0.2, 0.2}, {0.1, 0.1}, {0.3, 0.3}}, 0.1, 0.1);  // there and back, in line
  accepted({{0.1, 0.1}, {0.9, 0.9}, {0.9, 0.1}, {0.1, 0.9}}, 0.1, 0.1);  // crosses itself
  refused({}, 0.1, 0.1, reason::kBadSize, "0 vertices; give at least 2");
  refused({{0.5, 0.5}}, 0.1, 0.1, reason::kBadSize, "1 vertices; give at least 2");
  refused({{0.5, 0.5}, {0.5, 0.5}}, 0.1, 0.1, reason::kBadSize, "its vertex 2 (0.5, 0.5)");
  refused({{0.5, 0.5}, {0, 0.5}, {-0.0, 0.5}}, 0.1, 0.1, reason::kBadSize, "its vertex 3 (0, 0.5)");
  for (const double bad : {kInf, -kInf, kNan}) {
    refused({{0.5, 0.5}, {bad, 0.5}}, 0.1, 0.1, reason::kNotFinite, "finite");
    refused({{0.5, bad}, {0.5, 0.6}}, 0.1, 0.1, reason::kNotFinite, "finite");
    refused(line, bad, 0.1, reason::kNotFinite, "finite");
    refused(line, 0.1, bad, reason::kNotFinite, "finite");
  }
  refused({{0.5, 0.5}, {1 + kUlp, 0.5}}, 0.1, 0.1, reason::kOutsideBox, "number 2");
  refused({{-0.1, 0.5}, {0.5, 0.5}}, 0.5, 0.1, reason::kOutsideBox, "number 1");
  refused(line, -1, 0.1, reason::kBadSize, "has a negative radius");
  refused(line, 0.1, 0, reason::kBadSize, "target");
  refused(line, 0.1, -1, reason::kBadSize, "target");
  refused(line, 0.1, 0x1p-36, reason::kBadSize, "target");
  Path many;
  for (std::size_t i = 0; i < kMostPathVertices; ++i) {
    many.push_back({static_cast<double>(i) / kMostPathVertices, i % 2 == 0 ? 0.1 : 0.2});
  }
  accepted(many, 0.01, 0.1);
  many.push_back({0.5, 0.5});
  refused(many, 0.01, 0.1, reason::kBadSize, "65537 vertices; give at most 65536");
  // It moves by a set, and leaves as any feature.
  ExpectRefused({Edit::Add(Feature::SizeCapsule(30, line, 0.1, 0.1)), Edit::Move(30, 0.1, 0.1)},
                Code::kInvalidArgument, reason::kWrongKind, {30}, 1);
  ExpectAccepted({Edit::Add(Feature::SizeCapsule(30, line, 0.1, 0.1)),
                  Edit::Set(Feature::SizeCapsule(30, {{0, 0}, {1, 1}}, 0.2, 0.1)),
                  Edit::Remove(30)});
}

TEST_F(PlcRefusals, SizingPolygons) {
  const auto size = [](Rings rings, double target) {
    return Edit::Add(Feature::SizePolygon(30, std::move(rings), target));
  };
  ExpectRefused({size({{1, 2}}, 0.1)}, Code::kInvalidArgument, reason::kBadPolygon, {30}, 0);
  ExpectRefused({size({{1, 2, 77}}, 0.1)}, Code::kFailedPrecondition, reason::kUnknownEnd, {30, 77},
                0);
  ExpectRefused({size({{1, 2, 3}}, 0)}, Code::kInvalidArgument, reason::kBadSize, {30}, 0);
  ExpectRefused({size({{1, 5, 3}}, 0.1), Edit::Remove(5)}, Code::kFailedPrecondition,
                reason::kPointInUse, {5, 30}, 1);
  // It has no edges: it may cross anything, itself too.
  ExpectAccepted({size({{1, 3, 2, 4}, {6, 5, 1}}, 0.1)});
}

}  // namespace
}  // namespace dynmesh::plc::size_refusals_test
