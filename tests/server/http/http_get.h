// One request to a metrics port on loopback, byte for byte as the test wants it.
#ifndef DYNMESH_TESTS_SERVER_METRICS_HTTP_GET_H_
#define DYNMESH_TESTS_SERVER_METRICS_HTTP_GET_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <string>

namespace dynmesh::server {

// A connection; -1 if there is none to be had. `address` is 127.0.0.1:PORT.
inline int ConnectHttp(const std::string& address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port =
      htons(static_cast<std::uint16_t>(std::atoi(address.c_str() + address.rfind(':') + 1)));
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const timeval patience{30, 0};
  setsockopt(socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
  if (connect(socket, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0) return socket;
  close(socket);
  return -1;
}

// All that comes back until the other side closes. Closes.
inline std::string ReceiveAll(int socket) {
  std::string answer;
  char buffer[4096];
  for (ssize_t got; (got = recv(socket, buffer, sizeof(buffer), 0)) > 0;) {
    answer.append(buffer, static_cast<std::size_t>(got));
  }
  close(socket);
  return answer;
}

inline std::string SendHttp(const std::string& address, const std::string& bytes) {
  const int socket = ConnectHttp(address);
  if (socket < 0) return "no connection";
  // It is not an error if the server no longer reads.
  (void)!send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  return ReceiveAll(socket);
}

struct HttpAnswer {
  int status = 0;  // 0: no HTTP
  std::string headers;
  std::string body;
};

inline HttpAnswer ParseHttp(const std::string& answer) {
  HttpAnswer parsed;
  const std::size_t end = answer.find("\r\n\r\n");
  if (answer.rfind("HTTP/1.", 0) != 0 || end == std::string::npos) return parsed;
  parsed.status = std::atoi(answer.c_str() + 9);
  parsed.headers = answer.substr(0, end);
  parsed.body = answer.substr(end + 4);
  return parsed;
}

inline HttpAnswer HttpGet(const std::string& address, const std::string& path) {
  return ParseHttp(SendHttp(address, "GET " + path + " HTTP/1.1\r\nHost: x\r\n\r\n"));
}

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_METRICS_HTTP_GET_H_
