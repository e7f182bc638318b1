#include "server/http/static_files.h"

#include <string>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace dynmesh::server {
namespace {

constexpr absl::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' data: blob:; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

// If-None-Match compares weakly, and a proxy that compresses makes tags weak.
bool IsKnown(const std::string* known, absl::string_view tag) {
  if (known == nullptr) return false;
  for (absl::string_view one : absl::StrSplit(*known, ',')) {
    one = absl::StripAsciiWhitespace(one);
    absl::ConsumePrefix(&one, "W/");
    if (one == "*" || one == tag) return true;
  }
  return false;
}

}  // namespace

std::optional<HttpReply> AnswerWithFile(absl::Span<const StaticFile> files,
                                        const HttpRequest& request) {
  const absl::string_view path = request.path == "/" ? "/index.html" : request.path;
  for (const StaticFile& file : files) {
    if (file.path != path) continue;
    if (request.method != "GET" && request.method != "HEAD") {
      return PlainReply(405, "this is a file: GET or HEAD it\n", {{"Allow", "GET, HEAD"}});
    }
    const std::string tag = absl::StrCat("\"", file.tag, "\"");
    HttpReply reply;
    reply.headers = {{"Content-Security-Policy", std::string(kPolicy)},
                     {"Cross-Origin-Opener-Policy", "same-origin"},
                     {"Cross-Origin-Resource-Policy", "same-origin"},
                     {"Referrer-Policy", "no-referrer"},
                     {"Cache-Control", "no-cache"},
                     {"ETag", tag}};
    if (IsKnown(request.Find("If-None-Match"), tag)) {
      reply.status = 304;
      return reply;
    }
    reply.type = std::string(file.type);
    reply.body = std::string(file.bytes);
    return reply;
  }
  return std::nullopt;
}

}  // namespace dynmesh::server
