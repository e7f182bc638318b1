// Runs every file of tests/fuzz/corpus/TARGET (seeds) and tests/fuzz/found/TARGET (former failures)
// through its target, in the ordinary test run, without a fuzzer.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <ostream>
#include <string>
#include <vector>

#include "tests/fuzz/targets.h"
#include "tests/support/source_path.h"

namespace dynmesh::fuzz {
namespace {

struct Target {
  const char* name;
  std::string (*run)(std::string_view);
  friend std::ostream& operator<<(std::ostream& out, const Target& t) { return out << t.name; }
};

constexpr Target kTargets[] = {
    {"edit_script", &FuzzEditScript},
    {"planar_input", &FuzzPlanarInput},
    {"space_input", &FuzzSpaceInput},
    {"elements", &FuzzElements},
    {"sizes", &FuzzSizes},
#ifdef DYNMESH_FUZZ_SURFACES
    {"surfaces", &FuzzSurfaces},
#endif
#ifdef DYNMESH_FUZZ_MESH_FILES
    {"mesh_files", &FuzzMeshFiles},
#endif
#ifdef DYNMESH_FUZZ_MESH_INPUT
    {"mesh_input", &FuzzMeshInput},
#endif
#ifdef DYNMESH_FUZZ_WIRE
    {"requests", &FuzzRequests},
    {"answers", &FuzzAnswers},
    {"journal", &FuzzJournal},
#endif
    {"batches", &FuzzBatches},
    {"space_batches", &FuzzSpaceBatches},
};

std::vector<std::filesystem::path> FilesOf(const char* target) {
  std::vector<std::filesystem::path> files;
  for (const char* kind : {"corpus", "found"}) {
    const auto folder = std::filesystem::path(test::SourcePath("tests/fuzz")) / kind / target;
    if (!std::filesystem::exists(folder)) continue;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      files.push_back(entry.path());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string ReadBytes(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Corpus : public ::testing::TestWithParam<Target> {};

TEST_P(Corpus, GoesThrough) {
  const std::vector<std::filesystem::path> files = FilesOf(GetParam().name);
  EXPECT_FALSE(files.empty());
  for (const auto& file : files) {
    SCOPED_TRACE(file.string());
    EXPECT_EQ(GetParam().run(ReadBytes(file)), "");
  }
}

TEST_P(Corpus, GoesThroughCutShort) {
  for (const auto& file : FilesOf(GetParam().name)) {
    SCOPED_TRACE(file.string());
    const std::string bytes = ReadBytes(file);
    for (const std::size_t part : {1, 2, 3}) {
      EXPECT_EQ(GetParam().run(bytes.substr(0, bytes.size() * part / 4)), "") << part;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, Corpus, ::testing::ValuesIn(kTargets),
                         [](const auto& target) { return target.param.name; });

}  // namespace
}  // namespace dynmesh::fuzz
