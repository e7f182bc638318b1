#include "server/http/http_server.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <list>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/mutex.h"
#include "server/base/listening.h"
#include "server/http/http_connection.h"

namespace dynmesh::server {
namespace {

using std::chrono::milliseconds;

// Connections that are being refused, and the time that one has to send its request.
constexpr std::size_t kMostRefused = 32;
constexpr milliseconds kRefusing{1000};

struct Client {
  std::string ip;
  int port = 0;
};

Client ClientOf(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET) {
    const auto& in = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &in.sin_addr, text.data(), text.size());
    return {text.data(), ntohs(in.sin_port)};
  }
  const auto& in = reinterpret_cast<const sockaddr_in6&>(address);
  const bool is_v4 = IN6_IS_ADDR_V4MAPPED(&in.sin6_addr);
  inet_ntop(is_v4 ? AF_INET : AF_INET6, &in.sin6_addr.s6_addr[is_v4 ? 12 : 0], text.data(),
            text.size());
  return {text.data(), ntohs(in.sin6_port)};
}

std::string PeerText(const Client& client) {
  return absl::StrContains(client.ip, ':')
             ? absl::StrCat("ipv6:%5B", client.ip, "%5D:", client.port)
             : absl::StrCat("ipv4:", client.ip, ":", client.port);
}

void SetUp(int socket) {
  const auto set = [socket](int level, int option, int value) {
    setsockopt(socket, level, option, &value, sizeof(value));
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  // A machine that vanished is noticed, also if nothing is sent to it.
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 30);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 30);
  set(IPPROTO_TCP, TCP_KEEPCNT, 4);
}

HttpReply TooMany() {
  return PlainReply(503, "too many connections of HTTP are open: try again later\n",
                    {{"Retry-After", "1"}});
}

}  // namespace

class HttpServer::Impl {
 public:
  Impl(Listening listening, const Limits& limits, Handler handler)
      : listening_(std::move(listening)),
        limits_(limits),
        handler_(std::move(handler)),
        wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
    refusing_.receive_limit = refusing_.idle_limit = refusing_.send_limit = kRefusing;
    refusing_.most_request_bytes = limits.most_request_bytes;
  }

  ~Impl() {
    Stop(milliseconds(0));
    for (const int socket : listening_.sockets) close(socket);
    if (wake_ >= 0) close(wake_);
  }

  bool Start() {
    if (wake_ < 0) return false;
    thread_ = std::thread([this] { Run(); });
    return true;
  }

  void Stop(milliseconds grace) {
    if (!thread_.joinable()) return;
    ending_ = true;
    const std::uint64_t one = 1;
    (void)!write(wake_, &one, sizeof(one));
    thread_.join();
    {
      const MutexLock lock(mutex_);
      for (const Connection& c : connections_) {
        if (!c.is_answered) shutdown(c.socket, SHUT_RD);
      }
      idle_.WaitFor(mutex_, grace, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
        return std::none_of(connections_.begin(), connections_.end(),
                            [](const Connection& c) { return c.is_answered; });
      });
      stopping_ = true;
      for (const Connection& c : connections_) shutdown(c.socket, SHUT_RDWR);
    }
    for (Connection& connection : TakeAll()) Join(connection);
  }

  int port() const { return listening_.port; }

  Counts counts() const {
    const MutexLock lock(mutex_);
    Counts counts{0, refused_};
    for (const Connection& c : connections_) counts.open += !c.is_over && !c.is_refused;
    return counts;
  }

 private:
  struct Connection {
    int socket = -1;
    Client client;
    bool is_refused = false;
    bool is_answered = false;  // a reply is being made or sent
    bool is_over = false;      // its thread ends, and does not use it any more
    std::thread thread = {};
  };
  using Connections = std::list<Connection>;

  void Run() {
    std::vector<pollfd> waits = {{wake_, POLLIN, 0}};
    for (const int socket : listening_.sockets) waits.push_back({socket, POLLIN, 0});
    while (!ending_) {
      poll(waits.data(), waits.size(), -1);
      for (const int socket : listening_.sockets) {
        while (!ending_ && AcceptOne(socket)) {
        }
      }
    }
  }

  bool AcceptOne(int listening) {
    for (Connection& connection : TakeOver()) Join(connection);
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    const int socket = accept4(listening, reinterpret_cast<sockaddr*>(&address), &size,
                               SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EINTR || errno == ECONNABORTED) return true;
      if (errno != EAGAIN) std::this_thread::sleep_for(kAcceptRetry);
      return false;
    }
    SetUp(socket);
    const MutexLock lock(mutex_);
    Connection connection{socket, ClientOf(address)};
    std::size_t served = 0, of_client = 0;
    for (const Connection& c : connections_) {
      served += !c.is_refused;
      of_client += !c.is_refused && c.client.ip == connection.client.ip;
    }
    const std::size_t most_of_client = std::max<std::size_t>(1, limits_.most_connections / 2);
    connection.is_refused = served >= limits_.most_connections || of_client >= most_of_client;
    refused_ += connection.is_refused;
    if (connection.is_refused && connections_.size() - served >= kMostRefused) {
      close(socket);
      return true;
    }
    connections_.push_back(std::move(connection));
    Connection& added = connections_.back();
    try {
      added.thread = std::thread([this, &added] { Serve(added); });
    } catch (const std::system_error&) {  // no more threads
      refused_ += !added.is_refused;
      close(socket);
      connections_.pop_back();
    }
    return true;
  }

  void Serve(Connection& served) {
    HttpConnection connection(served.socket, served.is_refused ? refusing_ : limits_, stopping_);
    while (!ending_) {
      std::optional<HttpRequest> request = connection.Receive();
      if (!request) break;
      request->peer = PeerText(served.client);
      SetAnswered(served, true);
      const bool goes_on =
          connection.Send(*request, served.is_refused ? TooMany() : handler_(*request));
      SetAnswered(served, false);
      if (!goes_on || served.is_refused) break;
    }
    shutdown(served.socket, SHUT_RDWR);
    const MutexLock lock(mutex_);
    served.is_over = true;
  }

  void SetAnswered(Connection& connection, bool is_answered) {
    const MutexLock lock(mutex_);
    connection.is_answered = is_answered;
    if (!is_answered) idle_.NotifyAll();
  }

  // Those that are over.
  Connections TakeOver() {
    Connections over;
    const MutexLock lock(mutex_);
    for (auto it = connections_.begin(); it != connections_.end();) {
      const auto next = std::next(it);
      if (it->is_over) over.splice(over.end(), connections_, it);
      it = next;
    }
    return over;
  }
  // All. None is added any more; elements stay where their threads know them.
  Connections TakeAll() {
    const MutexLock lock(mutex_);
    return std::move(connections_);
  }

  static void Join(Connection& connection) {
    connection.thread.join();
    close(connection.socket);
  }

  const Listening listening_;
  const Limits limits_;
  Limits refusing_;
  const Handler handler_;
  std::atomic<bool> ending_{false};    // no more requests
  std::atomic<bool> stopping_{false};  // replies end, too
  const int wake_;
  mutable Mutex mutex_;
  CondVar idle_;
  Connections connections_ ABSL_GUARDED_BY(mutex_);
  std::uint64_t refused_ ABSL_GUARDED_BY(mutex_) = 0;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpServer>> HttpServer::Listen(const std::string& host, int port,
                                                               const Limits& limits,
                                                               Handler handler) {
  absl::StatusOr<Listening> listening = ListenOn(host, absl::StrCat(port));
  if (!listening.ok()) return listening.status();
  auto impl = std::make_unique<Impl>(*std::move(listening), limits, std::move(handler));
  if (!impl->Start()) return absl::UnavailableError("too many files are open");
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(impl)));
}

HttpServer::HttpServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

HttpServer::~HttpServer() = default;

void HttpServer::Stop(std::chrono::milliseconds grace) { impl_->Stop(grace); }

int HttpServer::port() const { return impl_->port(); }

HttpServer::Counts HttpServer::counts() const { return impl_->counts(); }

}  // namespace dynmesh::server
