// Linked into every test program: a test that does not end fails with a message, shortly before
// CTest would end it without one (tests/run). No thread: an alarm. A child process has none.
#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace dynmesh::test {
namespace {

constexpr unsigned kSeconds = 840;
char message[400];

extern "C" void Fail(int) {
  (void)!write(STDERR_FILENO, message, std::strlen(message));
  _exit(1);
}

class Deadline : public testing::EmptyTestEventListener {
  void OnTestStart(const testing::TestInfo& test) override {
    std::snprintf(message, sizeof message, "%s.%s did not end in %u s\n", test.test_suite_name(),
                  test.name(), kSeconds);
    signal(SIGALRM, &Fail);
    alarm(kSeconds);
  }
  void OnTestEnd(const testing::TestInfo&) override { alarm(0); }
};

// Nightly settings take longer.
[[maybe_unused]] const bool is_on = [] {
  if (std::getenv("DYNMESH_NIGHTLY") == nullptr) {
    testing::UnitTest::GetInstance()->listeners().Append(new Deadline);
  }
  return true;
}();

}  // namespace
}  // namespace dynmesh::test
