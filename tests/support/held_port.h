// A port of 127.0.0.1 that the system chose, and that it gives to nothing else while this lives:
// for a server that is to come back at its address. Without it, a connection of any program may
// get the port while the server is away.
#ifndef DYNMESH_TESTS_SUPPORT_HELD_PORT_H_
#define DYNMESH_TESTS_SUPPORT_HELD_PORT_H_

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <stdexcept>
#include <string>

namespace dynmesh::test {

class HeldPort {
 public:
  // The socket is bound and does not listen: connections are refused. With the same options, as
  // servers have that may be started again and as gRPC's have, another one can listen there.
  HeldPort() : socket_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const int yes = 1;
    setsockopt(socket_, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
    setsockopt(socket_, SOL_SOCKET, SO_REUSEPORT, &yes, sizeof(yes));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    auto* const any = reinterpret_cast<sockaddr*>(&address);
    if (bind(socket_, any, size) != 0 || getsockname(socket_, any, &size) != 0) {
      throw std::runtime_error("there is no free port");
    }
    address_ = "127.0.0.1:" + std::to_string(ntohs(address.sin_port));
  }
  HeldPort(const HeldPort&) = delete;
  HeldPort& operator=(const HeldPort&) = delete;
  ~HeldPort() { close(socket_); }

  const std::string& address() const { return address_; }

 private:
  const int socket_;
  std::string address_;
};

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_SUPPORT_HELD_PORT_H_
