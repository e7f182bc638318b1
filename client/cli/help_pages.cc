#include "client/cli/help_pages.h"

#include <algorithm>
#include <map>
#include <memory>
#include <numeric>

#include "core/base/text.h"
#include "core/io/formats/formats.h"
#include "dynmesh/version.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

struct Example {
  const char* command;
  const char* line;
  const char* what;
};
constexpr Example kExamples[] = {
    {"mesh", "plate.poly --inside -o plate.msh", "what the outline encloses, for Gmsh"},
    {"mesh", "plate.poly --inside -q 30 -a 0.01 --markers input -o m.node",
     "as triangle -pq30a.01"},
    {"mesh", "part.stl --inside -o part.vtu", "tetrahedra, for ParaView"},
    {"replay", "edits.dynmesh --check 1", "each revision compared with a run from scratch"},
    {"replay", "edits.dynmesh -o last.svg --fill change", "what the last edit added"},
    {"replay", "edits.dynmesh --json > times.json", "times and counts, an object a line"},
    {"import", "counties.json --polygons --clean -o counties.dynmesh", "a map that a mesh accepts"},
    {"import", "coast.poly --clean --tolerance 0.001 -o clean.poly --json", "with every change"},
    {"import", "scan.stl --clean --feature-angle 20 -o scan.poly",
     "a surface whose faces cross or touch, with fewer triangles"},
    {"verify", "m.node --input plate.poly", "is it a mesh of this input?"},
    {"verify", "m.msh --rho 1.5", "is another mesher's mesh good enough?"},
    {"verify", "m.node --input part.off --min-dihedral 10", "with dihedral angles"},
    {"diff", "before.node after.node", "what two meshes share"},
    {"diff", "a.node b.node --json", "the same as JSON"},
    {"diff", "a.node b.node && echo same", "by the exit code"},
    {"create", "plate --box 0,0,1,1", "a 2D mesh on the local server"},
    {"create", "room --dimension 3 --box 0,0,0,4,4,4", "a 3D one"},
    {"create", "plate --like edits.dynmesh --server HOST:7878", "with a script's options"},
    {"list", "", "meshes of the local server"},
    {"list", "--json", "an object a line"},
    {"list", "--server HOST:7878 --tls-ca ca.pem", "of another one"},
    {"delete", "plate", "on the local server"},
    {"delete", "plate --json", "with an object as answer"},
    {"delete", "plate --server HOST:7878", "on another one"},
    {"apply", "plate edits.dynmesh --create", "batch by batch, diffs stream back"},
    {"apply", "plate edits.dynmesh --one-by-one", "with the time of each answer"},
    {"apply", "plate edits.dynmesh --request-prefix monday", "may be repeated safely"},
    {"load", "coast coast.poly --create", "one revision, with a bar"},
    {"load", "part part.off --create", "a surface"},
    {"load", "plate p.poly --request-id 7", "may be repeated safely"},
    {"watch", "plate", "until the end, checking every step"},
    {"watch", "plate --until 20 -o then.vtu", "and write what is there"},
    {"watch", "plate --region 7,9", "only in polygons 7 and 9"},
    {"export", "plate -o plate.node -o plate.vtu", "several files at once"},
    {"export", "plate --region 7 -o hole.msh", "only in polygon 7"},
    {"export", "plate -o plate.svg --fill quality", "a picture"},
    {"lfs", "coast.poly -81.5,25.1", "of an input, at a position"},
    {"lfs", "part.off 0,0,0 1,1,1", "in 3D, at two"},
    {"lfs", "cells 0.25,0.5", "bounds by the leaves of a server's quadtree"},
    {"features", "plate -o now.dynmesh", "what was put in"},
    {"features", "plate --revision 7 -o then.dynmesh", "at a revision"},
    {"features", "plate --server HOST:7878 -o now.dynmesh", "of another server"},
    {"revert", "plate 7", "a new revision that is as the 7th"},
    {"revert", "plate 7 --json", "with an object as answer"},
    {"revert", "plate 7 --server HOST:7878", "on another server"},
    {"stats", "m.node --svg angles.svg", "a mesh file, with a picture of its angles"},
    {"stats", "m.node --histogram", "how many angles of each degree"},
    {"stats", "--watch 1", "a server's meshes, a table that updates"},
    {"token", "lab --role edit", "a token, and its line for --tokens"},
    {"token", "lab --role edit --meshes 'crack-*'", "for some meshes"},
    {"token", "lab --role read --json", "as JSON"},
    {"help", "mesh", "as dynmesh mesh --help"},
    {"help", "--man > dynmesh.1", "the manual page"},
    {"help", "--bash-completion > dynmesh", "for bash-completion"},
};

std::vector<const CLI::App*> CommandsOf(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

std::vector<std::string> CommandNames(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : CommandsOf(app)) names.push_back(command->get_name());
  return names;
}

std::vector<std::string> FlagsOf(const CLI::App& command) {
  std::vector<std::string> flags;
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
    for (const std::string& name : option->get_snames()) flags.push_back("-" + name);
  }
  return flags;
}

std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t above = row[j + 1];
      row[j + 1] = std::min({above + 1, row[j] + 1, diagonal + (a[i] == b[j] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

// Text as roff: a line may not begin with a dot or quote, and a backslash is a command.
std::string Roff(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else if ((c == '.' || c == '\'') && (result.empty() || result.back() == '\n')) {
      result += std::string("\\&") + c;
    } else {
      result += c;
    }
  }
  return result;
}

struct HelpCommand {
  std::string command;
  bool man = false, completion = false, formats = false;
};

int Run(const CLI::App& app, const HelpCommand& help) {
  if (help.man) return PrintOut(ManPage(app)) ? kExitDone : kExitFailed;
  if (help.completion) return PrintOut(BashCompletion(app)) ? kExitDone : kExitFailed;
  if (help.formats) return PrintOut(io::FormatTable()) ? kExitDone : kExitFailed;
  if (help.command.empty()) return PrintOut(app.help()) ? kExitDone : kExitFailed;
  for (const CLI::App* const command : CommandsOf(app)) {
    if (command->get_name() == help.command) {
      return PrintOut(command->help(app.get_name())) ? kExitDone : kExitFailed;
    }
  }
  const std::string nearest = Nearest(help.command, CommandNames(app));
  return ReportError(absl::InvalidArgumentError(
      Concat("no command ", text::Quoted(help.command),
             nearest.empty() ? "" : Concat("; did you mean ", text::Quoted(nearest), "?"))));
}

}  // namespace

void AddExamples(CLI::App& app) {
  std::map<std::string, std::string> texts;
  for (const Example& example : kExamples) {
    std::string line =
        Concat("  dynmesh ", example.command, *example.line == '\0' ? "" : " ", example.line);
    constexpr std::size_t kColumn = 60;
    line += line.size() < kColumn ? std::string(kColumn - line.size(), ' ') : "\n      ";
    texts[example.command] += Concat(line, "# ", example.what, "\n");
  }
  for (CLI::App* const command : app.get_subcommands([](CLI::App*) { return true; })) {
    const auto text = texts.find(command->get_name());
    if (text != texts.end()) command->footer("Examples:\n" + text->second);
  }
}

void RegisterHelpCommand(CLI::App& app, CommandSlot& slot) {
  auto help = std::make_shared<HelpCommand>();
  CLI::App* const sub = AddCommand(app, slot, "help", "Help on a command, or a manual page",
                                   [&app, help] { return Run(app, *help); });
  sub->add_option("COMMAND", help->command, "As `dynmesh COMMAND --help`");
  sub->add_flag("--man", help->man, "Print a page for man(1)");
  sub->add_flag("--formats", help->formats, "Print the formats of files that are read and written");
  sub->add_flag("--bash-completion", help->completion, "Print a script for bash-completion");
}

std::string Nearest(std::string_view word, const std::vector<std::string>& names) {
  std::string nearest;
  std::size_t least = std::min<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& name : names) {
    const std::size_t distance = EditDistance(word, name);
    if (distance < least) least = distance, nearest = name;
  }
  return nearest;
}

std::string Suggestion(const CLI::App& app, const std::vector<std::string>& arguments) {
  if (arguments.empty()) return "";
  const CLI::App* chosen = nullptr;
  for (const CLI::App* const command : CommandsOf(app)) {
    if (command->get_name() == arguments[0]) chosen = command;
  }
  const auto say = [](const std::string& word) {
    return word.empty() ? "" : Concat("; did you mean ", text::Quoted(word), "?");
  };
  if (chosen == nullptr) {
    if (arguments[0].starts_with("-")) return "";
    const std::string nearest = Nearest(arguments[0], CommandNames(app));
    return Concat("; there is no command ", text::Quoted(arguments[0]),
                  nearest.empty() ? ": `dynmesh --help` lists them" : say(nearest));
  }
  const std::vector<std::string> flags = FlagsOf(*chosen);
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string flag = arguments[i].substr(0, arguments[i].find('='));
    if (!flag.starts_with("--") || std::ranges::count(flags, flag) != 0) continue;
    return say(Nearest(flag, flags));
  }
  return "";
}

std::string ManPage(const CLI::App& app) {
  std::string page = Concat(".TH DYNMESH 1 \"\" \"dynmesh ", DYNMESH_VERSION_STRING,
                            "\" \"User Commands\"\n.SH NAME\ndynmesh \\- ",
                            Roff("meshes from scratch, edit by edit, and proof of both"),
                            "\n.SH SYNOPSIS\n.B dynmesh\n.I COMMAND\n[OPTIONS]\n.SH DESCRIPTION\n",
                            Roff(app.get_description()),
                            "\nExit codes: 0 done, 1 failed, 2 bad usage or bad input.\n"
                            ".SH COMMANDS\n");
  for (const CLI::App* const command : CommandsOf(app)) {
    page += Concat(".SS \"dynmesh ", command->get_name(), "\"\n", Roff(command->get_description()),
                   "\n");
    for (const CLI::Option* const option : command->get_options()) {
      const std::string name = option->get_name(option->get_positional(), true);
      const std::string type = option->get_type_name();
      page += Concat(".TP\n.B ", Roff(name), type.empty() ? "" : " ", Roff(type), "\n",
                     Roff(option->get_description()), "\n");
    }
    if (!command->get_footer().empty()) {
      page += Concat(".PP\n.nf\n", Roff(command->get_footer()), ".fi\n");
    }
  }
  return Concat(page, ".SH FILES\n.nf\n", Roff(io::FormatTable()), ".fi\n.SH SEE ALSO\n",
                Roff("docs/commands.md and docs/input.md of dynmesh"), "\n");
}

std::string BashCompletion(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* const command : CommandsOf(app)) {
    commands += Concat(commands.empty() ? "" : " ", command->get_name());
    std::string flags;
    for (const std::string& flag : FlagsOf(*command))
      flags += Concat(flags.empty() ? "" : " ", flag);
    cases += Concat("    ", command->get_name(), ") flags=\"", flags, "\" ;;\n");
  }
  return Concat(
      "# Completion of dynmesh for bash. Made by `dynmesh help --bash-completion`.\n"
      "_dynmesh() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} flags=\"\"\n"
      "  if ((COMP_CWORD == 1)); then\n"
      "    COMPREPLY=($(compgen -W \"",
      commands,
      " --help --version\" -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${COMP_WORDS[1]} in\n",
      cases,
      "  esac\n"
      "  if [[ $word == -* ]]; then\n"
      "    COMPREPLY=($(compgen -W \"$flags\" -- \"$word\"))\n"
      "  elif [[ ${COMP_WORDS[1]} == help ]]; then\n"
      "    COMPREPLY=($(compgen -W \"",
      commands,
      "\" -- \"$word\"))\n"
      "  else\n"
      "    COMPREPLY=($(compgen -f -- \"$word\"))\n"
      "  fi\n"
      "}\n"
      "complete -o filenames -F _dynmesh dynmesh\n");
}

}  // namespace dynmesh::cli
