// dynmeshd: the server. Exit codes: 0 drained, 1 failed, 2 bad usage.
#include <signal.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "core/base/process_memory.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/log.h"
#include "server/server.h"
#include "server/sqlite_journal.h"
#include "server/version.h"

namespace {

using dynmesh::server::Server;
using dynmesh::server::ServerConfig;

struct Flags {
  ServerConfig config;
  std::string port_file;
  std::string data_dir;
  std::string log_level = "info";
  double drain_seconds = 20;
  double progress_seconds = 10;
  std::uint64_t history_mebibytes = 64;
};

void AddFlags(CLI::App& app, Flags& f) {
  ServerConfig& c = f.config;
  app.add_option("--listen", c.listen, "host:port; port 0 takes a free one")->capture_default_str();
  app.add_option("--data-dir", f.data_dir,
                 "folder that keeps the meshes; an edit is answered when it is on the disk");
  app.add_option("--compact-bytes", c.compact_bytes,
                 "bytes of a mesh's edits in the folder before a snapshot takes their place")
      ->capture_default_str();
  app.add_option(
         "--metrics", c.metrics,
         "[HOST:]PORT of metrics and health over HTTP: /metrics /healthz /readyz; default: none")
      ->type_name("ADDRESS");
  app.add_option("--port-file", f.port_file, "write the port here when listening");
  app.add_option("--log-level", f.log_level, "debug, info, warning, error, off")
      ->capture_default_str();
  app.add_option("--drain-timeout", f.drain_seconds, "seconds to finish work after SIGTERM")
      ->capture_default_str();
  app.add_option("--progress-interval", f.progress_seconds,
                 "seconds between messages to idle watchers")
      ->capture_default_str();
  app.add_option("--writer-threads", c.writer_threads, "threads that apply edits; 0: by cores")
      ->capture_default_str();
  app.add_option("--reader-threads", c.reader_threads, "threads that serve readers; 0: by cores")
      ->capture_default_str();
  app.add_option("--max-meshes", c.max_meshes, "meshes held")->capture_default_str();
  app.add_option("--max-vertices", c.max_vertices, "vertices of one mesh")->capture_default_str();
  app.add_option("--max-batch-edits", c.max_batch_edits, "edits in one batch")
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
  app.add_option("--history-mib", f.history_mebibytes, "MiB of diffs kept of a mesh")
      ->capture_default_str();
  app.add_option("--watch-queue", c.watch_queue, "revisions a watcher may lag before coalescing")
      ->capture_default_str();
}

int Fail(int code, const absl::Status& status) {
  std::fprintf(stderr, "dynmeshd: %s\n", std::string(status.message()).c_str());
  return code;
}

// Complete or absent: whoever waits for the file may read it when it is there.
bool WritePortFile(const std::string& path, int port) {
  const std::string temporary = path + ".tmp";
  std::ofstream out(temporary);
  out << port << '\n';
  out.close();
  return out.good() && std::rename(temporary.c_str(), path.c_str()) == 0;
}

// Null if nothing is to be kept.
absl::StatusOr<std::unique_ptr<dynmesh::server::Journal>> OpenJournal(const Flags& flags) {
  using dynmesh::server::SqliteJournal;
  if (flags.data_dir.empty()) return nullptr;
  SqliteJournal::Options options;
  options.remembered_requests = flags.config.remembered_requests;
  return SqliteJournal::Open(flags.data_dir, options);
}

int Serve(const Flags& flags, const sigset_t& signals) {
  auto journal = OpenJournal(flags);
  if (!journal.ok()) return Fail(1, journal.status());
  auto server = Server::Start(flags.config, &dynmesh::DynamicMesh::Create, *std::move(journal));
  if (!server.ok()) {
    return Fail(server.status().code() == absl::StatusCode::kInvalidArgument ? 2 : 1,
                server.status());
  }
  std::printf("dynmeshd listening on %s\n", (*server)->address().c_str());
  std::fflush(stdout);
  if (!flags.port_file.empty() && !WritePortFile(flags.port_file, (*server)->port())) {
    return Fail(1, absl::UnknownError("cannot write " + flags.port_file));
  }
  int signal = 0;
  sigwait(&signals, &signal);
  // A second signal does not wait.
  std::thread([signals] {
    int second = 0;
    sigwait(&signals, &second);
    std::_Exit(1);
  }).detach();
  return (*server)->Drain(flags.config.drain_timeout) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  dynmesh::ReturnLargeBlocks();
  // Before any thread is made, so that all inherit the mask and only sigwait sees them.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGINT);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);

  CLI::App app{
      "dynmeshd: serves dynamic meshes over gRPC. Without --data-dir they live in memory only."};
  app.set_version_flag("--version", std::string("dynmeshd ") + dynmesh::server::kVersion);
  Flags flags;
  AddFlags(app, flags);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (absl::Status s = dynmesh::server::SetLogLevel(flags.log_level); !s.ok()) return Fail(2, s);
  flags.config.drain_timeout = absl::Seconds(flags.drain_seconds);
  flags.config.progress_interval = absl::Seconds(flags.progress_seconds);
  flags.config.history_bytes = flags.history_mebibytes << 20;
  return Serve(flags, signals);
}
