// A limit that all clients share. Where there are several clients, one of them gets half of it at
// most, so that it cannot keep the others out. Thread-safe; Take costs as ClientQuotas::Take.
#ifndef DYNMESH_SERVER_ACCESS_SHARED_LIMIT_H_
#define DYNMESH_SERVER_ACCESS_SHARED_LIMIT_H_

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "absl/strings/string_view.h"
#include "server/access/client_quotas.h"
#include "server/access/quota.h"

namespace dynmesh::server {

class SharedLimit {
 public:
  // What a client has of the limit, given back on destruction. Empty: refused.
  struct Place {
    Share of_all;
    Share of_client;

    explicit operator bool() const { return static_cast<bool>(of_all); }
  };

  // `what` names what is limited, in messages: "watches". A client may have `least_share` in any
  // case, if nothing else is in use.
  SharedLimit(absl::string_view what, std::uint64_t limit, std::uint64_t least_share = 0)
      : what_(what),
        share_(std::min(limit, std::max(limit - limit / 2, least_share))),
        all_(limit),
        clients_(0) {}

  // Takes `amount` for `client`, named as in Pass::client(). `is_shared`: there are several
  // clients. If the place is empty and `is_share` true, the client has its share, else the limit
  // is reached.
  Place Take(absl::string_view client, std::uint64_t amount, bool is_shared, bool& is_share) {
    Place place;
    place.of_client = clients_.Take(client, amount, is_shared ? share_ : ClientQuotas::kAny);
    if (place.of_client) place.of_all = all_.Take(amount);
    if (place) return place;
    const bool has_room = amount <= limit() && used() <= limit() - amount;
    is_share = !place.of_client && has_room;
    return {};
  }

  const std::string& what() const { return what_; }
  std::uint64_t used() const { return all_.used(); }
  std::uint64_t limit() const { return all_.limit(); }
  std::uint64_t share() const { return share_; }
  // The clients that have most of it: "token a 32, token b 5".
  std::string Holders() const { return clients_.Largest(kMostHolders); }

 private:
  static constexpr std::size_t kMostHolders = 4;

  const std::string what_;
  const std::uint64_t share_;
  Quota all_;
  ClientQuotas clients_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_ACCESS_SHARED_LIMIT_H_
