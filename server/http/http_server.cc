#include "server/http/http_server.h"

#include <arpa/inet.h>
#include <httplib.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <list>
#include <thread>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/mutex.h"
#include "server/base/listening.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

// Of a request beside its body.
constexpr std::size_t kMostHeadBytes = 64 << 10;
// Until the next try when there is no descriptor for a connection.
constexpr milliseconds kRetry{50};
// Of this server alone: what the library would decode is refused instead.
constexpr char kEncoding[] = "dynmesh-content-encoding";

int WaitFor(int socket, short events, Clock::time_point deadline) {
  pollfd wanted{socket, events, 0};
  while (true) {
    const auto left = std::chrono::ceil<milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return 0;
    const int ready = poll(&wanted, 1, static_cast<int>(std::min<std::int64_t>(left, 60'000)));
    if (ready > 0 || (ready < 0 && errno != EINTR)) return ready;
  }
}

bool HasLeft(int socket) {
  pollfd ends{socket, POLLRDHUP, 0};
  return poll(&ends, 1, 0) > 0;
}

struct Remote {
  std::string ip;
  int port = 0;
  bool is_v6 = false;
};

Remote RemoteOf(const sockaddr_storage& address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address.ss_family == AF_INET) {
    const auto& in = reinterpret_cast<const sockaddr_in&>(address);
    inet_ntop(AF_INET, &in.sin_addr, text.data(), text.size());
    return {text.data(), ntohs(in.sin_port), false};
  }
  const auto& in = reinterpret_cast<const sockaddr_in6&>(address);
  if (IN6_IS_ADDR_V4MAPPED(&in.sin6_addr)) {
    inet_ntop(AF_INET, &in.sin6_addr.s6_addr[12], text.data(), text.size());
    return {text.data(), ntohs(in.sin6_port), false};
  }
  inet_ntop(AF_INET6, &in.sin6_addr, text.data(), text.size());
  return {text.data(), ntohs(in.sin6_port), true};
}

std::string PeerText(const std::string& ip, int port) {
  return absl::StrContains(ip, ':') ? absl::StrCat("ipv6:%5B", ip, "%5D:", port)
                                    : absl::StrCat("ipv4:", ip, ":", port);
}

// A socket as the library reads and writes it, by the limits of a request. What it says of its
// socket is no descriptor: the library refuses those from 1,024 on.
class SocketStream final : public httplib::Stream {
 public:
  SocketStream(int socket, Remote remote, const HttpServer::Limits& limits)
      : socket_(socket), remote_(std::move(remote)), limits_(limits) {}

  // The request did not come whole, or was too long.
  bool is_cut() const { return is_cut_; }

  // Waits for the first byte of a request. False: the client has gone, or sent none.
  bool AwaitRequest() {
    left_ = limits_.most_request_bytes + kMostHeadBytes;
    if (at_ < end_) {
      deadline_ = Clock::now() + limits_.receive_limit;
      return true;
    }
    deadline_ = Clock::now() + limits_.idle_limit;
    if (!Fill()) return false;
    deadline_ = Clock::now() + limits_.receive_limit;
    return true;
  }

  bool is_readable() const override { return true; }
  bool is_writable() const override { return !HasLeft(socket_); }

  ssize_t read(char* data, std::size_t size) override {
    const bool has_more = at_ < end_ || Fill();
    const std::size_t count = has_more ? std::min({size, end_ - at_, left_}) : 0;
    if (count == 0) {
      is_cut_ = true;
      return -1;
    }
    std::copy_n(buffer_.data() + at_, count, data);
    at_ += count;
    left_ -= count;
    return static_cast<ssize_t>(count);
  }

  ssize_t write(const char* data, std::size_t size) override {
    const auto limit = limits_.send_limit.count() > 0 ? limits_.send_limit : std::chrono::hours(24);
    while (true) {
      const ssize_t sent = send(socket_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent >= 0) return sent;
      if (errno == EINTR) continue;
      if (errno != EAGAIN || WaitFor(socket_, POLLOUT, Clock::now() + limit) <= 0) return -1;
    }
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    ip = remote_.ip;
    port = remote_.port;
  }
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return -1; }

 private:
  bool Fill() {
    while (true) {
      const ssize_t got = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got > 0) {
        at_ = 0;
        end_ = static_cast<std::size_t>(got);
        return true;
      }
      if (got == 0) return false;
      if (errno == EINTR) continue;
      if (errno != EAGAIN || WaitFor(socket_, POLLIN, deadline_) <= 0) return false;
    }
  }

  const int socket_;
  const Remote remote_;
  const HttpServer::Limits& limits_;
  Clock::time_point deadline_;
  std::size_t left_ = 0;  // bytes that the request may still have
  bool is_cut_ = false;
  std::array<char, 8192> buffer_;
  std::size_t at_ = 0, end_ = 0;
};

// What the library writes in pieces.
class Sink final : public HttpSink {
 public:
  Sink(httplib::DataSink& sink, const std::atomic<bool>& stopping)
      : sink_(sink), stopping_(stopping) {}
  bool Write(absl::string_view bytes) override { return sink_.write(bytes.data(), bytes.size()); }
  bool IsOpen() override { return !stopping_ && sink_.is_writable(); }

 private:
  httplib::DataSink& sink_;
  const std::atomic<bool>& stopping_;
};

// Parses requests and writes answers. Thread-safe once it has been made.
class Protocol final : public httplib::Server {
 public:
  Protocol(const HttpServer::Limits& limits, HttpServer::Handler handler,
           const std::atomic<bool>& stopping)
      : handler_(std::move(handler)), stopping_(stopping) {
    // The library writes content in pieces only while it listens itself.
    svr_sock_ = 0;
    set_payload_max_length(limits.most_request_bytes);
    set_keep_alive_max_count(1'000'000);  // told to clients only
    set_keep_alive_timeout(static_cast<time_t>(limits.idle_limit.count() / 1000));
    const auto answer = [this](const httplib::Request& request, httplib::Response& response) {
      Answer(request, response);
    };
    constexpr char kAny[] = "[^]*";
    Get(kAny, answer).Post(kAny, answer).Put(kAny, answer);
    Patch(kAny, answer).Delete(kAny, answer).Options(kAny, answer);
  }

  // Answers the request that has begun to come. False: the connection is of no more use.
  bool AnswerNext(SocketStream& stream) {
    bool closes = false, has_unread = false;
    const bool good = process_request(
        stream, /*close_connection=*/false, closes, [&has_unread](httplib::Request& request) {
          request.ranges.clear();
          // Of these methods the library reads no body: it would be the next request.
          has_unread =
              (request.method == "GET" || request.method == "HEAD" || request.method == "OPTIONS" ||
               request.method == "DELETE") &&
              (request.has_header("Content-Length") || request.has_header("Transfer-Encoding"));
          // A few bytes may decode to very many.
          if (const auto coded = request.headers.find("Content-Encoding");
              coded != request.headers.end()) {
            const std::string coding = coded->second;
            request.headers.erase("Content-Encoding");
            if (coding != "identity") request.headers.emplace(kEncoding, coding);
          }
        });
    return good && !closes && !has_unread && !stream.is_cut();
  }

 private:
  void Answer(const httplib::Request& request, httplib::Response& response) const {
    if (request.has_header(kEncoding)) {
      response.status = 415;
      response.set_header("Accept-Encoding", "identity");
      return response.set_content("requests are taken uncompressed\n", "text/plain");
    }
    HttpRequest asked{request.method,
                      request.path,
                      {},
                      request.body,
                      PeerText(request.remote_addr, request.remote_port)};
    asked.headers.reserve(request.headers.size());
    for (const auto& [name, value] : request.headers) asked.headers.emplace_back(name, value);
    HttpReply answer = handler_(asked);
    response.status = answer.status;
    for (const auto& [name, value] : answer.headers) response.headers.emplace(name, value);
    if (answer.stream == nullptr) return response.set_content(answer.body, answer.type);
    response.set_chunked_content_provider(
        answer.type, [this, write = std::move(answer.stream)](std::size_t, httplib::DataSink& to) {
          Sink sink(to, stopping_);
          write(sink);
          if (!sink.IsOpen()) return false;
          to.done();
          return true;
        });
  }

  const HttpServer::Handler handler_;
  const std::atomic<bool>& stopping_;
};

HttpReply Refuse(const HttpRequest&) {
  return {503,
          {{"Retry-After", "1"}, {"Connection", "close"}},
          "text/plain",
          "too many connections of HTTP are open: try again later\n",
          nullptr};
}

}  // namespace

const std::string* HttpRequest::Find(absl::string_view name) const {
  for (const auto& [known, value] : headers) {
    if (absl::EqualsIgnoreCase(known, name)) return &value;
  }
  return nullptr;
}

class HttpServer::Impl {
 public:
  Impl(Listening listening, const Limits& limits, Handler handler)
      : listening_(std::move(listening)),
        limits_(limits),
        protocol_(limits_, std::move(handler), stopping_),
        refusal_(limits_, &Refuse, stopping_),
        wake_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {}

  ~Impl() {
    Stop();
    for (const int socket : listening_.sockets) close(socket);
    if (wake_ >= 0) close(wake_);
  }

  void Stop() {
    if (!thread_.joinable()) return;
    stopping_ = true;
    const std::uint64_t one = 1;
    (void)!write(wake_, &one, sizeof(one));
    thread_.join();
    {
      const MutexLock lock(mutex_);
      for (const Connection& connection : connections_) shutdown(connection.socket, SHUT_RDWR);
    }
    Reap(/*all=*/true);
  }

  bool Start() {
    if (wake_ < 0) return false;
    thread_ = std::thread([this] { Run(); });
    return true;
  }

  int port() const { return listening_.port; }

  Counts counts() const {
    const MutexLock lock(mutex_);
    Counts counts = counts_;
    for (const Connection& connection : connections_) counts.open += !connection.is_over;
    return counts;
  }

 private:
  struct Connection {
    int socket = -1;
    std::thread thread;
    bool is_over = false;  // its thread ends, and does not use it any more
  };

  void Run() {
    std::vector<pollfd> waits = {{wake_, POLLIN, 0}};
    for (const int socket : listening_.sockets) waits.push_back({socket, POLLIN, 0});
    while (!stopping_) {
      poll(waits.data(), waits.size(), -1);
      for (const int socket : listening_.sockets) {
        while (!stopping_ && AcceptOne(socket)) {
        }
      }
      Reap(/*all=*/false);
    }
  }

  bool AcceptOne(int listening) {
    sockaddr_storage address{};
    socklen_t size = sizeof(address);
    const int socket = accept4(listening, reinterpret_cast<sockaddr*>(&address), &size,
                               SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EINTR || errno == ECONNABORTED) return true;
      if (errno != EAGAIN) std::this_thread::sleep_for(kRetry);
      return false;
    }
    // A machine that vanished is noticed, if nothing is sent to it.
    const int yes = 1, idle = 30, times = 4;
    setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof(yes));
    setsockopt(socket, SOL_SOCKET, SO_KEEPALIVE, &yes, sizeof(yes));
    setsockopt(socket, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof(idle));
    setsockopt(socket, IPPROTO_TCP, TCP_KEEPINTVL, &idle, sizeof(idle));
    setsockopt(socket, IPPROTO_TCP, TCP_KEEPCNT, &times, sizeof(times));
    Reap(/*all=*/false);
    const MutexLock lock(mutex_);
    const bool refuse = connections_.size() >= limits_.most_connections;
    counts_.refused += refuse;
    if (connections_.size() >= 2 * limits_.most_connections) {
      close(socket);
      return true;
    }
    connections_.push_back({socket, {}, false});
    Connection& connection = connections_.back();
    try {
      connection.thread = std::thread([this, &connection, refuse, remote = RemoteOf(address)] {
        Serve(connection.socket, remote, refuse);
        const MutexLock done(mutex_);
        connection.is_over = true;
      });
    } catch (const std::system_error&) {  // no more threads
      close(socket);
      connections_.pop_back();
      ++counts_.refused;
    }
    return true;
  }

  void Serve(int socket, const Remote& remote, bool refuse) {
    SocketStream stream(socket, remote, limits_);
    if (refuse) {
      if (stream.AwaitRequest()) refusal_.AnswerNext(stream);
    } else {
      while (!stopping_ && stream.AwaitRequest() && protocol_.AnswerNext(stream)) {
      }
    }
    shutdown(socket, SHUT_RDWR);
  }

  // Joins threads that end; with `all`, waits for the others.
  void Reap(bool all) {
    std::list<Connection> over;
    {
      const MutexLock lock(mutex_);
      for (auto it = connections_.begin(); it != connections_.end();) {
        const auto next = std::next(it);
        if (it->is_over) over.splice(over.end(), connections_, it);
        it = next;
      }
    }
    for (Connection& connection : over) {
      connection.thread.join();
      close(connection.socket);
    }
    if (!all) return;
    // No thread is added any more.
    while (true) {
      Connection* first = nullptr;
      {
        const MutexLock lock(mutex_);
        if (connections_.empty()) return;
        first = &connections_.front();
      }
      first->thread.join();
      close(first->socket);
      const MutexLock lock(mutex_);
      connections_.pop_front();
    }
  }

  const Listening listening_;
  const Limits limits_;
  std::atomic<bool> stopping_{false};
  Protocol protocol_;
  Protocol refusal_;
  const int wake_;
  mutable Mutex mutex_;
  std::list<Connection> connections_ ABSL_GUARDED_BY(mutex_);
  Counts counts_ ABSL_GUARDED_BY(mutex_);  // without those that are open
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

void HttpServer::Stop() { impl_->Stop(); }

int HttpServer::port() const { return impl_->port(); }

HttpServer::Counts HttpServer::counts() const { return impl_->counts(); }

}  // namespace dynmesh::server
