#include "server/base/listening.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace dynmesh::server {
namespace {

in_port_t& PortIn(sockaddr_storage& address) {
  return address.ss_family == AF_INET6 ? reinterpret_cast<sockaddr_in6&>(address).sin6_port
                                       : reinterpret_cast<sockaddr_in&>(address).sin_port;
}

int PortOf(int socket) {
  sockaddr_storage address{};
  socklen_t size = sizeof(address);
  if (getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(PortIn(address));
}

// A listening socket, or -1. `port` 0: that of `info`.
int ListenAt(const addrinfo& info, int port) {
  sockaddr_storage address{};
  std::copy_n(reinterpret_cast<const char*>(info.ai_addr), info.ai_addrlen,
              reinterpret_cast<char*>(&address));
  if (port != 0) PortIn(address) = htons(static_cast<std::uint16_t>(port));
  const int listening = socket(info.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listening < 0) return -1;
  // To rebind after a restart; two servers on one port stay impossible.
  const int yes = 1, no = 0;
  setsockopt(listening, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  if (info.ai_family == AF_INET6) {
    setsockopt(listening, IPPROTO_IPV6, IPV6_V6ONLY, &no, sizeof(no));
  }
  if (bind(listening, reinterpret_cast<const sockaddr*>(&address), info.ai_addrlen) == 0 &&
      listen(listening, SOMAXCONN) == 0) {
    return listening;
  }
  close(listening);
  return -1;
}

}  // namespace

absl::StatusOr<HostPort> ParseHostPort(absl::string_view option, absl::string_view text) {
  const std::size_t colon = text.rfind(':');
  absl::string_view host = colon == absl::string_view::npos ? "" : text.substr(0, colon);
  const absl::string_view port = text.substr(colon == absl::string_view::npos ? 0 : colon + 1);
  HostPort address;
  if (!absl::SimpleAtoi(port, &address.port) || address.port < 0 || address.port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat(option, ": '", text, "' is not HOST:PORT, such as 127.0.0.1:9178"));
  }
  if (absl::StartsWith(host, "[") && absl::EndsWith(host, "]")) {
    host = host.substr(1, host.size() - 2);
  }
  address.host = host.empty() ? "127.0.0.1" : std::string(host);
  return address;
}

std::string AddressText(const HostPort& address) {
  const bool bracket = absl::StrContains(address.host, ':');
  return absl::StrCat(bracket ? "[" : "", address.host, bracket ? "]" : "", ":", address.port);
}

absl::StatusOr<Listening> ListenOn(const std::string& host, const std::string& port) {
  addrinfo wanted{};
  wanted.ai_socktype = SOCK_STREAM;
  wanted.ai_flags = AI_PASSIVE | AI_NUMERICSERV;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(host.c_str(), port.c_str(), &wanted, &found)) {
    return absl::UnavailableError(gai_strerror(error));
  }
  Listening listening;
  for (const addrinfo* info = found; info != nullptr; info = info->ai_next) {
    const int socket = ListenAt(*info, listening.port);
    if (socket < 0) continue;
    listening.sockets.push_back(socket);
    listening.port = PortOf(socket);
  }
  freeaddrinfo(found);
  if (listening.sockets.empty()) return absl::UnavailableError("is the port taken?");
  return listening;
}

}  // namespace dynmesh::server
