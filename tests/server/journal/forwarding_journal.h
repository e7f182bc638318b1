// A journal that is another one, for tests that change what some of its calls do. As thread-safe as
// that one.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_FORWARDING_JOURNAL_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_FORWARDING_JOURNAL_H_

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "server/journal/journal.h"

namespace dynmesh::server {

class ForwardingJournal : public Journal {
 public:
  // `inner` must outlive this.
  explicit ForwardingJournal(Journal& inner) : inner_(inner) {}

  std::string name() const override { return inner_.name(); }
  absl::StatusOr<std::vector<Mesh>> List() override { return inner_.List(); }
  absl::StatusOr<Key> Create(const std::string& id, const std::string& description) override {
    return inner_.Create(id, description);
  }
  absl::Status Delete(Key mesh) override { return inner_.Delete(mesh); }
  bool Sweep(Key mesh) override { return inner_.Sweep(mesh); }
  using Journal::Append;
  absl::Status Append(Key mesh, const std::vector<Entry>& entries,
                      const std::vector<Request>& requests) override {
    return inner_.Append(mesh, entries, requests);
  }
  absl::Status Read(Key mesh, const Visitor& visitor) override {
    return inner_.Read(mesh, visitor);
  }
  absl::Status ReadPast(Key mesh, std::uint64_t from, std::uint64_t to,
                        const Visitor& visitor) override {
    return inner_.ReadPast(mesh, from, to, visitor);
  }
  absl::StatusOr<std::uint64_t> Oldest(Key mesh) override { return inner_.Oldest(mesh); }
  using Journal::Compact;
  absl::Status Compact(Key mesh, std::uint64_t revision, const std::vector<std::string>& parts,
                       const std::atomic<bool>& stop) override {
    return inner_.Compact(mesh, revision, parts, stop);
  }

 private:
  Journal& inner_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_FORWARDING_JOURNAL_H_
