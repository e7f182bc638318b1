// An operation that emits more than the engine can store: the propagation ends before any of it is
// visible, and can be undone.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "tests/core/sac/engine_fixture.h"

namespace dynmesh::sac::testing {
namespace {

class EngineLimitsTest : public EngineTest {
 protected:
  EngineLimitsTest() {
    EngineLimits limits;
    limits.outputs = 3, limits.places = 4, limits.requests = 5, limits.reads = 6;
    limits.operations = 12;
    e_.set_limits(limits);
  }
  std::string RunOver() {
    EXPECT_FALSE(e_.Propagate([] { return false; }));
    return p_.TakeLog();
  }
};

// Emits that many items of each kind, all within the limits.
Program::Body Says(std::uint32_t outputs, Place places, Item requests, std::uint32_t reads) {
  return [=](Context& c) {
    for (std::uint32_t i = 0; i < outputs; ++i) c.Emit(100 + i);
    for (Place i = 0; i < places; ++i) {
      c.Subscribe(i, 1);
      c.Subscribe(i, 2);  // one place all the same
    }
    for (Item i = 0; i < requests; ++i) c.Request(kOnly, 10 + i, 1);
    for (std::uint32_t i = 0; i < reads; ++i) c.Read(i);
  };
}

TEST_F(EngineLimitsTest, AsMuchAsIsAllowedIsKept) {
  p_[1] = Says(3, 4, 5, 6);
  Request(1);
  Run();
  EXPECT_EQ(e_.overflowed(), kNoOp);
  const OpId op = p_.OperationOf(1);
  EXPECT_EQ(e_.outputs(op).size(), 3u);
  EXPECT_EQ(e_.places(op).size(), 4u);
  EXPECT_EQ(e_.reads(op).size(), 6u);
}

TEST_F(EngineLimitsTest, OneMoreOfAnythingEndsThePropagationWithoutATrace) {
  const Program::Body over[] = {Says(4, 4, 5, 6), Says(3, 5, 5, 6), Says(3, 4, 6, 6),
                                Says(3, 4, 5, 7)};
  for (const Program::Body& body : over) {
    p_[1] = body;
    Request(1);
    EXPECT_EQ(RunOver(), "run 1@0");
    EXPECT_EQ(e_.overflowed(), p_.OperationOf(1));
    EXPECT_FALSE(e_.IsFromScratch());
    EXPECT_TRUE(e_.outputs(e_.overflowed()).empty());
    Unrequest(1);
    // Its results are released, though none was visible.
    const std::string log = Run();
    EXPECT_EQ(log.find('+'), std::string::npos) << log;
    EXPECT_EQ(log.find('-'), std::string::npos) << log;
    EXPECT_NE(log.find("free 100, free 101, free 102"), std::string::npos) << log;
    EXPECT_EQ(e_.operation_count(), 0u);
  }
}

TEST_F(EngineLimitsTest, WhatItSaidBeforeStaysUntilItIsSaidAgain) {
  p_[1] = Says(2, 4, 2, 3);
  Request(1);
  Run();
  p_[1] = Says(3, 4, 2, 7);
  Touch(1);
  EXPECT_EQ(RunOver(), "run 1@0");
  EXPECT_EQ(e_.outputs(p_.OperationOf(1)).size(), 2u);
  EXPECT_EQ(e_.reads(p_.OperationOf(1)).size(), 3u);
  p_[1] = Says(2, 4, 2, 3);
  EXPECT_EQ(Run(), "run 1@0, free 102");
}

TEST_F(EngineLimitsTest, NoMoreOperationsThanThereMayBe) {
  for (Item i = 0; i < 12; ++i) Request(20 + i);
  Run();
  p_[40] = Emits({7});
  Request(40);
  EXPECT_NE(RunOver().find("run 40@0"), std::string::npos);
  EXPECT_NE(e_.overflowed(), kNoOp);
  Unrequest(40);
  EXPECT_EQ(Run(), "free 7");
  EXPECT_EQ(e_.operation_count(), 12u);
}

}  // namespace
}  // namespace dynmesh::sac::testing
