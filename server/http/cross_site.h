// Requests that a browser sends for a page of another site. A server on loopback is protected from
// other machines, but a page of any site can make the user's browser ask it. Pure.
#ifndef DYNMESH_SERVER_HTTP_CROSS_SITE_H_
#define DYNMESH_SERVER_HTTP_CROSS_SITE_H_

#include <string>

#include "absl/strings/string_view.h"
#include "server/http/http_message.h"

namespace dynmesh::server {

// Why the request is refused; empty: it is not. Without the headers of browsers (Origin,
// Sec-Fetch-Site) it is not. With them, the page is to be of this server, and the server's name an
// address, `localhost` or `own_name`: another name may be one that its owner has pointed here, so
// that a page of that name counts as this server's (DNS rebinding). A page of `own_name` may be
// behind a proxy that gives another Host.
std::string WhyCrossSite(const HttpRequest& request, absl::string_view own_name);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_CROSS_SITE_H_
