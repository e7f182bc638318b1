#include "server/access/acceptor.h"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"
#include "absl/time/clock.h"
#include "server/base/listening.h"
#include "server/base/log.h"
#include "server/base/process.h"

namespace dynmesh::server {
namespace {

// For files, and for sockets that gRPC opens itself.
constexpr std::uint64_t kReserve = 67;
// Least time between two counts of descriptors while there is no room.
constexpr absl::Duration kCountEvery = absl::Milliseconds(50);
constexpr absl::Duration kWarnEvery = absl::Seconds(10);

void SetOption(int socket, int level, int option, int value) {
  setsockopt(socket, level, option, &value, sizeof(value));
}

}  // namespace

void RaiseDescriptorLimit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

absl::StatusOr<std::unique_ptr<Acceptor>> Acceptor::Listen(const std::string& host_port,
                                                           std::uint64_t max_connections) {
  const std::size_t colon = host_port.rfind(':');
  absl::string_view host = absl::string_view(host_port).substr(0, colon);
  const std::string service = colon == std::string::npos ? "" : host_port.substr(colon + 1);
  if (absl::ConsumePrefix(&host, "[")) absl::ConsumeSuffix(&host, "]");
  absl::StatusOr<Listening> listening = ListenOn(std::string(host), service);
  if (!listening.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", host_port, ": ", listening.status().message()));
  }
  return std::unique_ptr<Acceptor>(
      new Acceptor(std::move(listening->sockets), listening->port, max_connections));
}

Acceptor::Acceptor(std::vector<int> sockets, int port, std::uint64_t max_connections)
    : sockets_(std::move(sockets)), port_(port), max_connections_(max_connections) {}

Acceptor::~Acceptor() {
  Stop();
  for (const int listening : sockets_) close(listening);
}

void Acceptor::Start(Sink sink, absl::Duration silence) {
  sink_ = std::move(sink);
  silence_ms_ = static_cast<int>(absl::ToInt64Milliseconds(silence));
  if (pipe(stop_pipe_) != 0) return;
  others_ = OpenDescriptors();
  thread_ = std::thread([this] { Run(); });
}

void Acceptor::Stop() {
  if (!thread_.joinable()) return;
  close(stop_pipe_[1]);
  thread_.join();
  close(stop_pipe_[0]);
}

void Acceptor::Run() {
  std::vector<pollfd> waits = {{stop_pipe_[0], POLLIN, 0}};
  for (const int listening : sockets_) waits.push_back({listening, POLLIN, 0});
  while (true) {
    poll(waits.data(), waits.size(), -1);
    if (waits[0].revents != 0) return;
    for (std::size_t i = 1; i < waits.size(); ++i) {
      if (waits[i].revents != 0) AcceptOne(waits[i].fd);
    }
  }
}

void Acceptor::AcceptOne(int listening) {
  const int connection = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (connection < 0) {
    // Not even a descriptor to refuse it with. Connections without a handshake time out and free
    // some.
    if (errno != EAGAIN && errno != EINTR && errno != ECONNABORTED) absl::SleepFor(kCountEvery);
    return;
  }
  if (!IsRoom()) {
    close(connection);
    return;
  }
  ++open_;
  SetOption(connection, IPPROTO_TCP, TCP_NODELAY, 1);
  SetOption(connection, IPPROTO_TCP, TCP_USER_TIMEOUT, silence_ms_);
  grpc::experimental::ExternalConnectionAcceptor::NewConnectionParameters parameters;
  parameters.listener_fd = listening;
  parameters.fd = connection;
  sink_->HandleNewConnection(&parameters);
}

bool Acceptor::IsRoom() {
  rlimit files{};
  getrlimit(RLIMIT_NOFILE, &files);
  const std::uint64_t most = std::min<std::uint64_t>(
      max_connections_,
      files.rlim_cur - std::min<std::uint64_t>(files.rlim_cur, others_ + kReserve));
  if (open_ < most) return true;
  const absl::Time now = absl::Now();
  if (now - counted_ < kCountEvery) return false;
  counted_ = now;
  const std::uint64_t descriptors = OpenDescriptors() - 1;  // gRPC does not have the new one yet
  open_ = descriptors - std::min(descriptors, others_);
  if (open_ < most) return true;
  if (now - warned_ > kWarnEvery) {
    warned_ = now;
    Log(LogLevel::kWarning, "connection_limit", {{"open", open_}, {"limit", most}});
  }
  return false;
}

}  // namespace dynmesh::server
