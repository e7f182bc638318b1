// Prints a new tests/golden/hashes.txt; ends with 1 if a mesh differs from that of a run from
// scratch. With --verdicts: a new tests/golden/verdicts.txt. With --scripts: the edits of all
// cases.
#include <cstdio>
#include <string_view>
#include <utility>

#include "core/io/script/edit_script.h"
#include "dynmesh/dynamic_mesh.h"
#include "dynmesh/mesh.h"
#include "tests/golden/golden_cases.h"
#include "tests/golden/golden_verdicts.h"

namespace dynmesh::test {
namespace {

bool PrintHashes() {
  std::puts(
      "# Golden hashes: name, revisions, input, mesh, trace:operations, all revisions.\n"
      "# Made by dynmesh_golden_hashes. See golden_cases.h, and \"A change of bits\" in\n"
      "# CONTRIBUTING.md.");
  std::printf("# Bits %u\n", kMeshBits);
  bool good = true;
  bool had_diffs = false;
  for (const GoldenCase& golden : GoldenCases()) {
    if (golden.has_diffs && !std::exchange(had_diffs, true)) {
      std::puts("# The same, and: snapshots, diffs.");
    }
    const GoldenResult result = RunGoldenCase(golden);
    std::puts(result.line.c_str());
    if (!result.problem.empty()) {
      std::fprintf(stderr, "%s: %s\n", golden.name.c_str(), result.problem.c_str());
      good = false;
    }
  }
  return good;
}

// Each case as a line with its name, and its script with all batches, those that are refused, too.
void PrintScripts() {
  for (const GoldenCase& golden : GoldenCases()) {
    std::printf("case %s\n%s\n", golden.name.c_str(), io::FormatMeshLine(golden.options).c_str());
    const auto mesh = DynamicMesh::Create(golden.options).value();
    const GoldenCase::NextBatch next = golden.script();
    for (int done = 0; done < golden.batches; ++done) {
      const EditBatch batch = next(done, mesh->Features());
      for (const Edit& edit : batch) {
        std::puts(io::FormatEdit(edit, golden.options.dimension).c_str());
      }
      std::puts("commit");
      mesh->Apply(batch).IgnoreError();
    }
  }
}

void PrintVerdicts() {
  std::puts(
      "# Golden verdicts: name, status code, reason, features, edit, message.\n"
      "# Made by dynmesh_golden_hashes --verdicts. See golden_verdicts.h.");
  for (const std::string& line : VerdictLines()) std::puts(line.c_str());
}

}  // namespace
}  // namespace dynmesh::test

int main(int argc, char** argv) {
  if (argc > 1 && std::string_view(argv[1]) == "--verdicts") {
    dynmesh::test::PrintVerdicts();
    return 0;
  }
  if (argc > 1 && std::string_view(argv[1]) == "--scripts") {
    dynmesh::test::PrintScripts();
    return 0;
  }
  return dynmesh::test::PrintHashes() ? 0 : 1;
}
