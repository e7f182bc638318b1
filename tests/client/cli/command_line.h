// Runs the `dynmesh` program like its users.
#ifndef DYNMESH_TESTS_CLIENT_CLI_COMMAND_LINE_H_
#define DYNMESH_TESTS_CLIENT_CLI_COMMAND_LINE_H_

#include <sys/wait.h>

#include <cstdlib>
#include <sstream>
#include <string>
#include <vector>

#include "gtest/gtest.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::cli {

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
};

class CommandLineFixture : public ::testing::Test {
 protected:
  // Runs `dynmesh` with arguments as a shell would split them, in the test's folder.
  Outcome Run(const std::string& arguments) const {
    const std::string command = "cd '" + folder_.Path("") + "' && '" DYNMESH_BINARY "' " +
                                arguments + " > out.txt 2> err.txt < /dev/null";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, folder_.Read("out.txt"),
            folder_.Read("err.txt")};
  }

  static std::vector<std::string> Lines(const std::string& text) {
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
  }

  // The value of a key of a flat JSON object, as text; fails the test if it is not there.
  static std::string Value(const std::string& json, const std::string& key) {
    const std::string start = "\"" + key + "\": ";
    const std::size_t at = json.find(start);
    if (at == std::string::npos) {
      ADD_FAILURE() << "no key " << key << " in " << json;
      return "";
    }
    const std::size_t begin = at + start.size();
    return json.substr(begin, json.find_first_of(",}", begin) - begin);
  }

  test::TempFolder folder_;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_TESTS_CLIENT_CLI_COMMAND_LINE_H_
