// Tables of numbers as texts.
#ifndef DYNMESH_TESTS_SUPPORT_NUMBER_ROWS_H_
#define DYNMESH_TESTS_SUPPORT_NUMBER_ROWS_H_

#include <sstream>
#include <string>
#include <vector>

namespace dynmesh::test {

// The numbers of each line, without empty lines and comments. Of a line only those before the first
// word that is no number.
inline std::vector<std::vector<double>> NumberRows(const std::string& text) {
  std::vector<std::vector<double>> rows;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::vector<double>& row = rows.emplace_back();
    std::istringstream numbers(line);
    for (double x = 0; numbers >> x;) row.push_back(x);
  }
  return rows;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_NUMBER_ROWS_H_
