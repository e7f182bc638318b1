// Many byte strings as one parameter of a statement, with the arrays that tell them apart: a
// parameter of its own for each would be written as hexadecimal digits. Pure functions.
#ifndef DYNMESH_SERVER_JOURNAL_POSTGRES_PIECES_H_
#define DYNMESH_SERVER_JOURNAL_POSTGRES_PIECES_H_

#include <cstdint>
#include <string>
#include <vector>

namespace dynmesh::server::postgres {

inline std::int64_t SizeOf(const std::string& text) {
  return static_cast<std::int64_t>(text.size());
}

// The position of each piece in the whole, from 1 on. `more`: sizes of second pieces, each behind
// its first one.
inline std::vector<std::int64_t> StartsOf(const std::vector<std::int64_t>& sizes,
                                          const std::vector<std::int64_t>& more = {}) {
  std::vector<std::int64_t> starts;
  std::int64_t start = 1;
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    starts.push_back(start);
    start += sizes[i] + (more.empty() ? 0 : more[i]);
  }
  return starts;
}

}  // namespace dynmesh::server::postgres

#endif  // DYNMESH_SERVER_JOURNAL_POSTGRES_PIECES_H_
