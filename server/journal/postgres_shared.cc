// The part of PostgresJournal for several servers on one database: leases, and where meshes are.
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/boot_time.h"
#include "server/journal/postgres_journal.h"
#include "server/journal/postgres_leases.h"
#include "server/journal/postgres_tails.h"

namespace dynmesh::server {

using Loan = postgres::Pool::Loan;

namespace {

constexpr std::int64_t kTailBytes = 4 << 20;

}  // namespace

absl::StatusOr<std::vector<Journal::Key>> PostgresJournal::Renew(const std::string& address) {
  absl::StatusOr<Loan> session = keeper_.Take();
  if (!session.ok()) return session.status();
  const std::chrono::nanoseconds sent = BootTime();
  absl::StatusOr<std::vector<Key>> renewed =
      postgres::RenewLeases(**session, {owner_, address}, options_.lease);
  if (renewed.ok()) renewed_ = sent.count();
  return renewed;
}

absl::Status PostgresJournal::GiveUp() {
  absl::StatusOr<Loan> session = keeper_.Take();
  if (!session.ok()) return session.status();
  return postgres::GiveUpLeases(**session, owner_);
}

absl::StatusOr<std::vector<std::string>> PostgresJournal::LiveNodes() {
  absl::StatusOr<Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  absl::StatusOr<std::vector<postgres::Node>> nodes =
      postgres::LiveNodes(**session, options_.lease);
  if (!nodes.ok()) return nodes.status();
  std::vector<std::string> addresses;
  for (postgres::Node& node : *nodes) addresses.push_back(std::move(node.address));
  return addresses;
}

absl::StatusOr<SharedJournal::Located> PostgresJournal::Locate(const std::string& id) {
  absl::StatusOr<Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::LocateMesh(**session, id, owner_, options_.lease);
}

absl::StatusOr<std::vector<SharedJournal::Located>> PostgresJournal::LocateAll(
    const std::string& after, std::size_t limit) {
  absl::StatusOr<Loan> session = readers_.Take(Patience());
  if (!session.ok()) return session.status();
  return postgres::LocateMeshes(**session, after, limit, owner_);
}

std::int64_t PostgresJournal::EpochOf(Key mesh) {
  const OwnedPtr owned = Find(mesh);
  return owned == nullptr ? 0 : owned->epoch.load();
}

absl::StatusOr<std::vector<SharedJournal::Tail>> PostgresJournal::ReadTails(
    const std::vector<Position>& positions) {
  absl::StatusOr<Loan> session = follower_.Take();
  if (!session.ok()) return session.status();
  return postgres::ReadTails(**session, positions, owner_, kTailBytes);
}

absl::Status PostgresJournal::AskToFollow(const std::vector<Wish>& wishes) {
  absl::StatusOr<Loan> session = follower_.Take();
  if (!session.ok()) return session.status();
  return postgres::AskToFollow(**session, wishes, options_.lease);
}

absl::StatusOr<std::vector<std::string>> PostgresJournal::AskedToFollow() {
  absl::StatusOr<Loan> session = follower_.Take();
  if (!session.ok()) return session.status();
  return postgres::AskedToFollow(**session, owner_);
}

absl::Status PostgresJournal::SetFollows(Key mesh, bool follows) {
  absl::StatusOr<Loan> session = follower_.Take();
  if (!session.ok()) return session.status();
  return postgres::SetFollows(**session, mesh, owner_, follows);
}

absl::StatusOr<std::int64_t> PostgresJournal::HandOver(Key mesh, const std::string& address) {
  const OwnedPtr owned = Find(mesh);
  if (owned == nullptr) return NotClaimed(mesh);
  const MutexLock lock(owned->mutex);
  if (!owned->gone.ok()) return owned->gone;
  absl::StatusOr<Loan> session = writers_.Take();
  if (!session.ok()) return session.status();
  const absl::StatusOr<std::int64_t> epoch =
      postgres::HandOver(**session, mesh, {owner_, owned->is.epoch}, address, options_.lease);
  if (!epoch.ok()) return epoch.status();  // if it was done all the same, the epoch tells
  owned->gone = absl::AbortedError(absl::StrCat("the mesh was handed over to ", address));
  owned->epoch = 0;
  return epoch;
}

}  // namespace dynmesh::server
