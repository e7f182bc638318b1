// Prints a new tests/golden/hashes.txt; ends with 1 if a mesh differs from that of a run from
// scratch. With --verdicts: a new tests/golden/verdicts.txt.
#include <cstdio>
#include <cstring>

#include "dynmesh/mesh.h"
#include "tests/golden/golden_cases.h"
#include "tests/golden/verdicts.h"

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "--verdicts") == 0) {
    for (const std::string& line : dynmesh::test::Verdicts()) std::puts(line.c_str());
    return 0;
  }
  std::puts(
      "# Golden hashes: name, revisions, input, mesh, trace:operations, all revisions.\n"
      "# Made by dynmesh_golden_hashes. See golden_cases.h, and \"A change of bits\" in\n"
      "# CONTRIBUTING.md.");
  std::printf("# Bits %u\n", dynmesh::kMeshBits);
  bool good = true;
  for (const dynmesh::test::GoldenCase& golden : dynmesh::test::GoldenCases()) {
    const dynmesh::test::GoldenResult result = dynmesh::test::RunGoldenCase(golden);
    std::puts(result.line.c_str());
    if (!result.problem.empty()) {
      std::fprintf(stderr, "%s: %s\n", golden.name.c_str(), result.problem.c_str());
      good = false;
    }
  }
  return good ? 0 : 1;
}
