#include "server/metrics/metrics_http.h"

#include <httplib.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/string_view.h"
#include "server/base/worker_pool.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kThreads = 2;
constexpr std::size_t kMaxWaiting = 16;  // connections not yet taken by a thread
constexpr std::size_t kMaxRequestBytes = 16 << 10;
constexpr std::chrono::seconds kMaxTime{5};  // of a connection
constexpr std::chrono::milliseconds kStopCheck{50};
constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";

struct Address {
  std::string host;
  int port = 0;
};

absl::StatusOr<Address> ParseAddress(absl::string_view listen) {
  const std::size_t colon = listen.rfind(':');
  absl::string_view host = colon == absl::string_view::npos ? "" : listen.substr(0, colon);
  const absl::string_view port = listen.substr(colon == absl::string_view::npos ? 0 : colon + 1);
  Address address;
  if (!absl::SimpleAtoi(port, &address.port) || address.port < 0 || address.port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat("metrics: '", listen, "' is not HOST:PORT, such as 127.0.0.1:9178"));
  }
  if (absl::StartsWith(host, "[") && absl::EndsWith(host, "]")) {
    host = host.substr(1, host.size() - 2);
  }
  address.host = host.empty() ? "127.0.0.1" : std::string(host);
  return address;
}

// The library's pool takes any number of connections; this one leaves further ones unaccepted.
class BoundedPool final : public httplib::TaskQueue {
 public:
  void enqueue(std::function<void()> task) override {
    {
      std::unique_lock lock(mutex_);
      room_.wait(lock, [this] { return waiting_ < kMaxWaiting; });
      ++waiting_;
    }
    pool_.Post([this, task = std::move(task)] {
      {
        const std::lock_guard lock(mutex_);
        --waiting_;
      }
      room_.notify_one();
      task();
    });
  }

  void shutdown() override { pool_.Stop(); }

 private:
  std::mutex mutex_;
  std::condition_variable room_;
  std::size_t waiting_ = 0;  // not yet taken by a thread
  WorkerPool pool_{kThreads};
};

// A connection that ends after a number of bytes, a time, or when the server stops. The library
// bounds neither a line's length nor the time between two bytes.
class BoundedStream final : public httplib::Stream {
 public:
  BoundedStream(int socket, const std::atomic<bool>& stopping)
      : socket_(socket), stopping_(stopping), deadline_(Clock::now() + kMaxTime) {}

  bool is_readable() const override { return begin_ < end_ || WaitFor(POLLIN); }
  bool is_writable() const override { return WaitFor(POLLOUT); }

  ssize_t read(char* data, std::size_t size) override {
    if (begin_ == end_) {
      if (received_ >= kMaxRequestBytes || !WaitFor(POLLIN)) return -1;
      const ssize_t got = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
      if (got <= 0) return got;
      begin_ = 0;
      end_ = static_cast<std::size_t>(got);
      received_ += end_;
    }
    const std::size_t count = std::min(size, end_ - begin_);
    std::copy_n(buffer_.data() + begin_, count, data);
    begin_ += count;
    return static_cast<ssize_t>(count);
  }

  ssize_t write(const char* data, std::size_t size) override {
    return WaitFor(POLLOUT) ? send(socket_, data, size, MSG_DONTWAIT | MSG_NOSIGNAL) : -1;
  }

  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return socket_; }

 private:
  bool WaitFor(short events) const {
    while (!stopping_ && Clock::now() < deadline_) {
      pollfd wanted{socket_, events, 0};
      const int ready = poll(&wanted, 1, static_cast<int>(kStopCheck.count()));
      if (ready > 0) return true;
      if (ready < 0 && errno != EINTR) return false;
    }
    return false;
  }

  const int socket_;
  const std::atomic<bool>& stopping_;
  const Clock::time_point deadline_;
  std::array<char, 4096> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t received_ = 0;
};

class BoundedServer final : public httplib::Server {
 public:
  std::atomic<bool> stopping{false};

 private:
  bool process_and_close_socket(socket_t socket) override {
    bool done = false;
    {
      BoundedStream stream(socket, stopping);
      bool closed = false;
      done = process_request(stream, /*close_connection=*/true, closed, nullptr);
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return done;
  }
};

}  // namespace

struct MetricsHttp::Impl {
  explicit Impl(Sources s) : sources(std::move(s)) {}

  void Answer(const httplib::Request& request, httplib::Response& response) const {
    if (request.method != "GET" && request.method != "HEAD") {
      response.status = 405;
      response.set_header("Allow", "GET, HEAD");
      response.set_content("only GET\n", "text/plain");
    } else if (request.path == "/metrics") {
      response.set_content(sources.metrics(), kTextFormat);
    } else if (request.path == "/healthz") {
      response.set_content("alive\n", "text/plain");
    } else if (request.path == "/readyz") {
      const std::string reason = sources.not_ready();
      const std::string amiss = sources.amiss();
      std::string text = "ready";
      if (!reason.empty()) {
        response.status = 503;
        text = reason;
      } else if (!amiss.empty()) {
        absl::StrAppend(&text, "; ", amiss);
      }
      response.set_content(text + "\n", "text/plain");
    } else {
      response.status = 404;
      response.set_content("there are /metrics, /healthz and /readyz\n", "text/plain");
    }
  }

  const Sources sources;
  BoundedServer server;
  std::string address;
  std::thread thread;
};

absl::StatusOr<std::unique_ptr<MetricsHttp>> MetricsHttp::Listen(const std::string& listen,
                                                                 Sources sources) {
  const absl::StatusOr<Address> wanted = ParseAddress(listen);
  if (!wanted.ok()) return wanted.status();
  auto impl = std::make_unique<Impl>(std::move(sources));
  httplib::Server& server = impl->server;
  server.new_task_queue = [] { return new BoundedPool; };
  // Not the library's options: with those, two servers could share a port and its requests.
  server.set_socket_options([](socket_t socket) {
    const int yes = 1;
    setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  });
  // Before any routing, which would read the body first.
  server.set_pre_routing_handler([i = impl.get()](const auto& request, auto& response) {
    i->Answer(request, response);
    return httplib::Server::HandlerResponse::Handled;
  });
  int port = wanted->port;
  if (port == 0) {
    port = server.bind_to_any_port(wanted->host);
  } else if (!server.bind_to_port(wanted->host, port)) {
    port = -1;
  }
  if (port <= 0) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", listen, " for metrics: is the port taken?"));
  }
  const bool bracket = absl::StrContains(wanted->host, ':');
  impl->address = absl::StrCat(bracket ? "[" : "", wanted->host, bracket ? "]" : "", ":", port);
  impl->thread = std::thread([&server] { server.listen_after_bind(); });
  // Before it runs, it cannot be stopped.
  while (!server.is_running()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return std::unique_ptr<MetricsHttp>(new MetricsHttp(std::move(impl)));
}

MetricsHttp::MetricsHttp(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

MetricsHttp::~MetricsHttp() {
  impl_->server.stopping = true;
  impl_->server.stop();
  impl_->thread.join();
}

const std::string& MetricsHttp::address() const { return impl_->address; }

}  // namespace dynmesh::server
