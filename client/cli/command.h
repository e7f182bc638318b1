// What all commands of `dynmesh` share: how they are run, how they fail.
//
// A command's file offers one function, Register*Command, which adds a subcommand
// with its flags; when the user picks it, it fills the slot, and main runs that.
// Exit codes: 0 done, 1 failed, 2 bad usage or bad input. Results go to standard
// output, everything else to standard error.
#ifndef DYNMESH_CLIENT_CLI_COMMAND_H_
#define DYNMESH_CLIENT_CLI_COMMAND_H_

#include <functional>
#include <string>
#include <string_view>

#include "CLI/CLI.hpp"
#include "absl/status/status.h"

namespace dynmesh::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;
inline constexpr int kExitBadInput = 2;

struct CommandSlot {
  std::function<int()> run;  // returns the exit code
};

// "dynmesh 1.2.3", for --version; every subcommand gets the flag.
std::string VersionText();

// A subcommand of `app` with --version that, when picked, puts `run` into `slot`.
// `slot` must outlive `app`'s parsing.
CLI::App* AddCommand(CLI::App& app, CommandSlot& slot, const std::string& name,
                     const std::string& description, std::function<int()> run);

// Says what went wrong on standard error and returns the exit code for it.
int ReportError(const absl::Status& status);
int ExitCodeOf(const absl::Status& status);
void PrintWarning(std::string_view message);

// Puts text on standard output at once, so that a reader at the other end of a pipe
// sees it. False if that is not possible (a full disk, a closed pipe).
bool PrintOut(std::string_view text);

// Progress is for people: only where standard error is a terminal.
bool ErrorIsTerminal();
bool OutIsTerminal();

void RegisterMeshCommand(CLI::App& app, CommandSlot& slot);
void RegisterReplayCommand(CLI::App& app, CommandSlot& slot);
void RegisterImportCommand(CLI::App& app, CommandSlot& slot);
void RegisterVerifyCommand(CLI::App& app, CommandSlot& slot);
void RegisterDiffCommand(CLI::App& app, CommandSlot& slot);
// All commands that talk to a server; only where remote/ is built, whose CMakeLists
// links itself to dynmesh_cli and defines DYNMESH_CLI_REMOTE there.
void RegisterRemoteCommands(CLI::App& app, CommandSlot& slot);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_COMMAND_H_
