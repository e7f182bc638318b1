// The remote commands of `dynmesh`, and `mesh`, run in the test's own process.
#ifndef DYNMESH_TESTS_E2E_RUN_DYNMESH_H_
#define DYNMESH_TESTS_E2E_RUN_DYNMESH_H_

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "client/cli/remote/remote_commands.h"
#include "client/cli/remote_mesher.h"

namespace dynmesh::cli {

struct Ran {
  int code = 0;
  std::string out, err;
};

// Runs `dynmesh ARGUMENTS` in this process.
inline Ran RunDynmesh(std::vector<std::string> arguments) {
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Ran ran;
  CLI::App app("", "dynmesh");
  app.require_subcommand(1);
  CommandSlot slot;
  RegisterMeshCommand(app, slot, MakeRemoteMesher());
  RegisterRemoteCommands(app, slot);
  std::reverse(arguments.begin(), arguments.end());
  try {
    app.parse(arguments);
    ran.code = slot.run();
  } catch (const CLI::ParseError& error) {
    ran.code = app.exit(error) == 0 ? kExitDone : kExitBadInput;
  }
  std::fflush(stdout);
  ran.out = testing::internal::GetCapturedStdout();
  ran.err = testing::internal::GetCapturedStderr();
  return ran;
}

}  // namespace dynmesh::cli

#endif  // DYNMESH_TESTS_E2E_RUN_DYNMESH_H_
