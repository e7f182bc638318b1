// What dynmeshd is told: the command line, and the configuration file, whose keys are the same
// names. What the command line says goes before the file. deploy/dynmeshd.conf shows every key.
#ifndef DYNMESH_SERVER_FLAGS_H_
#define DYNMESH_SERVER_FLAGS_H_

#include <CLI/CLI.hpp>
#include <cstdint>
#include <optional>
#include <string>

#include "server/config/config.h"

namespace dynmesh::server {

struct Flags {
  ServerConfig config;
  std::string port_file;
  std::string data_dir;
  std::string accept_loss;  // with commas between
  std::string log_level = "info";
};

// `flags` outlives the parsing.
void AddFlags(CLI::App& app, Flags& flags);

// Parses. Empty if the program is to go on; else its exit code, after having said why: 0 for help
// and version, 2 for bad usage, of which the log tells: key, value, and file and line if it came
// from there (bad_option).
std::optional<int> ParseFlags(CLI::App& app, int argc, const char* const* argv);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_FLAGS_H_
