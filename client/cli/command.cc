#include "client/cli/command.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "core/base/text.h"
#include "dynmesh/version.h"

namespace dynmesh::cli {

std::string VersionText() { return "dynmesh " DYNMESH_VERSION_STRING; }

CLI::App* AddCommand(CLI::App& app, CommandSlot& slot, const std::string& name,
                     const std::string& description, std::function<int()> run) {
  CLI::App* const command = app.add_subcommand(name, description);
  command->set_version_flag("--version", VersionText());
  command->callback([&slot, run = std::move(run)] { slot.run = run; });
  return command;
}

int ExitCodeOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kExitDone;
    case absl::StatusCode::kInvalidArgument:
    case absl::StatusCode::kNotFound:
    case absl::StatusCode::kAlreadyExists:
    case absl::StatusCode::kUnauthenticated:
    case absl::StatusCode::kPermissionDenied:
    case absl::StatusCode::kFailedPrecondition:
    case absl::StatusCode::kOutOfRange:
    case absl::StatusCode::kUnimplemented:
      return kExitBadInput;
    default:
      return kExitFailed;
  }
}

int ReportError(const absl::Status& status) {
  const std::string_view message = text::View(status.message());
  const std::string line = text::Concat("dynmesh: ", message, "\n");
  std::fwrite(line.data(), 1, line.size(), stderr);
  return ExitCodeOf(status);
}

void PrintWarning(std::string_view message) {
  const std::string line = text::Concat("dynmesh: warning: ", message, "\n");
  std::fwrite(line.data(), 1, line.size(), stderr);
}

bool PrintOut(std::string_view text) {
  return std::fwrite(text.data(), 1, text.size(), stdout) == text.size() &&
         std::fflush(stdout) == 0;
}

bool ErrorIsTerminal() { return isatty(STDERR_FILENO) == 1; }

bool OutIsTerminal() { return isatty(STDOUT_FILENO) == 1; }

}  // namespace dynmesh::cli
