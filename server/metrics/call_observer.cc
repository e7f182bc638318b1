#include "server/metrics/call_observer.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <utility>

#include "absl/strings/str_cat.h"
#include "dynmesh/v1/mesh_service.pb.h"
#include "server/base/call_id.h"
#include "server/base/call_peer.h"
#include "server/metrics/server_metrics.h"

namespace dynmesh::server {
namespace {

using grpc::experimental::InterceptionHookPoints;
using grpc::experimental::InterceptorBatchMethods;

constexpr double kLongestCall = 1e5;  // seconds: watches last for hours
constexpr std::chrono::milliseconds kLateCheck{5};
constexpr std::size_t kCodes = 17;
constexpr std::array<const char*, kCodes> kCodeNames = {
    "OK",       "Canceled",       "Unknown",          "InvalidArgument",   "DeadlineExceeded",
    "NotFound", "AlreadyExists",  "PermissionDenied", "ResourceExhausted", "FailedPrecondition",
    "Aborted",  "OutOfRange",     "Unimplemented",    "Internal",          "Unavailable",
    "DataLoss", "Unauthenticated"};

std::size_t IndexOf(grpc::StatusCode code) {
  const auto index = static_cast<std::size_t>(code);
  return index < kCodes ? index : static_cast<std::size_t>(grpc::StatusCode::UNKNOWN);
}

const char* TypeOf(const google::protobuf::MethodDescriptor& method) {
  if (method.client_streaming()) return method.server_streaming() ? "bidi_stream" : "client_stream";
  return method.server_streaming() ? "server_stream" : "unary";
}

struct Families {
  explicit Families(MetricRegistry& r)
      : started(r.AddCounters("grpc_server_started_total", "Calls begun.")),
        handled(r.AddCounters("grpc_server_handled_total", "Calls ended, by code.")),
        received(r.AddCounters("grpc_server_msg_received_total", "Messages received.")),
        sent(r.AddCounters("grpc_server_msg_sent_total", "Messages sent.")),
        sent_bytes(r.AddCounters("dynmesh_sent_bytes_total",
                                 "Bytes of the messages sent, uncompressed, without framing.")),
        seconds(r.AddHistograms("grpc_server_handling_seconds", "Time of calls until they ended.",
                                SecondsBounds(kLongestCall))) {}

  MetricFamily<Counter>& started;
  MetricFamily<Counter>& handled;
  MetricFamily<Counter>& received;
  MetricFamily<Counter>& sent;
  MetricFamily<Counter>& sent_bytes;
  MetricFamily<Histogram>& seconds;
};

}  // namespace

struct CallMetrics::Method {
  Method(Families& f, const std::string& t, const std::string& s, const std::string& m, bool ours)
      : type(t),
        service(s),
        method(m),
        is_ours(ours),
        families(f),
        started(f.started.With(Labels())),
        received(f.received.With(Labels())),
        sent(f.sent.With(Labels())),
        sent_bytes(f.sent_bytes.With(Labels())),
        seconds(f.seconds.With(Labels())) {}

  MetricLabels Labels() const {
    return {{"grpc_type", type}, {"grpc_service", service}, {"grpc_method", method}};
  }

  // A code's counter is made at its first use: few codes ever occur.
  Counter& Handled(grpc::StatusCode code) {
    const std::size_t index = IndexOf(code);
    Counter* counter = handled[index].load(std::memory_order_acquire);
    if (counter == nullptr) {
      MetricLabels labels = Labels();
      labels.emplace_back("grpc_code", kCodeNames[index]);
      counter = &families.handled.With(labels);
      handled[index].store(counter, std::memory_order_release);
    }
    return *counter;
  }

  const std::string type, service, method;
  const bool is_ours;  // not health or reflection: a drain does not wait for their streams
  Families& families;
  Counter& started;
  Counter& received;
  Counter& sent;
  Counter& sent_bytes;
  Histogram& seconds;
  std::array<std::atomic<Counter*>, kCodes> handled{};
};

struct CallMetrics::Impl {
  explicit Impl(MetricRegistry& registry) : families(registry), failed(registry) {}

  void Add(const std::string& type, const std::string& service, const std::string& method,
           bool is_ours) {
    methods.emplace(absl::StrCat("/", service, "/", method),
                    std::make_unique<Method>(families, type, service, method, is_ours));
  }

  Families families;
  FailedCalls failed;
  CallJudge judge;
  WorkGate open;
  WorkGate late;  // calls that came after it was closed
  std::atomic<MetricsClock::rep> last_late{0};
  std::map<std::string, std::unique_ptr<Method>, std::less<>> methods;
  std::unique_ptr<Method> other;
};

CallMetrics::CallMetrics(MetricRegistry& registry) : impl_(std::make_unique<Impl>(registry)) {
  const auto& file = *v1::GetMeshRequest::descriptor()->file();
  for (int s = 0; s < file.service_count(); ++s) {
    const google::protobuf::ServiceDescriptor& service = *file.service(s);
    for (int m = 0; m < service.method_count(); ++m) {
      const google::protobuf::MethodDescriptor& method = *service.method(m);
      impl_->Add(TypeOf(method), service.full_name(), method.name(), /*is_ours=*/true);
    }
  }
  impl_->Add("unary", "grpc.health.v1.Health", "Check", false);
  impl_->Add("server_stream", "grpc.health.v1.Health", "Watch", false);
  impl_->other = std::make_unique<Method>(impl_->families, "other", "other", "other", false);
}

CallMetrics::~CallMetrics() = default;

CallMetrics::Method& CallMetrics::Find(const char* path) const {
  const auto found = impl_->methods.find(absl::string_view(path == nullptr ? "" : path));
  return found == impl_->methods.end() ? *impl_->other : *found->second;
}

FailedCalls& CallMetrics::failed() const { return impl_->failed; }

void CallMetrics::Judge(CallJudge judge) { impl_->judge = std::move(judge); }

const CallJudge& CallMetrics::judge() const { return impl_->judge; }

WorkGate& CallMetrics::open() const { return impl_->open; }

WorkGate::Ticket CallMetrics::Enter() const {
  WorkGate::Ticket ticket = impl_->open.Enter();
  if (ticket != nullptr) return ticket;
  impl_->last_late = MetricsClock::now().time_since_epoch().count();
  return impl_->late.Enter();
}

bool CallMetrics::WaitQuiet(absl::Duration quiet, absl::Duration limit) const {
  const auto end = MetricsClock::now() + absl::ToChronoNanoseconds(limit);
  const auto start = MetricsClock::now();
  const auto pause = absl::ToChronoNanoseconds(quiet);
  while (true) {
    const MetricsClock::time_point last(MetricsClock::duration(impl_->last_late.load()));
    const auto quiet_at = std::max(start, last) + pause;
    const auto now = MetricsClock::now();
    if (now >= quiet_at && impl_->late.WaitEmpty(absl::ZeroDuration())) return true;
    if (now >= end) return false;
    std::this_thread::sleep_until(std::min(end, std::max(quiet_at, now + kLateCheck)));
  }
}

namespace {

// Observes one call. A stream's reads and writes are concurrent; all else is sequential.
class CallObserver final : public grpc::experimental::Interceptor {
 public:
  CallObserver(const CallMetrics& metrics, CallMetrics::Method& method,
               grpc::ServerContextBase* context)
      : method_(method),
        failed_(metrics.failed()),
        judge_(metrics.judge()),
        context_(context),
        open_(method.is_ours ? metrics.Enter() : nullptr),
        start_(MetricsClock::now()) {
    method_.started.Add();
  }
  // If the client vanished, no status arrives.
  ~CallObserver() override { End(grpc::Status::CANCELLED, ""); }

  void Intercept(InterceptorBatchMethods* step) override {
    if (step->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_INITIAL_METADATA)) {
      TakeId(*step->GetRecvInitialMetadata());
    }
    if (step->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_MESSAGE) &&
        step->GetRecvMessage() != nullptr) {
      method_.received.Add();
    }
    if (step->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      step->GetSendInitialMetadata()->emplace(kCallIdKey, id_);
    }
    const bool ends = step->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_STATUS);
    if (!ends &&
        step->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_INITIAL_METADATA)) {
      TellAnswered();
    }
    if (step->QueryInterceptionHookPoint(InterceptionHookPoints::PRE_SEND_MESSAGE)) {
      method_.sent.Add();
      // Serialises the message here; gRPC does not do so again.
      method_.sent_bytes.Add(step->GetSerializedSendMessage()->Length());
    }
    if (ends) {
      const grpc::Status status = step->GetSendStatus();
      End(status, status.ok() || context_ == nullptr ? "" : PeerOf(*context_));
      JudgeStatus(status.error_code());
    }
    if (step->QueryInterceptionHookPoint(InterceptionHookPoints::POST_RECV_CLOSE)) JudgeClose();
    step->Proceed();
  }

 private:
  // A client that cancels after less did not wait for an answer.
  static constexpr double kAtOnce = 0.1;  // seconds

  void TellAnswered() {
    if (!method_.is_ours || context_ == nullptr || judge_.answered == nullptr) return;
    if (judge_.wants_answered() && !told_answered_.exchange(true)) {
      judge_.answered(context_->peer());
    }
  }
  void TellWasted() {
    if (context_ == nullptr || judge_.wasted == nullptr || told_wasted_.exchange(true)) return;
    judge_.wasted(context_->peer());
  }
  void JudgeStatus(grpc::StatusCode code) {
    if (!method_.is_ours || code == grpc::StatusCode::UNAUTHENTICATED) return TellWasted();
    switch (code) {
      case grpc::StatusCode::CANCELLED:
      case grpc::StatusCode::UNKNOWN:
      case grpc::StatusCode::INVALID_ARGUMENT:
      case grpc::StatusCode::RESOURCE_EXHAUSTED:
        return;
      default:
        return TellAnswered();
    }
  }
  // Of other services not: asking a synchronous call would wait.
  void JudgeClose() {
    if (!method_.is_ours || context_ == nullptr || judge_.wasted == nullptr) return;
    if (context_->IsCancelled() && SecondsSince(start_) < kAtOnce) TellWasted();
  }

  using Metadata = std::multimap<grpc::string_ref, grpc::string_ref>;

  // The id replaces the client's in the metadata, from which the handler of the call reads it.
  void TakeId(Metadata& metadata) {
    const auto given = metadata.find(kCallIdKey);
    id_ = ChooseCallId(given == metadata.end()
                           ? absl::string_view()
                           : absl::string_view(given->second.data(), given->second.size()));
    metadata.erase(kCallIdKey);
    metadata.emplace(kCallIdKey, id_);
  }

  void End(const grpc::Status& status, std::string peer) {
    if (ended_.exchange(true)) return;
    method_.Handled(status.error_code()).Add();
    method_.seconds.Observe(SecondsSince(start_));
    if (status.ok()) return;
    failed_.Tell({id_, method_.method, kCodeNames[IndexOf(status.error_code())], std::move(peer)},
                 status);
  }

  CallMetrics::Method& method_;
  FailedCalls& failed_;
  const CallJudge& judge_;
  const grpc::ServerContextBase* const context_;  // ends before the observer does
  const WorkGate::Ticket open_;
  const MetricsClock::time_point start_;
  std::string id_;
  std::atomic<bool> ended_{false};
  std::atomic<bool> told_answered_{false};
  std::atomic<bool> told_wasted_{false};
};

class CallObservers final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallObservers(const CallMetrics* metrics) : metrics_(*metrics) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(
      grpc::experimental::ServerRpcInfo* info) override {
    return new CallObserver(metrics_, metrics_.Find(info->method()), info->server_context());
  }

 private:
  const CallMetrics& metrics_;
};

}  // namespace

std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface> MakeCallObservers(
    const CallMetrics* metrics) {
  return std::make_unique<CallObservers>(metrics);
}

}  // namespace dynmesh::server
