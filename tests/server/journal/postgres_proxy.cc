#include "tests/server/journal/postgres_proxy.h"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <stdexcept>
#include <utility>

#include "tests/support/deadline.h"

namespace dynmesh::server {
namespace {

sockaddr_un AddressOf(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  return address;
}

int ConnectTo(const std::string& path) {
  const int out = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = AddressOf(path);
  if (connect(out, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) return out;
  close(out);
  return -1;
}

// False if the other side is gone.
bool Send(int to, const std::string& bytes) {
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t n = send(to, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (n <= 0) return false;
    sent += static_cast<std::size_t>(n);
  }
  return true;
}

// What is there; empty at the end of the connection.
std::string Receive(int from) {
  std::string bytes(1 << 16, 0);
  const ssize_t n = recv(from, bytes.data(), bytes.size(), 0);
  bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
  return bytes;
}

}  // namespace

PostgresProxy::PostgresProxy(const std::string& socket_file) : server_(socket_file) {
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_un address = AddressOf(folder_.path() + "/.s.PGSQL.5432");
  if (bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0 ||
      listen(listener_, 64) != 0) {
    throw std::runtime_error("no socket for the proxy");
  }
  acceptor_ = std::thread([this] { Accept(); });
}

PostgresProxy::~PostgresProxy() {
  ends_ = true;
  acceptor_.join();
  for (std::thread& connection : connections_) connection.join();
  close(listener_);
}

void PostgresProxy::CutNext(Cut cut, std::function<void()> then, int skipped) {
  const std::lock_guard lock(mutex_);
  cut_ = cut;
  skipped_ = skipped;
  then_ = std::move(then);
  released_ = false;
}

void PostgresProxy::Release() {
  released_ = true;
  test::WaitUntil("the answer to what came late", [this] { return late_ == 0; });
}

void PostgresProxy::Accept() {
  while (!ends_) {
    pollfd ready{listener_, POLLIN, 0};
    if (poll(&ready, 1, 10) <= 0) continue;
    const int client = accept(listener_, nullptr, nullptr);
    if (client < 0) continue;
    if (refuses_) {
      close(client);
    } else {
      connections_.emplace_back([this, client] { Serve(client); });
    }
  }
}

bool PostgresProxy::Take(Cut wanted) {
  std::function<void()> then;
  {
    const std::lock_guard lock(mutex_);
    if (cut_ != wanted || skipped_-- > 0) return false;
    cut_ = Cut::kNone;
    then = std::exchange(then_, nullptr);
  }
  if (then != nullptr) then();
  ++cuts_;
  return true;
}

void PostgresProxy::Serve(int client) {
  const bool ignored = ignores_;
  while (ignores_ && !ends_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const int server = ignored ? -1 : ConnectTo(server_);
  bool open = server >= 0;
  while (open && !ends_) {
    pollfd sides[] = {{client, POLLIN, 0}, {server, POLLIN, 0}};
    if (poll(sides, 2, 10) <= 0) continue;
    if (sides[1].revents != 0) {
      const std::string bytes = Receive(server);
      if (bytes.empty() || Take(Cut::kAnswer)) break;
      open = Send(client, bytes);
    }
    if (sides[0].revents != 0) {
      const std::string bytes = Receive(client);
      if (bytes.empty() || Take(Cut::kQuestion)) break;
      if (Take(Cut::kLate)) {
        ++late_;
        close(std::exchange(client, -1));
        while (!released_ && !ends_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (Send(server, bytes)) Receive(server);
        --late_;
        break;
      }
      open = open && Send(server, bytes);
    }
  }
  if (client >= 0) close(client);
  if (server >= 0) close(server);
}

}  // namespace dynmesh::server
