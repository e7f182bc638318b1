// Help beside `--help`: examples, suggestions for misspelt words, a manual page, completion.
#ifndef DYNMESH_CLIENT_CLI_HELP_PAGES_H_
#define DYNMESH_CLIENT_CLI_HELP_PAGES_H_

#include <string>
#include <string_view>
#include <vector>

#include "CLI/CLI.hpp"
#include "client/cli/command.h"

namespace dynmesh::cli {

// Puts three examples below the help of each command of `app`.
void AddExamples(CLI::App& app);

// dynmesh help [COMMAND] [--man] [--formats] [--bash-completion]
void RegisterHelpCommand(CLI::App& app, CommandSlot& slot);

// What the arguments of a failed parse should have been: "", or "; did you mean 'mesh'?". `message`
// is the parser's.
std::string Suggestion(const CLI::App& app, const std::vector<std::string>& arguments);

// A name of `names` that is one or two letters (a third of the word) from `word`; else empty. The
// first of the nearest ones.
std::string Nearest(std::string_view word, const std::vector<std::string>& names);

// A page for man(1), and a script for bash-completion, of all commands.
std::string ManPage(const CLI::App& app);
std::string BashCompletion(const CLI::App& app);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_HELP_PAGES_H_
