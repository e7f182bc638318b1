#include "server/journal/postgres_append.h"

#include "absl/strings/str_cat.h"
#include "server/journal/postgres_pieces.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server::postgres {
namespace {

// Parameters: 1 mesh, 2 epoch, 3 head, 4 answers; of the entries 5 data, 6 starts, 7 sizes, 8 sums;
// of the requests 9 data, 10 starts, 11 sizes of ids, 12 sizes of answers, 13 sums; 14 forgotten.
constexpr char kAppend[] = R"(
WITH mine AS (
  UPDATE dynmesh.meshes SET head = head + cardinality($8::bigint[]),
    answers = answers + cardinality($13::bigint[]), tail_bytes = tail_bytes + length($5::bytea)
  WHERE key = $1::bigint AND epoch = $2::bigint AND head = $3::bigint AND answers = $4::bigint
  RETURNING key),
added AS (
  INSERT INTO dynmesh.entries(mesh, revision, epoch, checksum, data)
  SELECT key, $3::bigint + n, $2::bigint, sum, substring($5::bytea FROM start FOR size)
  FROM mine, unnest($6::int[], $7::int[], $8::bigint[]) WITH ORDINALITY AS e(start, size, sum, n)),
answered AS (
  INSERT INTO dynmesh.requests(mesh, number, checksum, id, answer)
  SELECT key, $4::bigint + n, sum, substring($9::bytea FROM start FOR id_size),
    substring($9::bytea FROM start + id_size FOR answer_size)
  FROM mine, unnest($10::int[], $11::int[], $12::int[], $13::bigint[]) WITH ORDINALITY
    AS r(start, id_size, answer_size, sum, n)
  WHERE $4::bigint + n > $14::bigint),
forgotten AS (
  DELETE FROM dynmesh.requests WHERE mesh IN (SELECT key FROM mine) AND number <= $14::bigint)
SELECT key FROM mine)";

}  // namespace

GroupAppend::GroupAppend(Journal::Key mesh, const Belief& belief,
                         const std::vector<Journal::Entry>& entries,
                         const std::vector<Journal::Request>& requests, std::size_t remembered)
    : mesh_(mesh), before_(belief) {
  for (const Journal::Entry& entry : entries) {
    const auto revision = static_cast<std::int64_t>(entry.revision);
    entries_ += entry.data;
    entry_sizes_.push_back(SizeOf(entry.data));
    entry_sums_.push_back(RowSumOf(mesh, revision, absl::string_view(entry.data)));
  }
  std::int64_t number = belief.answers;
  for (const Journal::Request& request : requests) {
    ++number;
    absl::StrAppend(&requests_, request.id, request.answer);
    id_sizes_.push_back(SizeOf(request.id));
    answer_sizes_.push_back(SizeOf(request.answer));
    request_sums_.push_back(
        RowSumOf(mesh, number, absl::string_view(request.id), absl::string_view(request.answer)));
  }
  // By the hundred, as in SQLite: deleted rows are far from the newest.
  const auto kept = static_cast<std::int64_t>(remembered);
  const std::int64_t at_once = 1 + kept / 100;
  if (number / at_once != belief.answers / at_once) forgotten_ = number - kept;
}

Answer GroupAppend::Run(Session& session, std::int64_t epoch) const {
  return session.Run(kAppend, mesh_, epoch, before_.head, before_.answers, Bytes{entries_},
                     StartsOf(entry_sizes_), entry_sizes_, entry_sums_, Bytes{requests_},
                     StartsOf(id_sizes_, answer_sizes_), id_sizes_, answer_sizes_, request_sums_,
                     forgotten_);
}

}  // namespace dynmesh::server::postgres
