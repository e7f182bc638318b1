// The commands of `dynmesh` for servers: create, list, delete, apply, load, watch, export,
// features, revert, stats; and token, which makes a client's token. They are registered like those
// of command.h.
#ifndef DYNMESH_CLIENT_CLI_REMOTE_REMOTE_COMMANDS_H_
#define DYNMESH_CLIENT_CLI_REMOTE_REMOTE_COMMANDS_H_

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace dynmesh::cli {

void RegisterCreateCommand(CLI::App& app, CommandSlot& slot);
void RegisterListCommand(CLI::App& app, CommandSlot& slot);
void RegisterDeleteCommand(CLI::App& app, CommandSlot& slot);
void RegisterApplyCommand(CLI::App& app, CommandSlot& slot);
void RegisterLoadCommand(CLI::App& app, CommandSlot& slot);
void RegisterWatchCommand(CLI::App& app, CommandSlot& slot);
void RegisterExportCommand(CLI::App& app, CommandSlot& slot);
void RegisterStatsCommand(CLI::App& app, CommandSlot& slot);
void RegisterLfsCommand(CLI::App& app, CommandSlot& slot);
void RegisterFeaturesCommand(CLI::App& app, CommandSlot& slot);
void RegisterRevertCommand(CLI::App& app, CommandSlot& slot);
void RegisterTokenCommand(CLI::App& app, CommandSlot& slot);

// All of them.
void RegisterRemoteCommands(CLI::App& app, CommandSlot& slot);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REMOTE_REMOTE_COMMANDS_H_
