// dynmesh stats --watch: a table of a server's meshes, refreshed every few seconds.
#ifndef DYNMESH_CLIENT_CLI_REMOTE_STATS_WATCH_H_
#define DYNMESH_CLIENT_CLI_REMOTE_STATS_WATCH_H_

#include <cstdint>
#include <string>

#include "absl/time/time.h"
#include "client/cli/remote/connection.h"

namespace dynmesh::cli {

struct StatsWatch {
  absl::Duration interval = absl::Seconds(2);
  std::uint64_t count = 0;  // number of refreshes; 0: until SIGINT or SIGTERM
};

// Shows one mesh, or all if `mesh` is empty. Returns the exit code; a signal ends with success.
int RunStatsWatch(const std::string& mesh, const StatsWatch& watch, const ServerFlags& server);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_REMOTE_STATS_WATCH_H_
