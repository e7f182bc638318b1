// The greatest of 1,024 values through 2,000 changes: runs maximum_program.h, tells what the last
// changes ran again and because of what, and compares with a search of all values. At the end the
// trace must be that of a run from scratch.
//
//   c++ -std=c++20 maximum.cc $(pkg-config --cflags --libs dynmesh) && ./a.out
#include <dynmesh/sac/propagation_log.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <map>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "maximum_program.h"

namespace {

constexpr int kHeight = 10;
constexpr int kChanges = 2000, kShown = 5;

// Propagates; says, if `show`, which nodes ran again.
void Propagate(MaximumProgram& program, dynmesh::sac::PropagationLog<MaximumProgram::Engine>& log,
               bool show) {
  program.engine().Propagate([&log] {
    log.Look();
    return false;
  });
  log.Look();
  if (!show) return;
  for (const dynmesh::sac::MadeStale& stale : log.made_stale()) {
    if (stale.by == dynmesh::sac::kNoOp) {
      std::printf("  node %u: the input changed\n", program.NodeOf(stale.op));
    } else {
      std::printf("  node %u: the value of node %u changed\n", program.NodeOf(stale.op),
                  program.NodeOf(stale.by));
    }
  }
}

std::optional<std::int64_t> GreatestOf(const std::map<std::uint32_t, std::int64_t>& values) {
  std::optional<std::int64_t> greatest;
  for (const auto& [index, value] : values) greatest = std::max(greatest.value_or(value), value);
  return greatest;
}

}  // namespace

int main() {
  MaximumProgram program(kHeight);
  std::map<std::uint32_t, std::int64_t> values;  // the same, for the search
  std::mt19937 random(1);
  std::uint64_t ran = 0;
  for (int change = 0; change < kChanges; ++change) {
    const std::uint32_t index = random() % (1u << kHeight);
    dynmesh::sac::PropagationLog log(program.engine());
    if (change % 4 == 3) {
      program.Remove(index);
      values.erase(index);
    } else {
      const std::int64_t value = static_cast<std::int64_t>(random() % 1000) - 500;
      program.Set(index, value);
      values[index] = value;
    }
    const bool show = change >= kChanges - kShown;
    if (show) std::printf("a change of value %u\n", index);
    Propagate(program, log, show);
    ran += log.ran().size();
    if (program.Greatest() != GreatestOf(values)) {
      std::printf("change %d: the greatest value is wrong\n", change);
      return 1;
    }
  }
  std::printf("%d changes of up to %d values: %.1f operations each\n", kChanges, 1 << kHeight,
              static_cast<double>(ran) / kChanges);

  MaximumProgram scratch(kHeight);
  for (const auto& [index, value] : values) scratch.Set(index, value);
  scratch.engine().Propagate();
  std::vector<std::string> problems;
  if (program.HashOfTrace(&problems) != scratch.HashOfTrace(&problems) || !problems.empty()) {
    std::printf("the trace is not that of a run from scratch\n");
    for (const std::string& problem : problems) std::printf("  %s\n", problem.c_str());
    return 1;
  }
  std::printf("the trace is that of a run from scratch\n");
  return 0;
}
