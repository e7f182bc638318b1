// One connection of HTTP: reads requests of a socket and writes replies to it, by the limits of its
// server. By one thread.
#ifndef DYNMESH_SERVER_HTTP_HTTP_CONNECTION_H_
#define DYNMESH_SERVER_HTTP_HTTP_CONNECTION_H_

#include <atomic>
#include <chrono>
#include <optional>
#include <string>

#include "absl/strings/string_view.h"
#include "server/http/http_message.h"
#include "server/http/http_server.h"

namespace dynmesh::server {

class HttpConnection {
 public:
  // The socket does not block, and stays the caller's. `stopping`: streams end.
  HttpConnection(int socket, const HttpServer::Limits& limits, const std::atomic<bool>& stopping)
      : socket_(socket), limits_(limits), stopping_(stopping) {}

  // The next request; nothing: the client has gone or is too slow, or it was refused, which it has
  // been told.
  std::optional<HttpRequest> Receive();
  // False: the connection is of no more use.
  bool Send(const HttpRequest& request, const HttpReply& reply);

 private:
  class Sink;
  using Clock = std::chrono::steady_clock;

  // Reads more into buffer_. False: there is no more, or none in time.
  bool Fill(Clock::time_point deadline);
  // Tells the client why, and reads on for a moment: a reset would take the reply away.
  void Refuse(int status);
  bool Write(absl::string_view bytes);
  bool HasLeft() const;

  const int socket_;
  const HttpServer::Limits& limits_;
  const std::atomic<bool>& stopping_;
  std::string buffer_;  // received, not yet used
  bool is_last_ = false;
  bool has_chunks_ = true;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_CONNECTION_H_
