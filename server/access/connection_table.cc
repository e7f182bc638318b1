#include "server/access/connection_table.h"

#include <algorithm>

namespace dynmesh::server {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

// While an address has had too many wasted calls.
constexpr seconds kBlocked{1};
// And then its new connections enter one at a time.
constexpr seconds kProbation{30};
// From an answered call on, an address is no new one.
constexpr std::chrono::minutes kKnown{10};
// After which a connection of a new address without an answered call delays no other one: it may
// be one that makes no calls.
constexpr milliseconds kUnderWay{200};
// Between two sweeps of an address that has no room.
constexpr milliseconds kBetweenSweeps{50};
// Wasted calls of a second for which a connection with an answered call is cut, too: others may
// share it by a proxy.
constexpr std::uint64_t kWastedOfAnswered = 100;

double SecondsOf(ConnectionTable::Clock::duration d) {
  return std::chrono::duration<double>(d).count();
}

}  // namespace

double ConnectionTable::Bucket::Most(double rate) const { return std::max(1.0, seconds_ * rate); }

void ConnectionTable::Bucket::Fill(double rate, Time now) {
  const double most = Most(rate);
  if (!left_.has_value()) {
    left_ = most;
  } else if (now > filled_) {
    left_ = std::min(most, *left_ + rate * SecondsOf(now - filled_));
  }
  filled_ = now;
}

bool ConnectionTable::Bucket::Take(double rate, Time now) {
  if (rate == 0) return true;
  Fill(rate, now);
  if (*left_ < 1) return false;
  *left_ -= 1;
  return true;
}

void ConnectionTable::Bucket::GiveBack(double rate) {
  if (left_.has_value()) left_ = std::min(Most(rate), *left_ + 1);
}

bool ConnectionTable::Bucket::IsFull(double rate, Time now) {
  if (rate == 0) return true;
  Fill(rate, now);
  return *left_ >= Most(rate);
}

ConnectionTable::Address& ConnectionTable::AddressOfLocked(const PeerKey& peer, Time now) {
  if (addresses_.size() >= sweep_at_) ForgetAddressesLocked(now);
  std::unique_ptr<Address>& address = addresses_[ClientKeyOf(peer)];
  if (address == nullptr) address = std::make_unique<Address>();
  return *address;
}

// An address with full buckets and without a connection equals a new one.
void ConnectionTable::ForgetAddressesLocked(Time now) {
  absl::erase_if(addresses_, [&](auto& entry) {
    Address& address = *entry.second;
    return address.waiting.empty() && address.descriptors.empty() &&
           now >= address.probation_until && now >= address.known_until &&
           address.fresh.IsFull(limits_.new_per_second, now) &&
           address.wasted.IsFull(limits_.wasted_per_second, now);
  });
  sweep_at_ = std::max<std::size_t>(1024, 2 * addresses_.size());
}

bool ConnectionTable::IsOneUnderWayLocked(const Address& address, Time now) const {
  return address.unanswered > 0 &&
         (now < address.probation_until || now - address.entered < kUnderWay);
}

bool ConnectionTable::MayEnterLocked(Address& address, Time now) {
  if (EntersAlone(address, now) && IsOneUnderWayLocked(address, now)) {
    SweepIfDueLocked(address, now);
    if (IsOneUnderWayLocked(address, now)) return false;
  }
  return address.fresh.Take(limits_.new_per_second, now);
}

ConnectionTable::Arrival ConnectionTable::Arrive(const Waiting& connection, Time now) {
  const MutexLock lock(mutex_);
  Address& address = AddressOfLocked(connection.peer, now);
  const auto is_full = [&] {
    return address.descriptors.size() + address.waiting.size() >= limits_.per_address;
  };
  if (is_full()) SweepIfDueLocked(address, now);
  if (now < address.blocked_until || is_full() || address.waiting.size() >= kMostWaiting) {
    ++counts_.refused;
    return Arrival::kRefused;
  }
  if (address.waiting.empty() && MayEnterLocked(address, now)) return Arrival::kEnters;
  address.waiting.push_back(connection);
  ++counts_.waiting;
  return Arrival::kWaits;
}

void ConnectionTable::Enter(const PeerKey& peer, const Socket& socket, Time now) {
  const MutexLock lock(mutex_);
  ForgetLocked(socket.descriptor);
  Address& address = AddressOfLocked(peer, now);
  address.descriptors.insert(socket.descriptor);
  ++address.unanswered;
  address.entered = now;
  Connection connection;
  connection.peer = peer;
  connection.cookie = socket.cookie;
  connections_.insert_or_assign(socket.descriptor, connection);
  descriptors_.insert_or_assign(peer, socket.descriptor);
  unanswered_.fetch_add(1, std::memory_order_relaxed);
}

void ConnectionTable::ForgetLocked(int descriptor) {
  const auto it = connections_.find(descriptor);
  if (it == connections_.end()) return;
  const Connection& connection = it->second;
  const PeerKey peer = connection.peer;
  if (!connection.is_answered) unanswered_.fetch_sub(1, std::memory_order_relaxed);
  if (const auto address = addresses_.find(ClientKeyOf(peer)); address != addresses_.end()) {
    address->second->descriptors.erase(descriptor);
    if (!connection.is_answered && !connection.is_cut) --address->second->unanswered;
  }
  // The client may have opened another one from the same port.
  const auto named = descriptors_.find(peer);
  if (named != descriptors_.end() && named->second == descriptor) descriptors_.erase(named);
  connections_.erase(it);
}

void ConnectionTable::SweepIfDueLocked(Address& address, Time now) {
  if (now - address.swept < kBetweenSweeps) return;
  address.swept = now;
  SweepLocked(address);
}

void ConnectionTable::SweepLocked(const Address& address) {
  std::vector<int> closed;
  for (const int descriptor : address.descriptors) {
    if (!system_.is_open({descriptor, connections_.at(descriptor).cookie})) {
      closed.push_back(descriptor);
    }
  }
  for (const int descriptor : closed) ForgetLocked(descriptor);
}

void ConnectionTable::Sweep() {
  const MutexLock lock(mutex_);
  for (const auto& [key, address] : addresses_) SweepLocked(*address);
}

ConnectionTable::Ready ConnectionTable::TakeReady(Time now,
                                                  const std::function<Sender(int)>& look) {
  Ready ready;
  const MutexLock lock(mutex_);
  if (counts_.waiting == 0) return ready;
  for (auto& [key, address] : addresses_) {
    const bool is_blocked = now < address->blocked_until;
    const bool enters_alone = EntersAlone(*address, now);
    bool has_room = true;
    std::deque<Waiting> stay;
    for (; !address->waiting.empty(); address->waiting.pop_back()) {
      const Waiting& waiting = address->waiting.back();
      const Sender sender = is_blocked ? Sender::kLeft : look(waiting.socket);
      const bool is_late = now - waiting.since >= limits_.silence;
      if (sender == Sender::kLeft || (sender == Sender::kSilent && is_late)) {
        ready.close.push_back(waiting.socket);
        continue;
      }
      has_room = has_room && (sender == Sender::kSilent || MayEnterLocked(*address, now));
      if (sender == Sender::kReady && has_room) {
        ready.enter.push_back(waiting);
        if (enters_alone) has_room = false;
      } else {
        stay.push_front(waiting);
      }
    }
    address->waiting = std::move(stay);
  }
  counts_.waiting -= ready.enter.size() + ready.close.size();
  return ready;
}

bool ConnectionTable::HasWaiting() const {
  const MutexLock lock(mutex_);
  return counts_.waiting > 0;
}

std::vector<int> ConnectionTable::TakeWaiting() {
  std::vector<int> sockets;
  const MutexLock lock(mutex_);
  for (const auto& [key, address] : addresses_) {
    for (const Waiting& waiting : address->waiting) sockets.push_back(waiting.socket);
    address->waiting.clear();
  }
  counts_.waiting = 0;
  return sockets;
}

bool ConnectionTable::Answered(const PeerKey& peer, Time now) {
  const MutexLock lock(mutex_);
  const auto named = descriptors_.find(peer);
  if (named == descriptors_.end()) return false;
  Connection& connection = connections_.at(named->second);
  if (connection.is_answered || connection.is_cut) return false;
  connection.is_answered = true;
  unanswered_.fetch_sub(1, std::memory_order_relaxed);
  Address& address = AddressOfLocked(peer, now);
  --address.unanswered;
  address.known_until = now + kKnown;
  address.fresh.GiveBack(limits_.new_per_second);
  return !address.waiting.empty();
}

bool ConnectionTable::Wasted(const PeerKey& peer, Time now) {
  const MutexLock lock(mutex_);
  ++counts_.wasted;
  Address& address = AddressOfLocked(peer, now);
  const bool is_within = address.wasted.Take(limits_.wasted_per_second, now);
  if (!is_within) {
    address.blocked_until = now + kBlocked;
    address.probation_until = now + kProbation;
  }
  const auto named = descriptors_.find(peer);
  if (named == descriptors_.end()) return false;
  Connection& connection = connections_.at(named->second);
  if (connection.is_cut) return false;  // the call was under way
  if (now - connection.second >= seconds(1)) {
    connection.second = now;
    connection.wasted = 0;
  }
  ++connection.wasted;
  if (is_within || (connection.is_answered && connection.wasted < kWastedOfAnswered)) return false;
  if (!connection.is_answered) --address.unanswered;
  connection.is_cut = true;
  ++counts_.cut;
  system_.cut({named->second, connection.cookie});
  return true;
}

ConnectionTable::Counts ConnectionTable::counts() const {
  const MutexLock lock(mutex_);
  Counts counts = counts_;
  counts.open = connections_.size();
  return counts;
}

std::size_t ConnectionTable::addresses() const {
  const MutexLock lock(mutex_);
  return addresses_.size();
}

}  // namespace dynmesh::server
