// The checksum of a row of the journal: 64 bits over its numbers and its texts, including the key.
// It detects, at reading, a damaged row or a row in another's place. Journals store it, so it never
// changes. It misses a random damage with probability 2^-64. It is not cryptographic. Pure,
// O(bytes), some gigabytes per second.
#ifndef DYNMESH_SERVER_JOURNAL_ROW_SUM_H_
#define DYNMESH_SERVER_JOURNAL_ROW_SUM_H_

#include <cstdint>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

// The sum of the added values, in this order. A text differs from the same text in two parts.
class RowSum {
 public:
  RowSum& Add(std::int64_t number);
  RowSum& Add(absl::string_view text);
  // As SQLite stores it.
  std::int64_t value() const { return static_cast<std::int64_t>(state_); }

 private:
  std::uint64_t state_ = 0x9e3779b97f4a7c15u;
};

// Of the columns of a row.
template <typename... Columns>
std::int64_t RowSumOf(const Columns&... columns) {
  RowSum sum;
  (sum.Add(columns), ...);
  return sum.value();
}

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_JOURNAL_ROW_SUM_H_
