// The options of dynmeshd: the command line, and a configuration file with the same names as keys.
// The command line takes precedence. deploy/dynmeshd.conf shows every key.
#ifndef DYNMESH_SERVER_FLAGS_H_
#define DYNMESH_SERVER_FLAGS_H_

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "server/config/config.h"

namespace CLI {
class App;
}

namespace dynmesh::server {

struct Flags {
  ServerConfig config;
  std::string port_file;
  std::string data_dir;     // not with `journal`
  std::string journal;      // postgresql://...
  std::string accept_loss;  // comma-separated
  // Source and target, each a folder or postgresql://...; empty: it serves.
  std::vector<std::string> copy_journal;
  std::string copy_meshes;  // comma-separated
  std::string log_level = "info";
};

// Reads the command line, and the configuration file that it names. Returns as ParseFlags.
std::optional<int> ReadFlags(int argc, const char* const* argv, Flags& flags);

// The two parts of ReadFlags, for tests. `flags` outlives the parsing.
void AddFlags(CLI::App& app, Flags& flags);

// Parses. Returns nothing if the program continues, else its exit code after the reason was
// printed: 0 for help and version, 2 for bad usage. Bad usage is logged as bad_option with key and
// value, and with file and line if it is from the configuration file.
std::optional<int> ParseFlags(CLI::App& app, int argc, const char* const* argv);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_FLAGS_H_
