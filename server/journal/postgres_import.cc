// The part of PostgresJournal that takes meshes from other journals. Rows of a key without a mesh
// are leftovers (postgres_generations.h) until Publish makes the mesh. Each statement has the same
// effect when it is repeated.
#include <utility>

#include "server/journal/journal_errors.h"
#include "server/journal/postgres_journal.h"
#include "server/journal/postgres_pieces.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server {
namespace {

using postgres::Answer;
using postgres::Bytes;
using postgres::Session;
using postgres::SizeOf;
using postgres::StartsOf;

constexpr char kParts[] = R"(
INSERT INTO dynmesh.snapshots(mesh, revision, part, checksum, data)
SELECT $1::bigint, revision, part, sum, substring($2::bytea FROM start FOR size)
FROM unnest($3::int[], $4::int[], $5::bigint[], $6::bigint[], $7::bigint[])
  AS p(start, size, sum, revision, part)
ON CONFLICT DO NOTHING)";
constexpr char kImportEntries[] = R"(
INSERT INTO dynmesh.entries(mesh, revision, epoch, checksum, data)
SELECT $1::bigint, $2::bigint + n - 1, 1, sum, substring($3::bytea FROM start FOR size)
FROM unnest($4::int[], $5::int[], $6::bigint[]) WITH ORDINALITY AS e(start, size, sum, n)
ON CONFLICT DO NOTHING)";
// Parameters: 1 key, 2 id, 3 description, 4 checksum, 5 newest snapshot, 6 head, 7 bytes since that
// snapshot; 8 entries and 9 parts that are to be there; of the generations 10 revisions, 11 parts,
// 12 bytes; of the requests 13 data, 14 starts, 15 sizes of ids, 16 sizes of answers, 17 sums.
constexpr char kPublish[] = R"(
WITH made AS (
  INSERT INTO dynmesh.meshes(key, id, description, checksum, snapshot, head, answers, tail_bytes,
    owner)
  SELECT $1::bigint, $2::text, $3::bytea, $4::bigint, $5::bigint, $6::bigint,
    cardinality($17::bigint[]), $7::bigint, ''
  WHERE (SELECT count(*) FROM dynmesh.entries WHERE mesh = $1::bigint) = $8::bigint
    AND (SELECT count(*) FROM dynmesh.snapshots WHERE mesh = $1::bigint) = $9::bigint
  ON CONFLICT DO NOTHING RETURNING key),
past AS (
  INSERT INTO dynmesh.generations(mesh, revision, parts, bytes)
  SELECT key, revision, parts, bytes
  FROM made, unnest($10::bigint[], $11::bigint[], $12::bigint[]) AS g(revision, parts, bytes)),
answered AS (
  INSERT INTO dynmesh.requests(mesh, number, checksum, id, answer)
  SELECT key, n, sum, substring($13::bytea FROM start FOR id_size),
    substring($13::bytea FROM start + id_size FOR answer_size)
  FROM made, unnest($14::int[], $15::int[], $16::int[], $17::bigint[]) WITH ORDINALITY
    AS r(start, id_size, answer_size, sum, n))
SELECT key FROM made)";

struct Answers {
  std::string data;
  std::vector<std::int64_t> id_sizes, answer_sizes, sums;
};

Answers AnswersOf(Journal::Key mesh, const std::vector<Journal::Request>& requests) {
  Answers answers;
  std::int64_t number = 0;
  for (const Journal::Request& request : requests) {
    ++number;
    answers.data += request.id;
    answers.data += request.answer;
    answers.id_sizes.push_back(SizeOf(request.id));
    answers.answer_sizes.push_back(SizeOf(request.answer));
    answers.sums.push_back(
        RowSumOf(mesh, number, absl::string_view(request.id), absl::string_view(request.answer)));
  }
  return answers;
}

Answer InsertParts(Session& session, Journal::Key mesh,
                   const std::vector<MeshImport::Part>& parts) {
  std::string data;
  std::vector<std::int64_t> sizes, sums, revisions, numbers;
  for (const MeshImport::Part& part : parts) {
    const auto revision = static_cast<std::int64_t>(part.revision);
    data += part.data;
    sizes.push_back(SizeOf(part.data));
    sums.push_back(RowSumOf(mesh, revision, part.number, absl::string_view(part.data)));
    revisions.push_back(revision);
    numbers.push_back(part.number);
  }
  return session.Run(kParts, mesh, Bytes{data}, StartsOf(sizes), sizes, sums, revisions, numbers);
}

Answer InsertEntries(Session& session, Journal::Key mesh,
                     const std::vector<Journal::Entry>& entries) {
  std::string data;
  std::vector<std::int64_t> sizes, sums;
  for (const Journal::Entry& entry : entries) {
    data += entry.data;
    sizes.push_back(SizeOf(entry.data));
    sums.push_back(
        RowSumOf(mesh, static_cast<std::int64_t>(entry.revision), absl::string_view(entry.data)));
  }
  const auto first = static_cast<std::int64_t>(entries.front().revision);
  return session.Run(kImportEntries, mesh, first, Bytes{data}, StartsOf(sizes), sizes, sums);
}

}  // namespace

absl::StatusOr<Journal::Key> PostgresJournal::NewKey() {
  Key key = 0;
  const absl::Status status =
      Repeatedly([&](Session& session, bool* unknown) { return DrawKey(session, &key, unknown); });
  if (!status.ok()) return status;
  return key;
}

// Two statements: after the first one alone there are leftovers, as before.
absl::Status PostgresJournal::WriteUnseen(Key mesh, const std::vector<Part>& parts,
                                          const std::vector<Entry>& entries) {
  return Repeatedly([&](Session& session, bool* unknown) {
    Answer written;
    if (!parts.empty()) written = InsertParts(session, mesh, parts);
    if (written.status.ok() && !entries.empty()) written = InsertEntries(session, mesh, entries);
    *unknown = written.unknown;
    return written.status;
  });
}

absl::Status PostgresJournal::Publish(Key mesh, const Whole& whole) {
  const Generation& newest = whole.generations.back();
  std::vector<std::int64_t> revisions, parts, bytes;
  for (const Generation& generation : whole.generations) {
    revisions.push_back(static_cast<std::int64_t>(generation.revision));
    parts.push_back(static_cast<std::int64_t>(generation.parts));
    // The newest one's entries are counted in the mesh's row.
    bytes.push_back(static_cast<std::int64_t>(
        generation.snapshot_bytes + (&generation == &newest ? 0 : generation.entry_bytes)));
  }
  const Answers answers = AnswersOf(mesh, whole.requests);
  const std::int64_t sum =
      RowSumOf(absl::string_view(whole.id), absl::string_view(whole.description));
  return Repeatedly([&](Session& session, bool* unknown) -> absl::Status {
    const Answer made = session.Run(
        kPublish, mesh, whole.id, Bytes{whole.description}, sum,
        static_cast<std::int64_t>(newest.revision), static_cast<std::int64_t>(whole.head),
        static_cast<std::int64_t>(newest.entry_bytes), static_cast<std::int64_t>(whole.entries()),
        static_cast<std::int64_t>(whole.parts()), revisions, parts, bytes, Bytes{answers.data},
        StartsOf(answers.id_sizes, answers.answer_sizes), answers.id_sizes, answers.answer_sizes,
        answers.sums);
    *unknown = made.unknown;
    if (!made.status.ok() || !made.empty()) return made.status;
    const Answer there =
        session.Run("SELECT key FROM dynmesh.meshes WHERE id = $1::text", whole.id);
    if (!there.status.ok()) return there.status;
    if (there.empty()) return RowsMissing(whole.id);
    // An attempt before this one made it.
    return there.Integer(0, 0) == mesh ? absl::OkStatus() : MeshExists(whole.id);
  });
}

}  // namespace dynmesh::server
