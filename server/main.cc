// dynmeshd: the server. Exit codes: 0 drained, or copied a journal; 1 failed, or not all running
// work ended within the drain's limit; 2 bad usage; 3 the disk or the database did not answer at
// the end.
#include <signal.h>

#include <cstdio>
#include <fstream>
#include <string>
#include <thread>

#include "absl/strings/str_split.h"
#include "absl/time/clock.h"
#include "absl/time/time.h"
#include "core/base/mutex.h"
#include "core/base/process_memory.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/access/acceptor.h"
#include "server/base/bus_error.h"
#include "server/base/log.h"
#include "server/copy_journal.h"
#include "server/flags.h"
#include "server/journal/open_postgres.h"
#include "server/journal/sqlite_journal.h"
#include "server/server.h"

namespace {

using dynmesh::CondVar;
using dynmesh::Mutex;
using dynmesh::MutexLock;
using dynmesh::server::Flags;
using dynmesh::server::Server;

int Fail(int code, const absl::Status& status) {
  dynmesh::server::Log(dynmesh::server::LogLevel::kError, "not_started",
                       {{"message", status.message()}});
  return code;
}

// Atomic: the file is complete or absent, so that a process that waits for it can read it.
bool WritePortFile(const std::string& path, int port) {
  const std::string temporary = path + ".tmp";
  std::ofstream out(temporary);
  out << port << '\n';
  out.close();
  return out.good() && std::rename(temporary.c_str(), path.c_str()) == 0;
}

// Handles signals on its own thread. It starts first, since recovery may take long.
class Signals {
 public:
  // To be made before any other thread: all threads inherit the mask, so only sigwait gets the
  // signals.
  Signals() {
    sigemptyset(&signals_);
    for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals_, signal);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
    // Runs until the process ends.
    std::thread([this] { Run(); }).detach();
  }

  // From now on a signal drains `server` instead of ending the process.
  void Serves(Server* server) {
    const MutexLock lock(mutex_);
    server_ = server;
  }
  // The exit code of a signal that comes before it serves; 0 unless it is set.
  void EndsWith(int code) {
    const MutexLock lock(mutex_);
    idle_code_ = code;
  }
  // Blocks until a signal asks the process to end. A second one ends the process at once.
  void WaitForEnd() {
    const MutexLock lock(mutex_);
    ended_.Wait(mutex_, [this]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return ending_; });
    server_ = nullptr;
  }

 private:
  void Run() {
    int signal = 0;
    while (sigwait(&signals_, &signal) == 0) {
      const MutexLock lock(mutex_);
      if (signal == SIGHUP) {
        if (server_ != nullptr) server_->Reload();
      } else if (ending_) {
        std::_Exit(1);
      } else if (server_ == nullptr) {
        std::_Exit(idle_code_);  // no call has been answered yet
      } else {
        ending_ = true;
        ended_.NotifyOne();
      }
    }
  }

  sigset_t signals_;
  Mutex mutex_;
  CondVar ended_;
  Server* server_ ABSL_GUARDED_BY(mutex_) = nullptr;  // while it serves
  bool ending_ ABSL_GUARDED_BY(mutex_) = false;
  int idle_code_ ABSL_GUARDED_BY(mutex_) = 0;
};

// After --drain-timeout, for calls to be cancelled and for the write that the disk or the database
// has. Both together are less than what systemd, Docker and Kubernetes wait here (deploy/).
constexpr absl::Duration kEndGrace = absl::Seconds(8);

// The process ends after this time at the latest: a disk may never answer. That is as good as a
// crash, which loses nothing that was acknowledged.
void EndWithin(absl::Duration limit) {
  std::thread([limit] {
    absl::SleepFor(limit);
    dynmesh::server::Log(
        dynmesh::server::LogLevel::kError, "not_drained",
        {{"after", absl::FormatDuration(limit)},
         {"message",
          "running work has not ended, as when the disk or the database does not answer: the "
          "process ends without it. Nothing that was acknowledged is lost; what was not may be "
          "there or not after the next start"}});
    std::_Exit(3);
  }).detach();
}

// Null without a data folder and without a database.
absl::StatusOr<std::unique_ptr<dynmesh::server::Journal>> OpenJournal(const Flags& flags) {
  if (!flags.journal.empty()) {
    dynmesh::server::PostgresOptions options;
    options.remembered_requests = flags.config.remembered_requests;
    options.history_bytes = flags.config.journal_history_bytes;
    if (!flags.config.node_address.empty()) options.lease = flags.config.lease;
    return dynmesh::server::OpenPostgresJournal(flags.journal, options);
  }
  using dynmesh::server::SqliteJournal;
  if (flags.data_dir.empty()) return nullptr;
  SqliteJournal::Options options;
  options.remembered_requests = flags.config.remembered_requests;
  options.history_bytes = flags.config.journal_history_bytes;
  options.accept_loss = absl::StrSplit(flags.accept_loss, ',', absl::SkipWhitespace());
  return SqliteJournal::Open(flags.data_dir, options);
}

absl::Status CheckOneJournal(const Flags& flags) {
  if (flags.journal.empty() && !flags.config.node_address.empty()) {
    return absl::InvalidArgumentError(
        "node-address: servers share the meshes of a database: give --journal postgresql://...");
  }
  if (flags.journal.empty() || (flags.data_dir.empty() && flags.accept_loss.empty())) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      "journal: the meshes are in a database or in a folder: give --journal, or --data-dir and "
      "--accept-loss");
}

int Serve(const Flags& flags, Signals& signals) {
  // Before any file is made in the folder.
  if (absl::Status s = dynmesh::server::ValidateConfig(flags.config); !s.ok()) return Fail(2, s);
  if (absl::Status s = CheckOneJournal(flags); !s.ok()) return Fail(2, s);
  auto journal = OpenJournal(flags);
  if (!journal.ok()) {
    return Fail(absl::IsInvalidArgument(journal.status()) ? 2 : 1, journal.status());
  }
  auto server = Server::Start(flags.config, &dynmesh::DynamicMesh::Create, *std::move(journal),
                              &dynmesh::BuildMesh, dynmesh::server::WebPage());
  if (!server.ok()) {
    return Fail(server.status().code() == absl::StatusCode::kInvalidArgument ? 2 : 1,
                server.status());
  }
  signals.Serves(server->get());
  std::printf("dynmeshd listening on %s\n", (*server)->address().c_str());
  if (const std::string http = (*server)->http_address(); !http.empty()) {
    std::printf("over HTTP, with a page for browsers: http://%s/\n", http.c_str());
  }
  std::fflush(stdout);
  if (!flags.port_file.empty() && !WritePortFile(flags.port_file, (*server)->port())) {
    return Fail(1, absl::UnknownError("cannot write " + flags.port_file));
  }
  signals.WaitForEnd();
  EndWithin(flags.config.drain_timeout + kEndGrace);
  return (*server)->Drain(flags.config.drain_timeout) ? 0 : 1;
}

int Copy(const Flags& flags, Signals& signals) {
  signals.EndsWith(1);
  const auto counts = dynmesh::server::CopyJournal(flags);
  if (!counts.ok()) {
    dynmesh::server::Log(dynmesh::server::LogLevel::kError, "not_copied",
                         {{"message", counts.status().message()}});
    return absl::IsInvalidArgument(counts.status()) ? 2 : 1;
  }
  std::printf("copied %llu meshes, %llu were there already: %llu revisions, %llu bytes\n",
              static_cast<unsigned long long>(counts->copied),
              static_cast<unsigned long long>(counts->there),
              static_cast<unsigned long long>(counts->revisions),
              static_cast<unsigned long long>(counts->bytes));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  dynmesh::SetUpMemory(dynmesh::MemoryUse::kServer);
  dynmesh::server::RaiseDescriptorLimit();
  dynmesh::server::TellBusErrors();
  static Signals signals;
  Flags flags;
  if (const auto code = dynmesh::server::ReadFlags(argc, argv, flags)) return *code;
  if (absl::Status s = dynmesh::server::SetLogLevel(flags.log_level); !s.ok()) return Fail(2, s);
  if (!flags.copy_journal.empty() || !flags.copy_meshes.empty()) return Copy(flags, signals);
  return Serve(flags, signals);
}
