#include "server/metrics/metrics_http.h"

#include <httplib.h>

#include <cstddef>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/base/listening.h"
#include "server/metrics/http_listener.h"

namespace dynmesh::server {
namespace {

constexpr char kTextFormat[] = "text/plain; version=0.0.4; charset=utf-8";

// A request that was received, and its answer.
class MemoryStream final : public httplib::Stream {
 public:
  explicit MemoryStream(std::string request) : request_(std::move(request)) {}

  bool is_readable() const override { return true; }
  bool is_writable() const override { return true; }
  ssize_t read(char* data, std::size_t size) override {
    const std::size_t count = request_.copy(data, size, read_);
    read_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, std::size_t size) override {
    answer.append(data, size);
    return static_cast<ssize_t>(size);
  }
  void get_remote_ip_and_port(std::string&, int&) const override {}
  void get_local_ip_and_port(std::string&, int&) const override {}
  socket_t socket() const override { return -1; }

  std::string answer;

 private:
  const std::string request_;
  std::size_t read_ = 0;
};

// Reads requests and writes answers as HTTP. It does not listen: the library has a thread for each
// connection, and bounds neither a line's length nor the time between two bytes.
class Parser final : public httplib::Server {
 public:
  std::string Answer(std::string request) {
    MemoryStream stream(std::move(request));
    bool closed = false;
    process_request(stream, /*close_connection=*/true, closed, nullptr);
    return std::move(stream.answer);
  }
};

}  // namespace

struct MetricsHttp::Impl {
  explicit Impl(Sources s) : sources(std::move(s)) {}

  void Answer(const httplib::Request& request, httplib::Response& response) const {
    if (request.method != "GET" && request.method != "HEAD") {
      response.status = 405;
      response.set_header("Allow", "GET, HEAD");
      response.set_content("only GET\n", "text/plain");
    } else if (request.path == "/metrics") {
      response.set_content(sources.metrics(), kTextFormat);
    } else if (request.path == "/healthz") {
      response.set_content("alive\n", "text/plain");
    } else if (request.path == "/readyz") {
      const std::string reason = sources.not_ready();
      const std::string amiss = sources.amiss();
      std::string text = "ready";
      if (!reason.empty()) {
        response.status = 503;
        text = reason;
      } else if (!amiss.empty()) {
        absl::StrAppend(&text, "; ", amiss);
      }
      response.set_content(text + "\n", "text/plain");
    } else {
      response.status = 404;
      response.set_content("there are /metrics, /healthz and /readyz\n", "text/plain");
    }
  }

  const Sources sources;
  Parser parser;
  std::string address;
  std::unique_ptr<HttpListener> listener;  // the first to end: it calls the others
};

absl::StatusOr<std::unique_ptr<MetricsHttp>> MetricsHttp::Listen(const std::string& listen,
                                                                 Sources sources) {
  const absl::StatusOr<HostPort> wanted = ParseHostPort("metrics", listen);
  if (!wanted.ok()) return wanted.status();
  auto impl = std::make_unique<Impl>(std::move(sources));
  // Before any routing, which would read the body first.
  impl->parser.set_pre_routing_handler([i = impl.get()](const auto& request, auto& response) {
    i->Answer(request, response);
    return httplib::Server::HandlerResponse::Handled;
  });
  auto listener = HttpListener::Listen(
      wanted->host, wanted->port,
      [i = impl.get()](std::string request) { return i->parser.Answer(std::move(request)); });
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
