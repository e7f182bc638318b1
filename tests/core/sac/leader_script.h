// Random scripts of edits for leader_program.h, and the invariants after each.
#ifndef DYNMESH_TESTS_CORE_SAC_LEADER_SCRIPT_H_
#define DYNMESH_TESTS_CORE_SAC_LEADER_SCRIPT_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/core/sac/leader_changes.h"
#include "tests/core/sac/leader_oracle.h"
#include "tests/core/sac/leader_program.h"
#include "tests/core/sac/random_script.h"

namespace dynmesh::sac::testing {

using Input = std::map<Position, Weight>;
using Traced = LeaderProgram<Engine>;
using Untraced = LeaderProgram<UntracedEngine>;

// The point at x gets a weight, or none: then it is not there.
struct Edit {
  Position x;
  bool present;
  Weight weight = 0;
};
using Batch = std::vector<Edit>;  // applied together

inline Edit StateOf(const Input& input, Position x) {
  const auto it = input.find(x);
  return it == input.end() ? Edit{x, false} : Edit{x, true, it->second};
}

// Applies the batch to both; returns the batch that undoes it.
inline Batch Apply(const Batch& batch, Traced* program, Input* input) {
  Batch inverse;
  for (const Edit& e : batch) {
    inverse.push_back(StateOf(*input, e.x));
    const bool was = inverse.back().present;
    if (was && e.present) {
      program->SetWeight(e.x, e.weight);
    } else if (was) {
      program->Remove(e.x);
    } else if (e.present) {
      program->Add(e.x, e.weight);
    }
    if (e.present) {
      (*input)[e.x] = e.weight;
    } else {
      input->erase(e.x);
    }
  }
  std::reverse(inverse.begin(), inverse.end());
  return inverse;
}

inline Input RandomInput(const Line& line, std::size_t count, Weight weights, Random& random) {
  Input input;
  while (input.size() < count) input[random.Below(line.side())] = random.Below(weights);
  return input;
}

// Adds, removes, reweighs, or takes a point away and puts it back in one batch.
inline Batch RandomBatch(const Line& line, const Input& input, std::size_t aim, Weight weights,
                         Random& random) {
  Batch batch;
  Input now = input;
  for (int edits = random.OneIn(3) ? 3 : 1; edits > 0; --edits) {
    const bool grow = now.empty() || random.Below(2 * aim) >= now.size();
    Position x = random.Below(line.side());
    if (!now.empty() && (!grow || random.OneIn(3))) {
      auto it = now.lower_bound(x);
      if (it == now.end()) it = now.begin();
      x = it->first;
    }
    const bool was = now.contains(x);
    if (was && random.OneIn(4)) batch.push_back({x, false});  // and comes back below
    if (was && !grow) {
      batch.push_back({x, false});
      now.erase(x);
    } else {
      batch.push_back({x, true, random.Below(weights)});
      now[x] = batch.back().weight;
    }
  }
  return batch;
}

inline void AddAll(const Input& input, Traced* program) {
  for (const auto& [x, weight] : input) program->Add(x, weight);
}

// The hash of the trace, which must be sound.
inline std::uint64_t SoundTrace(const Traced& program) {
  std::vector<std::string> problems;
  const std::uint64_t hash = program.Audit(&problems);
  for (const std::string& p : problems) ADD_FAILURE() << p;
  return hash;
}

inline std::uint64_t TraceFromScratch(const Line& line, const Input& input) {
  Traced program(line);
  AddAll(input, &program);
  EXPECT_TRUE(program.Propagate());
  return SoundTrace(program);
}

// Result and complete trace are those of a run from scratch.
inline void ExpectAsFromScratch(const Traced& program, const Line& line, const Input& input) {
  ASSERT_EQ(program.Rows(), LeadersByDefinition(input, line));
  ASSERT_EQ(SoundTrace(program), TraceFromScratch(line, input));
}

inline void PrintTo(const LeaderRow& r, std::ostream* os) {
  *os << (r.is_link ? "link" : "summit") << "{level " << r.level << ", " << r.x << " -> "
      << r.leader << ", value " << r.value << (r.deposed ? ", deposed}" : "}");
}

}  // namespace dynmesh::sac::testing

#endif  // DYNMESH_TESTS_CORE_SAC_LEADER_SCRIPT_H_
