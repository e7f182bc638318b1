// A set of features for tests of refusals, and what they expect of one: its code, reason, features
// and edit, and that it changes nothing.
#ifndef DYNMESH_TESTS_CORE_PLC_PLC_REFUSALS_H_
#define DYNMESH_TESTS_CORE_PLC_PLC_REFUSALS_H_

#include <gtest/gtest.h>

#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/plc/plc.h"
#include "dynmesh/error.h"
#include "tests/core/plc/plc_test_util.h"

namespace dynmesh::plc {

using Code = absl::StatusCode;

inline constexpr double kInf = std::numeric_limits<double>::infinity();
inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kUlp = 0x1p-52;  // a step that every coordinate used here can take

// Points 1..4 are the corners of a square, 5 its centre, 6 apart; segments 11, 12, 13 are
// three sides of the square, 14 goes from 6 to a point 7.
class PlcRefusals : public testing::Test {
 protected:
  PlcRefusals() : plc_(Square(0, 1)) {
    Apply(plc_, {AddPoint(1, 0.25, 0.25), AddPoint(2, 0.75, 0.25), AddPoint(3, 0.75, 0.75),
                 AddPoint(4, 0.25, 0.75), AddPoint(5, 0.5, 0.5), AddPoint(6, 0.875, 0.25),
                 AddPoint(7, 0.875, 0.75), AddSegment(11, 1, 2), AddSegment(12, 2, 3),
                 AddSegment(13, 3, 4), AddSegment(14, 6, 7)});
  }

  void ExpectRefused(const EditBatch& batch, Code code, const char* reason,
                     const std::vector<FeatureId>& features, std::size_t edit) {
    SCOPED_TRACE(ScriptOf(batch));
    const std::vector<Feature> before = plc_.Features();
    const absl::Status status = plc_.Check(batch).status();
    EXPECT_EQ(status.code(), code) << status;
    const std::optional<ErrorDetail> detail = GetErrorDetail(status);
    ASSERT_TRUE(detail.has_value()) << status;
    EXPECT_EQ(detail->reason, reason) << status;
    EXPECT_EQ(detail->features, features) << status;
    EXPECT_EQ(detail->edit, edit) << status;
    for (const FeatureId id : features) {
      EXPECT_NE(status.message().find(std::to_string(id)), std::string::npos) << status;
    }
    EXPECT_EQ(plc_.Features(), before);
    // Nothing sticks to the index either: the same again, and a legal batch is legal.
    EXPECT_EQ(plc_.Check(batch).status(), status);
    EXPECT_TRUE(plc_.Check({AddPoint(99, 0.0625, 0.0625)}).ok());
  }

  void ExpectAccepted(const EditBatch& batch) {
    const absl::Status status = plc_.Check(batch).status();
    EXPECT_TRUE(status.ok()) << status << "\n" << ScriptOf(batch);
  }

  Plc2 plc_;
};

}  // namespace dynmesh::plc

#endif  // DYNMESH_TESTS_CORE_PLC_PLC_REFUSALS_H_
