// The checksum of a row of the journal: 64 bits over its numbers and its texts, the key included,
// so that a row that was damaged, or stands in another's place, is found when it is read. Files
// keep it: it never changes. Chance overlooks one damage in 2^64; nobody is kept out by it.
// Pure, O(bytes), some gigabytes a second.
#ifndef DYNMESH_SERVER_JOURNAL_ROW_SUM_H_
#define DYNMESH_SERVER_JOURNAL_ROW_SUM_H_

#include <cstdint>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

// Of what is added, in this order. A text is told from two that make it together.
class RowSum {
 public:
  RowSum& Add(std::int64_t number);
  RowSum& Add(absl::string_view text);
  // As SQLite keeps it.
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
