// A dynmeshd of its own, as a process, on a free port.
#ifndef DYNMESH_TESTS_E2E_DAEMON_H_
#define DYNMESH_TESTS_E2E_DAEMON_H_

#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/deadline.h"

namespace dynmesh::test {

class Daemon {
 public:
  // Port file and log go to the folder, which outlives it.
  explicit Daemon(std::string folder) : folder_(std::move(folder)) {}
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;
  ~Daemon() {
    if (child_ > 0) End(SIGKILL);
  }

  // Does not wait until it has come up. False if there is no process.
  bool Spawn(std::vector<std::string> arguments = {}, const char* listen = "127.0.0.1:0") {
    const std::string log = folder_ + "/log";
    std::filesystem::remove(PortFile());
    arguments.insert(arguments.begin(),
                     {"dynmeshd", "--listen", listen, "--port-file", PortFile()});
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::fflush(nullptr);  // or the child would write it once more
    child_ = fork();
    if (child_ == 0) {
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // it does not outlive the test
      if (std::freopen(log.c_str(), "a", stderr) == nullptr) _exit(126);
      if (std::freopen("/dev/null", "w", stdout) == nullptr) _exit(126);
      execv(DYNMESHD_BINARY, argv.data());
      _exit(127);
    }
    return child_ > 0;
  }

  // False if it does not come up: it ends, or it does nothing for `limit`. On a busy machine a
  // start may take longer than that.
  bool Start(std::vector<std::string> arguments = {}, const char* listen = "127.0.0.1:0",
             std::chrono::seconds limit = std::chrono::seconds(60)) {
    if (!Spawn(std::move(arguments), listen)) return false;
    auto deadline = std::chrono::steady_clock::now() + limit;
    std::uint64_t work = 0;
    while (!std::filesystem::exists(PortFile())) {
      if (const std::uint64_t now = Work(); now != work) {
        work = now;
        deadline = std::chrono::steady_clock::now() + limit;
      }
      if (std::chrono::steady_clock::now() > deadline) return false;
      if (int status = 0; waitpid(child_, &status, WNOHANG) == child_) {
        child_ = 0;
        exit_code_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
        return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    std::string port;
    std::ifstream(PortFile()) >> port;
    address_ = "127.0.0.1:" + port;
    return !port.empty();
  }

  const std::string& address() const { return address_; }
  pid_t process() const { return child_; }  // 0 if it does not run
  // The log of one that did not start.
  int exit_code() const { return exit_code_; }

  void Signal(int signal) const {
    kill(child_, signal);
    // Until all its threads are stopped: one may still answer a call after the signal was sent.
    siginfo_t stopped;
    if (signal == SIGSTOP) waitid(P_PID, static_cast<id_t>(child_), &stopped, WSTOPPED);
  }

  // The exit code after that signal; -1 if the signal ended it.
  int End(int signal) {
    kill(child_, signal);
    const int status = WaitForEnd(std::exchange(child_, 0));
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }

  // It has ended and was waited for.
  void Forget() { child_ = 0; }

  std::string Log() const {
    std::ostringstream text;
    text << std::ifstream(folder_ + "/log").rdbuf();
    return text.str();
  }

 private:
  // Grows while the process does something: its processor time, and the bytes that it read and
  // wrote.
  std::uint64_t Work() const {
    const std::string proc = "/proc/" + std::to_string(child_);
    std::uint64_t sum = 0;
    std::ifstream io(proc + "/io");
    std::string word;
    for (std::uint64_t value = 0; io >> word >> value;) sum += value;
    std::ifstream stat(proc + "/stat");
    std::getline(stat, word, ')');  // the name may have spaces
    std::uint64_t value = 0;
    for (int field = 3; field <= 15 && stat >> word; ++field) {
      if (field >= 14 &&
          std::from_chars(word.data(), word.data() + word.size(), value).ec == std::errc())
        sum += value;
    }
    return sum;
  }

  std::string PortFile() const { return folder_ + "/port"; }

  const std::string folder_;
  pid_t child_ = 0;
  int exit_code_ = 0;
  std::string address_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_E2E_DAEMON_H_
