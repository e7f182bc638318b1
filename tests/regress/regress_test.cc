// Every script in this folder is replayed, and each revision compared with a run from
// scratch. A script's first lines say what it shows.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/io/script/edit_script.h"
#include "tests/differential/differential.h"
#include "tests/support/source_path.h"

namespace dynmesh::test {
namespace {

std::vector<std::string> Scripts() {
  std::vector<std::string> names;
  const std::filesystem::path folder = SourcePath("tests/regress");
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() == ".dynmesh") names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

class Regress : public ::testing::TestWithParam<std::string> {};

TEST_P(Regress, EveryRevisionIsThatOfARunFromScratch) {
  const auto script = io::ReadEditScript(SourcePath("tests/regress/") + GetParam() + ".dynmesh");
  ASSERT_TRUE(script.ok()) << script.status().ToString();
  const bool is_planar = script->dimension == 2;
  const double asked = script->Options().quality, finest = is_planar ? 1.0 : kDefaultQuality2D,
               least_of_thesis = is_planar ? kDefaultQuality2D : kDefaultQuality3D;
  for (const auto& [quality, criterion] :
       {std::pair(2.0, Criterion::kEdge), std::pair(asked, Criterion::kEdge),
        std::pair(finest, Criterion::kEdge),
        std::pair(std::max(asked, least_of_thesis), Criterion::kThesis)}) {
    MeshOptions options = script->Options();
    options.quality = quality;
    options.criterion = criterion;
    const auto mesh = NewMesh(options);
    for (std::size_t b = 0; b < script->batches.size(); ++b) {
      const auto diff = mesh->Apply(script->batches[b].edits, ApplyOptions{});
      ASSERT_TRUE(diff.ok()) << script->Where(b, std::nullopt) << diff.status().ToString();
      for (const bool local : {false, true}) {
        EXPECT_EQ(CompareWithScratch(*mesh, local).what, "")
            << script->Where(b, std::nullopt) << ", rho " << quality
            << (criterion == Criterion::kEdge ? "" : ", thesis's criterion");
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scripts, Regress, ::testing::ValuesIn(Scripts()), [](const auto& script) {
  std::string name = script.param;
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
});

}  // namespace
}  // namespace dynmesh::test
