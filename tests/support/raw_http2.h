// HTTP/2 by hand, for tests that do what no client library would: stop reading, stop answering,
// send wrong lengths. One connection to 127.0.0.1.
#ifndef DYNMESH_TESTS_SUPPORT_RAW_HTTP2_H_
#define DYNMESH_TESTS_SUPPORT_RAW_HTTP2_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>
#include <utility>

namespace dynmesh::test {

class RawConnection {
 public:
  // A small buffer, so that what is not read stays with the server. `from`: this machine's address
  // that the server sees, such as 127.0.0.2.
  explicit RawConnection(int port, const char* from = "127.0.0.1")
      : socket_(socket(AF_INET, SOCK_STREAM, 0)) {
    const int bytes = 4096;
    setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof(bytes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    inet_pton(AF_INET, from, &address.sin_addr);
    if (bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) Close();
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof(address)) != 0) Close();
  }
  RawConnection(RawConnection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}
  RawConnection& operator=(RawConnection&&) = delete;
  ~RawConnection() { Close(); }

  bool connected() const { return socket_ >= 0; }
  void Close() {
    if (socket_ >= 0) close(socket_);
    socket_ = -1;
  }

  // False after the server has closed. Does not block.
  bool Send(const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n =
          send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  // Blocks until all is sent. False after the server has closed.
  bool SendAll(const std::string& bytes) {
    std::size_t sent = 0;
    while (sent < bytes.size()) {
      const ssize_t n = send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  // Reads, and throws away, until the server closes. False if it does not in that time.
  bool WaitForClose(int milliseconds) {
    std::string bytes;
    return ReadUntilClose(milliseconds, &bytes);
  }

  // Reads until the server closes, and puts the types of the frames that come, in order, a byte
  // each, into `types`. False if it takes longer.
  bool ReadFrameTypes(int milliseconds, std::string* types) {
    std::string bytes;
    const bool closed = ReadUntilClose(milliseconds, &bytes);
    constexpr std::size_t kHeader = 9;
    for (std::size_t at = 0; at + kHeader <= bytes.size();) {
      std::size_t length = 0;
      for (std::size_t i = 0; i < 3; ++i) {
        length = length << 8 | static_cast<unsigned char>(bytes[at + i]);
      }
      types->push_back(bytes[at + 3]);
      at += kHeader + length;
    }
    return closed;
  }
  // Waits for the first thing the server does. True if it closes before it has sent a byte.
  bool IsRefused(int milliseconds) const {
    char byte = 0;
    return WaitForBytes(milliseconds) && recv(socket_, &byte, 1, 0) <= 0;
  }
  // True when something has come.
  bool WaitForBytes(int milliseconds) const {
    pollfd wait = {socket_, POLLIN, 0};
    return poll(&wait, 1, milliseconds) > 0;
  }

  // The connection preface.
  bool Greet() { return Send("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + Frame(4, 0, 0, "")); }
  // Begins a call of the service.
  bool Call(std::uint32_t stream, const std::string& method) {
    return Send(CallFrame(stream, method));
  }
  static std::string CallFrame(std::uint32_t stream, const std::string& method) {
    std::string headers;
    const auto add = [&headers](const std::string& name, const std::string& value) {
      headers += '\0';  // a literal that is not remembered, its name spelled out
      headers += static_cast<char>(name.size()) + name;
      headers += static_cast<char>(value.size()) + value;
    };
    add(":method", "POST");
    add(":scheme", "http");
    add(":path", "/dynmesh.v1.MeshService/" + method);
    add(":authority", "127.0.0.1");
    add("te", "trailers");
    add("content-type", "application/grpc");
    return Frame(1, 4, stream, headers);
  }
  // Ends it, as a client that is not interested any more.
  static std::string ResetFrame(std::uint32_t stream) {
    constexpr int kCancel = 8;
    return Frame(3, 0, stream, Number(kCancel, 4));
  }
  // A message, the call's last one if `end`.
  bool Message(std::uint32_t stream, const std::string& proto, bool end) {
    return Send(
        Frame(0, end ? 1 : 0, stream, std::string(1, '\0') + Number(proto.size(), 4) + proto));
  }

  static std::string Frame(int type, int flags, std::uint32_t stream, const std::string& payload) {
    return Number(payload.size(), 3) + static_cast<char>(type) + static_cast<char>(flags) +
           Number(stream, 4) + payload;
  }
  // Big-endian.
  static std::string Number(std::uint64_t value, int bytes) {
    std::string text;
    for (int i = bytes - 1; i >= 0; --i) text += static_cast<char>((value >> (8 * i)) & 0xff);
    return text;
  }

 private:
  bool ReadUntilClose(int milliseconds, std::string* bytes) {
    char buffer[4096];
    while (WaitForBytes(milliseconds)) {
      const ssize_t count = recv(socket_, buffer, sizeof(buffer), 0);
      if (count <= 0) return true;
      bytes->append(buffer, static_cast<std::size_t>(count));
    }
    return false;
  }

  int socket_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_RAW_HTTP2_H_
