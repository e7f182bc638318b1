// Takes connections and their requests for an HTTP server whose answers are short, and sends these.
//
// One thread waits for all connections together. So a client that says nothing, sends a byte now
// and then, or does not read its answer, delays no other one. A connection has one request, of a
// few kilobytes, and a few seconds for all of it. If as many are open as there may be, a new one
// takes the place of the oldest one that has not sent its request; if all have, of the oldest one
// that has not read its answer. Thread-safe.
#ifndef DYNMESH_SERVER_HTTP_HTTP_LISTENER_H_
#define DYNMESH_SERVER_HTTP_HTTP_LISTENER_H_

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "absl/status/statusor.h"

namespace dynmesh::server {

class HttpListener {
 public:
  // Connections open at a time.
  static constexpr std::size_t kMostConnections = 128;
  // Bytes of a request's head, and of what follows it.
  static constexpr std::size_t kMostRequestBytes = 16 << 10;

  // The bytes to send for a request. The request is what came until there was an empty line in it,
  // or until the client's end. Called on two threads, also concurrently.
  using Answer = std::function<std::string(std::string request)>;

  // Listens. Errors as of ListenOn. `port` 0 picks a free one.
  static absl::StatusOr<std::unique_ptr<HttpListener>> Listen(const std::string& host, int port,
                                                              Answer answer);
  // Closes all connections. Waits for answers that are being made.
  ~HttpListener();

  int port() const;

 private:
  class Loop;
  explicit HttpListener(std::unique_ptr<Loop> loop);
  const std::unique_ptr<Loop> loop_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_LISTENER_H_
