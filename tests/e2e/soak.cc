// A long run of everything at once: a dynmeshd with a journal, over TLS, four meshes, two writers
// on each, a hundred watchers, some slow and some reconnecting. A tool; a test runs it for some
// seconds.
//   dynmesh_soak [--seconds 3600] [--rate 5] [--vertices 100000] ...      see --help
// One line of JSON a minute, and one in the end. Exit code 1 if a revision was lost or came twice,
// a hash differs, a watcher does not reach the end, an edit got an unexpected answer, the server
// does not recover its meshes after a restart, or its memory grew.
#include <CLI/CLI.hpp>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "absl/strings/str_cat.h"
#include "client/cli/json.h"
#include "client/cli/percentile.h"
#include "dynmesh/client/mesh_client.h"
#include "tests/e2e/daemon.h"
#include "tests/e2e/soak/audience_process.h"
#include "tests/e2e/soak/figures.h"
#include "tests/e2e/soak/ledger.h"
#include "tests/e2e/soak/writer.h"
#include "tests/support/certificates.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::soak {
namespace {

using cli::JsonObject;
using cli::Percentile;

// A mesh with what is known of it.
struct Site {
  MeshPlan plan;
  Ledger ledger;
  MeshHead head;  // at the end, as the server has it
};

constexpr int kWritersPerMesh = 2;

volatile std::sig_atomic_t interrupted = 0;

struct Settings {
  double seconds = 3600, report_seconds = 60, close_seconds = 120, restart_seconds = 600;
  double rate = 5;
  std::uint64_t vertices = 100'000;
  Audience::Plan audience;
  bool idle_watchers = false;
  double growth_part = 0.05, growth_megabytes = 20;
  std::uint64_t history = 1'000;
  std::uint64_t seed = 1;
  std::string folder;
  std::vector<std::string> server_flags;
};

void AddFlags(CLI::App& app, Settings& s) {
  const auto add = [&](const char* name, auto& value, const char* help) {
    app.add_option(name, value, help)->capture_default_str();
  };
  add("--seconds", s.seconds, "how long the writers write");
  add("--report-seconds", s.report_seconds, "between two lines");
  add("--close-seconds", s.close_seconds, "for watchers to get to the end");
  add("--restart-seconds", s.restart_seconds, "for the server to make its meshes again");
  add("--rate", s.rate, "batches a second of each writer");
  add("--vertices", s.vertices,
      "of the first mesh; the others have a fifth, a tenth (space), a 20th");
  add("--watchers", s.audience.watchers, "of all meshes together");
  add("--slow", s.audience.slow, "of these, which pause between events");
  add("--restless", s.audience.restless, "of these, which disconnect and return");
  add("--sessions", s.audience.sessions, "of these, with a mesh of their own in a WatchSession");
  add("--nap-seconds", s.audience.nap_seconds, "mean pause of the slow and the restless");
  app.add_flag("--idle-watchers", s.idle_watchers,
               "they take no core that server or writers want; on a busy machine they starve");
  add("--growth-part", s.growth_part, "growth of memory that is borne, as a part of it");
  add("--growth-megabytes", s.growth_megabytes, "and in MB, added to that");
  add("--history", s.history, "revisions that the server keeps of each mesh");
  add("--seed", s.seed, "of all that is random");
  add("--folder", s.folder, "for data, log and the disk's probe; default: one in the temp folder");
  app.add_option("--server-flag", s.server_flags,
                 "for dynmeshd, e.g. --server-flag=--log-level=debug");
}

class Soak {
 public:
  explicit Soak(Settings settings)
      : settings_(std::move(settings)),
        audience_(settings_.audience, settings_.idle_watchers ? AudienceProcess::Share::kRest
                                                              : AudienceProcess::Share::kTenth) {
    if (settings_.folder.empty()) {
      temp_.emplace();
      settings_.folder = temp_->path();
    }
    std::filesystem::create_directories(settings_.folder);
    daemon_ = std::make_unique<test::Daemon>(settings_.folder);
    certificates_.MakeAuthority("ca");
    certificates_.Make("server", "ca");
  }

  int Run() {
    if (!Begin()) return Fail("dynmeshd or its meshes did not start:\n" + daemon_->Log());
    std::vector<std::string> meshes;
    for (const Site& site : sites_) meshes.push_back(site.plan.name);
    audience_.Start(daemon_->address(), certificates_.Certificate("ca"), meshes);
    StartWriters();
    std::thread disk_probe([this] { ProbeDisk(settings_.folder + "/probe", 2, stop_, disk_); });
    std::thread call_probe([this, client = Connect()] { ProbeCalls(*client, 0.2, stop_, calls_); });
    Watch();
    stop_.Notify();
    for (std::thread& thread : writer_threads_) thread.join();
    disk_probe.join();
    call_probe.join();
    ReadHeads();
    std::vector<MeshHead> heads;
    for (const Site& site : sites_) heads.push_back(site.head);
    watched_ = audience_.Close(heads, settings_.close_seconds);
    const double megabytes = ResidentMegabytes(daemon_->process());
    Restart();
    return Summarise(megabytes) ? 0 : 1;
  }

 private:
  using Clock = std::chrono::steady_clock;

  static int Fail(const std::string& why) {
    std::fprintf(stderr, "dynmesh_soak: %s\n", why.c_str());
    return 1;
  }
  double Elapsed() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }

  std::vector<std::string> ServerFlags() const {
    // Past revisions are kept for minutes, not hours, so that what is kept of them fills in the
    // warm-up.
    std::vector<std::string> flags = {"--data-dir",          settings_.folder + "/data",
                                      "--tls-cert",          certificates_.Path("server.pem"),
                                      "--tls-key",           certificates_.Path("server.key"),
                                      "--history-revisions", absl::StrCat(settings_.history)};
    flags.insert(flags.end(), settings_.server_flags.begin(), settings_.server_flags.end());
    return flags;
  }

  std::unique_ptr<client::MeshClient> Connect() const {
    client::ClientOptions options;
    options.own_connection = true;
    options.tls_ca = certificates_.Certificate("ca");
    return client::MeshClient::Connect(daemon_->address(), options);
  }

  bool Begin() {
    if (!daemon_->Start(ServerFlags())) return false;
    control_ = Connect();
    const std::uint64_t v = settings_.vertices;
    const MeshPlan plans[] = {{"large", 2, v, false},
                              {"middle", 2, v / 5, true},
                              {"space", 3, v / 10, true},
                              {"small", 2, v / 20, true}};
    for (const MeshPlan& plan : plans) {
      Site& site = sites_.emplace_back();
      site.plan = plan;
      MeshOptions options;
      options.dimension = plan.dimension;
      options.quality = DefaultQuality(plan.dimension);
      // In 3D the bare box has some hundreds.
      options.limits.max_vertices = plan.vertices * 13 / 10 + 4'000;
      if (const auto made = control_->CreateMesh(plan.name, options); !made.ok()) {
        return Fail(made.status().ToString()) == 0;
      }
      const absl::Status loaded =
          LoadMesh(plan, *control_, settings_.seed + sites_.size(), site.ledger);
      if (!loaded.ok()) return Fail(loaded.ToString()) == 0;
    }
    start_ = Clock::now();
    return true;
  }

  void StartWriters() {
    for (Site& site : sites_) {
      for (int i = 0; i < kWritersPerMesh; ++i) {
        Writer::Config config;
        config.plan = site.plan;
        config.index = i;
        config.writers = kWritersPerMesh;
        config.rate = settings_.rate;
        config.seed = settings_.seed + 100 + writers_.size();
        clients_.push_back(Connect());
        writers_.push_back(
            std::make_unique<Writer>(config, clients_.back().get(), &site.ledger, &faults_));
        writer_threads_.emplace_back([this, w = writers_.back().get()] { w->Run(stop_); });
      }
    }
  }

  // Until the time is over: a look at the memory each second, a line now and then.
  void Watch() {
    double next_report = settings_.report_seconds;
    while (Elapsed() < settings_.seconds && interrupted == 0) {
      std::this_thread::sleep_for(std::chrono::seconds(1));
      memory_.push_back({Elapsed(), ResidentMegabytes(daemon_->process())});
      if (Elapsed() >= next_report) {
        Report();
        next_report += settings_.report_seconds;
      }
    }
  }

  JsonObject MeshReport(Site& site) {
    JsonObject report;
    report.AddText("mesh", site.plan.name);
    report.Add("revision", site.ledger.head());
    if (const auto status = control_->GetStats(site.plan.name); status.ok()) {
      const MeshStats& stats = status->mesh->stats;
      report.Add("features", stats.features);
      report.Add("vertices", stats.vertices);
      report.Add("mesh_mb", static_cast<double>((stats.trace_bytes + stats.mesh_bytes) >> 20));
    }
    report.AddObject("single_ms", Spread(site.ledger.single.TakeRecent()));
    report.AddObject("batch_ms", Spread(site.ledger.batch.TakeRecent()));
    return report;
  }

  JsonObject EditReport() const {
    std::uint64_t edits = 0, refused = 0, cancelled = 0, replayed = 0;
    for (const Site& site : sites_) {
      edits += site.ledger.head();
      refused += site.ledger.refused;
      cancelled += site.ledger.cancelled;
      replayed += site.ledger.replayed;
    }
    JsonObject report;
    report.Add("revisions", edits);
    report.Add("refused", refused);
    report.Add("cancelled", cancelled);
    report.Add("replayed", replayed);
    return report;
  }

  static JsonObject WatchReport(const Audience::Report& watched) {
    JsonObject report;
    report.Add("lag_steady_max", watched.lag_steady_max);
    report.Add("lag_slow_p50", watched.lag_slow_p50);
    report.Add("lag_slow_max", watched.lag_slow_max);
    report.Add("revisions", watched.revisions);
    report.Add("coalesced", watched.coalesced);
    report.Add("resyncs", watched.resyncs);
    report.Add("reconnects", watched.reconnects);
    report.Add("compacted", watched.compacted);
    report.Add("broken", watched.broken);
    return report;
  }

  void Report() {
    std::vector<MeshHead> heads;
    for (const Site& site : sites_) heads.push_back({site.ledger.head()});
    const Audience::Report watched = audience_.ReportOf(heads);
    JsonObject line;
    line.Add("seconds", std::round(Elapsed()));
    line.Add("rss_mb", memory_.empty() ? 0 : std::round(memory_.back().megabytes * 10) / 10);
    line.Add("data_mb", std::round(FolderMegabytes(settings_.folder + "/data") * 10) / 10);
    line.AddObject("edits", EditReport());
    std::vector<JsonObject> meshes;
    for (Site& site : sites_) meshes.push_back(MeshReport(site));
    line.AddObjects("meshes", meshes);
    line.AddObject("disk_sync_ms", Spread(disk_.TakeRecent()));
    line.AddObject("empty_call_ms", Spread(calls_.TakeRecent()));
    line.AddObject("watchers", WatchReport(watched));
    line.Add("faults", faults_.count() + watched.faults);
    std::fputs(line.ToLine().c_str(), stdout);
    std::fflush(stdout);
  }

  // No edit will follow.
  void ReadHeads() {
    for (Site& site : sites_) {
      const auto info = control_->GetMesh(site.plan.name);
      if (!info.ok()) {
        faults_.Add("no mesh at the end: " + info.status().ToString());
        continue;
      }
      site.head = {info->revision, info->hash};
    }
  }

  // Answered edits must be on the disk.
  void Restart() {
    if (const int code = daemon_->End(SIGTERM); code != 0) {
      faults_.Add(absl::StrCat("dynmeshd ended with ", code));
    }
    const auto start = Clock::now();
    const std::chrono::seconds limit(static_cast<int>(settings_.restart_seconds));
    if (!daemon_->Start(ServerFlags(), "127.0.0.1:0", limit)) {
      return faults_.Add("dynmeshd does not start again");
    }
    const auto client = Connect();
    for (const Site& site : sites_) {
      const auto info = client->GetMesh(site.plan.name);
      if (!info.ok()) {
        faults_.Add("not there after a restart: " + info.status().ToString());
      } else if (info->revision != site.head.revision || info->hash != site.head.hash) {
        faults_.Add("another mesh after a restart: " + site.plan.name);
      }
    }
    restart_seconds_ = std::chrono::duration<double>(Clock::now() - start).count();
    daemon_->End(SIGTERM);
  }

  // True if all is well.
  bool Summarise(double megabytes) {
    std::uint64_t lost = watched_.lost, doubled = watched_.doubled;
    for (const Site& site : sites_) {
      lost += site.ledger.Lost(site.head.revision);
      doubled += site.ledger.doubled();
    }
    const Growth growth = JudgeGrowth(memory_);
    const double borne = settings_.growth_part * growth.warm + settings_.growth_megabytes;
    const bool grew = growth.last - growth.warm > borne;
    std::vector<std::string> faults = faults_.words();
    faults.insert(faults.end(), audience_.faults().begin(), audience_.faults().end());
    const std::uint64_t fault_count = faults_.count() + watched_.faults;
    const bool well = lost == 0 && doubled == 0 && watched_.damaged == 0 && fault_count == 0 &&
                      watched_.at_end == watched_.watchers && !grew;
    JsonObject memory;
    memory.Add("warm_mb", growth.warm);
    memory.Add("last_mb", growth.last);
    memory.Add("highest_mb", growth.highest);
    memory.Add("growth_mb", growth.last - growth.warm);
    memory.Add("highest_over_warm_mb", growth.highest - growth.warm);
    memory.Add("mb_per_hour", growth.per_hour);
    memory.Add("borne_mb", borne);
    memory.Add("without_watchers_mb", megabytes);
    JsonObject line;
    line.AddText("summary", well ? "good" : "BAD");
    line.Add("seconds", std::round(Elapsed()));
    line.Add("seed", settings_.seed);
    std::vector<JsonObject> meshes;
    for (const Site& site : sites_) {
      meshes.push_back(JsonObject().AddText("mesh", site.plan.name));
      meshes.back().AddObject("single_ms", Spread(site.ledger.single.All()));
      meshes.back().AddObject("batch_ms", Spread(site.ledger.batch.All()));
    }
    // The guarantees for the large mesh.
    line.Add("large_single_p99_ms", Percentile(sites_.front().ledger.single.All(), 0.99));
    line.AddObjects("meshes", meshes);
    line.AddObject("disk_sync_ms", Spread(disk_.All()));
    line.AddObject("empty_call_ms", Spread(calls_.All()));
    line.AddObject("edits", EditReport());
    line.AddObject("watchers", WatchReport(watched_));
    line.AddObject("memory", memory);
    line.Add("lost", lost);
    line.Add("doubled", doubled);
    line.Add("damaged", watched_.damaged);
    line.Add("watchers_at_end", watched_.at_end);
    line.Add("watchers_all", watched_.watchers);
    line.Add("restart_seconds", restart_seconds_);
    line.Add("faults", fault_count);
    line.AddTexts("first_faults", faults);
    std::fputs(line.ToLine().c_str(), stdout);
    if (fault_count > 0) std::fputs(daemon_->Log().c_str(), stderr);
    // Once more at the end: the summary is a long line, which a report of tests may cut.
    for (const std::string& fault : faults) std::fprintf(stderr, "%s\n", fault.c_str());
    return well;
  }

  Settings settings_;
  AudienceProcess audience_;  // made before all that has threads
  Audience::Report watched_;  // in the end
  std::optional<test::TempFolder> temp_;
  test::Certificates certificates_;
  std::unique_ptr<test::Daemon> daemon_;
  std::unique_ptr<client::MeshClient> control_;
  std::deque<Site> sites_;
  Clock::time_point start_;
  absl::Notification stop_;
  Faults faults_;
  Latencies disk_, calls_;  // the probes
  std::vector<MemorySample> memory_;
  std::vector<std::unique_ptr<client::MeshClient>> clients_;  // of the writers
  std::vector<std::unique_ptr<Writer>> writers_;
  std::vector<std::thread> writer_threads_;
  double restart_seconds_ = 0;
};

}  // namespace
}  // namespace dynmesh::soak

int main(int argc, char** argv) {
  dynmesh::soak::Settings settings;
  CLI::App app("Runs dynmeshd under load for long, and watches what becomes of it");
  dynmesh::soak::AddFlags(app, settings);
  CLI11_PARSE(app, argc, argv);
  settings.audience.seed = settings.seed + 1'000;
  for (const int signal : {SIGINT, SIGTERM}) {
    std::signal(signal, [](int) { dynmesh::soak::interrupted = 1; });
  }
  return dynmesh::soak::Soak(std::move(settings)).Run();
}
