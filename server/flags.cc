#include "server/flags.h"

#include <algorithm>
#include <cstdio>

#include "absl/strings/str_cat.h"
#include "absl/strings/strip.h"

namespace dynmesh::server {
namespace {

// A duration, in seconds.
void AddSeconds(CLI::App& app, const char* name, absl::Duration& target, const char* help) {
  app.add_option_function<double>(
         name, [&target](const double& seconds) { target = absl::Seconds(seconds); }, help)
      ->default_str(absl::StrCat(absl::ToDoubleSeconds(target)));
}

void AddMebibytes(CLI::App& app, const char* name, std::uint64_t& bytes, const char* help) {
  app.add_option_function<std::uint64_t>(
         name, [&bytes](const std::uint64_t& mebibytes) { bytes = mebibytes << 20; }, help)
      ->default_str(absl::StrCat(bytes >> 20));
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
                 "file that says which tokens may do what; read again when it changes");
}

void AddMeshLimits(CLI::App& app, ServerConfig& c) {
  app.add_option("--max-meshes", c.max_meshes, "meshes held")->capture_default_str();
  app.add_option("--max-vertices", c.max_vertices,
                 "vertices of one mesh; 0: as many as half of the memory limit holds")
      ->capture_default_str();
  app.add_option("--max-features", c.max_features, "features of one mesh")->capture_default_str();
  app.add_option("--max-batch-edits", c.max_batch_edits, "edits in one batch")
      ->capture_default_str();
  app.add_option("--max-batch-operations", c.max_batch_operations,
                 "operations that one batch may execute; 0: any number")
      ->capture_default_str();
  app.add_option("--max-pending-edits", c.max_pending_edits, "edits received and not applied")
      ->capture_default_str();
  app.add_option("--max-message-bytes", c.max_message_bytes, "bytes of one request message")
      ->capture_default_str();
  app.add_option("--max-watchers", c.max_watchers, "watches open")->capture_default_str();
  app.add_option("--max-edit-streams", c.max_edit_streams, "edit streams open")
      ->capture_default_str();
  app.add_option("--max-snapshot-streams", c.max_snapshot_streams, "snapshots under way")
      ->capture_default_str();
  app.add_option("--max-waiting-edits", c.max_waiting_edits, "batches that wait for one mesh")
      ->capture_default_str();
  app.add_option("--history-revisions", c.history_revisions, "diffs kept of a mesh")
      ->capture_default_str();
  AddMebibytes(app, "--history-mib", c.history_bytes, "MiB of diffs kept of a mesh");
  app.add_option("--watch-queue", c.watch_queue, "revisions a watcher may lag before coalescing")
      ->capture_default_str();
}

void AddClientLimits(CLI::App& app, ServerConfig& c) {
  app.add_option("--max-requests-per-second", c.max_requests_per_second,
                 "requests and batches of one client; 0: any number")
      ->default_str(absl::StrCat(c.max_requests_per_second));
  app.add_option("--max-memory-bytes", c.max_memory_bytes,
                 "resident bytes above which nothing grows; 0: nine tenths of what there is")
      ->capture_default_str();
  app.add_option("--max-connections", c.max_connections, "connections open")->capture_default_str();
  app.add_option("--max-streams-per-connection", c.max_streams_per_connection,
                 "calls open on one connection")
      ->capture_default_str();
  AddSeconds(app, "--handshake-timeout", c.handshake_timeout, "seconds for a client's first words");
  AddSeconds(app, "--keepalive-interval", c.keepalive_interval,
             "seconds of silence after which a client is asked whether it is there");
  AddSeconds(app, "--keepalive-timeout", c.keepalive_timeout, "seconds for its answer");
  AddSeconds(app, "--idle-timeout", c.idle_timeout,
             "seconds without calls after which a connection is closed");
  AddSeconds(app, "--batch-timeout", c.batch_timeout,
             "seconds that a batch in pieces, or a load, waits for its next piece");
  AddSeconds(app, "--send-timeout", c.send_timeout,
             "seconds until a call is ended whose client takes nothing of it; 0: never");
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
  app.add_option(
         "--compact-bytes", c.compact_bytes,
         "bytes of a mesh's edits in the folder before a snapshot, from which it is made again")
      ->capture_default_str();
  app.add_option(
         "--compact-operations", c.compact_operations,
         "operations that a mesh's edits executed before a snapshot, from which it is made again")
      ->capture_default_str();
  AddMebibytes(app, "--journal-history-mib", c.journal_history_bytes,
               "MiB kept in the folder of a mesh's past before that snapshot; at least back to the "
               "one before it");
  app.add_option(
         "--metrics", c.metrics,
         "[HOST:]PORT of metrics and health over HTTP: /metrics /healthz /readyz; default: none")
      ->type_name("ADDRESS");
  app.add_option("--port-file", f.port_file, "write the port here when it serves");
  app.add_option("--log-level", f.log_level, "debug, info, warning, error, off")
      ->capture_default_str();
  AddSeconds(app, "--drain-timeout", c.drain_timeout, "seconds to finish work after SIGTERM");
  AddSeconds(app, "--progress-interval", c.progress_interval,
             "seconds between messages to idle watchers");
  app.add_option("--writer-threads", c.writer_threads, "threads that apply edits; 0: by cores")
      ->capture_default_str();
  app.add_option("--reader-threads", c.reader_threads, "threads that serve readers; 0: by cores")
      ->capture_default_str();
  AddMeshLimits(app, c);
  AddClientLimits(app, c);
}

std::optional<int> ParseFlags(CLI::App& app, int argc, const char* const* argv) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::ConfigError& error) {
    // CLI11's own words end with the key, and name neither the file nor what is wrong with it.
    constexpr char kExtra[] = "INI was not able to parse ";
    const std::string what = error.what();
    absl::string_view key = what;
    const bool unknown = absl::ConsumePrefix(&key, kExtra);
    // "lab.++" is how it calls the beginning of a section.
    const bool section = absl::ConsumeSuffix(&key, ".++");
    const std::string why = !unknown  ? what
                            : section ? absl::StrCat("there is no section [", key, "]")
                                      : absl::StrCat("there is no option ", key);
    std::fprintf(stderr, "dynmeshd: %s: %s\n", app.get_config_ptr()->as<std::string>().c_str(),
                 why.c_str());
    return 2;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return std::nullopt;
}

}  // namespace dynmesh::server
