// An operation executed again beside its record: what counts as a difference, and that nothing is
// committed.
#include "core/sac/engine_audit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <string>
#include <vector>

#include "tests/core/sac/engine_fixture.h"

namespace dynmesh::sac::testing {
namespace {

class EngineAudit : public EngineTest {
 protected:
  // What differs; empty if nothing does. Items read words and keep a payload.
  std::string Again(Item item) {
    std::string why;
    const auto same = [this](OpId id, int payload, std::span<const std::uint32_t> reads) {
      return payload == e_.payload(id) && std::ranges::equal(reads, e_.reads(id));
    };
    const bool is_same = e_.Reproduces(p_.OperationOf(item), same, &why);
    EXPECT_EQ(is_same, why.empty());
    return why;
  }
};

TEST_F(EngineAudit, WithoutAChangeAnOperationIsReproduced) {
  p_[1] = [](Context& c) {
    c.Emit(7);
    c.Read(3);
    c.payload() += 5;  // from an empty one
    c.Request(kOnly, 2, 1);
    c.Subscribe(0);
  };
  Request(1);
  Run();
  EXPECT_EQ(Again(1), "");
  EXPECT_EQ(Again(2), "");
  EXPECT_EQ(p_.TakeLog(), "run 1@0, run 2@1");
}

TEST_F(EngineAudit, AMissedChangeShows) {
  Output made = 7;
  Item requested = 2;
  std::uint32_t read = 3;
  int kept = 5;
  p_[1] = [&](Context& c) {
    c.Emit(made);
    c.Read(read);
    c.payload() = kept;
    c.Request(kOnly, requested, 1);
  };
  Request(1);
  Run();
  const Counters before = e_.counters();
  made = 8;
  EXPECT_EQ(Again(1), "outputs");
  EXPECT_EQ(p_.TakeLog(), "run 1@0, free 8") << "what it made in vain is released";
  made = 7, requested = 4;
  EXPECT_EQ(Again(1), "requests");
  requested = 2, read = 9;
  EXPECT_EQ(Again(1), "reads");
  read = 3, kept = 6;
  EXPECT_EQ(Again(1), "reads");
  kept = 5;
  EXPECT_EQ(Again(1), "");
  // Nothing is committed.
  const OpId op = p_.OperationOf(1);
  EXPECT_EQ(e_.payload(op), 5);
  EXPECT_EQ(e_.outputs(op)[0], 7u);
  EXPECT_EQ(e_.reads(op)[0], 3u);
  EXPECT_TRUE(e_.executed(op));
  EXPECT_EQ(e_.counters().executed, before.executed);
  EXPECT_EQ(e_.operation_count(), 2u);
  p_.TakeLog();
  EXPECT_EQ(Run(), "");
}

TEST_F(EngineAudit, ItRunsAsForTheFirstTimeBesideItsOutputs) {
  bool first = false;
  std::size_t outputs = 0, reads = 9;
  p_[1] = [&](Context& c) {
    first = c.first_time();
    outputs = c.old_outputs().size();
    reads = c.old_reads().size();
    c.Emit(7);
    c.Read(3);
  };
  Request(1);
  Run();
  Touch(1);
  Run();
  EXPECT_FALSE(first);
  EXPECT_EQ(reads, 1u);
  EXPECT_EQ(Again(1), "");
  EXPECT_TRUE(first);
  EXPECT_EQ(outputs, 1u);
  EXPECT_EQ(reads, 0u);
}

TEST_F(EngineAudit, TheOrderOfOutputsAndRequestsDoesNotCount) {
  bool turned = false;
  p_[1] = [&](Context& c) {
    for (const Output o : turned ? std::vector<Output>{8, 7} : std::vector<Output>{7, 8}) c.Emit(o);
    for (const Item i : turned ? std::vector<Item>{3, 2} : std::vector<Item>{2, 3}) {
      c.Request(kOnly, i, 1);
    }
  };
  Request(1);
  Run();
  turned = true;
  EXPECT_EQ(Again(1), "");
}

TEST_F(EngineAudit, StateIsReadAsOfItsTime) {
  std::vector<bool> sees;  // operation 2: the times of 1 and 3
  p_[2] = [&](Context& c) {
    for (const Item i : {1, 3}) {
      const Stamp stamp = e_.stamp(p_.OperationOf(i));
      sees.push_back(stamp != kNoStamp && c.Sees(stamp));
    }
  };
  for (const Item i : {1, 2, 3}) Request(i);
  Run();
  sees.clear();
  EXPECT_EQ(Again(2), "");
  EXPECT_EQ(sees, (std::vector<bool>{true, false}));
}

}  // namespace
}  // namespace dynmesh::sac::testing
