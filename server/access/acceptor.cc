#include "server/access/acceptor.h"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "server/base/listening.h"
#include "server/base/log.h"
#include "server/base/process.h"

namespace dynmesh::server {
namespace {

using Clock = ConnectionTable::Clock;

// For files, and for sockets that gRPC opens itself.
constexpr std::uint64_t kReserve = 67;
// Until the next try when there is no descriptor for a connection.
constexpr absl::Duration kAcceptAgain = absl::Milliseconds(50);
// At the connections that wait. A look costs a system call for each.
constexpr std::chrono::milliseconds kBetweenLooks{10};
// Least time between two sweeps while there is no room.
constexpr absl::Duration kSweepEvery = absl::Milliseconds(50);

void SetOption(int socket, int level, int option, int value) {
  setsockopt(socket, level, option, &value, sizeof(value));
}

using Socket = ConnectionTable::Socket;

// 0 for a descriptor that is no socket.
std::uint64_t CookieOf(int descriptor) {
  std::uint64_t cookie = 0;
  socklen_t size = sizeof(cookie);
  if (getsockopt(descriptor, SOL_SOCKET, SO_COOKIE, &cookie, &size) != 0) return 0;
  return cookie;
}

bool IsOpen(const Socket& socket) { return CookieOf(socket.descriptor) == socket.cookie; }

// Ends a connection that gRPC has. A shutdown would leave what has been received, and gRPC would
// read it all first; this drops it, and the client gets a reset.
void Cut(const Socket& socket) {
  if (!IsOpen(socket)) return;
  sockaddr nowhere{};
  nowhere.sa_family = AF_UNSPEC;
  connect(socket.descriptor, &nowhere, sizeof(nowhere));
}

ConnectionTable::Sender LookAt(int socket) {
  pollfd ends{socket, POLLIN | POLLRDHUP, 0};
  if (poll(&ends, 1, 0) <= 0) return ConnectionTable::Sender::kSilent;
  return (ends.revents & ~POLLIN) == 0 ? ConnectionTable::Sender::kReady
                                       : ConnectionTable::Sender::kLeft;
}

}  // namespace

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

absl::StatusOr<std::unique_ptr<Acceptor>> Acceptor::Listen(const std::string& host_port,
                                                           const Limits& limits) {
  const std::size_t colon = host_port.rfind(':');
  absl::string_view host = absl::string_view(host_port).substr(0, colon);
  const std::string service = colon == std::string::npos ? "" : host_port.substr(colon + 1);
  if (absl::ConsumePrefix(&host, "[")) absl::ConsumeSuffix(&host, "]");
  absl::StatusOr<Listening> listening = ListenOn(std::string(host), service);
  if (!listening.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", host_port, ": ", listening.status().message()));
  }
  std::unique_ptr<Acceptor> acceptor(
      new Acceptor(std::move(listening->sockets), listening->port, limits));
  if (acceptor->wake_ < 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", host_port, ": too many files are open"));
  }
  return acceptor;
}

Acceptor::Acceptor(std::vector<int> sockets, int port, const Limits& limits)
    : sockets_(std::move(sockets)),
      port_(port),
      limits_(limits),
      table_(limits.of_address, {&Cut, &IsOpen}),
      wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

Acceptor::~Acceptor() {
  Stop();
  for (const std::vector<int>& all : {table_.TakeWaiting(), sockets_}) {
    for (const int open : all) close(open);
  }
  if (wake_ >= 0) close(wake_);
}

void Acceptor::Start(Sink sink, absl::Duration silence) {
  sink_ = std::move(sink);
  silence_ms_ = static_cast<int>(absl::ToInt64Milliseconds(silence));
  others_ = OpenDescriptors();
  thread_ = std::thread([this] { Run(); });
}

void Acceptor::Stop() {
  if (!thread_.joinable()) return;
  stopping_ = true;
  Wake();
  thread_.join();
}

void Acceptor::Wake() const {
  const std::uint64_t one = 1;
  (void)!write(wake_, &one, sizeof(one));
}

void Acceptor::Run() {
  std::vector<pollfd> waits = {{wake_, POLLIN, 0}};
  for (const int listening : sockets_) waits.push_back({listening, POLLIN, 0});
  Clock::time_point next_look;
  while (!stopping_) {
    poll(waits.data(), waits.size(),
         table_.HasWaiting() ? static_cast<int>(kBetweenLooks.count()) : -1);
    if (waits[0].revents != 0) {
      std::uint64_t ignored = 0;
      (void)!read(wake_, &ignored, sizeof(ignored));
    }
    for (std::size_t i = 1; i < waits.size(); ++i) {
      if (waits[i].revents != 0) AcceptAll(waits[i].fd);
    }
    if (Clock::now() < next_look) continue;
    const ConnectionTable::Ready ready = table_.TakeReady(Clock::now(), &LookAt);
    for (const int socket : ready.close) close(socket);
    for (const ConnectionTable::Waiting& connection : ready.enter) LetIn(connection);
    next_look = Clock::now() + kBetweenLooks;
  }
}

// A part at a time: others wait for a look.
void Acceptor::AcceptAll(int listening) {
  constexpr int kAtATime = 64;
  for (int i = 0; i < kAtATime && AcceptOne(listening); ++i) {
  }
}

// False: there is none, or no descriptor for it.
bool Acceptor::AcceptOne(int listening) {
  sockaddr_storage from{};
  socklen_t size = sizeof(from);
  ConnectionTable::Waiting connection;
  connection.socket =
      accept4(listening, reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (connection.socket < 0) {
    if (errno == EINTR || errno == ECONNABORTED) return true;
    // Not even a descriptor to refuse it with. Connections without a handshake time out and free
    // some.
    if (errno != EAGAIN) absl::SleepFor(kAcceptAgain);
    return false;
  }
  connection.peer = PeerKeyOf(from).value_or(PeerKey());
  connection.since = Clock::now();
  if (!IsRoom()) {
    close(connection.socket);
    return true;
  }
  switch (table_.Arrive(connection, connection.since)) {
    case ConnectionTable::Arrival::kEnters:
      LetIn(connection);
      break;
    case ConnectionTable::Arrival::kWaits:
      break;
    case ConnectionTable::Arrival::kRefused:
      close(connection.socket);
      if (full_line_.IsDue()) {
        Log(LogLevel::kWarning, "connection_limit",
            {{"address", ClientText(ClientKeyOf(connection.peer))},
             {"limit", limits_.of_address.per_address},
             {"message",
              "this address has as many connections as it may have, or its calls were cut off"}});
      }
      break;
  }
  return true;
}

void Acceptor::LetIn(const ConnectionTable::Waiting& connection) {
  SetOption(connection.socket, IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(connection.socket, IPPROTO_TCP, TCP_USER_TIMEOUT, silence_ms_);
  table_.Enter(connection.peer, {connection.socket, CookieOf(connection.socket)}, Clock::now());
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.listener_fd = sockets_.front();
  parameters.fd = connection.socket;
  sink_->HandleNewConnection(&parameters);
}

bool Acceptor::IsRoom() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  const std::uint64_t free = files.rlim_cur - std::min(files.rlim_cur, others_ + kReserve);
  const std::uint64_t most = std::min(limits_.connections, free);
  const auto open_now = [this] {
    const ConnectionTable::Counts counts = table_.counts();
    return counts.open + counts.waiting;
  };
  std::uint64_t open = open_now();
  if (open < most) return true;
  const absl::Time now = absl::Now();
  if (now - swept_ < kSweepEvery) return false;
  swept_ = now;
  table_.Sweep();
  open = open_now();
  if (open < most) return true;
  if (full_line_.IsDue()) {
    Log(LogLevel::kWarning, "connection_limit", {{"open", open}, {"limit", most}});
  }
  return false;
}

void Acceptor::Answered(absl::string_view peer) {
  const auto key = PeerKeyOf(peer);
  if (key.has_value() && table_.Answered(*key, Clock::now())) Wake();
}

void Acceptor::Wasted(absl::string_view peer) {
  const auto key = PeerKeyOf(peer);
  if (!key.has_value()) return;
  if (!table_.Wasted(*key, Clock::now()) || !cut_line_.IsDue()) return;
  Log(LogLevel::kWarning, "connections_cut",
      {{"address", ClientText(ClientKeyOf(*key))},
       {"cut", table_.counts().cut},
       {"limit", limits_.of_address.wasted_per_second},
       {"message",
        "more calls a second were refused for their token, or cancelled at once, than one address "
        "may make: its new connections are refused for a second"}});
}

}  // namespace dynmesh::server
