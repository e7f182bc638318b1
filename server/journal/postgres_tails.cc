#include "server/journal/postgres_tails.h"

#include <map>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/journal/journal_errors.h"
#include "server/journal/row_sum.h"

namespace dynmesh::server::postgres {
namespace {

using Position = SharedJournal::Position;
using Tail = SharedJournal::Tail;

// Parameter 1: keys. 2: the node that asks.
constexpr char kStates[] =
    "SELECT m.key, m.head, m.answers, m.epoch, m.snapshot, coalesce(g.bytes, 0), "
    "(m.owner = $2::text)::integer, (m.lease_until <= clock_timestamp())::integer, "
    "convert_to(coalesce(n.address, ''), 'UTF8') "
    "FROM unnest($1::bigint[]) AS f(key) JOIN dynmesh.meshes AS m ON m.key = f.key "
    "LEFT JOIN dynmesh.nodes AS n ON n.id = m.owner "
    "LEFT JOIN dynmesh.generations AS g ON g.mesh = m.key AND g.revision = m.snapshot";
// 1: keys, 2: revisions, 3: bytes of a mesh. Rows are chosen by their sizes, which are read without
// the data.
constexpr char kTailEntries[] = R"(
SELECT f.key, e.revision, e.checksum, e.data
FROM unnest($1::bigint[], $2::bigint[]) AS f(key, after) CROSS JOIN LATERAL (
  SELECT revision, checksum, data,
    sum(length(data) + 64) OVER (ORDER BY revision) - length(data) - 64 AS before
  FROM (SELECT revision, checksum, data FROM dynmesh.entries
    WHERE mesh = f.key AND revision > f.after ORDER BY revision LIMIT 1000) AS next) AS e
WHERE e.before < $3::bigint ORDER BY f.key, e.revision)";
// 1: keys, 2: numbers.
constexpr char kRequests[] = R"(
SELECT r.mesh, r.number, r.checksum, r.id, r.answer
FROM unnest($1::bigint[], $2::bigint[]) AS f(key, after) CROSS JOIN LATERAL (
  SELECT mesh, number, checksum, id, answer FROM dynmesh.requests
  WHERE mesh = f.key AND number > f.after ORDER BY number LIMIT 4000) AS r
ORDER BY r.mesh, r.number)";

// Tails by their mesh, and where their follower is.
class Tails {
 public:
  explicit Tails(const std::vector<Position>& positions) {
    for (const Position& position : positions) by_mesh_[position.mesh].from = position;
  }

  std::vector<std::int64_t> keys() const {
    std::vector<std::int64_t> keys;
    for (const auto& [key, reading] : by_mesh_) keys.push_back(key);
    return keys;
  }

  void TakeState(const Answer& answer, std::size_t row) {
    Tail& tail = by_mesh_.at(answer.Integer(row, 0)).tail;
    tail.exists = true;
    tail.head = static_cast<std::uint64_t>(answer.Integer(row, 1));
    tail.answers = answer.Integer(row, 2);
    tail.epoch = answer.Integer(row, 3);
    tail.snapshot = static_cast<std::uint64_t>(answer.Integer(row, 4));
    tail.snapshot_bytes = static_cast<std::uint64_t>(answer.Integer(row, 5));
    tail.is_mine = answer.Integer(row, 6) != 0;
    tail.is_free = answer.Integer(row, 7) != 0;
    tail.address = answer.Bytes(row, 8);
  }

  // The meshes whose `present` number is larger than the one that their follower `had`.
  void Behind(std::int64_t (*present)(const Tail&), std::int64_t (*had)(const Position&),
              std::vector<std::int64_t>* keys, std::vector<std::int64_t>* after) const {
    for (const auto& [key, reading] : by_mesh_) {
      if (!reading.tail.exists || present(reading.tail) <= had(reading.from)) continue;
      keys->push_back(key);
      after->push_back(had(reading.from));
    }
  }

  void TakeEntry(const Answer& answer, std::size_t row) {
    const Journal::Key mesh = answer.Integer(row, 0);
    Reading& reading = by_mesh_.at(mesh);
    Tail& tail = reading.tail;
    if (!tail.damage.ok()) return;
    const std::int64_t revision = answer.Integer(row, 1);
    const std::uint64_t last =
        tail.entries.empty() ? reading.from.revision : tail.entries.back().revision;
    Journal::Entry entry{static_cast<std::uint64_t>(revision), answer.Bytes(row, 3)};
    if (entry.revision != last + 1) {
      tail.damage = Gap(mesh, last);
    } else if (RowSumOf(mesh, revision, absl::string_view(entry.data)) != answer.Integer(row, 2)) {
      tail.damage = ReadingErrors(absl::StrCat("@", mesh))
                        .Damaged(absl::StrCat("the entry of revision ", revision));
    } else {
      tail.entries.push_back(std::move(entry));
    }
  }

  void TakeRequest(const Answer& answer, std::size_t row) {
    const Journal::Key mesh = answer.Integer(row, 0);
    Tail& tail = by_mesh_.at(mesh).tail;
    const std::int64_t number = answer.Integer(row, 1);
    Journal::Request request{answer.Bytes(row, 3), answer.Bytes(row, 4)};
    tail.answers = number;
    if (RowSumOf(mesh, number, absl::string_view(request.id), absl::string_view(request.answer)) !=
        answer.Integer(row, 2)) {
      tail.damage = ReadingErrors(absl::StrCat("@", mesh))
                        .Damaged(absl::StrCat("the answer to request ", request.id));
    } else {
      tail.requests.push_back(std::move(request));
    }
  }

  std::vector<Tail> Take() {
    std::vector<Tail> tails;
    for (auto& [key, reading] : by_mesh_) {
      Tail& tail = reading.tail;
      tail.mesh = key;
      // Entries are older than the state that tells of them.
      if (tail.exists && tail.damage.ok() && tail.entries.empty() &&
          tail.head > reading.from.revision) {
        tail.damage = Gap(key, reading.from.revision);
      }
      tails.push_back(std::move(tail));
    }
    return tails;
  }

 private:
  struct Reading {
    Position from;
    Tail tail;
  };
  static absl::Status Gap(Journal::Key mesh, std::uint64_t after) {
    return absl::OutOfRangeError(absl::StrCat("what follows revision ", after, " of mesh @", mesh,
                                              " is not in the journal"));
  }

  std::map<Journal::Key, Reading> by_mesh_;
};

}  // namespace

absl::StatusOr<std::vector<Tail>> ReadTails(Session& session,
                                            const std::vector<Position>& positions,
                                            const std::string& node, std::int64_t bytes) {
  Tails tails(positions);
  const Answer states = session.Run(kStates, tails.keys(), node);
  if (!states.status.ok()) return states.status;
  for (std::size_t row = 0; row < states.size(); ++row) tails.TakeState(states, row);
  std::vector<std::int64_t> keys, after;
  tails.Behind([](const Tail& t) { return static_cast<std::int64_t>(t.head); },
               [](const Position& p) { return static_cast<std::int64_t>(p.revision); }, &keys,
               &after);
  if (!keys.empty()) {
    const Answer entries = session.Run(kTailEntries, keys, after, bytes);
    if (!entries.status.ok()) return entries.status;
    for (std::size_t row = 0; row < entries.size(); ++row) tails.TakeEntry(entries, row);
  }
  keys.clear();
  after.clear();
  tails.Behind([](const Tail& t) { return t.answers; }, [](const Position& p) { return p.answers; },
               &keys, &after);
  if (!keys.empty()) {
    const Answer requests = session.Run(kRequests, keys, after);
    if (!requests.status.ok()) return requests.status;
    for (std::size_t row = 0; row < requests.size(); ++row) tails.TakeRequest(requests, row);
  }
  return tails.Take();
}

}  // namespace dynmesh::server::postgres
