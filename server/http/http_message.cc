#include "server/http/http_message.h"

#include <algorithm>
#include <cstdint>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"

namespace dynmesh::server {
namespace {

// RFC 9110: tchar.
bool IsToken(absl::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
    return absl::ascii_isalnum(c) || absl::StrContains("!#$%&'*+-.^_`|~", static_cast<char>(c));
  });
}

bool IsPrintable(absl::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return c > 0x20 && c < 0x7f; });
}

// Of a value: no byte of control but the tab.
bool IsValue(absl::string_view text) {
  return std::all_of(text.begin(), text.end(),
                     [](unsigned char c) { return c == '\t' || (c >= 0x20 && c != 0x7f); });
}

const char* ReasonOf(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 409:
      return "Conflict";
    case 411:
      return "Length Required";
    case 413:
      return "Content Too Large";
    case 415:
      return "Unsupported Media Type";
    case 429:
      return "Too Many Requests";
    case 431:
      return "Request Header Fields Too Large";
    case 499:
      return "Client Closed Request";
    case 500:
      return "Internal Server Error";
    case 501:
      return "Not Implemented";
    case 503:
      return "Service Unavailable";
    case 504:
      return "Gateway Timeout";
    case 505:
      return "HTTP Version Not Supported";
    default:
      return "Other";
  }
}

// The status to refuse the line with; 0: it is good.
int ParseRequestLine(absl::string_view line, HttpHead& head) {
  const std::vector<absl::string_view> words = absl::StrSplit(line, ' ');
  if (words.size() != 3 || !IsToken(words[0]) || !absl::StartsWith(words[1], "/") ||
      !IsPrintable(words[1])) {
    return 400;
  }
  if (words[2] != "HTTP/1.1" && words[2] != "HTTP/1.0") return 505;
  head.request.method = std::string(words[0]);
  head.request.path = std::string(words[1].substr(0, words[1].find('?')));
  head.is_last = words[2] == "HTTP/1.0";
  head.has_chunks = !head.is_last;
  return 0;
}

int ParseLength(absl::string_view value, std::size_t most_body, HttpHead& head) {
  std::uint64_t length = 0;
  if (value.empty() || value.size() > 18 ||
      !std::all_of(value.begin(), value.end(), absl::ascii_isdigit) ||
      !absl::SimpleAtoi(value, &length)) {
    return 400;
  }
  if (length > most_body) return 413;
  head.body_bytes = length;
  return 0;
}

int ParseHeaders(const std::vector<absl::string_view>& lines, std::size_t most_body,
                 HttpHead& head) {
  int hosts = 0, lengths = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::size_t colon = lines[i].find(':');
    if (colon == absl::string_view::npos) return 400;
    const absl::string_view name = lines[i].substr(0, colon);
    const absl::string_view value = absl::StripAsciiWhitespace(lines[i].substr(colon + 1));
    if (!IsToken(name) || !IsValue(value)) return 400;
    if (absl::EqualsIgnoreCase(name, "Transfer-Encoding")) return 411;
    if (absl::EqualsIgnoreCase(name, "Content-Encoding") &&
        !absl::EqualsIgnoreCase(value, "identity")) {
      return 415;
    }
    hosts += absl::EqualsIgnoreCase(name, "Host");
    if (absl::EqualsIgnoreCase(name, "Content-Length")) {
      if (++lengths > 1) return 400;
      if (const int error = ParseLength(value, most_body, head)) return error;
    }
    if (absl::EqualsIgnoreCase(name, "Connection")) {
      for (const absl::string_view word : absl::StrSplit(value, ',')) {
        head.is_last |= absl::EqualsIgnoreCase(absl::StripAsciiWhitespace(word), "close");
      }
    }
    head.awaits_continue |=
        absl::EqualsIgnoreCase(name, "Expect") && absl::EqualsIgnoreCase(value, "100-continue");
    head.request.headers.emplace_back(name, value);
  }
  const bool needs_host = head.has_chunks;  // HTTP/1.1
  return hosts > 1 || (needs_host && hosts == 0) ? 400 : 0;
}

}  // namespace

const std::string* HttpRequest::Find(absl::string_view name) const {
  for (const auto& [known, value] : headers) {
    if (absl::EqualsIgnoreCase(known, name)) return &value;
  }
  return nullptr;
}

HttpReply PlainReply(int status, std::string text, HttpHeaders headers) {
  return {status, std::move(headers), "text/plain", std::move(text), nullptr};
}

HttpReply Refusal(int status) {
  return PlainReply(status, status == 411   ? "the request is to have a Content-Length\n"
                            : status == 413 ? "the request is larger than this server takes\n"
                            : status == 415
                                ? "requests are taken uncompressed\n"
                                : "this is no request of HTTP/1.1 as RFC 9112 has it\n");
}

HttpHead ParseHttpHead(absl::string_view text, std::size_t most_body) {
  HttpHead head;
  absl::ConsumeSuffix(&text, "\r\n\r\n");
  const std::vector<absl::string_view> lines = absl::StrSplit(text, "\r\n");
  if (lines.size() > kMostHttpHeaders + 1) {
    head.error = 431;
  } else {
    head.error = ParseRequestLine(lines[0], head);
    if (head.error == 0) head.error = ParseHeaders(lines, most_body, head);
  }
  return head;
}

std::string HttpReplyHead(const HttpReply& reply, bool closes, bool is_chunked) {
  std::string head = absl::StrCat("HTTP/1.1 ", reply.status, " ", ReasonOf(reply.status), "\r\n");
  for (const auto& [name, value] : reply.headers) absl::StrAppend(&head, name, ": ", value, "\r\n");
  if (reply.status != 304) {  // that has no content, and would describe the client's
    absl::StrAppend(&head, "Content-Type: ", reply.type, "\r\nX-Content-Type-Options: nosniff\r\n");
    if (is_chunked) {
      absl::StrAppend(&head, "Transfer-Encoding: chunked\r\n");
    } else if (reply.stream == nullptr) {
      absl::StrAppend(&head, "Content-Length: ", reply.body.size(), "\r\n");
    }
  }
  absl::StrAppend(&head, closes ? "Connection: close\r\n\r\n" : "\r\n");
  return head;
}

}  // namespace dynmesh::server
