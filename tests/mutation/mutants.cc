#include "tests/mutation/mutants.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <thread>

#include "tests/support/temp_folder.h"

namespace dynmesh::test {
namespace {

constexpr char kMutant[] = "--mutant=";
constexpr std::chrono::seconds kDeadline(600);  // with sanitizers, too

struct Outcome {
  bool ended = false;
  int status = 0;  // as of waitpid
  std::string output;
};

// Runs this program's tests that `filter` names, with that mutant.
Outcome RunTests(const std::string& mutant, const std::string& filter) {
  const TempFolder folder;
  const std::string log = folder.path() + "/log";
  std::vector<std::string> words = {"/proc/self/exe", kMutant + mutant, "--gtest_filter=" + filter,
                                    "--gtest_fail_fast", "--gtest_brief=1"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    unsetenv("GTEST_OUTPUT");
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  Outcome outcome;
  const auto end = std::chrono::steady_clock::now() + kDeadline;
  while (!(outcome.ended = waitpid(child, &outcome.status, WNOHANG) == child) &&
         std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  if (!outcome.ended) {
    kill(child, SIGKILL);
    waitpid(child, &outcome.status, 0);
  }
  std::ifstream in(log);
  outcome.output = {std::istreambuf_iterator<char>(in), {}};
  constexpr std::size_t kMost = 4000;
  if (outcome.output.size() > kMost) outcome.output.resize(kMost);
  return outcome;
}

TEST_P(MutantTest, IsNoticed) {
  const Mutant& mutant = GetParam();
  const Outcome outcome = RunTests(mutant.name, mutant.tests);
  ASSERT_TRUE(outcome.ended) << "the tests did not end in " << kDeadline.count() << " s\n"
                             << outcome.output;
  ASSERT_TRUE(WIFEXITED(outcome.status)) << "crashed\n" << outcome.output;
  EXPECT_EQ(WEXITSTATUS(outcome.status), 1) << "survived " << mutant.tests << "\n"
                                            << outcome.output;
}

INSTANTIATE_TEST_SUITE_P(All, MutantTest, testing::ValuesIn(Mutants().begin(), Mutants().end()),
                         NameOf);

// Otherwise mutants would be noticed by tests that fail anyway.
TEST(NoMutant, LetsTheTestsPass) {
  std::set<std::string> all;
  for (const Mutant& mutant : Mutants()) all.insert(mutant.tests);
  std::string filter;
  for (const std::string& tests : all) filter += (filter.empty() ? "" : ":") + tests;
  const Outcome outcome = RunTests("", filter);
  ASSERT_TRUE(outcome.ended) << "the tests did not end in " << kDeadline.count() << " s";
  ASSERT_TRUE(WIFEXITED(outcome.status)) << "crashed\n" << outcome.output;
  EXPECT_EQ(WEXITSTATUS(outcome.status), 0) << outcome.output;
  EXPECT_EQ(outcome.output.find("no test"), std::string::npos) << outcome.output;
}

// Takes the argument that names a mutant. Returns false if there is no such mutant.
bool Apply(const char* name) {
  if (*name == '\0') return true;
  const auto all = Mutants();
  const auto found = std::ranges::find_if(
      all, [&](const Mutant& mutant) { return std::strcmp(mutant.name, name) == 0; });
  if (found == all.end()) return false;
  found->apply();
  return true;
}

}  // namespace

std::string NameOf(const testing::TestParamInfo<Mutant>& given) { return given.param.name + 1; }

std::ostream& operator<<(std::ostream& out, const Mutant& mutant) { return out << mutant.name; }

}  // namespace dynmesh::test

int main(int argc, char** argv) {
  for (int i = 1; i < argc; ++i) {
    const std::size_t length = std::strlen(dynmesh::test::kMutant);
    if (std::strncmp(argv[i], dynmesh::test::kMutant, length) != 0) continue;
    if (!dynmesh::test::Apply(argv[i] + length)) {
      std::cerr << "no mutant has the name " << argv[i] + length << "\n";
      return 2;
    }
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
