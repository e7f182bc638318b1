// Files that are part of the program, as those of the page in the browser, and how they are
// answered.
#ifndef DYNMESH_SERVER_HTTP_STATIC_FILES_H_
#define DYNMESH_SERVER_HTTP_STATIC_FILES_H_

#include <optional>

#include "absl/strings/string_view.h"
#include "absl/types/span.h"
#include "server/http/http_message.h"

namespace dynmesh::server {

struct StaticFile {
  absl::string_view path;   // from the root: /index.html
  absl::string_view type;   // of the content
  absl::string_view tag;    // differs where `bytes` differ; without quotes
  absl::string_view bytes;  // these, and the names, outlive the server
};

// The page of the program; empty where it was built without one. In sources made by
// client/web/embed.py.
absl::Span<const StaticFile> WebPage();

// The answer to a request for one of `files`; / is /index.html. Nothing: none of them has that
// path. Browsers are told
//   * that the page loads from its own server alone and is in no frame
//     (Content-Security-Policy);
//   * that they ask again before they use what they have, by its tag (304, if it is as it was).
// O(files + bytes). Thread-safe.
std::optional<HttpReply> AnswerWithFile(absl::Span<const StaticFile> files,
                                        const HttpRequest& request);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_STATIC_FILES_H_
