#include "server/server.h"

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <iterator>
#include <thread>
#include <utility>
#include <vector>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/string_view.h"
#include "absl/time/clock.h"
#include "core/base/mutex.h"
#include "dynmesh/version.h"
#include "server/access/acceptor.h"
#include "server/access/access.h"
#include "server/access/tls.h"
#include "server/base/log.h"
#include "server/base/memory_guard.h"
#include "server/calls/admission.h"
#include "server/calls/mesh_service.h"
#include "server/calls/unknown_methods.h"
#include "server/cluster/lease_keeper.h"
#include "server/collect.h"
#include "server/http/http_door.h"
#include "server/http/metrics_http.h"
#include "server/journal_watch.h"
#include "server/metrics/call_observer.h"

namespace dynmesh::server {
namespace {

constexpr char kServiceName[] = "dynmesh.v1.MeshService";
// Resolution of the progress timer of idle watchers.
constexpr std::chrono::milliseconds kTick{100};
// For the last calls of a drain to be answered, and for cancelled calls to unwind.
constexpr absl::Duration kCallGrace = absl::Seconds(5);
// For clients to read the GOAWAY and to close their connections themselves. A client without a call
// often notices only at its next call.
constexpr std::chrono::milliseconds kConnectionGrace{50};
// For the last replies of HTTP to be sent.
constexpr std::chrono::milliseconds kHttpGrace{1000};
// For clients to notice the drain by a refusal, which says so: calls on a connection that is being
// closed get no reason. Ends when none has come for a while.
constexpr absl::Duration kRefusalGrace = absl::Seconds(1);
constexpr absl::Duration kQuiet = absl::Milliseconds(50);

// 500 calls of the smallest size. A larger read would save loads little: a message of 4 MB is 256
// of these, some microseconds each.
constexpr int kReadBytes = 16 << 10;

int Threads(int configured) {
  if (configured > 0) return configured;
  return std::max(2, static_cast<int>(std::thread::hardware_concurrency()));
}

// A thread that waits for the journal uses no core. More threads share one sync.
int WriterThreads(int configured, bool journal) {
  constexpr int kLeastWithJournal = 8;
  if (configured > 0 || !journal) return Threads(configured);
  return std::max(kLeastWithJournal, 2 * Threads(configured));
}

Acceptor::Limits ConnectionLimits(const ServerConfig& config) {
  Acceptor::Limits limits;
  limits.connections = config.max_connections;
  const std::uint64_t half = std::max<std::uint64_t>(1, config.max_connections / 2);
  const std::uint64_t own = config.max_connections_per_address;
  limits.of_address = {own != 0 ? own : half, config.max_new_connections_per_second,
                       config.max_wasted_calls_per_second,
                       absl::ToChronoNanoseconds(config.handshake_timeout)};
  return limits;
}

int Milliseconds(absl::Duration d) { return static_cast<int>(absl::ToInt64Milliseconds(d)); }

void LimitConnections(const ServerConfig& config, grpc::ServerBuilder& builder) {
  const auto set = [&builder](const char* name, int value) {
    builder.AddChannelArgument(name, value);
  };
  // Detects clients that vanished without closing their connection.
  set(GRPC_ARG_KEEPALIVE_TIME_MS, Milliseconds(config.keepalive_interval));
  set(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, Milliseconds(config.keepalive_timeout));
  // Less than the 5 s of the client library and the second of other servers. Clients that ping more
  // often are sent away.
  set(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 500);
  set(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  // Closes connections without a handshake, and idle ones.
  set(GRPC_ARG_SERVER_HANDSHAKE_TIMEOUT_MS, Milliseconds(config.handshake_timeout));
  set(GRPC_ARG_MAX_CONNECTION_IDLE_MS, Milliseconds(config.idle_timeout));
  set(GRPC_ARG_MAX_CONCURRENT_STREAMS, config.max_streams_per_connection);
  // What is read of a connection before its calls are handled. All that a read brings is queued,
  // and calls that are for nothing are counted only when they are handled.
  set(GRPC_ARG_TCP_MAX_READ_CHUNK_SIZE, kReadBytes);
}

// For calls that are handed on; null: none is. The files are read once.
absl::StatusOr<std::shared_ptr<grpc::ChannelCredentials>> NeighbourCredentials(
    const ServerConfig& config) {
  if (config.node_address.empty()) return nullptr;
  if (!config.tls.enabled()) return grpc::InsecureChannelCredentials();
  if (config.node_ca.empty()) return nullptr;
  grpc::SslCredentialsOptions options;
  for (const auto& [path, text] : {std::pair{&config.node_ca, &options.pem_root_certs},
                                   std::pair{&config.tls.key, &options.pem_private_key},
                                   std::pair{&config.tls.certificate, &options.pem_cert_chain}}) {
    std::ifstream in(*path, std::ios::binary);
    text->assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    if (!in.good() || text->empty()) {
      return absl::InvalidArgumentError(
          absl::StrCat("node-ca: ", *path, " cannot be read, or is empty"));
    }
  }
  return grpc::SslCredentials(options);
}

// Calls a function every kTick until destroyed.
class Ticker {
 public:
  explicit Ticker(std::function<void()> tick)
      : thread_([this, run = std::move(tick)] {
          const MutexLock lock(mutex_);
          while (!stop_.WaitFor(
              mutex_, kTick, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return stopped_; }))
            run();
        }) {}
  ~Ticker() {
    {
      const MutexLock lock(mutex_);
      stopped_ = true;
    }
    stop_.NotifyAll();
    thread_.join();
  }

 private:
  Mutex mutex_;
  CondVar stop_;
  bool stopped_ ABSL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace

struct Server::Impl {
  Impl(const ServerConfig& c, MeshFactory factory, std::unique_ptr<Journal> j,
       std::unique_ptr<Access> a, MeshBuilder builder,
       std::shared_ptr<grpc::ChannelCredentials> neighbours, absl::Span<const StaticFile> files)
      : config(c),
        page(files),
        journal(std::move(j)),
        journal_watch(journal.get()),
        access(std::move(a)),
        memory(c.max_memory_bytes, c.resident_bytes),
        writers(WriterThreads(c.writer_threads, journal != nullptr)),
        readers(Threads(c.reader_threads), WorkerPool::Priority::kBackground),
        answers(Threads(c.writer_threads) / 2),
        builds(c, std::move(builder), &memory, &metrics.builds),
        registry(c, std::move(factory), &writers, &readers, journal.get(), &metrics, &memory),
        calls(metrics.registry),
        context(c, &registry, &writers, &readers, &answers, &metrics, access.get(), absl::Now(),
                &builds),
        service(&context, std::move(neighbours)) {
    calls.failed().NameHolders(
        [this](const std::string& limit) { return HoldersOf(context, limit); });
  }

  // A Listen that fails has opened the port already.
  ~Impl() {
    if (acceptor != nullptr) acceptor->Stop();
    if (door != nullptr) door->Stop(kConnectionGrace);
    if (server != nullptr) server->Shutdown(std::chrono::system_clock::now());
  }

  // From here on calls are answered, with RECOVERING until the meshes are recovered.
  absl::Status Listen() {
    grpc::EnableDefaultHealthCheckService(true);
    grpc::reflection::InitProtoReflectionServerBuilderPlugin();
    grpc::ServerBuilder builder;
    Acceptor::Sink sink;
    if (absl::StartsWith(config.listen, "unix:")) {
      builder.AddListeningPort(config.listen, credentials, &port);
    } else {
      auto listening = Acceptor::Listen(config.listen, ConnectionLimits(config));
      if (!listening.ok()) return listening.status();
      acceptor = *std::move(listening);
      listener = acceptor.get();
      calls.Judge({[this] { return acceptor->WantsAnswered(); },
                   [this](absl::string_view peer) { acceptor->Answered(peer); },
                   [this](absl::string_view peer) { acceptor->Wasted(peer); }});
      port = acceptor->port();
      using External = grpc::ServerBuilder::experimental_type::ExternalConnectionType;
      sink = builder.experimental().AddExternalConnectionAcceptor(External::FROM_FD, credentials);
    }
    builder.RegisterService(&service);
    builder.RegisterCallbackGenericService(&unknown);
    builder.SetMaxReceiveMessageSize(config.max_message_bytes);
    LimitConnections(config, builder);
    std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> observers;
    observers.push_back(MakeCallObservers(&calls));
    builder.experimental().SetInterceptorCreators(std::move(observers));
    context.recovering = true;
    server = builder.BuildAndStart();
    if (server == nullptr || port == 0) {
      return absl::UnavailableError(
          absl::StrCat("cannot listen on ", config.listen, ": is the port taken?"));
    }
    if (absl::Status status = ListenForHttp(); !status.ok()) return status;
    SetHealth(false);
    if (sink != nullptr) acceptor->Start(std::move(sink), config.keepalive_timeout);
    Log(LogLevel::kInfo, "listening", {{"address", Address()}, {"version", kVersion}});
    return absl::OkStatus();
  }

  absl::Status ListenForHttp() {
    if (config.http.empty()) return absl::OkStatus();
    HttpDoor::Options options;
    options.listen = config.http;
    options.limits.most_connections = config.max_http_connections;
    options.limits.most_request_bytes = static_cast<std::size_t>(config.max_message_bytes);
    options.limits.receive_limit =
        std::chrono::milliseconds(Milliseconds(config.handshake_timeout));
    options.limits.send_limit = std::chrono::milliseconds(Milliseconds(config.send_timeout));
    options.name = config.http_name;
    options.has_tokens = !config.tokens_file.empty();
    options.files = page;
    grpc::ChannelArguments arguments;
    arguments.SetMaxReceiveMessageSize(-1);  // answers are the service's own
    auto listening = HttpDoor::Listen(options, server->InProcessChannel(arguments));
    if (!listening.ok()) return listening.status();
    door = *std::move(listening);
    open_door = door.get();
    Log(LogLevel::kInfo, "http_listen", {{"address", door->address()}});
    if (!IsLoopback(door->address())) {
      Log(LogLevel::kWarning, "exposed",
          {{"address", door->address()},
           {"encrypted", "no"},
           {"message", "tokens and meshes cross the network unencrypted over HTTP"}});
    }
    return absl::OkStatus();
  }

  std::string Address() const {
    const absl::string_view listen = config.listen;
    return absl::StrCat(listen.substr(0, listen.rfind(':')), ":", port);
  }

  absl::Status RecoverMeshes() {
    if (journal == nullptr) {
      Log(LogLevel::kWarning, "in_memory",
          {{"durability", "none"},
           {"message", "meshes live in memory only: they are gone when this process ends"}});
      return absl::OkStatus();
    }
    const absl::Time start = absl::Now();
    if (!config.node_address.empty()) return Join();
    if (absl::Status status = registry.Recover(); !status.ok()) return status;
    Log(LogLevel::kInfo, "journal_open",
        {{"journal", journal->name()},
         {"meshes", registry.size()},
         {"milliseconds", absl::ToInt64Milliseconds(absl::Now() - start)}});
    return absl::OkStatus();
  }

  // HOST:PORT for other nodes.
  std::string NodeAddress() const {
    const std::string& given = config.node_address;
    const std::size_t colon = given.rfind(':');
    const bool has_port = colon != std::string::npos && given.find(']', colon) == std::string::npos;
    if (!has_port) return absl::StrCat(given, ":", port);
    if (given.substr(colon + 1) == "0") return absl::StrCat(given.substr(0, colon + 1), port);
    return given;
  }

  // Meshes of other nodes stay there, and those that are free are opened while calls are answered.
  absl::Status Join() {
    const std::string address = NodeAddress();
    const auto may_answer = [this] {
      const LeaseKeeper* const now = joined;
      return now != nullptr && now->MayAnswerReads();
    };
    if (absl::Status status = registry.Join(address, may_answer); !status.ok()) return status;
    keeper = std::make_unique<LeaseKeeper>(
        absl::ToChronoNanoseconds(journal->shared()->lease()),
        LeaseKeeper::Calls{[this] { return registry.Renew(); },
                           [this] { return journal->shared()->GiveUp(); }});
    joined = keeper.get();
    Log(LogLevel::kInfo, "node_joined",
        {{"journal", journal->name()},
         {"address", address},
         {"lease", absl::FormatDuration(config.lease)}});
    return absl::OkStatus();
  }

  void Tick() {
    // Not the time of day, which can be set back.
    const absl::Time now =
        absl::UnixEpoch() + absl::FromChrono(std::chrono::steady_clock::now().time_since_epoch());
    journal_watch.Look();  // first: others read files, perhaps of the same disk
    registry.Tick(now);
    service.Tick();
    memory.Measure();
    memory.NoteStreams(context.watchers.used() + context.edit_streams.used() +
                       context.snapshot_streams.used() + context.builds.used());
    access->ReloadIfChanged(now);
    if (tls != nullptr) tls->Look(absl::Now());
  }

  void SetHealth(bool serving) {
    if (auto* health = server->GetHealthCheckService()) {
      health->SetServingStatus(serving);
      health->SetServingStatus(kServiceName, serving);
    }
  }

  // Neither makes the server unready. While the journal fails, is gone or hangs, reads are answered
  // and the next edit retries the journal. Besides damaged meshes, the others are served.
  std::string Amiss() const {
    std::vector<std::string> amiss;
    if (std::string journals = journal_watch.Amiss(); !journals.empty()) {
      amiss.push_back(std::move(journals));
    }
    if (const std::size_t damaged = registry.damaged(); damaged > 0) {
      amiss.push_back(absl::StrCat("damaged meshes: ", damaged));
    }
    return absl::StrJoin(amiss, "; ");
  }

  // Before recovery, so that clients of HTTP see that it is under way.
  absl::Status ListenForMetrics() {
    metrics.registry.AddSource([this](MetricsText& out) {
      WriteMeshes(registry, out);
      if (journal != nullptr) WriteJournal(*journal, out);
      if (const LeaseKeeper* const now = joined; now != nullptr) {
        WriteNode(registry, *now, config.lease, out);
      }
      WriteLimits(memory, config.tls, out);
      WriteStreams(context.client_streams, out);
      if (Acceptor* const now = listener; now != nullptr) {
        WriteConnections(now->counts(), out);
      }
      if (HttpDoor* const now = open_door; now != nullptr) WriteHttp(now->counts(), out);
      WriteProcess(out);
    });
    if (config.metrics.empty()) return absl::OkStatus();
    auto listening =
        MetricsHttp::Listen(config.metrics, {[this] { return metrics.registry.Text(); },
                                             [this] { return std::string(not_ready.load()); },
                                             [this] { return Amiss(); }});
    if (!listening.ok()) return listening.status();
    http = *std::move(listening);
    Log(LogLevel::kInfo, "metrics_listen", {{"address", http->address()}});
    if (!IsLoopback(http->address())) {
      Log(LogLevel::kWarning, "exposed",
          {{"address", http->address()},
           {"message",
            "every client that can connect to the metrics reads the names of the meshes"}});
    }
    return absl::OkStatus();
  }

  // Destroyed in reverse order: first the calls end (Stop), then the tasks, then the meshes.
  const ServerConfig config;
  const absl::Span<const StaticFile> page;
  const std::unique_ptr<Journal> journal;  // null: nothing outlives this process
  JournalWatch journal_watch;
  const std::unique_ptr<Access> access;
  MemoryGuard memory;
  ServerMetrics metrics;
  WorkerPool writers;
  WorkerPool readers;
  WorkerPool answers;  // not shared with readers: their tasks may take O(mesh)
  BuildPool builds;
  MeshRegistry registry;
  std::unique_ptr<LeaseKeeper> keeper;  // null: the journal's meshes are this server's alone
  std::atomic<const LeaseKeeper*> joined{nullptr};  // the same, for all threads
  CallMetrics calls;
  ServiceContext context;
  MeshServiceImpl service;
  UnknownMethods unknown;
  std::shared_ptr<grpc::ServerCredentials> credentials;  // outlive the server
  std::shared_ptr<TlsCredentials> tls;                   // the same, if it is TLS
  std::unique_ptr<Acceptor> acceptor;  // null: gRPC itself listens; calls use it until they end
  std::atomic<Acceptor*> listener{nullptr};  // the same, for all threads
  std::unique_ptr<grpc::Server> server;
  std::unique_ptr<HttpDoor> door;             // null: not over HTTP; its calls are the server's
  std::atomic<HttpDoor*> open_door{nullptr};  // the same, for all threads
  int port = 0;
  std::unique_ptr<Ticker> ticker;
  Mutex drain_mutex;
  bool drained ABSL_GUARDED_BY(drain_mutex) = false;
  // The answer of /readyz; empty: ready.
  std::atomic<const char*> not_ready{"recovering"};
  std::unique_ptr<MetricsHttp> http;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerConfig& config,
                                                      MeshFactory factory,
                                                      std::unique_ptr<Journal> journal,
                                                      MeshBuilder builder,
                                                      absl::Span<const StaticFile> page) {
  if (absl::Status status = ValidateConfig(config); !status.ok()) return status;
  std::shared_ptr<grpc::ServerCredentials> credentials = grpc::InsecureServerCredentials();
  std::shared_ptr<TlsCredentials> tls;  // null: none
  if (config.tls.enabled()) {
    auto made = MakeTlsCredentials(config.tls);
    if (!made.ok()) return made.status();
    credentials = tls = *std::move(made);
  }
  absl::StatusOr<std::unique_ptr<Access>> access =
      Access::Create(config.tokens_file, config.max_requests_per_second);
  if (!access.ok()) return access.status();
  auto neighbours = NeighbourCredentials(config);
  if (!neighbours.ok()) return neighbours.status();
  auto impl =
      std::make_unique<Impl>(config, std::move(factory), std::move(journal), *std::move(access),
                             std::move(builder), *std::move(neighbours), page);
  if (absl::Status status = impl->ListenForMetrics(); !status.ok()) return status;
  impl->credentials = std::move(credentials);
  impl->tls = std::move(tls);
  if (absl::Status status = impl->Listen(); !status.ok()) return status;
  if (absl::Status status = impl->RecoverMeshes(); !status.ok()) return status;
  impl->context.recovering = false;
  impl->SetHealth(true);
  impl->not_ready = "";
  impl->ticker = std::make_unique<Ticker>([impl = impl.get()] { impl->Tick(); });
  std::unique_ptr<Server> server(new Server(std::move(impl)));
  Log(LogLevel::kInfo, "serving", {{"address", server->address()}});
  const bool authenticates = !config.tokens_file.empty() || !config.tls.client_ca.empty();
  if (!IsLoopback(config.listen) && (!config.tls.enabled() || !authenticates)) {
    Log(LogLevel::kWarning, "exposed",
        {{"address", config.listen},
         {"encrypted", config.tls.enabled() ? "yes" : "no"},
         {"message", authenticates
                         ? "tokens and meshes cross the network unencrypted"
                         : "no authentication: every client that can connect can make, edit "
                           "and delete every mesh; give --tokens or --tls-client-ca"}});
  }
  return server;
}

Server::~Server() {
  if (impl_ != nullptr && impl_->server != nullptr) Drain(absl::ZeroDuration());
}

int Server::port() const { return impl_->port; }

std::string Server::address() const { return impl_->Address(); }

std::string Server::http_address() const {
  return impl_->door == nullptr ? "" : impl_->door->address();
}

void Server::Reload() { impl_->access->Reload(); }

MeshRegistry& Server::registry() { return impl_->registry; }

ConnectionTable::Counts Server::connections() const {
  return impl_->acceptor == nullptr ? ConnectionTable::Counts() : impl_->acceptor->counts();
}

HttpServer::Counts Server::http_counts() const {
  return impl_->door == nullptr ? HttpServer::Counts() : impl_->door->counts();
}

bool Server::Drain(absl::Duration limit) {
  const MutexLock lock(impl_->drain_mutex);
  if (impl_->drained) return true;
  impl_->drained = true;
  const absl::Time start = absl::Now();
  Log(LogLevel::kInfo, "draining", {{"limit", absl::FormatDuration(limit)}});
  impl_->not_ready = "draining";
  impl_->SetHealth(false);
  // Calls are answered meanwhile, with the next owner when it has the mesh.
  const bool waits = limit > absl::ZeroDuration();
  if (waits) {
    impl_->registry.HandOver(limit);
    limit = std::max(absl::ZeroDuration(), limit - (absl::Now() - start));
  }
  impl_->service.BeginDrain();
  impl_->calls.open().Close();
  const bool done = impl_->context.gate.WaitEmpty(limit);
  // Only what was handed to the disk or the database is waited for.
  if (!done && impl_->journal != nullptr) impl_->journal->EndWrites(DrainingError());
  if (impl_->acceptor != nullptr) impl_->acceptor->Stop();
  // Edits of calls that are still open are cancelled and undone. The other calls are being ended.
  if (!done) impl_->service.CancelEdits();
  const bool answered = (done || waits) && impl_->calls.open().WaitEmpty(kCallGrace);
  if (!answered) impl_->service.CutCalls();
  if (done && waits) impl_->calls.WaitQuiet(kQuiet, kRefusalGrace);
  if (impl_->door != nullptr) impl_->door->Stop(kHttpGrace);
  impl_->server->Shutdown(std::chrono::system_clock::now() +
                          (done ? kConnectionGrace : std::chrono::milliseconds(0)));
  impl_->ticker.reset();
  impl_->registry.EndSweeps();
  impl_->registry.CloseOpening(DrainingError());
  impl_->writers.Stop();
  // After the last append: another server may take the meshes over at once.
  if (impl_->keeper != nullptr) impl_->keeper->Stop();
  impl_->readers.Stop();
  impl_->answers.Stop();
  impl_->builds.Stop();
  Log(LogLevel::kInfo, "drained",
      {{"complete", done}, {"took", absl::FormatDuration(absl::Now() - start)}});
  return done;
}

}  // namespace dynmesh::server
