// The `dynmesh` command. To add a command: write a file with Register*Command (command.h), and add
// one line below.
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "CLI/CLI.hpp"
#include "client/cli/command.h"
#include "client/cli/help_pages.h"
#include "client/cli/remote_mesher.h"
#include "core/base/process_memory.h"
#include "core/base/text.h"

namespace dynmesh::cli {
namespace {

void SetUp(CLI::App& app) {
  app.set_version_flag("--version", VersionText());
  app.require_subcommand(0, 1);
  app.failure_message(CLI::FailureMessage::simple);
}

void RegisterMesh(CLI::App& app, CommandSlot& slot) {
#ifdef DYNMESH_CLI_REMOTE
  RegisterMeshCommand(app, slot, MakeRemoteMesher());
#else
  RegisterMeshCommand(app, slot, nullptr);
#endif
}

constexpr std::pair<std::string_view, void (*)(CLI::App&, CommandSlot&)> kLocal[] = {
    {"mesh", RegisterMesh},
    {"replay", RegisterReplayCommand},
    {"import", RegisterImportCommand},
    {"verify", RegisterVerifyCommand},
    {"diff", RegisterDiffCommand},
};

// Runs the command line if it begins with one of those, and is right. Only that one is registered:
// the flags of all take longer than a small mesh. Returns the exit code.
std::optional<int> RunLocal(int argc, char** argv) {
  // CLI11 lists flags that exclude each other by address: help is that of flags registered first.
  for (int i = 1; i < argc; ++i) {
    if (argv[i] == std::string_view("--help") || argv[i] == std::string_view("-h")) return {};
  }
  for (const auto& [name, add] : kLocal) {
    if (argc < 2 || argv[1] != name) continue;
    CLI::App app;
    SetUp(app);
    CommandSlot slot;
    add(app, slot);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError&) {
      return std::nullopt;  // an error, which is told with all commands at hand
    }
    if (slot.run) return slot.run();
  }
  return std::nullopt;
}

int Main(int argc, char** argv) {
  if (const std::optional<int> code = RunLocal(argc, argv)) return *code;
  CLI::App app("Dynamic Delaunay meshes: from scratch, edit by edit, and proof of both.",
               "dynmesh");
  SetUp(app);
  CommandSlot slot;
  for (const auto& [name, add] : kLocal) add(app, slot);
#ifdef DYNMESH_CLI_REMOTE
  RegisterRemoteCommands(app, slot);
#endif
  RegisterHelpCommand(app, slot);
  AddExamples(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // CLI11 reports help and version as errors with code 0. It has a code for each kind of bad
    // usage; here all have the same.
    if (error.get_exit_code() == 0) return app.exit(error), kExitDone;
    return ReportError(absl::InvalidArgumentError(
        text::Concat(error.what(), Suggestion(app, {argv + 1, argv + argc}),
                     "\nRun with --help for more information.")));
  }
  if (slot.run) return slot.run();
  std::fputs(app.help().c_str(), stderr);
  return kExitBadInput;
}

}  // namespace
}  // namespace dynmesh::cli

int main(int argc, char** argv) {
  dynmesh::SetUpMemory(dynmesh::MemoryUse::kCommand);
  // If the reader closes the pipe, the write fails instead of a signal ending the process.
  std::signal(SIGPIPE, SIG_IGN);
  try {
    return dynmesh::cli::Main(argc, argv);
  } catch (const std::bad_alloc&) {
    std::fputs("dynmesh: out of memory\n", stderr);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "dynmesh: internal error: %s\n", error.what());
  }
  return dynmesh::cli::kExitFailed;
}
