// HTTP/1.1 over TCP: connections, each with a thread of its own, and their limits. What is asked
// and answered is the handler's. Nothing waits without end:
//   * a request has `receive_limit` to arrive, 16 KiB for its head and `most_request_bytes` for its
//     body;
//   * a reply has `send_limit` for the client to take each part of it, and ends when the client has
//     closed its end of the connection;
//   * connections above `most_connections`, or above half of them from one address, are answered
//     503, and further ones are closed at once.
// Not by cpp-httplib: it leaves the body of a refused request in the connection, where it is taken
// for the next request, and bounds neither lines nor time.
#ifndef DYNMESH_SERVER_HTTP_HTTP_SERVER_H_
#define DYNMESH_SERVER_HTTP_HTTP_SERVER_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"
#include "server/http/http_message.h"

namespace dynmesh::server {

class HttpServer {
 public:
  struct Limits {
    std::size_t most_connections = 256;
    std::size_t most_request_bytes = 4 << 20;  // of the body
    std::chrono::milliseconds receive_limit{20'000};
    std::chrono::milliseconds send_limit{300'000};  // 0: none
    std::chrono::milliseconds idle_limit{60'000};   // between two requests of a connection
  };
  struct Counts {
    std::size_t open = 0;
    std::uint64_t refused = 0;  // so far
  };
  // Called by many threads at a time.
  using Handler = std::function<HttpReply(const HttpRequest&)>;

  // Listens on all addresses of `host`, a name or an address without brackets, and answers. `port`
  // 0 picks a free one. UNAVAILABLE, with the reason, if that is not possible.
  static absl::StatusOr<std::unique_ptr<HttpServer>> Listen(const std::string& host, int port,
                                                            const Limits& limits, Handler handler);
  ~HttpServer();  // as Stop, with no grace
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Takes no more connections and requests, and waits for the replies that are being made, up to
  // `grace`; then those are cut off. By one thread.
  void Stop(std::chrono::milliseconds grace);

  int port() const;
  Counts counts() const;

 private:
  class Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_SERVER_H_
