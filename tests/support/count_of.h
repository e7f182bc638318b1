// How often a part occurs in a text.
#ifndef DYNMESH_TESTS_SUPPORT_COUNT_OF_H_
#define DYNMESH_TESTS_SUPPORT_COUNT_OF_H_

#include <cstddef>
#include <string>

namespace dynmesh::test {

// Overlapping occurrences count each.
inline std::size_t CountOf(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++count;
  return count;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_COUNT_OF_H_
