// The client's end of a connection, as a key: address and port. Pure; no allocation.
#ifndef DYNMESH_SERVER_ACCESS_PEER_KEY_H_
#define DYNMESH_SERVER_ACCESS_PEER_KEY_H_

#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

struct PeerKey {
  std::array<std::uint8_t, 16> ip = {};  // of IPv4: mapped into IPv6
  std::uint16_t port = 0;

  friend bool operator==(const PeerKey&, const PeerKey&) = default;
  template <typename H>
  friend H AbslHashValue(H h, const PeerKey& key) {
    return H::combine(std::move(h), key.ip, key.port);
  }
};

// Nothing unless it is an address of IP.
std::optional<PeerKey> PeerKeyOf(const sockaddr_storage& address);
// The same of gRPC's text, as "ipv4:127.0.0.1:54321" or "ipv6:%5B::1%5D:54321".
std::optional<PeerKey> PeerKeyOf(absl::string_view peer);

// The part of it that one client has: an address of IPv4, or a network of 64 bits of IPv6. Without
// a port.
PeerKey ClientKeyOf(const PeerKey& peer);
// As the log has it: "10.0.0.7", "2001:db8::/64".
std::string ClientText(const PeerKey& client);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_PEER_KEY_H_
