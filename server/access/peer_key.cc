#include "server/access/peer_key.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <algorithm>
#include <cstddef>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace dynmesh::server {
namespace {

constexpr std::array<std::uint8_t, 12> kMapped = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xff, 0xff};
constexpr std::size_t kNetworkBytes = 8;

void SetV4(const in_addr& address, PeerKey& key) {
  std::copy(kMapped.begin(), kMapped.end(), key.ip.begin());
  std::copy_n(reinterpret_cast<const std::uint8_t*>(&address), 4, key.ip.begin() + kMapped.size());
}

bool IsV4(const PeerKey& key) { return std::equal(kMapped.begin(), kMapped.end(), key.ip.begin()); }

bool ReadIp(absl::string_view text, bool v6, PeerKey& key) {
  char buffer[INET6_ADDRSTRLEN] = {};
  if (text.size() >= sizeof(buffer)) return false;
  text.copy(buffer, text.size());
  if (v6) return inet_pton(AF_INET6, buffer, key.ip.data()) == 1;
  in_addr address{};
  if (inet_pton(AF_INET, buffer, &address) != 1) return false;
  SetV4(address, key);
  return true;
}

}  // namespace

std::optional<PeerKey> PeerKeyOf(const sockaddr_storage& address) {
  PeerKey key;
  if (address.ss_family == AF_INET) {
    const auto& v4 = reinterpret_cast<const sockaddr_in&>(address);
    SetV4(v4.sin_addr, key);
    key.port = ntohs(v4.sin_port);
    return key;
  }
  if (address.ss_family != AF_INET6) return std::nullopt;
  const auto& v6 = reinterpret_cast<const sockaddr_in6&>(address);
  std::copy_n(v6.sin6_addr.s6_addr, key.ip.size(), key.ip.begin());
  key.port = ntohs(v6.sin6_port);
  return key;
}

std::optional<PeerKey> PeerKeyOf(absl::string_view peer) {
  const bool v6 = absl::ConsumePrefix(&peer, "ipv6:");
  if (!v6 && !absl::ConsumePrefix(&peer, "ipv4:")) return std::nullopt;
  const std::size_t colon = peer.rfind(':');
  if (colon == absl::string_view::npos) return std::nullopt;
  PeerKey key;
  int port = 0;
  if (!absl::SimpleAtoi(peer.substr(colon + 1), &port) || port < 0 || port > 65535) {
    return std::nullopt;
  }
  key.port = static_cast<std::uint16_t>(port);
  peer = peer.substr(0, colon);
  if (!absl::ConsumePrefix(&peer, "%5B")) absl::ConsumePrefix(&peer, "[");
  if (!absl::ConsumeSuffix(&peer, "%5D")) absl::ConsumeSuffix(&peer, "]");
  peer = peer.substr(0, peer.find('%'));  // a link's name
  if (!ReadIp(peer, v6, key)) return std::nullopt;
  return key;
}

PeerKey ClientKeyOf(const PeerKey& peer) {
  PeerKey client = peer;
  client.port = 0;
  if (!IsV4(peer)) std::fill(client.ip.begin() + kNetworkBytes, client.ip.end(), 0);
  return client;
}

std::string ClientText(const PeerKey& client) {
  char buffer[INET6_ADDRSTRLEN] = {};
  const bool v4 = IsV4(client);
  inet_ntop(v4 ? AF_INET : AF_INET6, client.ip.data() + (v4 ? kMapped.size() : 0), buffer,
            sizeof(buffer));
  return absl::StrCat(buffer, v4 ? "" : "/64");
}

}  // namespace dynmesh::server
