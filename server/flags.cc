#include "server/flags.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <type_traits>
#include <utility>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "absl/strings/strip.h"
#include "absl/time/time.h"
#include "dynmesh/version.h"
#include "server/base/log.h"

namespace dynmesh::server {
namespace {

// Upper bound of counts: more than any machine holds.
constexpr std::uint64_t kMost = 1'000'000'000'000'000;
constexpr absl::Duration kDay = absl::Hours(24);
constexpr int kMostThreads = 1024;

// A value that its option does not accept.
class BadValue final : public CLI::ValidationError {
 public:
  BadValue(std::string key, std::string value, const std::string& why)
      : CLI::ValidationError(key, why), key_(std::move(key)), value_(std::move(value)), why_(why) {}
  const std::string& key() const { return key_; }
  const std::string& value() const { return value_; }
  const std::string& why() const { return why_; }

 private:
  std::string key_, value_, why_;
};

// An option that takes a number from `least` to `most` and nothing after it. (CLI11 itself reads -1
// as 2^64 - 1, and 1e3 as 1.)
template <typename T>
CLI::Option* AddNumber(CLI::App& app, const std::string& key, T least, T most, const char* help,
                       std::function<void(T)> set) {
  return app.add_option_function<std::string>(
      absl::StrCat("--", key),
      [=, set = std::move(set)](const std::string& text) {
        T value = 0;
        const char* const end = text.data() + text.size();
        const auto [rest, error] = std::from_chars(text.data(), end, value);
        // NaN is in no range.
        const bool good = error == std::errc() && rest == end && value >= least && value <= most;
        if (!good) {
          throw BadValue(key, text,
                         absl::StrCat("is not a ", std::is_integral_v<T> ? "whole " : "",
                                      "number from ", least, " to ", most));
        }
        set(value);
      },
      help);
}

template <typename T>
void AddCount(CLI::App& app, const char* key, T& target, T least, const char* help,
              T most = static_cast<T>(std::min<std::uint64_t>(kMost,
                                                              std::numeric_limits<T>::max()))) {
  AddNumber<T>(app, key, least, most, help, [&target](T value) { target = value; })
      ->default_str(absl::StrCat(target))
      ->type_name("UINT");
}

// A time: bare seconds, or numbers with units, as 8s, 500ms, 1h30m. Nothing if it is neither.
std::optional<absl::Duration> ParseTime(const std::string& text) {
  double seconds = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, seconds);
  if (error == std::errc() && rest == end) return absl::Seconds(seconds);
  absl::Duration time;
  if (absl::ParseDuration(text, &time)) return time;
  return std::nullopt;
}

// A time from `least` to one day. The library's text of `target` is the default that is shown.
void AddTime(CLI::App& app, const std::string& key, absl::Duration& target, absl::Duration least,
             const char* help) {
  app.add_option_function<std::string>(
         absl::StrCat("--", key),
         [=, &target](const std::string& text) {
           const std::optional<absl::Duration> time = ParseTime(text);
           if (!time.has_value() || *time < least || *time > kDay) {
             throw BadValue(key, text,
                            absl::StrCat("is not a time from ", absl::FormatDuration(least), " to ",
                                         absl::FormatDuration(kDay),
                                         ": give seconds, or a unit, as 8s, 500ms or 10m"));
           }
           target = *time;
         },
         help)
      ->default_str(absl::FormatDuration(target))
      ->type_name("TIME");
}

void AddMebibytes(CLI::App& app, const char* key, std::uint64_t& bytes, const char* help) {
  AddNumber<std::uint64_t>(app, key, 0, kMost >> 20, help,
                           [&bytes](std::uint64_t mebibytes) { bytes = mebibytes << 20; })
      ->default_str(absl::StrCat(bytes >> 20))
      ->type_name("UINT");
}

void AddSecurityFlags(CLI::App& app, ServerConfig& c) {
  app.add_option("--tls-cert", c.tls.certificate,
                 "PEM file: the server's certificate, then its chain; read again when it changes");
  app.add_option("--tls-key", c.tls.key, "PEM file: the certificate's private key");
  app.add_option("--tls-client-ca", c.tls.client_ca,
                 "PEM file: clients must show a certificate that this authority signed");
  app.add_flag("--insecure-listen", c.insecure_listen,
               "listen elsewhere than on loopback without TLS");
  app.add_option("--tokens", c.tokens_file,
                 "file of tokens and their roles; read again when it changes");
}

void AddMeshLimits(CLI::App& app, ServerConfig& c) {
  AddCount<std::uint64_t>(app, "max-meshes", c.max_meshes, 1, "meshes held");
  AddCount<std::uint64_t>(app, "max-vertices", c.max_vertices, 0,
                          "vertices of one mesh; 0: as many as half of the memory limit holds");
  AddCount<std::uint64_t>(app, "max-features", c.max_features, 1, "features of one mesh");
  AddCount<std::uint64_t>(app, "max-batch-edits", c.max_batch_edits, 1, "edits in one batch");
  AddCount<std::uint64_t>(app, "max-batch-operations", c.max_batch_operations, 0,
                          "operations that one batch may execute; 0: any number");
  AddCount<std::uint64_t>(app, "max-pending-edits", c.max_pending_edits, 1,
                          "edits received and not applied");
  AddCount(app, "max-message-bytes", c.max_message_bytes, 64 << 10, "bytes of one request message");
  AddCount<std::uint64_t>(app, "max-watchers", c.max_watchers, 0, "watches open");
  AddCount<std::uint64_t>(app, "max-edit-streams", c.max_edit_streams, 0, "edit streams open");
  AddCount<std::uint64_t>(app, "max-snapshot-streams", c.max_snapshot_streams, 0,
                          "concurrent snapshots");
  AddCount<std::uint64_t>(app, "max-builds", c.max_builds, 0,
                          "builds open, each on a thread of its own; 0: none", kMostThreads);
  AddCount<std::uint64_t>(app, "max-build-vertices", c.max_build_vertices, 0,
                          "vertices of the mesh of one build; 0: as max-vertices");
  AddTime(app, "max-build-seconds", c.max_build_time, absl::ZeroDuration(),
          "time that one build may compute; 0: any");
  AddCount<std::uint64_t>(app, "max-waiting-edits", c.max_waiting_edits, 1,
                          "batches that wait for one mesh");
  AddCount<std::uint64_t>(app, "history-revisions", c.history_revisions, 1, "diffs kept of a mesh");
  AddMebibytes(app, "history-mib", c.history_bytes, "MiB of diffs kept of a mesh");
  AddCount<std::uint64_t>(app, "watch-queue", c.watch_queue, 0,
                          "revisions a watcher may lag before coalescing");
}

void AddRate(CLI::App& app, const char* key, double& rate, const char* help) {
  AddNumber<double>(app, key, 0, 1e9, help, [&rate](double given) { rate = given; })
      ->default_str(absl::StrCat(rate))
      ->type_name("FLOAT");
}

void AddAddressLimits(CLI::App& app, ServerConfig& c) {
  AddCount<std::uint64_t>(app, "max-connections-per-address", c.max_connections_per_address, 0,
                          "connections open of one address; 0: half of max-connections");
  AddRate(app, "max-new-connections-per-second", c.max_new_connections_per_second,
          "connections of one address without an answered call; further ones wait; 0: any number");
  AddRate(app, "max-wasted-calls-per-second", c.max_wasted_calls_per_second,
          "calls of one address that are refused for their token or cancelled at once; then their "
          "connections are cut; 0: any number");
}

void AddClientLimits(CLI::App& app, ServerConfig& c) {
  AddRate(app, "max-requests-per-second", c.max_requests_per_second,
          "requests and batches of one client; 0: any number");
  AddCount<std::uint64_t>(app, "max-streams-per-client", c.max_streams_per_client, 0,
                          "watches, edit streams, loads, builds and snapshots open of one client, "
                          "a token or an address; 0: any number");
  AddCount<std::uint64_t>(app, "max-memory-bytes", c.max_memory_bytes, 0,
                          "resident bytes above which nothing grows; 0: nine tenths of "
                          "the available memory");
  AddCount<std::uint64_t>(app, "max-connections", c.max_connections, 1, "connections open");
  AddCount<std::uint64_t>(app, "max-http-connections", c.max_http_connections, 1,
                          "connections of HTTP open, each with a thread; others are answered 503",
                          10'000);
  AddAddressLimits(app, c);
  AddCount(app, "max-streams-per-connection", c.max_streams_per_connection, 1,
           "calls open on one connection");
  AddTime(app, "handshake-timeout", c.handshake_timeout, absl::Milliseconds(100),
          "time for the TLS handshake and a client's first bytes of HTTP/2");
  AddTime(app, "keepalive-interval", c.keepalive_interval, absl::Milliseconds(100),
          "silence after which a client is pinged");
  AddTime(app, "keepalive-timeout", c.keepalive_timeout, absl::Milliseconds(100),
          "time for its answer");
  AddTime(app, "idle-timeout", c.idle_timeout, absl::Milliseconds(100),
          "time without calls after which a connection is closed");
  AddTime(app, "batch-timeout", c.batch_timeout, absl::Milliseconds(1),
          "time that a batch in parts, or a load, waits for its next part");
  AddTime(app, "send-timeout", c.send_timeout, absl::ZeroDuration(),
          "time after which a call ends if its client reads nothing of it; 0: never");
}

// Not for the configuration file: they are for one run, which serves nothing.
void AddCopyFlags(CLI::App& app, Flags& f) {
  app.add_option("--copy-journal", f.copy_journal,
                 "copy the meshes of the journal FROM, with their past, into the journal TO, and "
                 "end; each is a folder or postgresql://...; no server may use them meanwhile")
      ->type_name("FROM TO")
      ->type_size(2)
      ->expected(1)
      ->configurable(false);
  app.add_option("--copy-meshes", f.copy_meshes,
                 "copy these only, with commas between; default: all")
      ->type_name("MESHES")
      ->configurable(false);
}

// The line (from 1) of a key in a configuration file. If the key is there twice: the line with that
// value. 0 if the key is absent.
int LineOf(const std::string& path, absl::string_view key, absl::string_view value) {
  std::ifstream in(path);
  int line = 0, found = 0;
  for (std::string text; std::getline(in, text);) {
    ++line;
    const std::vector<absl::string_view> sides = absl::StrSplit(text, absl::MaxSplits('=', 1));
    if (absl::StripAsciiWhitespace(sides[0]) != key) continue;
    if (found == 0) found = line;
    if (sides.size() == 2 && absl::StrContains(sides[1], value)) return line;
  }
  return found;
}

bool IsOnCommandLine(absl::string_view key, int argc, const char* const* argv) {
  const std::string flag = absl::StrCat("--", key);
  return std::any_of(argv + std::min(argc, 1), argv + argc, [&](absl::string_view argument) {
    return argument == flag || absl::StartsWith(argument, flag + "=");
  });
}

// In the log's form: usually a program starts the server and keeps its log.
void TellBadValue(const CLI::App& app, const BadValue& bad, int argc, const char* const* argv) {
  if (IsOnCommandLine(bad.key(), argc, argv)) {
    Log(LogLevel::kError, "bad_option",
        {{"key", bad.key()}, {"value", bad.value()}, {"message", bad.why()}});
    return;
  }
  const auto path = app.get_config_ptr()->as<std::string>();
  Log(LogLevel::kError, "bad_option",
      {{"key", bad.key()},
       {"value", bad.value()},
       {"file", path},
       {"line", LineOf(path, bad.key(), bad.value())},
       {"message", bad.why()}});
}

void TellBadFile(const CLI::App& app, const CLI::ConfigError& error) {
  // CLI11's message ends with the key. It names neither the file nor the fault.
  constexpr char kExtra[] = "INI was not able to parse ";
  const std::string what = error.what();
  absl::string_view key = what;
  const bool unknown = absl::ConsumePrefix(&key, kExtra);
  // CLI11 reports the beginning of a section as "lab.++".
  const bool section = absl::ConsumeSuffix(&key, ".++");
  const auto path = app.get_config_ptr()->as<std::string>();
  if (!unknown) {
    Log(LogLevel::kError, "bad_option", {{"file", path}, {"message", what}});
    return;
  }
  const std::string word = section ? absl::StrCat("[", key, "]") : std::string(key);
  Log(LogLevel::kError, "bad_option",
      {{"key", word},
       {"file", path},
       {"line", LineOf(path, word, "")},
       {"message", section ? "there are no sections" : "there is no such option"}});
}

}  // namespace

void AddFlags(CLI::App& app, Flags& f) {
  ServerConfig& c = f.config;
  app.set_config("--config", "", "file with these options as keys: deploy/dynmeshd.conf");
  app.allow_config_extras(CLI::config_extras_mode::error);
  app.add_option("--listen", c.listen, "host:port; port 0 takes a free one")->capture_default_str();
  AddSecurityFlags(app, c);
  app.add_option("--data-dir", f.data_dir,
                 "folder that keeps the meshes; an edit is answered when it is on the disk");
  app.add_option("--journal", f.journal,
                 "postgresql://[USER@]HOST[:PORT][,...]/DATABASE that keeps the meshes, instead of "
                 "--data-dir; the password belongs into the file of PGPASSFILE")
      ->type_name("ADDRESS");
  app.add_option("--node-address", c.node_address,
                 "HOST[:PORT] at which clients and other servers reach this one: it shares the "
                 "meshes of --journal with them; default: it has all meshes")
      ->type_name("ADDRESS");
  app.add_option("--node-ca", c.node_ca,
                 "PEM file: the authority that signed the other servers' certificates; with TLS, "
                 "calls of clients that do not go there themselves are handed on only with it");
  AddTime(app, "lease", c.lease, absl::Milliseconds(100),
          "time after which another server takes over the meshes of one that has ended; the "
          "same at all servers of a journal");
  AddCount<std::uint64_t>(app, "followers", c.followers, 0,
                          "servers that follow each mesh in use, to take it over at once; 0: none; "
                          "the same at all servers of a journal",
                          16);
  AddCount<std::uint64_t>(app, "max-followed-meshes", c.max_followed_meshes, 0,
                          "meshes of other servers followed here; 0: none");
  AddTime(app, "follower-idle", c.follower_idle, absl::Seconds(1),
          "time without use after which a mesh is not followed any more");
  app.add_option(
         "--accept-loss", f.accept_loss,
         "go on with a mesh from what is left of it, or without it: what the log's mesh_loss "
         "or journal_losses says, with commas between. It accepts that loss and no later one")
      ->type_name("LOSS");
  AddCopyFlags(app, f);
  AddCount<std::uint64_t>(
      app, "compact-bytes", c.compact_bytes, 0,
      "bytes of a mesh's edits in the folder before a snapshot, from which it is recovered");
  AddCount<std::uint64_t>(
      app, "compact-operations", c.compact_operations, 0,
      "operations that a mesh's edits executed before a snapshot, from which it is recovered");
  AddMebibytes(app, "journal-history-mib", c.journal_history_bytes,
               "MiB kept in the folder of a mesh's past before that snapshot; at least back to the "
               "one before it");
  app.add_option(
         "--metrics", c.metrics,
         "[HOST:]PORT of metrics and health over HTTP: /metrics /healthz /readyz; default: none")
      ->type_name("ADDRESS");
  app.add_option("--http", c.http,
                 "[HOST:]PORT of the service over HTTP, for browsers and curl (docs/http.md); "
                 "default: none")
      ->type_name("ADDRESS");
  app.add_option("--http-name", c.http_name,
                 "name in the address that browsers have, as behind a proxy: requests of pages of "
                 "other names are refused; default: the host of --http")
      ->type_name("NAME");
  app.add_option("--port-file", f.port_file, "write the port here when it serves");
  app.add_option_function<std::string>(
         "--log-level",
         [&f](const std::string& text) {
           if (!IsLogLevel(text)) {
             throw BadValue("log-level", text, "is none of debug, info, warning, error and off");
           }
           f.log_level = text;
         },
         "debug, info, warning, error, off")
      ->default_str(f.log_level);
  AddTime(
      app, "drain-timeout", c.drain_timeout, absl::ZeroDuration(),
      "time to finish work after SIGTERM; the process ends 8 s later at most, with exit code 3, "
      "also if the disk or the database does not answer");
  AddTime(app, "progress-interval", c.progress_interval, absl::Milliseconds(100),
          "time between messages to idle watchers");
  AddCount(app, "writer-threads", c.writer_threads, 0, "threads that apply edits; 0: by cores",
           kMostThreads);
  AddCount(app, "reader-threads", c.reader_threads, 0, "threads that serve readers; 0: by cores",
           kMostThreads);
  AddMeshLimits(app, c);
  AddClientLimits(app, c);
}

std::optional<int> ParseFlags(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const BadValue& bad) {
    TellBadValue(app, bad, argc, argv);
    return 2;
  } catch (const CLI::ConfigError& error) {
    TellBadFile(app, error);
    return 2;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // help and version
    Log(LogLevel::kError, "bad_option",
        {{"message", absl::StrCat(error.what(), " (dynmeshd --help has all there are)")}});
    return 2;
  }
  return std::nullopt;
}

std::optional<int> ReadFlags(int argc, const char* const* argv, Flags& flags) {
  CLI::App app{
      "dynmeshd: serves dynamic meshes over gRPC. They live in memory only, without --data-dir or "
      "--journal."};
  app.set_version_flag("--version", std::string("dynmeshd ") + kVersion);
  AddFlags(app, flags);
  return ParseFlags(app, argc, argv);
}

}  // namespace dynmesh::server
