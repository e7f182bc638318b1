// The part of PostgresJournal for several servers on one database: leases, and where meshes are.
#include <utility>

#include "server/journal/postgres_journal.h"
#include "server/journal/postgres_leases.h"

namespace dynmesh::server {

using SessionLease = postgres::Pool::Lease;

absl::StatusOr<std::vector<Journal::Key>> PostgresJournal::Renew(const std::string& address) {
  absl::StatusOr<SessionLease> session = keeper_.Take();
  if (!session.ok()) return session.status();
  return postgres::RenewLeases(**session, {owner_, address}, options_.lease);
}

absl::Status PostgresJournal::GiveUp() {
  absl::StatusOr<SessionLease> session = keeper_.Take();
  if (!session.ok()) return session.status();
  return postgres::GiveUpLeases(**session, owner_);
}

absl::StatusOr<std::vector<std::string>> PostgresJournal::LiveNodes() {
  absl::StatusOr<SessionLease> session = readers_.Take();
  if (!session.ok()) return session.status();
  absl::StatusOr<std::vector<postgres::Node>> nodes =
      postgres::LiveNodes(**session, options_.lease);
  if (!nodes.ok()) return nodes.status();
  std::vector<std::string> addresses;
  for (postgres::Node& node : *nodes) addresses.push_back(std::move(node.address));
  return addresses;
}

absl::StatusOr<SharedJournal::Place> PostgresJournal::Locate(const std::string& id) {
  absl::StatusOr<SessionLease> session = readers_.Take();
  if (!session.ok()) return session.status();
  return postgres::LocateMesh(**session, id, owner_);
}

absl::StatusOr<std::vector<SharedJournal::Place>> PostgresJournal::LocateAll(
    const std::string& after, std::size_t limit) {
  absl::StatusOr<SessionLease> session = readers_.Take();
  if (!session.ok()) return session.status();
  return postgres::LocateMeshes(**session, after, limit, owner_);
}

std::int64_t PostgresJournal::EpochOf(Key mesh) {
  const OwnedPtr owned = Find(mesh);
  return owned == nullptr ? 0 : owned->epoch.load();
}

}  // namespace dynmesh::server
