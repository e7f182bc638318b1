// Meshes and complete traces of many inputs have the hashes that hashes.txt records. A change of
// one of them is a change of the product: see "A change of bits" in CONTRIBUTING.md.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <string>

#include "dynmesh/mesh.h"
#include "tests/golden/golden_cases.h"
#include "tests/support/source_path.h"

namespace dynmesh::test {
namespace {

// The lines of hashes.txt by the names of their cases.
std::map<std::string, std::string> Recorded() {
  std::map<std::string, std::string> lines;
  std::ifstream file(test::SourcePath("tests/golden/hashes.txt"));
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::string name;
    std::istringstream(line) >> name;
    EXPECT_TRUE(lines.emplace(name, line).second) << name << " stands twice";
  }
  return lines;
}

std::vector<std::string> Words(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

class Golden : public testing::TestWithParam<std::size_t> {};

TEST_P(Golden, MeshAndTraceAreThoseRecorded) {
  const GoldenCase& golden = GoldenCases()[GetParam()];
  const auto recorded = Recorded();
  ASSERT_TRUE(recorded.contains(golden.name)) << "hashes.txt has no line of it";
  const GoldenResult result = RunGoldenCase(golden);
  EXPECT_EQ(result.problem, "");
  const auto ours = Words(result.line), theirs = Words(recorded.at(golden.name));
  ASSERT_EQ(ours.size(), theirs.size());
  ASSERT_EQ(ours[2], theirs[2]) << "this machine makes another input; the hashes say nothing";
  EXPECT_EQ(ours, theirs) << "now: " << result.line;
}

INSTANTIATE_TEST_SUITE_P(Cases, Golden, testing::Range<std::size_t>(0, GoldenCases().size()),
                         [](const auto& given) { return GoldenCases()[given.param].name; });

// New hashes of meshes require a new number of bits (kMeshBits).
TEST(GoldenHashes, AreOfTheBitsThatTheProductTells) {
  std::ifstream file(test::SourcePath("tests/golden/hashes.txt"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  EXPECT_NE(text.find("# Bits " + std::to_string(kMeshBits) + "\n"), std::string::npos);
}

TEST(GoldenHashes, EveryLineIsOfACase) {
  std::set<std::string> names;
  for (const GoldenCase& golden : GoldenCases()) names.insert(golden.name);
  EXPECT_EQ(names.size(), GoldenCases().size()) << "two cases have one name";
  for (const auto& [name, line] : Recorded()) EXPECT_TRUE(names.contains(name)) << name;
}

}  // namespace
}  // namespace dynmesh::test
