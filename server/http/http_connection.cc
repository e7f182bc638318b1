#include "server/http/http_connection.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>

#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

using std::chrono::milliseconds;

// Of bytes that a refused client has sent already, and for them to come.
constexpr std::size_t kMostIgnored = 1 << 20;
constexpr milliseconds kIgnoring{500};

// Positive if the socket is ready by then.
int WaitFor(int socket, short events, std::chrono::steady_clock::time_point deadline) {
  pollfd wanted{socket, events, 0};
  while (true) {
    const auto left =
        std::chrono::ceil<milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    if (left <= 0) return 0;
    const int ready = poll(&wanted, 1, static_cast<int>(std::min<std::int64_t>(left, 60'000)));
    if (ready > 0 || (ready < 0 && errno != EINTR)) return ready;
  }
}

}  // namespace

// Content in chunks; of HTTP/1.0 as it is, up to the end of the connection.
class HttpConnection::Sink final : public HttpSink {
 public:
  explicit Sink(HttpConnection& connection) : connection_(connection) {}
  bool Write(absl::string_view bytes) override {
    if (bytes.empty()) return is_good_;
    is_good_ =
        is_good_ &&
        (connection_.has_chunks_
             ? connection_.Write(absl::StrCat(absl::Hex(bytes.size()), "\r\n", bytes, "\r\n"))
             : connection_.Write(bytes));
    return is_good_;
  }
  bool IsOpen() override { return is_good_ && !connection_.stopping_ && !connection_.HasLeft(); }
  bool is_good() const { return is_good_; }

 private:
  HttpConnection& connection_;
  bool is_good_ = true;
};

bool HttpConnection::HasLeft() const {
  pollfd ends{socket_, POLLRDHUP, 0};
  return poll(&ends, 1, 0) > 0;
}

bool HttpConnection::Fill(Clock::time_point deadline) {
  std::array<char, 16 << 10> bytes;
  while (true) {
    const ssize_t got = recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (got > 0) {
      buffer_.append(bytes.data(), static_cast<std::size_t>(got));
      return true;
    }
    if (got == 0) return false;
    if (errno == EINTR) continue;
    if (errno != EAGAIN || WaitFor(socket_, POLLIN, deadline) <= 0) return false;
  }
}

bool HttpConnection::Write(absl::string_view bytes) {
  const auto limit = limits_.send_limit.count() > 0 ? limits_.send_limit : std::chrono::hours(24);
  while (!bytes.empty()) {
    const ssize_t sent = send(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
    } else if (errno != EINTR &&
               (errno != EAGAIN || WaitFor(socket_, POLLOUT, Clock::now() + limit) <= 0)) {
      return false;
    }
  }
  return true;
}

void HttpConnection::Refuse(int status) {
  const HttpReply reply = Refusal(status);
  if (!Write(absl::StrCat(HttpReplyHead(reply, /*closes=*/true, false), reply.body))) return;
  shutdown(socket_, SHUT_WR);
  std::size_t ignored = buffer_.size();
  buffer_.clear();
  const Clock::time_point deadline = Clock::now() + kIgnoring;
  while (ignored < kMostIgnored && Clock::now() < deadline && Fill(deadline)) {
    ignored += buffer_.size();
    buffer_.clear();
  }
}

std::optional<HttpRequest> HttpConnection::Receive() {
  if (is_last_) return std::nullopt;
  if (buffer_.empty() && !Fill(Clock::now() + limits_.idle_limit)) return std::nullopt;
  const Clock::time_point deadline = Clock::now() + limits_.receive_limit;
  std::size_t end = 0, looked = 0;
  while ((end = buffer_.find("\r\n\r\n", looked)) == std::string::npos) {
    if (buffer_.size() > kMostHeadBytes) {
      Refuse(431);
      return std::nullopt;
    }
    looked = buffer_.size() - std::min<std::size_t>(buffer_.size(), 3);
    if (!Fill(deadline)) return std::nullopt;
  }
  end += 4;
  HttpHead head =
      ParseHttpHead(absl::string_view(buffer_).substr(0, end), limits_.most_request_bytes);
  if (head.error == 0 && end > kMostHeadBytes) head.error = 431;
  if (head.error != 0) {
    Refuse(head.error);
    return std::nullopt;
  }
  buffer_.erase(0, end);
  if (head.awaits_continue && buffer_.size() < head.body_bytes &&
      !Write("HTTP/1.1 100 Continue\r\n\r\n")) {
    return std::nullopt;
  }
  while (buffer_.size() < head.body_bytes) {
    if (!Fill(deadline)) return std::nullopt;
  }
  head.request.body = buffer_.substr(0, head.body_bytes);
  buffer_.erase(0, head.body_bytes);
  is_last_ = head.is_last;
  has_chunks_ = head.has_chunks;
  return std::move(head.request);
}

bool HttpConnection::Send(const HttpRequest& request, const HttpReply& reply) {
  const bool is_stream = reply.stream != nullptr;
  is_last_ |= is_stream && !has_chunks_;
  const std::string head = HttpReplyHead(reply, is_last_, is_stream && has_chunks_);
  if (request.method == "HEAD") return Write(head) && !is_last_;
  if (!is_stream) return Write(absl::StrCat(head, reply.body)) && !is_last_;
  if (!Write(head)) return false;
  Sink sink(*this);
  reply.stream(sink);
  if (!sink.is_good() || HasLeft()) return false;
  return (!has_chunks_ || Write("0\r\n\r\n")) && !is_last_;
}

}  // namespace dynmesh::server
