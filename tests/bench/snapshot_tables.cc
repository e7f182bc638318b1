// What a mesh's snapshot for the journal costs the edits beside it, as a table on standard output.
//
//   dynmesh_snapshot_tables DIMENSION POINTS [ROUNDS]
//
// A registry with one mesh of labelled points and a journal in SQLite, in a folder of the working
// directory that is removed. In each round the points' labels change until a snapshot is due; then
// points are added and removed, one an edit, until the journal has the snapshot, and for a second
// more. Of these edits: the processor time of the mesh's strand until the answer; what the strand
// does behind the answer to any batch, which the next one waits for; and the wall time until the
// strand is free again. The server has one writing thread, so the strand's time is that thread's.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <future>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "dynmesh/dynamic_mesh.h"
#include "server/base/log.h"
#include "server/journal/sqlite_journal.h"
#include "server/meshes/mesh_registry.h"
#include "tests/bench/thread_clock.h"

namespace dynmesh::server {
namespace {

using Clock = std::chrono::steady_clock;

// Milliseconds of a batch: the strand's processor time before its answer, and behind it, which the
// next batch waits for; the wall time of all.
struct Cost {
  double strand = 0, behind = 0, wall = 0;
};

class Bench {
 public:
  Bench(const std::string& folder, int dimension) : dimension_(dimension) {
    journal_ = *SqliteJournal::Open(folder, {});
    ServerConfig config;
    config.compact_operations = ~std::uint64_t{0};
    registry_ = std::make_unique<MeshRegistry>(config, &DynamicMesh::Create, &writers_, &readers_,
                                               journal_.get());
    MeshOptions options;
    options.dimension = dimension;
    options.quality = DefaultQuality(dimension);
    options.limits.max_vertices = 20'000'000;
    host_ = *registry_->Create("m", options, "");
  }

  Cost Apply(EditBatch edits) {
    const double before = Strand();
    const auto start = Clock::now();
    std::promise<double> answered;
    EditJob job;
    job.edits = std::move(edits);
    job.done = [&answered](absl::StatusOr<EditOutcome> outcome) {
      if (!outcome.ok()) std::printf("%s\n", outcome.status().ToString().c_str());
      answered.set_value(ThreadSeconds());
    };
    host_->ApplyUnbounded(std::move(job));
    const double answer = answered.get_future().get();
    const double after = Strand();
    const double wall = std::chrono::duration<double, std::milli>(Clock::now() - start).count();
    return {1e3 * (answer - before), 1e3 * (after - answer), wall};
  }
  // Entries and snapshot that a recovery would read.
  std::uint64_t entries() { return journal_->List()->front().entries; }
  MeshStats stats() const { return host_->stats(); }
  Edit AddPoint(FeatureId id) {
    std::uniform_real_distribution<double> place(0.01, 0.99);
    const double x = place(random_), y = place(random_), z = dimension_ == 3 ? place(random_) : 0;
    return Edit::Add(Feature::Point(id, x, y, z));
  }

 private:
  // The processor time of the strand's thread, when it has done all so far.
  double Strand() {
    std::promise<double> seconds;
    (void)host_->Locate({}, nullptr, [&](const auto&) { seconds.set_value(ThreadSeconds()); });
    return seconds.get_future().get();
  }

  const int dimension_;
  std::unique_ptr<Journal> journal_;
  WorkerPool writers_{1};
  WorkerPool readers_{1, WorkerPool::Priority::kBackground};
  std::unique_ptr<MeshRegistry> registry_;
  std::shared_ptr<MeshHost> host_;
  std::mt19937_64 random_{1};
};

FeatureLabel LabelOf(FeatureId id, int round) {
  return {static_cast<std::int32_t>(round), absl::StrCat("part ", id % 1'000, " of round ", round)};
}

EditBatch Labels(FeatureId first, FeatureId end, int round) {
  EditBatch batch;
  for (FeatureId id = first; id < end; ++id)
    batch.push_back(Edit::SetLabel(id, LabelOf(id, round)));
  return batch;
}

double At(const std::vector<double>& sorted, double part) {
  return sorted[static_cast<std::size_t>(part * static_cast<double>(sorted.size() - 1))];
}

void Print(const char* what, std::vector<double> values) {
  std::sort(values.begin(), values.end());
  std::printf("  %s: p50 %.2f, p99 %.2f, most %.2f ms", what, At(values, 0.5), At(values, 0.99),
              values.back());
}

void Round(Bench& bench, FeatureId points, int round) {
  const std::uint64_t before = bench.entries();
  const std::uint64_t revision = bench.stats().revision;
  std::vector<double> strand, behind, wall;
  // A tenth of the labels a batch.
  constexpr FeatureId kParts = 10;
  std::uint64_t applied = 0;
  bool is_there = false;
  auto end = Clock::now() + std::chrono::minutes(10);
  for (int k = 0; Clock::now() < end; ++k) {
    if (!is_there && k % 40 == 0 && applied < 3 * kParts) {
      const FeatureId part = applied++ % kParts;
      behind.push_back(
          bench.Apply(Labels(1 + part * points / kParts, 1 + (part + 1) * points / kParts, round))
              .behind);
    }
    const Cost cost =
        bench.Apply({k % 2 == 0 ? bench.AddPoint(points + 1) : Edit::Remove(points + 1)});
    strand.push_back(cost.strand);
    behind.push_back(cost.behind);
    wall.push_back(cost.wall);
    if (is_there || k % 10 != 0) continue;
    is_there = bench.entries() < before + (bench.stats().revision - revision);
    if (is_there) end = Clock::now() + std::chrono::seconds(1);
  }
  if (strand.size() % 2 == 1) bench.Apply({Edit::Remove(points + 1)});
  std::printf("round %d, %zu edits beside a snapshot%s", round, strand.size(),
              is_there ? "" : " THAT DID NOT COME");
  Print("strand before the answer", strand);
  Print("behind any answer", behind);
  Print("wall", wall);
  std::printf("\n");
  std::fflush(stdout);
}

int Main(int argc, char** argv) {
  int dimension = 0, rounds = 3;
  FeatureId points = 0;
  if (argc < 3 || !absl::SimpleAtoi(argv[1], &dimension) || !absl::SimpleAtoi(argv[2], &points) ||
      (argc > 3 && !absl::SimpleAtoi(argv[3], &rounds)) || (dimension != 2 && dimension != 3)) {
    std::fprintf(stderr, "usage: dynmesh_snapshot_tables DIMENSION POINTS [ROUNDS]\n");
    return 2;
  }
  std::string folder = "snapshot-tables-XXXXXX";
  if (mkdtemp(folder.data()) == nullptr) return 1;
  {
    (void)SetLogLevel("info");
    Bench bench(folder, dimension);
    EditBatch load;
    for (FeatureId id = 1; id <= points; ++id) {
      load.push_back(bench.AddPoint(id));
      load.back().feature.label = LabelOf(id, 0);
    }
    bench.Apply(std::move(load));
    const MeshStats stats = bench.stats();
    std::printf("%dD, %llu points, %llu vertices\n", dimension,
                static_cast<unsigned long long>(points),
                static_cast<unsigned long long>(stats.vertices));
    std::fflush(stdout);
    for (int round = 1; round <= rounds; ++round) Round(bench, points, round);
  }
  std::filesystem::remove_all(folder);
  return 0;
}

}  // namespace
}  // namespace dynmesh::server

int main(int argc, char** argv) { return dynmesh::server::Main(argc, argv); }
