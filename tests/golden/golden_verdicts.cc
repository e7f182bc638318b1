#include "tests/golden/golden_verdicts.h"

#include "tests/golden/verdict_scene.h"

namespace dynmesh::test {

std::vector<std::string> VerdictLines() {
  std::vector<std::string> lines;
  AddPlanarVerdicts(lines);
  AddSpaceVerdicts(lines);
  AddOptionVerdicts(lines);
  AddLimitVerdicts(lines);
  return lines;
}

}  // namespace dynmesh::test
