#include "server/http/cross_site.h"

#include <arpa/inet.h>

#include <array>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace dynmesh::server {
namespace {

// Without the port; of an address of IPv6 without brackets.
absl::string_view NameOf(absl::string_view host) {
  if (absl::ConsumePrefix(&host, "[")) return host.substr(0, host.find(']'));
  return host.substr(0, host.find(':'));
}

bool IsAddress(const std::string& name) {
  std::array<unsigned char, sizeof(in6_addr)> address{};
  return inet_pton(AF_INET, name.c_str(), address.data()) == 1 ||
         inet_pton(AF_INET6, name.c_str(), address.data()) == 1;
}

}  // namespace

std::string WhyCrossSite(const HttpRequest& request, absl::string_view own_name) {
  const std::string* const origin = request.Find("Origin");
  const std::string* const site = request.Find("Sec-Fetch-Site");
  if (origin == nullptr && site == nullptr) return "";
  if (site != nullptr && *site != "same-origin" && *site != "none") {
    return "a page of another site asked for this";
  }
  const std::string* const host = request.Find("Host");
  if (host == nullptr) return "the request has no Host";
  if (origin != nullptr) {
    absl::string_view of_page = *origin;
    if (!absl::ConsumePrefix(&of_page, "http://")) absl::ConsumePrefix(&of_page, "https://");
    if (!own_name.empty() && absl::EqualsIgnoreCase(NameOf(of_page), own_name)) return "";
    if (!absl::EqualsIgnoreCase(of_page, *host)) {
      return absl::StrCat("a page of ", *origin, " asked for this, which is not of ", *host);
    }
  }
  const std::string name(NameOf(*host));
  if (IsAddress(name) || absl::EqualsIgnoreCase(name, "localhost") ||
      (!own_name.empty() && absl::EqualsIgnoreCase(name, own_name))) {
    return "";
  }
  return absl::StrCat("the name ", name,
                      " is not known to be this server's: use its address, or give that name "
                      "with --http-name");
}

}  // namespace dynmesh::server
