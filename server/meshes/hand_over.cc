#include "server/meshes/hand_over.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <future>
#include <thread>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/cluster/placement.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

// Between two looks for the claim.
constexpr std::chrono::milliseconds kLook(5);

// What became of a mesh; its strand sets it, perhaps after the end of the call.
struct Given {
  std::int64_t epoch = 0;  // in which it was handed over; 0: it was not
  std::promise<void> ended;
};

absl::StatusOr<MeshOwner> Give(SharedJournal* journal, const std::string& address,
                               const std::vector<std::string>& nodes, const std::string& id,
                               Journal::Key key) {
  absl::StatusOr<SharedJournal::Located> located = journal->Locate(id);
  if (!located.ok()) return located.status();
  std::erase(located->followers, address);
  const std::vector<std::string>& choice = located->followers.empty() ? nodes : located->followers;
  const std::string& next = choice[*ChooseNode(choice, id)];
  const absl::StatusOr<std::int64_t> epoch = journal->HandOver(key, next);
  if (!epoch.ok()) return epoch.status();
  return MeshOwner{next, *epoch};
}

// Until the new owner has claimed the mesh, which makes an epoch, or `end`.
void WaitForClaim(SharedJournal* journal, const std::string& id, std::int64_t epoch,
                  Clock::time_point end) {
  while (Clock::now() < end) {
    std::this_thread::sleep_for(kLook);
    const absl::StatusOr<SharedJournal::Located> located = journal->Locate(id);
    if (!located.ok() || located->epoch > epoch) return;
  }
}

}  // namespace

void HandMeshesOver(SharedJournal* journal, const std::string& address,
                    const std::vector<OwnedHost>& meshes, absl::Duration limit,
                    absl::Duration turn) {
  const Clock::time_point end = Clock::now() + absl::ToChronoNanoseconds(limit);
  absl::StatusOr<std::vector<std::string>> nodes = journal->LiveNodes();
  if (!nodes.ok()) return;
  std::erase(*nodes, address);
  if (nodes->empty()) return;
  turn = std::min(turn, limit / (4 * static_cast<std::int64_t>(meshes.size() + 1)));
  std::vector<std::future<void>> late;
  for (const auto& [host, key] : meshes) {
    const Clock::time_point over = Clock::now() + absl::ToChronoNanoseconds(turn);
    const std::string id = host->id();
    const auto given = std::make_shared<Given>();
    std::future<void> ended = given->ended.get_future();
    host->HandOver(
        [=, nodes = *nodes, key = key] {
          absl::StatusOr<MeshOwner> owner = Give(journal, address, nodes, id, key);
          if (owner.ok()) given->epoch = owner->epoch;
          return owner;
        },
        [given](const absl::Status&) { given->ended.set_value(); });
    if (ended.wait_until(over) != std::future_status::ready) {
      late.push_back(std::move(ended));
    } else if (given->epoch != 0) {
      WaitForClaim(journal, id, given->epoch, over);
    }
  }
  for (const std::future<void>& one : late) one.wait_until(end);
}

}  // namespace dynmesh::server
