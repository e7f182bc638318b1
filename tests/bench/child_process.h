// Runs a program to its end and measures it: for peers that are separate programs.
#ifndef DYNMESH_TESTS_BENCH_CHILD_PROCESS_H_
#define DYNMESH_TESTS_BENCH_CHILD_PROCESS_H_

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>
#include <string>
#include <vector>

namespace dynmesh {

// Processor time of the process, user's and system's, from its start to its end.
// `arguments` begin with the program: a path, or a name searched in PATH. Its output goes to the
// file `output`. Nothing if it cannot be run or fails.
inline std::optional<double> SecondsOfProcess(const std::vector<std::string>& arguments,
                                              const std::string& output) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const pid_t pid = fork();
  if (pid < 0) return std::nullopt;
  if (pid == 0) {
    const int file = open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    if (file < 0 || dup2(file, 1) < 0 || dup2(file, 2) < 0) _exit(127);
    execvp(argv[0], argv.data());
    _exit(127);
  }
  int status = 0;
  rusage usage = {};
  if (wait4(pid, &status, 0, &usage) != pid) return std::nullopt;
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return std::nullopt;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace dynmesh

#endif  // DYNMESH_TESTS_BENCH_CHILD_PROCESS_H_
