#include "server/journal/whole_reading.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

namespace dynmesh::server {
namespace {

// The revision at which the generation begins that `read` visits, by its first row. `without_rows`:
// the answer if it has none.
absl::StatusOr<std::uint64_t> BaseOf(
    const std::function<absl::Status(const Journal::Visitor&)>& read, std::uint64_t without_rows) {
  std::optional<std::uint64_t> base;
  Journal::Visitor visitor;
  visitor.snapshot = [&base](std::uint64_t revision, const std::string&) {
    base = revision;
    return absl::CancelledError("the first row is enough");
  };
  visitor.entry = [&base](const Journal::Entry& entry) {
    base = entry.revision - 1;
    return absl::CancelledError("the first row is enough");
  };
  const absl::Status status = read(visitor);
  if (base.has_value()) return *base;
  if (!status.ok()) return status;
  return without_rows;
}

}  // namespace

absl::StatusOr<std::vector<std::uint64_t>> GenerationsOf(Journal& journal, Journal::Key mesh) {
  const absl::StatusOr<std::uint64_t> oldest = journal.Oldest(mesh);
  if (!oldest.ok()) return oldest.status();
  std::vector<std::uint64_t> bases;
  absl::StatusOr<std::uint64_t> base =
      BaseOf([&](const Journal::Visitor& visitor) { return journal.Read(mesh, visitor); }, *oldest);
  while (base.ok() && *base > *oldest) {
    bases.push_back(*base);
    const std::uint64_t before = *base - 1;
    base = BaseOf(
        [&](const Journal::Visitor& visitor) {
          return journal.ReadPast(mesh, before, before, visitor);
        },
        before);
  }
  if (!base.ok()) return base.status();
  bases.push_back(*base);
  std::reverse(bases.begin(), bases.end());
  return bases;
}

absl::Status ReadWhole(Journal& journal, Journal::Key mesh,
                       const std::vector<std::uint64_t>& generations,
                       const Journal::Visitor& visitor) {
  for (std::size_t i = 0; i + 1 < generations.size(); ++i) {
    absl::Status status = journal.ReadPast(mesh, generations[i], generations[i + 1], visitor);
    if (!status.ok()) return status;
  }
  return journal.Read(mesh, visitor);
}

}  // namespace dynmesh::server
