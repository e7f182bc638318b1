// The content of a journal for one mesh, as text: "?request=answer @revision:part revision:entry".
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_TOLD_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_TOLD_H_

#include <functional>
#include <string>

#include "absl/strings/str_cat.h"
#include "server/journal/journal.h"

namespace dynmesh::server {

inline std::string ToldBy(const std::function<absl::Status(const Journal::Visitor&)>& read) {
  std::string text;
  Journal::Visitor visitor;
  visitor.request = [&](const Journal::Request& r) {
    absl::StrAppend(&text, "?", r.id, "=", r.answer, " ");
    return absl::OkStatus();
  };
  visitor.snapshot = [&](std::uint64_t revision, const std::string& part) {
    absl::StrAppend(&text, "@", revision, ":", part, " ");
    return absl::OkStatus();
  };
  visitor.entry = [&](const Journal::Entry& e) {
    absl::StrAppend(&text, e.revision, ":", e.data, " ");
    return absl::OkStatus();
  };
  const absl::Status status = read(visitor);
  return status.ok() ? text : status.ToString();
}

inline std::string Told(Journal& journal, Journal::Key mesh) {
  return ToldBy([&](const auto& visitor) { return journal.Read(mesh, visitor); });
}

inline std::string ToldPast(Journal& journal, Journal::Key mesh, std::uint64_t from,
                            std::uint64_t to) {
  return ToldBy([&](const auto& visitor) { return journal.ReadPast(mesh, from, to, visitor); });
}

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_TOLD_H_
