// HTTP/1.1 over TCP: connections, each with a thread of its own, and their limits. What is asked
// and answered is the handler's. The library underneath (cpp-httplib) parses and writes HTTP;
// sockets and threads are this class's, so that nothing waits without end:
//   * a request has `receive_limit` to arrive, and at most `most_request_bytes`;
//   * an answer has `send_limit` for the client to take each part of it, and ends when the client
//     has closed the connection;
//   * connections above `most_connections` are answered 503, those above twice as many are closed.
#ifndef DYNMESH_SERVER_HTTP_HTTP_SERVER_H_
#define DYNMESH_SERVER_HTTP_HTTP_SERVER_H_

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "absl/strings/string_view.h"

namespace dynmesh::server {

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

struct HttpRequest {
  std::string method;  // in capitals
  std::string path;    // without a query, decoded
  HttpHeaders headers;
  std::string body;
  std::string peer;  // in gRPC's format: ipv4:127.0.0.1:54321

  // The first of that name, in any case; null: there is none.
  const std::string* Find(absl::string_view name) const;
};

// Where an answer goes whose length is not known. By the thread of the connection only.
class HttpSink {
 public:
  virtual ~HttpSink() = default;
  // False: the client has gone, or has not taken it in time. Blocks meanwhile.
  virtual bool Write(absl::string_view bytes) = 0;
  // False: the client has gone, or the server ends. A system call.
  virtual bool IsOpen() = 0;
};

struct HttpReply {
  int status = 200;
  HttpHeaders headers;
  std::string type;  // of the content
  std::string body;
  // Not null: writes the content, instead of `body`.
  std::function<void(HttpSink&)> stream;
};

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
  ~HttpServer();  // as Stop
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // Closes all connections, and takes no more; waits for the handlers that run. By one thread.
  void Stop();

  int port() const;
  Counts counts() const;

 private:
  class Impl;
  explicit HttpServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_SERVER_H_
