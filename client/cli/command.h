// Shared by all commands of `dynmesh`: running, and reporting errors.
//
// A command's file offers one function, Register*Command, which adds a subcommand with its flags.
// If the user selects it, it fills the slot, and main runs that. Exit codes: 0 done, 1 failed, 2
// bad usage or bad input. Results go to standard output, all else to standard error.
#ifndef DYNMESH_CLIENT_CLI_COMMAND_H_
#define DYNMESH_CLIENT_CLI_COMMAND_H_

#include <functional>
#include <memory>
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

// A subcommand of `app` with --version. If selected, it puts `run` into `slot`, which must outlive
// `app`'s parsing.
CLI::App* AddCommand(CLI::App& app, CommandSlot& slot, const std::string& name,
                     const std::string& description, std::function<int()> run);

// Prints the error to standard error and returns its exit code.
int ReportError(const absl::Status& status);
int ExitCodeOf(const absl::Status& status);
void PrintWarning(std::string_view message);

// Writes text to standard output and flushes, so that the reader of a pipe sees it at once. False
// if that fails (a full disk, a closed pipe).
bool PrintOut(std::string_view text);

// Progress is shown only if standard error is a terminal.
bool ErrorIsTerminal();
bool OutIsTerminal();

class RemoteMesher;
// `remote` is null where remote/ is not built: then there is no --server.
void RegisterMeshCommand(CLI::App& app, CommandSlot& slot, std::shared_ptr<RemoteMesher> remote);
void RegisterReplayCommand(CLI::App& app, CommandSlot& slot);
void RegisterImportCommand(CLI::App& app, CommandSlot& slot);
void RegisterVerifyCommand(CLI::App& app, CommandSlot& slot);
void RegisterDiffCommand(CLI::App& app, CommandSlot& slot);
// All commands that use a server; only where remote/ is built. Its CMakeLists links it to
// dynmesh_cli and defines DYNMESH_CLI_REMOTE there.
void RegisterRemoteCommands(CLI::App& app, CommandSlot& slot);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_COMMAND_H_
