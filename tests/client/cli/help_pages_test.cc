// Help beside --help: examples, suggestions, the manual page, completion; all refusals.
#include "client/cli/help_pages.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "core/io/formats/formats.h"
#include "gtest/gtest.h"
#include "tests/client/cli/command_line.h"

namespace dynmesh::cli {
namespace {

class HelpPages : public CommandLineFixture {
 protected:
  std::vector<std::string> Commands() const {
    std::vector<std::string> commands;
    const std::string help = Run("--help").out;
    for (const std::string& line : Lines(help.substr(help.find("Subcommands:")))) {
      if (line.starts_with("  ") && line.size() > 2 && line[2] != ' ') {
        commands.push_back(line.substr(2, line.find(' ', 2) - 2));
      }
    }
    return commands;
  }
};

TEST_F(HelpPages, EveryCommandHasThreeExamplesWithItsOwnFlags) {
  const std::vector<std::string> commands = Commands();
  EXPECT_GE(commands.size(), 6U);
  for (const std::string& command : commands) {
    const Outcome help = Run(command + " --help");
    EXPECT_EQ(help.code, 0);
    EXPECT_EQ(Run("help " + command).out, help.out) << command;
    const std::size_t at = help.out.find("Examples:\n");
    ASSERT_NE(at, std::string::npos) << command;
    int examples = 0;
    for (const std::string& line : Lines(help.out.substr(at))) {
      if (!line.starts_with("  dynmesh ")) continue;
      ++examples;
      EXPECT_TRUE(line.starts_with("  dynmesh " + command)) << line;
      std::istringstream words(line.substr(0, line.find('#')));
      for (std::string word; words >> word;) {
        if (!word.starts_with("-") || word[1] == '8') continue;
        EXPECT_NE(help.out.substr(0, at).find(word), std::string::npos) << line << ": " << word;
      }
    }
    EXPECT_EQ(examples, 3) << command;
  }
}

TEST_F(HelpPages, WhatIsMisspeltGetsASuggestion) {
  const struct {
    std::string arguments, said;
  } wrong[] = {
      {"foo", "there is no command 'foo': `dynmesh --help` lists them"},
      {"msh a.poly", "there is no command 'msh'; did you mean 'mesh'?"},
      {"mesh a.poly --insde", "did you mean '--inside'?"},
      {"mesh a.poly --rhoo=1", "did you mean '--rho'?"},
      {"help verfy", "no command 'verfy'; did you mean 'verify'?"},
      {"mesh", "INPUT is required"},
  };
  for (const auto& [arguments, said] : wrong) {
    const Outcome outcome = Run(arguments);
    EXPECT_EQ(outcome.code, 2) << arguments;
    EXPECT_NE(outcome.err.find(said), std::string::npos) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
  EXPECT_EQ(Nearest("zzzzzz", {"mesh", "diff"}), "");
  EXPECT_EQ(Nearest("dif", {"mesh", "diff"}), "diff");
}

TEST_F(HelpPages, ManualAndCompletionHaveEveryCommand) {
  const std::string man = Run("help --man").out, completion = Run("help --bash-completion").out;
  EXPECT_TRUE(man.starts_with(".TH DYNMESH 1"));
  for (const std::string& command : Commands()) {
    EXPECT_NE(man.find(".SS \"dynmesh " + command + "\"\n"), std::string::npos) << command;
    EXPECT_NE(completion.find("    " + command + ") flags="), std::string::npos) << command;
  }
  // It completes.
  folder_.Write("c.bash", completion);
  folder_.Write("try.bash",
                "source c.bash\nCOMP_WORDS=(dynmesh mesh --ins); COMP_CWORD=2; _dynmesh\n"
                "echo \"${COMPREPLY[@]}\"\nCOMP_WORDS=(dynmesh rep); COMP_CWORD=1; _dynmesh\n"
                "echo \"${COMPREPLY[@]}\"\n");
  const std::string command = "cd '" + folder_.Path("") + "' && bash try.bash > tried.txt";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(folder_.Read("tried.txt"), "--inside\nreplay\n");
}

// A row that is added to the table is in the help.
TEST_F(HelpPages, FormatsAreThoseOfTheTable) {
  const std::string list = Run("help --formats").out, man = Run("help --man").out;
  const std::string mesh = Run("mesh --help").out, import = Run("import --help").out;
  const auto has = [](const std::string& text, const io::Format& f) {
    const std::string extension(f.extension);
    for (std::size_t at = 0; (at = text.find(extension, at)) != std::string::npos; ++at) {
      const std::size_t end = at + extension.size();
      if (end == text.size() || std::isalnum(static_cast<unsigned char>(text[end])) == 0)
        return true;
    }
    return false;
  };
  EXPECT_EQ(Lines(list).size(), io::Formats().size() + 1);
  for (const io::Format& f : io::Formats()) {
    SCOPED_TRACE(f.extension);
    EXPECT_NE(list.find("\n" + std::string(f.extension) + " "), std::string::npos);
    EXPECT_TRUE(has(man, f));
    const bool is_output = (f.write_mesh && f.IsMainFile()) || f.write_leaves;
    // The help of `mesh` calls a script so: it may have any extension.
    if (!f.Is(io::kScript)) {
      EXPECT_TRUE(has(mesh, f) || !(f.read_geometry || f.read_sizes || is_output));
    }
    EXPECT_TRUE(has(import, f) || !(f.read_geometry || f.write_features));
  }
}

TEST_F(HelpPages, FacesInOnePlaneGetTheAdviceThatHelps) {
  // A low wall at 80 degrees over a floor. Cut into triangles it has an edge that leans, at 0.0009
  // degrees.
  const std::string corners =
      "0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 0.000011 0.0000628\n0 0.000011 0.0000628\n";
  folder_.Write("c.off", "OFF\n6 3 0\n" + corners + "4 0 1 2 3\n3 0 1 4\n3 0 4 5\n");
  const Outcome refused = Run("mesh c.off --exact --keep-facets");
  EXPECT_EQ(refused.code, 2);
  EXPECT_NE(refused.err.find("3 faces lie in 2 planes: --merge-coplanar joins them"),
            std::string::npos)
      << refused.err;
  // It helps: what is left is that the mesh is large, which takes its time.
  const Outcome joined = Run("mesh c.off --keep-facets --merge-coplanar --max-vertices 2000");
  EXPECT_EQ(joined.code, 1);
  EXPECT_NE(joined.err.find("6.4e-05 apart"), std::string::npos) << joined.err;
  EXPECT_EQ(joined.err.find("angle"), std::string::npos) << joined.err;
  // At 0.04 degrees it would not help.
  const std::string sharp = "0 0 0\n4 0 0\n4 4 0\n0 4 0\n4 1.5 0.001\n0 1.5 0.001\n";
  folder_.Write("s.off", "OFF\n6 3 0\n" + sharp + "4 0 1 2 3\n3 0 1 4\n3 0 4 5\n");
  const Outcome hopeless = Run("mesh s.off");
  EXPECT_EQ(hopeless.code, 2);
  EXPECT_EQ(hopeless.err.find("--merge-coplanar"), std::string::npos) << hopeless.err;
}

}  // namespace
}  // namespace dynmesh::cli
