// Requests and replies of HTTP/1.1, and how they look as bytes: what a browser, a proxy and `curl`
// send, and nothing else. Where a request ends is said by Content-Length alone, and what is
// doubtful is an error that ends the connection: so no two programs on its way read the bytes
// differently (request smuggling). Pure.
#ifndef DYNMESH_SERVER_HTTP_HTTP_MESSAGE_H_
#define DYNMESH_SERVER_HTTP_HTTP_MESSAGE_H_

#include <cstddef>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/string_view.h"

namespace dynmesh::server {

using HttpHeaders = std::vector<std::pair<std::string, std::string>>;

struct HttpRequest {
  std::string method;  // in capitals
  std::string path;    // as it came, without a query
  HttpHeaders headers;
  std::string body;
  std::string peer;  // in gRPC's format: ipv4:127.0.0.1:54321

  // The first of that name, in any case; null: there is none.
  const std::string* Find(absl::string_view name) const;
};

// Where a reply goes whose length is not known. By the thread of the connection only.
class HttpSink {
 public:
  virtual ~HttpSink() = default;
  // False: the client has gone, or has not taken it in time. Blocks meanwhile.
  virtual bool Write(absl::string_view bytes) = 0;
  // False: the client has gone, or the server ends. A system call.
  virtual bool IsOpen() = 0;
};

struct HttpReply {
  int status = 200;
  HttpHeaders headers;
  std::string type;  // of the content
  std::string body;
  // Not null: writes the content, instead of `body`.
  std::function<void(HttpSink&)> stream;
};

// Text for people, as of an error.
HttpReply PlainReply(int status, std::string text, HttpHeaders headers = {});

// The head of a request: all up to the empty line.
struct HttpHead {
  int error = 0;  // the status to refuse it with; 0: it is good
  HttpRequest request;
  std::size_t body_bytes = 0;
  bool is_last = false;          // the client closes, or has HTTP/1.0
  bool has_chunks = true;        // the client takes content in chunks: HTTP/1.1
  bool awaits_continue = false;  // it sends its body when it was told to go on
};
inline constexpr std::size_t kMostHeadBytes = 16 << 10, kMostHttpHeaders = 100;
// `head` ends with the empty line. Refused: another version than HTTP/1.x (505), a body of more
// than `most_body` bytes (413), in chunks (411) or coded (415), and what is malformed (400): line
// ends other than CR LF, folded lines, bytes of control, names with spaces, two lengths, no Host or
// two.
HttpHead ParseHttpHead(absl::string_view head, std::size_t most_body);

// The answer to a request with such an error.
HttpReply Refusal(int status);

// The status line and headers of a reply, with the empty line. `closes`: the connection ends after
// it. `is_chunked`: its content comes in chunks.
std::string HttpReplyHead(const HttpReply& reply, bool closes, bool is_chunked);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_HTTP_HTTP_MESSAGE_H_
