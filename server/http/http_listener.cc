#include "server/http/http_listener.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <list>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "core/base/mutex.h"
#include "server/base/listening.h"
#include "server/base/worker_pool.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kThreads = 2;
constexpr std::chrono::seconds kMostTime{5};  // of a connection, without making its answer

enum class State { kReading, kAnswering, kWriting };

struct Connection {
  std::uint64_t id = 0;
  int socket = -1;
  State state = State::kReading;
  Clock::time_point deadline;
  std::string bytes;  // the request, then the answer
  std::size_t sent = 0;
};

// Oldest first.
using Connections = std::list<Connection>;

bool IsWhole(const std::string& request) {
  return absl::StrContains(request, "\r\n\r\n") || absl::StrContains(request, "\n\n");
}

// Reads what is there. False: the connection is of no more use.
bool Receive(Connection& connection, bool& is_whole) {
  std::array<char, 4096> buffer;
  while (true) {
    const ssize_t got = recv(connection.socket, buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (got < 0) return errno == EAGAIN || errno == EINTR;
    // A request may also end with the client's half of the connection.
    if (got == 0) return is_whole = !connection.bytes.empty();
    connection.bytes.append(buffer.data(), static_cast<std::size_t>(got));
    if (IsWhole(connection.bytes)) return is_whole = true;
    if (connection.bytes.size() > HttpListener::kMostRequestBytes) return false;
  }
}

// Sends what there is room for. False: all is sent, or the connection is of no more use.
bool Send(Connection& connection) {
  while (connection.sent < connection.bytes.size()) {
    const ssize_t sent =
        send(connection.socket, connection.bytes.data() + connection.sent,
             connection.bytes.size() - connection.sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent < 0) return errno == EAGAIN || errno == EINTR;
    connection.sent += static_cast<std::size_t>(sent);
  }
  return false;
}

}  // namespace

class HttpListener::Loop {
 public:
  Loop(Listening listening, Answer answer)
      : listening_(std::move(listening)), answer_(std::move(answer)), workers_(kThreads) {}
  ~Loop() {
    if (thread_.joinable()) {
      {
        const MutexLock lock(mutex_);
        stopping_ = true;
      }
      Wake();
      thread_.join();
    }
    workers_.Stop();
    for (const int socket : listening_.sockets) close(socket);
    for (const int end : wake_) {
      if (end >= 0) close(end);
    }
  }

  bool Start() {
    if (pipe2(wake_, O_CLOEXEC | O_NONBLOCK) != 0) return false;
    thread_ = std::thread([this] { Run(); });
    return true;
  }

  int port() const { return listening_.port; }

 private:
  void Run() {
    while (TakeAnswers()) {
      Wait();
      for (auto it = connections_.begin(); it != connections_.end();) {
        it = IsOver(*it) ? Close(it) : std::next(it);
      }
      AcceptAll();
    }
    while (!connections_.empty()) Close(connections_.begin());
  }

  // Until something can be done.
  void Wait() {
    waits_.assign({{wake_[0], POLLIN, 0}});
    if (HasRoom()) {
      for (const int socket : listening_.sockets) waits_.push_back({socket, POLLIN, 0});
    }
    Clock::time_point next = Clock::time_point::max();
    for (const Connection& connection : connections_) {
      if (connection.state == State::kAnswering) continue;
      const short events = connection.state == State::kReading ? POLLIN : POLLOUT;
      waits_.push_back({connection.socket, events, 0});
      next = std::min(next, connection.deadline);
    }
    int milliseconds = -1;
    if (next != Clock::time_point::max()) {
      const auto left = std::chrono::ceil<std::chrono::milliseconds>(next - Clock::now());
      milliseconds = static_cast<int>(std::max<std::int64_t>(0, left.count()));
    }
    poll(waits_.data(), waits_.size(), milliseconds);
  }

  // Goes on with a connection as far as possible. True: it is to be closed.
  bool IsOver(Connection& connection) {
    if (connection.state == State::kAnswering) return false;
    if (Clock::now() >= connection.deadline) return true;
    if (connection.state == State::kWriting) return !Send(connection);
    bool is_whole = false;
    if (!Receive(connection, is_whole)) return true;
    if (is_whole) Ask(connection);
    return false;
  }

  void Ask(Connection& connection) {
    connection.state = State::kAnswering;
    workers_.Post([this, id = connection.id, request = std::move(connection.bytes)]() mutable {
      if (IsStopping()) return;
      std::string answer = answer_(std::move(request));
      {
        const MutexLock lock(mutex_);
        answers_.emplace_back(id, std::move(answer));
      }
      Wake();
    });
  }

  bool IsStopping() {
    const MutexLock lock(mutex_);
    return stopping_;
  }

  // False: this ends.
  bool TakeAnswers() {
    std::array<char, 64> bytes;
    while (read(wake_[0], bytes.data(), bytes.size()) > 0) {
    }
    std::vector<std::pair<std::uint64_t, std::string>> answers;
    {
      const MutexLock lock(mutex_);
      if (stopping_) return false;
      answers.swap(answers_);
    }
    for (auto& [id, answer] : answers) {
      const auto it = std::find_if(connections_.begin(), connections_.end(),
                                   [wanted = id](const Connection& c) { return c.id == wanted; });
      it->state = State::kWriting;
      it->bytes = std::move(answer);
      it->deadline = Clock::now() + kMostTime;
      if (!Send(*it)) Close(it);
    }
    return true;
  }

  void AcceptAll() {
    for (const int socket : listening_.sockets) {
      while (HasRoom() && AcceptOne(socket)) {
      }
    }
  }

  bool AcceptOne(int listening) {
    const int socket = accept4(listening, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (socket < 0) {
      if (errno == EINTR || errno == ECONNABORTED) return true;
      if (errno != EAGAIN) std::this_thread::sleep_for(kAcceptRetry);
      return false;
    }
    MakeRoom();
    Connection connection;
    connection.id = ++last_id_;
    connection.socket = socket;
    connection.deadline = Clock::now() + kMostTime;
    connections_.push_back(std::move(connection));
    // Most clients have sent their request already.
    if (IsOver(connections_.back())) Close(std::prev(connections_.end()));
    return true;
  }

  // The connection that a new one replaces, if one has to go.
  Connections::iterator Replaceable() {
    for (const State state : {State::kReading, State::kWriting}) {
      const auto it = std::find_if(connections_.begin(), connections_.end(),
                                   [state](const Connection& c) { return c.state == state; });
      if (it != connections_.end()) return it;
    }
    return connections_.end();
  }
  bool HasRoom() {
    return connections_.size() < kMostConnections || Replaceable() != connections_.end();
  }
  void MakeRoom() {
    if (connections_.size() >= kMostConnections) Close(Replaceable());
  }

  Connections::iterator Close(Connections::iterator it) {
    shutdown(it->socket, SHUT_RDWR);
    close(it->socket);
    return connections_.erase(it);
  }

  void Wake() {
    const char byte = 0;
    (void)!write(wake_[1], &byte, 1);  // a full pipe wakes, too
  }

  const Listening listening_;
  const Answer answer_;
  int wake_[2] = {-1, -1};
  Mutex mutex_;
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  // By the connection's id.
  std::vector<std::pair<std::uint64_t, std::string>> answers_ ABSL_GUARDED_BY(mutex_);

  // Used by the thread.
  Connections connections_;
  std::uint64_t last_id_ = 0;
  std::vector<pollfd> waits_;

  WorkerPool workers_;
  std::thread thread_;
};

absl::StatusOr<std::unique_ptr<HttpListener>> HttpListener::Listen(const std::string& host,
                                                                   int port, Answer answer) {
  absl::StatusOr<Listening> listening = ListenOn(host, absl::StrCat(port));
  if (!listening.ok()) return listening.status();
  auto loop = std::make_unique<Loop>(*std::move(listening), std::move(answer));
  if (!loop->Start()) return absl::UnavailableError("there are too many open files");
  return std::unique_ptr<HttpListener>(new HttpListener(std::move(loop)));
}

HttpListener::HttpListener(std::unique_ptr<Loop> loop) : loop_(std::move(loop)) {}

HttpListener::~HttpListener() = default;

int HttpListener::port() const { return loop_->port(); }

}  // namespace dynmesh::server
