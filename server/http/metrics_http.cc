#include "server/http/metrics_http.h"

#include <cstddef>
#include <limits>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/listening.h"
#include "server/http/http_listener.h"
#include "server/http/http_message.h"

namespace dynmesh::server {
namespace {

constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";

}  // namespace

struct MetricsHttp::Impl {
  explicit Impl(Sources s) : sources(std::move(s)) {}

  HttpReply Ready() const {
    const std::string reason = sources.not_ready();
    const std::string amiss = sources.amiss();
    if (!reason.empty()) return PlainReply(503, absl::StrCat(reason, "\n"));
    return PlainReply(200, absl::StrCat("ready", amiss.empty() ? "" : "; ", amiss, "\n"));
  }

  HttpReply Answer(const HttpRequest& request) const {
    if (request.method != "GET" && request.method != "HEAD") {
      return PlainReply(405, "only GET\n", {{"Allow", "GET, HEAD"}});
    }
    if (request.path == "/metrics") {
      HttpReply reply = PlainReply(200, sources.metrics());
      reply.type = kTextFormat;
      return reply;
    }
    if (request.path == "/healthz") return PlainReply(200, "alive\n");
    if (request.path == "/readyz") return Ready();
    return PlainReply(404, "there are /metrics, /healthz and /readyz\n");
  }

  // `bytes`: a request's head, with what came behind it. That is not looked at.
  std::string AnswerBytes(absl::string_view bytes) const {
    constexpr absl::string_view kEnd = "\r\n\r\n";
    const std::size_t end = bytes.find(kEnd);
    HttpHead head;
    head.error = 400;
    if (end != absl::string_view::npos) {
      head = ParseHttpHead(bytes.substr(0, end + kEnd.size()),
                           std::numeric_limits<std::size_t>::max());
    }
    const HttpReply reply = head.error != 0 ? Refusal(head.error) : Answer(head.request);
    const bool is_whole = head.request.method != "HEAD";
    return absl::StrCat(HttpReplyHead(reply, /*closes=*/true, /*is_chunked=*/false),
                        is_whole ? reply.body : "");
  }

  const Sources sources;
  std::string address;
  std::unique_ptr<HttpListener> listener;  // the first to end: it calls the others
};

absl::StatusOr<std::unique_ptr<MetricsHttp>> MetricsHttp::Listen(const std::string& listen,
                                                                 Sources sources) {
  const absl::StatusOr<HostPort> wanted = ParseHostPort("metrics", listen);
  if (!wanted.ok()) return wanted.status();
  auto impl = std::make_unique<Impl>(std::move(sources));
  auto listener = HttpListener::Listen(
      wanted->host, wanted->port,
      [i = impl.get()](const std::string& request) { return i->AnswerBytes(request); });
  if (!listener.ok()) {
    return absl::UnavailableError(
        absl::StrCat("cannot listen on ", listen, " for metrics: ", listener.status().message()));
  }
  impl->listener = *std::move(listener);
  impl->address = AddressText({wanted->host, impl->listener->port()});
  return std::unique_ptr<MetricsHttp>(new MetricsHttp(std::move(impl)));
}

MetricsHttp::MetricsHttp(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

MetricsHttp::~MetricsHttp() = default;

const std::string& MetricsHttp::address() const { return impl_->address; }

}  // namespace dynmesh::server
