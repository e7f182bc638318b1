// Counters and their text; figures of meshes, of recovery, of the process. No network.
#include "server/metrics/metrics.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <set>
#include <thread>
#include <vector>

#include "dynmesh/version.h"
#include "server/base/call_id.h"
#include "server/base/log.h"
#include "server/collect.h"
#include "server/meshes/recovery_progress.h"
#include "server/metrics/server_metrics.h"
#include "tests/server/journal/durable_registry.h"
#include "tests/server/metrics/metrics_parser.h"
#include "tests/server/test_support.h"
#include "tests/support/temp_folder.h"

namespace dynmesh::server::metrics_test {
namespace {

TEST(MetricsParser, RefusesWhatIsNotTheFormat) {
  const std::string head = "# HELP a_total x\n# TYPE a_total counter\n";
  const std::string histogram = "# HELP h x\n# TYPE h histogram\n";
  EXPECT_EQ(ParsedMetrics(head + "a_total 1\n").error(), "");
  EXPECT_EQ(ParsedMetrics(head + "a_total{b=\"c\\\\\\\"\\n,}\",d=\"\"} 1e-05\n").error(), "");
  EXPECT_EQ(ParsedMetrics(histogram + "h_bucket{le=\"1\"} 1\nh_bucket{le=\"+Inf\"} 2\n"
                                      "h_sum 3\nh_count 2\n")
                .error(),
            "");
  for (const std::string& bad :
       {std::string("a 1\n"),
        head + "a_total 1",
        head + "b_total 1\n",
        head + "a_total  1\n",
        head + "a_total 1\na_total 2\n",
        head + head,
        head + "a_total -1\n",
        head + "a_total\n",
        head + "a_total{b=c} 1\n",
        head + "a_total{b=\"c} 1\n",
        head + "a_total{b=\"c\"}\n",
        head + "a_total{b=\"\\c\"} 1\n",
        head + "a_total{b=\"c\"d=\"e\"} 1\n",
        head + "a_total{b=\"1\",b=\"2\"} 1\n",
        head + "a_total{1b=\"1\"} 1\n",
        head + "a_total 1x\n",
        head + "\n",
        std::string("# TYPE a gauge\na 1\n"),
        std::string("# HELP a x\n# TYPE a counter\n"),
        std::string("# HELP a x\n"),
        histogram + "h_bucket{le=\"1\"} 1\nh_sum 3\nh_count 1\n",
        histogram + "h_bucket{le=\"1\"} 3\nh_bucket{le=\"+Inf\"} 2\nh_sum 3\nh_count 2\n",
        histogram + "h_bucket{le=\"+Inf\"} 2\nh_sum 3\nh_count 3\n",
        histogram + "h_bucket{le=\"+Inf\"} 2\nh_count 2\n",
        histogram + "h_sum 2\nh_count 2\n"}) {
    EXPECT_NE(ParsedMetrics(bad).error(), "") << bad;
  }
}

TEST(Metrics, TheTextIsTheFormatAndTellsWhatWasCounted) {
  MetricRegistry registry;
  registry.AddCounters("calls_total", "Calls.").With().Add(7);
  auto& gauges = registry.AddGauges("level", "A level with \\ and\nsecond line.");
  gauges.With({{"place", "here"}}).Set(-2.5);
  gauges.With({{"place", "there"}}).Add(0.1);
  registry.AddSource([](MetricsText& out) { out.Single("now", "gauge", "Looked up.", 1e300); });
  const ParsedMetrics parsed(registry.Text());
  EXPECT_EQ(parsed.error(), "");
  EXPECT_EQ(parsed.Value("calls_total"), 7);
  EXPECT_EQ(parsed.Value("level", {{"place", "here"}}), -2.5);
  EXPECT_EQ(parsed.Value("level", {{"place", "there"}}), 0.1);
  EXPECT_EQ(parsed.Value("now"), 1e300);
  EXPECT_EQ(parsed.size(), 4u);
}

TEST(Metrics, MembersWithTheSameLabelsAreOne) {
  MetricRegistry registry;
  auto& family = registry.AddCounters("calls_total", "Calls.");
  EXPECT_EQ(&family.With({{"a", "1"}}), &family.With({{"a", "1"}}));
  EXPECT_NE(&family.With({{"a", "1"}}), &family.With({{"a", "2"}}));
}

TEST(Metrics, LabelsMayHoldAnything) {
  MetricRegistry registry;
  auto& family = registry.AddCounters("calls_total", "Calls.");
  const std::vector<std::string> nasty = {
      "", "\\", "\"", "\n", "a\\nb", "a\\\nb", "\"} 5", "x\"} 1\ny ", "\\\"\\\\", ",=", "\xc3\xa9"};
  for (std::size_t i = 0; i < nasty.size(); ++i) family.With({{"mesh", nasty[i]}}).Add(i + 1);
  const ParsedMetrics parsed(registry.Text());
  EXPECT_EQ(parsed.error(), "");
  EXPECT_EQ(parsed.size(), nasty.size());
  for (std::size_t i = 0; i < nasty.size(); ++i) {
    EXPECT_EQ(parsed.Value("calls_total", {{"mesh", nasty[i]}}), static_cast<double>(i + 1));
  }
}

TEST(Metrics, AHistogramPutsABoundIntoItsOwnBucket) {
  MetricRegistry registry;
  Histogram& h = registry.AddHistograms("h", "A histogram.", {0.1, 1, 10}).With({{"a", "b"}});
  for (const double value : {0.0, 0.1, 0.5, 1.0, 5.0, 10.0, 11.0, 1e9}) h.Observe(value);
  const ParsedMetrics parsed(registry.Text());
  EXPECT_EQ(parsed.error(), "");
  EXPECT_EQ(parsed.Value("h_bucket", {{"a", "b"}, {"le", "0.1"}}), 2);
  EXPECT_EQ(parsed.Value("h_bucket", {{"a", "b"}, {"le", "1"}}), 4);
  EXPECT_EQ(parsed.Value("h_bucket", {{"a", "b"}, {"le", "10"}}), 6);
  EXPECT_EQ(parsed.Value("h_bucket", {{"a", "b"}, {"le", "+Inf"}}), 8);
  EXPECT_EQ(parsed.Value("h_count", {{"a", "b"}}), 8);
  EXPECT_EQ(parsed.Value("h_sum", {{"a", "b"}}), 0.0 + 0.1 + 0.5 + 1 + 5 + 10 + 11 + 1e9);
}

// A load takes minutes, a watch hours: what is above the last bound cannot be told apart.
TEST(Metrics, TimesOfLoadsAndWatchesAreWithinTheBounds) {
  ServerMetrics metrics;
  WorkCounters load;
  load.microseconds = 90e6;
  metrics.edits.ObserveWork(load, EditSource::kLoad);
  const ParsedMetrics now(metrics.registry.Text());
  EXPECT_EQ(now.error(), "");
  const auto below = [&](const char* bound) {
    return now.Value("dynmesh_edit_seconds_bucket",
                     {{"stage", "propagate"}, {"kind", "load"}, {"le", bound}});
  };
  EXPECT_EQ(below("50"), 0);
  EXPECT_EQ(below("100"), 1);
  EXPECT_EQ(below("10000"), 1);
  const std::vector<double> bounds = SecondsBounds(1e5);
  EXPECT_TRUE(std::is_sorted(bounds.begin(), bounds.end()));
  EXPECT_EQ(bounds.back(), 1e5);
  EXPECT_EQ(SecondsBounds(10).back(), 10);
}

TEST(Metrics, NothingIsLostAndEveryTextIsSoundWhileOthersCount) {
  constexpr int kThreads = 4, kEach = 20'000;
  MetricRegistry registry;
  auto& counters = registry.AddCounters("calls_total", "Calls.");
  auto& histograms = registry.AddHistograms("h", "A histogram.", {0.25, 0.5});
  std::atomic<int> left{kThreads};
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t) {
    threads.emplace_back([&, t] {
      Histogram& histogram = histograms.With({{"which", t % 2 == 0 ? "even" : "odd"}});
      for (int i = 0; i < kEach; ++i) {
        counters.With({{"which", t % 2 == 0 ? "even" : "odd"}}).Add();
        histogram.Observe(0.25 * (i % 4));
      }
      --left;
    });
  }
  double before = 0;
  while (left > 0) {
    const ParsedMetrics parsed(registry.Text());
    ASSERT_EQ(parsed.error(), "");
    const double now = parsed.Value("calls_total", {{"which", "even"}});
    if (std::isnan(now)) continue;
    EXPECT_GE(now, before);
    before = now;
  }
  for (std::thread& thread : threads) thread.join();
  const ParsedMetrics parsed(registry.Text());
  for (const char* which : {"even", "odd"}) {
    EXPECT_EQ(parsed.Value("calls_total", {{"which", which}}), kThreads / 2 * kEach);
    EXPECT_EQ(parsed.Value("h_bucket", {{"which", which}, {"le", "0.25"}}),
              kThreads / 2 * kEach / 2);
    EXPECT_EQ(parsed.Value("h_sum", {{"which", which}}), kThreads / 2 * kEach * 0.375);
  }
}

TEST(CallId, TheClientsIsTakenIfItIsShortAndPrintable) {
  EXPECT_EQ(ChooseCallId("a-1/b=\"c\""), "a-1/b=\"c\"");
  EXPECT_EQ(ChooseCallId(std::string(64, 'x')), std::string(64, 'x'));
  std::set<std::string> fresh;
  for (const std::string& bad :
       {std::string(), std::string(65, 'x'), std::string("a b"), std::string("a\nb"),
        std::string("\xc3\xa9"), std::string("\x7f"), std::string(1, '\0')}) {
    const std::string id = ChooseCallId(bad);
    EXPECT_EQ(id.size(), 16u);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos);
    fresh.insert(id);
  }
  EXPECT_EQ(fresh.size(), 7u);
}

// A registry of fake meshes that counts.
class CollectTest : public ::testing::Test {
 protected:
  CollectTest() {
    EXPECT_TRUE(SetLogLevel("off").ok());
    metrics_.registry.AddSource([this](MetricsText& out) {
      WriteMeshes(meshes_, out);
      WriteLimits(memory_, TlsFiles(), out);
      WriteProcess(out);
    });
  }
  ParsedMetrics Scrape() { return ParsedMetrics(metrics_.registry.Text()); }
  absl::StatusOr<EditOutcome> Apply(EditJob job) {
    Mailbox<absl::StatusOr<EditOutcome>> box;
    job.done = [&box](auto outcome) { box.Put(std::move(outcome)); };
    if (auto s = (*meshes_.Find("meshes/m"))->Apply(std::move(job)); !s.ok()) return s;
    return box.Take();
  }
  static EditJob Job(EditBatch edits, std::string request_id = "") {
    EditJob job;
    job.edits = std::move(edits);
    job.request_id = std::move(request_id);
    return job;
  }

  ServerMetrics metrics_;
  const MemoryGuard memory_{std::uint64_t{1} << 40};
  WorkerPool writers_{2};
  WorkerPool readers_{2};
  MeshRegistry meshes_{
      ServerConfig(), [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); },
      &writers_,      &readers_,
      nullptr,        &metrics_};
};

TEST_F(CollectTest, AMeshIsThereWithItsFiguresUntilItIsDeleted) {
  EXPECT_FALSE(std::isnan(Scrape().Value("dynmesh_meshes")));
  ASSERT_TRUE(meshes_.Create("m", MeshOptions(), "").ok());
  ASSERT_TRUE(meshes_.Create("n", MeshOptions(), "").ok());
  ASSERT_TRUE(Apply(Job({AddPoint(1), AddPoint(2), AddPoint(3)})).ok());
  ASSERT_TRUE(Apply(Job({AddPoint(4)})).ok());
  ParsedMetrics now = Scrape();
  EXPECT_EQ(now.error(), "");
  EXPECT_EQ(now.Value("dynmesh_meshes"), 2);
  const MeshStats stats = (*meshes_.Find("meshes/m"))->stats();
  EXPECT_EQ(now.Value("dynmesh_mesh_revision", {{"mesh", "m"}}), 2);
  EXPECT_EQ(now.Value("dynmesh_mesh_features", {{"mesh", "m"}}), 4);
  EXPECT_EQ(now.Value("dynmesh_mesh_vertices", {{"mesh", "m"}}), stats.vertices);
  EXPECT_EQ(now.Value("dynmesh_mesh_simplices", {{"mesh", "m"}}), stats.simplices);
  EXPECT_EQ(now.Value("dynmesh_mesh_trace_bytes", {{"mesh", "m"}}), stats.trace_bytes);
  EXPECT_EQ(now.Value("dynmesh_mesh_bytes", {{"mesh", "m"}}), stats.mesh_bytes);
  for (const char* name :
       {"dynmesh_mesh_watchers", "dynmesh_mesh_watchers_behind",
        "dynmesh_mesh_watch_coalesced_total", "dynmesh_mesh_watch_resynced_total"}) {
    EXPECT_EQ(now.Value(name, {{"mesh", "m"}}), 0) << name;
  }
  EXPECT_EQ(now.Value("dynmesh_mesh_waiting_edits", {{"mesh", "m"}}), 0);
  EXPECT_EQ(now.Value("dynmesh_mesh_revision", {{"mesh", "n"}}), 0);

  ASSERT_TRUE(meshes_.Delete("meshes/m").ok());
  now = Scrape();
  EXPECT_EQ(now.error(), "");
  EXPECT_TRUE(std::isnan(now.Value("dynmesh_mesh_revision", {{"mesh", "m"}})));
  EXPECT_EQ(now.Value("dynmesh_mesh_revision", {{"mesh", "n"}}), 0);
}

TEST_F(CollectTest, BatchesAreCountedByTheirResult) {
  ASSERT_TRUE(meshes_.Create("m", MeshOptions(), "").ok());
  for (FeatureId id = 1; id <= 5; ++id) ASSERT_TRUE(Apply(Job({AddPoint(id)})).ok());
  ASSERT_TRUE(Apply(Job({AddPoint(6), AddPoint(7)}, "r")).ok());
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(Apply(Job({AddPoint(6), AddPoint(7)}, "r"))->replayed);
  EditJob check = Job({AddPoint(8)});
  check.validate_only = true;
  ASSERT_TRUE(Apply(check).ok());
  ASSERT_FALSE(Apply(Job({AddPoint(1)})).ok());  // it is there
  EditJob cancelled = Job({AddPoint(9)});
  cancelled.cancelled = std::make_shared<std::atomic<bool>>(true);
  ASSERT_FALSE(Apply(cancelled).ok());
  EditJob failed = Job({AddPoint(9)});
  failed.refused = absl::InternalError("broken");
  ASSERT_FALSE(Apply(failed).ok());

  const ParsedMetrics now = Scrape();
  const auto edits = [&](const char* result) {
    return now.Value("dynmesh_edits_total", {{"result", result}});
  };
  EXPECT_EQ(edits("applied"), 6);
  EXPECT_EQ(edits("replayed"), 2);
  EXPECT_EQ(edits("validated"), 1);
  EXPECT_EQ(edits("refused"), 1);
  EXPECT_EQ(edits("cancelled"), 1);
  EXPECT_EQ(edits("failed"), 1);
  EXPECT_EQ(now.Value("dynmesh_operations_executed_total"), 7);  // a fake runs one an edit
  for (const char* stage : {"validate", "propagate", "diff"}) {
    EXPECT_EQ(now.Value("dynmesh_edit_seconds_count", {{"stage", stage}, {"kind", "edit"}}), 6)
        << stage;
  }
  EXPECT_EQ(now.Value("dynmesh_edit_seconds_count", {{"stage", "journal"}, {"kind", "edit"}}), 0);
}

TEST_F(CollectTest, ScrapesGoOnWhileMeshesAreEditedMadeAndDeleted) {
  ASSERT_TRUE(meshes_.Create("m", MeshOptions(), "").ok());
  std::atomic<bool> done{false};
  std::thread scraper([&] {
    while (!done) {
      const ParsedMetrics now = Scrape();
      ASSERT_EQ(now.error(), "");
      ASSERT_GE(now.Value("dynmesh_mesh_revision", {{"mesh", "m"}}), 0);
    }
  });
  for (FeatureId id = 1; id <= 100; ++id) {
    ASSERT_TRUE(Apply(Job({AddPoint(id)})).ok());
    ASSERT_TRUE(meshes_.Create("n", MeshOptions(), "").ok());
    ASSERT_TRUE(meshes_.Delete("meshes/n").ok());
  }
  done = true;
  scraper.join();
  EXPECT_EQ(Scrape().Value("dynmesh_mesh_revision", {{"mesh", "m"}}), 100);
}

TEST_F(CollectTest, TheProcessIsDescribed) {
  const ParsedMetrics now = Scrape();
  EXPECT_GT(now.Value("process_resident_memory_bytes"), 1e6);
  EXPECT_LT(now.Value("process_resident_memory_bytes"), 1e12);
  EXPECT_EQ(now.Value("dynmesh_memory_limit_bytes"), 1024.0 * 1024 * 1024 * 1024);
  EXPECT_TRUE(std::isnan(now.Value("dynmesh_certificate_end_time_seconds"))) << "without TLS";
  EXPECT_GE(now.Value("process_cpu_seconds_total"), 0);
  const double age = absl::ToDoubleSeconds(absl::Now() - absl::UnixEpoch()) -
                     now.Value("process_start_time_seconds");
  EXPECT_GT(age, -2);
  EXPECT_LT(age, 3600);
  EXPECT_EQ(now.Value("dynmesh_build_info", {{"version", kVersion}}), 1);
  // One more file is open: one more.
  const double before = Scrape().Value("process_open_fds");
  std::FILE* file = std::fopen("/dev/null", "r");
  EXPECT_EQ(Scrape().Value("process_open_fds"), before + 1);
  std::fclose(file);
}

TEST(RecoveryMetricsTest, EntriesAreCountedAsTheyAreApplied) {
  EXPECT_TRUE(SetLogLevel("off").ok());
  test::TempFolder folder;
  ServerConfig config;
  {
    DurableRegistry server(folder.path(), config);
    ASSERT_TRUE(server.status().ok()) << server.status();
    const Journal::Counts before = server.journal().counts();
    ASSERT_TRUE(server->Create("m", MeshOptions(), "").ok());
    ASSERT_TRUE(server->Create("n", MeshOptions(), "").ok());
    for (FeatureId id = 1; id <= 3; ++id) ASSERT_TRUE(server.Apply({AddPoint(id)}).ok());
    ASSERT_TRUE(server.Apply({AddPoint(1)}, "", "n").ok());
    const Journal::Counts after = server.journal().counts();
    EXPECT_EQ(after.syncs - before.syncs, 6u);
    EXPECT_EQ(after.failures, 0u);
  }
  auto journal = SqliteJournal::Open(folder.path(), {});
  ASSERT_TRUE(journal.ok());
  ServerMetrics metrics;
  WorkerPool writers(2), readers(2);
  MeshRegistry meshes(
      config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); }, &writers,
      &readers, journal->get(), &metrics);
  ASSERT_TRUE(meshes.Recover().ok());
  const ParsedMetrics now(metrics.registry.Text());
  EXPECT_EQ(now.Value("dynmesh_recovery_entries"), 4);
  EXPECT_EQ(now.Value("dynmesh_recovery_entries_done"), 4);
  EXPECT_EQ(now.Value("dynmesh_recovery_entries_done_total"), 4);
  EXPECT_EQ(now.Value("dynmesh_recovery_meshes_damaged"), 0);
  EXPECT_GT(now.Value("dynmesh_recovery_seconds"), 0);
  // Edits made again are no edits of clients.
  EXPECT_EQ(now.Value("dynmesh_edits_total", {{"result", "applied"}}), 0);
}

TEST(RecoveryMetricsTest, ASnapshotIsOneEntry) {
  EXPECT_TRUE(SetLogLevel("off").ok());
  test::TempFolder folder;
  ServerConfig config;
  config.compact_bytes = 1;
  {
    DurableRegistry server(folder.path(), config);
    ASSERT_TRUE(server->Create("m", MeshOptions(), "").ok());
    for (FeatureId id = 1; id <= 20; ++id) ASSERT_TRUE(server.Apply({AddPoint(id)}).ok());
  }
  auto journal = SqliteJournal::Open(folder.path(), {});
  ASSERT_TRUE(journal.ok());
  const auto found = (*journal)->List();
  ASSERT_TRUE(found.ok());
  ASSERT_EQ(found->size(), 1u);
  EXPECT_LT((*found)[0].entries, 20u);
  ServerMetrics metrics;
  WorkerPool writers(2), readers(2);
  MeshRegistry meshes(
      config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); }, &writers,
      &readers, journal->get(), &metrics);
  ASSERT_TRUE(meshes.Recover().ok());
  EXPECT_EQ(metrics.recovery.entries.value(), static_cast<double>((*found)[0].entries));
  EXPECT_EQ(metrics.recovery.entries_done.value(), metrics.recovery.entries.value());
}

TEST(SnapshotMetricsTest, EachPartOfASnapshotIsCounted) {
  EXPECT_TRUE(SetLogLevel("off").ok());
  test::TempFolder folder;
  auto journal = SqliteJournal::Open(folder.path(), {});
  ASSERT_TRUE(journal.ok());
  ServerConfig config;
  config.compact_bytes = 1;
  ServerMetrics metrics;
  WorkerPool writers(2), readers(2);
  MeshRegistry meshes(
      config, [](const MeshOptions& o, const ApplyOptions&) { return MakeFake(o); }, &writers,
      &readers, journal->get(), &metrics);
  const auto host = meshes.Create("m", MeshOptions(), "");
  ASSERT_TRUE(host.ok()) << host.status();
  const auto count = [&](absl::string_view part) {
    return ParsedMetrics(metrics.registry.Text())
        .Value("dynmesh_snapshot_seconds_count", {{"part", std::string(part)}});
  };
  EXPECT_EQ(count("write"), 0);
  for (const EditBatch& batch : {EditBatch{AddPoint(1)}, ManyPoints(2, 5)}) {
    Mailbox<absl::Status> done;
    EditJob job;
    job.edits = batch;
    job.done = [&](const auto& outcome) { done.Put(outcome.status()); };
    ASSERT_TRUE((*host)->Apply(std::move(job)).ok());
    ASSERT_TRUE(done.Take().ok());
  }
  test::WaitUntil("a snapshot", [&] { return count("take") == 1; });
  meshes.WaitForSnapshots();
  EXPECT_EQ(count("take"), 1);
  EXPECT_EQ(count("encode"), 1);
  EXPECT_EQ(count("write"), 1);
}

TEST(RecoveryMetricsTest, LongRecoveriesTellHowFarTheyAre) {
  ASSERT_TRUE(SetLogLevel("info").ok());
  testing::internal::CaptureStderr();
  RecoveryProgress progress({{1, "m", "", 10, {}, {}}, {2, "n", "", 5, {}, {}}}, nullptr);
  std::thread worker([&] {
    for (int i = 0; i < 7; ++i) progress.Apply();
    absl::SleepFor(absl::Milliseconds(100));
    progress.EndMesh();
    progress.EndMesh();
  });
  progress.Wait(absl::Milliseconds(20));
  worker.join();
  const std::string log = testing::internal::GetCapturedStderr();
  EXPECT_NE(log.find("event=recovering entries_done=7 entries=15 meshes_done=0 meshes=2"),
            std::string::npos)
      << log;
}

}  // namespace
}  // namespace dynmesh::server::metrics_test
