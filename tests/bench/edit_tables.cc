// The cost of edits, as tables on standard output.
//
//   dynmesh_edit_tables edits   [FILE.poly ...]   kinds of single edits, by percentiles
//   dynmesh_edit_tables batches [FILE.poly ...]   k nearby edits at once against one by one
//   dynmesh_edit_tables rebuild [FILE.poly ...]   propagating a large batch against building
//                                                 anew (LiveMeshTuning)
//   dynmesh_edit_tables triangulations [MOST]     single edits of triangulations of 1,000,
//                                                 100,000 and, up to MOST, 1,000,000 points
//
// On uniform points, and on each file: coastlines, where subsegments are removed and put back,
// points move with their segments, and small sizing discs are added and removed. Times are
// microseconds of this thread's processor time in Apply: processes that take its core do not count,
// except for their effect on the caches. Every edit is undone before the next one, so all start
// from the same mesh.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/container/flat_hash_map.h"
#include "client/cli/percentile.h"
#include "core/base/process_memory.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/io/plane/planar_input.h"
#include "tests/bench/thread_clock.h"
#include "tests/support/workload.h"

namespace dynmesh {
namespace {

using test::Distribution;
using test::Random;

constexpr double kRoot2 = 1.4142135623730951;

// --- Inputs -----------------------------------------------------------------------------

struct Input {
  std::string name;
  std::vector<Feature> features;
  Box box;
  std::vector<std::size_t> points, segments;  // rows of features
  absl::flat_hash_map<FeatureId, std::vector<std::size_t>> segments_at;
  absl::flat_hash_map<FeatureId, std::size_t> row_of;

  Input(std::string called, std::vector<Feature> given)
      : name(std::move(called)), features(std::move(given)) {
    for (int k = 0; k < 2; ++k) box.lo[k] = INFINITY, box.hi[k] = -INFINITY;
    for (std::size_t i = 0; i < features.size(); ++i) {
      const Feature& f = features[i];
      row_of[f.id] = i;
      if (f.kind == FeatureKind::kPoint) {
        points.push_back(i);
        for (int k = 0; k < 2; ++k) {
          box.lo[k] = std::min(box.lo[k], f.position[k]);
          box.hi[k] = std::max(box.hi[k], f.position[k]);
        }
      } else if (f.kind == FeatureKind::kSegment) {
        segments.push_back(i);
        for (const FeatureId end : f.ends) segments_at[end].push_back(i);
      }
    }
  }
  double width() const { return std::max(box.hi[0] - box.lo[0], box.hi[1] - box.lo[1]); }
  // Of the same number of points spread evenly.
  double spacing() const { return width() / std::sqrt(static_cast<double>(points.size())); }
  double LengthOf(const Feature& segment) const {
    const auto &a = features[row_of.at(segment.ends[0])].position,
               &b = features[row_of.at(segment.ends[1])].position;
    return std::hypot(a[0] - b[0], a[1] - b[1]);
  }
  // About the distance from the point to others.
  double ScaleAt(const Feature& point) const {
    double scale = spacing();
    const auto at = segments_at.find(point.id);
    if (at == segments_at.end()) return scale;
    for (const std::size_t s : at->second) scale = std::min(scale, LengthOf(features[s]));
    return scale;
  }
  const Feature& RandomPoint(Random& random) const {
    return features[points[static_cast<std::size_t>(
        random.Below(static_cast<int>(points.size())))]];
  }
};

std::vector<Input> Inputs(std::span<char*> files, std::initializer_list<int> uniform) {
  std::vector<Input> inputs;
  for (const int n : uniform) {
    inputs.emplace_back("uniform " + std::to_string(n),
                        test::MakeFeatures(Distribution::kUniform, n, 1));
  }
  for (const char* file : files) {
    auto read = io::ReadPolyFile(file);
    if (!read.ok()) {
      std::fprintf(stderr, "%s\n", read.status().ToString().c_str());
      std::exit(1);
    }
    inputs.emplace_back(std::filesystem::path(file).stem().string(), std::move(read->features));
  }
  return inputs;
}

MeshOptions OptionsFor(const Input& input, double rho) {
  MeshOptions options;
  options.box = input.box;
  options.quality = rho;
  return options;
}

// Built, or null if the input is refused.
std::unique_ptr<LiveMesh<2>> Make(const Input& input, double rho, const LiveMeshTuning& tuning) {
  auto mesh = std::make_unique<LiveMesh<2>>(OptionsFor(input, rho), tuning);
  const auto diff = mesh->Apply(AddAll(input.features), ApplyOptions{});
  if (diff.ok()) return mesh;
  std::fprintf(stderr, "%s: %s\n", input.name.c_str(), diff.status().ToString().c_str());
  return nullptr;
}

// --- Edits and their inverses -------------------------------------------------------------

struct Change {
  EditBatch edits, inverse;  // edits[i] is undone by inverse[n-1-i]
};

FeatureId FreshId(std::size_t i) { return (FeatureId{1} << 40) + i; }

Edit MoveBy(const Feature& point, double dx, double dy) {
  return Edit::Move(point.id, point.position[0] + dx, point.position[1] + dy);
}

enum class Kind { kAddPoint, kMovePoint, kRemoveSegment, kSizingDisc };
constexpr std::pair<Kind, const char*> kKinds[] = {
    {Kind::kAddPoint, "add, remove a point"},
    {Kind::kMovePoint, "move a point, back"},
    {Kind::kRemoveSegment, "remove, add a segment"},
    {Kind::kSizingDisc, "add, drop a disc"},
};

// `k` edits of a kind near one place. Not all need be legal.
Change MakeChange(const Input& input, Kind kind, int k, Random& random) {
  Change change;
  const Feature& centre = input.RandomPoint(random);
  const double scale = input.ScaleAt(centre);
  const double radius = scale * std::sqrt(static_cast<double>(k));
  const auto add = [&](Edit edit, Edit inverse) {
    change.edits.push_back(std::move(edit));
    change.inverse.insert(change.inverse.begin(), std::move(inverse));
  };
  // Rows near the centre's row are usually near it in position: points along a coast. Others are
  // searched.
  std::vector<std::size_t> near;
  if (kind == Kind::kMovePoint || kind == Kind::kRemoveSegment) {
    const auto& rows = kind == Kind::kMovePoint ? input.points : input.segments;
    if (rows.empty()) return change;
    if (input.segments.empty() && k > 1) {
      near = rows;
      const auto distance = [&](std::size_t i) {
        const auto& p = input.features[i].position;
        return std::hypot(p[0] - centre.position[0], p[1] - centre.position[1]);
      };
      std::nth_element(near.begin(), near.begin() + k, near.end(),
                       [&](auto a, auto b) { return distance(a) < distance(b); });
    } else {
      const int first = random.Below(std::max(1, static_cast<int>(rows.size()) - k));
      near.assign(rows.begin() + first, rows.end());
    }
  }
  for (int i = 0; i < k; ++i) {
    const double x = centre.position[0] + radius * (2 * random.Unit() - 1);
    const double y = centre.position[1] + radius * (2 * random.Unit() - 1);
    const FeatureId id = FreshId(static_cast<std::size_t>(i));
    if (kind == Kind::kAddPoint) {
      add(Edit::Add(Feature::Point(id, x, y)), Edit::Remove(id));
    } else if (kind == Kind::kSizingDisc) {
      add(Edit::Add(Feature::SizeDisc(id, x, y, scale, scale / 4)), Edit::Remove(id));
    } else if (kind == Kind::kMovePoint) {
      const Feature& point = input.features[near[static_cast<std::size_t>(i)]];
      const double step = 0.1 * input.ScaleAt(point);
      add(MoveBy(point, step * (2 * random.Unit() - 1), step * (2 * random.Unit() - 1)),
          MoveBy(point, 0, 0));
    } else {
      const Feature& segment = input.features[near[static_cast<std::size_t>(i)]];
      add(Edit::Remove(segment.id), Edit::Add(segment));
    }
  }
  return change;
}

struct Cost {
  double microseconds = 0, executed = 0, changed = 0;
  void Add(const MeshDiff& diff, double seconds) {
    microseconds += 1e6 * seconds;
    executed += static_cast<double>(diff.work.executed);
    changed += static_cast<double>(diff.added_vertices.size() + diff.removed_vertices.size());
  }
};

// False if it is refused; then nothing has changed.
bool Do(LiveMesh<2>& mesh, const EditBatch& batch, Cost* cost) {
  const double start = ThreadSeconds();
  const auto diff = mesh.Apply(batch, ApplyOptions{});
  if (diff.ok()) cost->Add(*diff, ThreadSeconds() - start);
  return diff.ok();
}

// All at once, then undone.
bool AtOnce(LiveMesh<2>& mesh, const Change& change, Cost* there, Cost* back) {
  return Do(mesh, change.edits, there) && Do(mesh, change.inverse, back);
}

// One by one, then undone; also after a refusal in the middle.
bool OneByOne(LiveMesh<2>& mesh, const Change& change, Cost* there, Cost* back) {
  std::size_t done = 0;
  while (done < change.edits.size() && Do(mesh, {change.edits[done]}, there)) ++done;
  for (std::size_t i = change.edits.size() - done; i < change.inverse.size(); ++i) {
    if (!Do(mesh, {change.inverse[i]}, back)) std::abort();
  }
  return done == change.edits.size();
}

// --- Tables -------------------------------------------------------------------------------

void PrintEdits(const Input& input, double rho) {
  const double start = ThreadSeconds();
  const auto built = BuildMesh(input.features, OptionsFor(input, rho));
  const double middle = ThreadSeconds();
  const auto mesh = Make(input, rho, {});
  const double end = ThreadSeconds();
  if (!built.ok() || mesh == nullptr) return;
  const MeshStats stats = mesh->Stats();
  std::printf(
      "\n%s, rho %.4g: %zu points, %zu segments, %zu vertices; from scratch %.3f s, with trace "
      "%.3f s; %.0f bytes a vertex\n",
      input.name.c_str(), rho, input.points.size(), input.segments.size(),
      static_cast<std::size_t>(stats.vertices), middle - start, end - middle,
      static_cast<double>(stats.trace_bytes + stats.mesh_bytes) /
          static_cast<double>(stats.vertices));
  std::printf("%-22s %8s %8s %8s %8s | %8s %8s | %8s %8s\n", "edit", "p50 us", "p90", "p99", "max",
              "ops mean", "p99", "vertices", "p99");
  for (const auto& [kind, name] : kKinds) {
    Random random(7);
    std::vector<double> times, executed, changed;
    for (int i = 0; i < 1500; ++i) {
      const Change change = MakeChange(input, kind, 1, random);
      Cost there, back;
      if (change.edits.empty() || !AtOnce(*mesh, change, &there, &back)) continue;
      for (const Cost& cost : {there, back}) {
        times.push_back(cost.microseconds);
        executed.push_back(cost.executed);
        changed.push_back(cost.changed);
      }
    }
    if (times.empty()) continue;
    const auto mean = [](const std::vector<double>& values) {
      double sum = 0;
      for (const double v : values) sum += v;
      return sum / static_cast<double>(values.size());
    };
    std::printf("%-22s %8.0f %8.0f %8.0f %8.0f | %8.1f %8.0f | %8.1f %8.0f\n", name,
                cli::Percentile(times, .5), cli::Percentile(times, .9), cli::Percentile(times, .99),
                cli::Percentile(times, 1), mean(executed), cli::Percentile(executed, .99),
                mean(changed), cli::Percentile(changed, .99));
  }
}

void PrintBatches(const Input& input, double rho) {
  const auto mesh = Make(input, rho, {});
  if (mesh == nullptr) return;
  std::printf("\n%s, rho %.4g: k nearby edits at once, as a part of the same one by one; medians\n",
              input.name.c_str(), rho);
  std::printf("%-22s %4s | %10s %10s %6s | %10s %10s %6s\n", "edit", "k", "us", "one by one",
              "part", "operations", "one by one", "part");
  for (const auto& [kind, name] : kKinds) {
    for (int k = 2; k <= 64; k *= 2) {
      Random random(11);
      std::vector<double> times, single_times, executed, single_executed;
      for (int i = 0; i < std::clamp(640 / k, 20, 100); ++i) {
        const Change change = MakeChange(input, kind, k, random);
        if (change.edits.empty()) break;
        Cost once, single;
        // The order alternates, since the second one finds warm caches.
        const bool ok =
            i % 2 == 0
                ? AtOnce(*mesh, change, &once, &once) && OneByOne(*mesh, change, &single, &single)
                : OneByOne(*mesh, change, &single, &single) && AtOnce(*mesh, change, &once, &once);
        if (!ok) continue;
        times.push_back(once.microseconds);
        executed.push_back(once.executed);
        single_times.push_back(single.microseconds);
        single_executed.push_back(single.executed);
      }
      if (times.empty()) continue;
      const double t = cli::Percentile(times, .5), s = cli::Percentile(single_times, .5);
      const double e = cli::Percentile(executed, .5), f = cli::Percentile(single_executed, .5);
      std::printf("%-22s %4d | %10.0f %10.0f %6.2f | %10.0f %10.0f %6.2f\n", name, k, t / 2, s / 2,
                  t / s, e / 2, f / 2, e / f);
    }
  }
}

LiveMeshTuning Always(bool rebuild) {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = rebuild ? 0 : ~std::size_t{0};
  tuning.rebuild.features = rebuild ? -1 : 1;
  return tuning;
}

// A part of the points and the features that depend on them: each k-th, or the leftmost.
std::vector<std::size_t> Chosen(const Input& input, double part, bool in_one_place) {
  std::vector<std::size_t> rows = input.points;
  Random random(3);
  std::vector<double> key(input.features.size());
  for (const std::size_t i : rows) {
    key[i] = in_one_place ? input.features[i].position[0] : random.Unit();
  }
  std::sort(rows.begin(), rows.end(), [&](auto a, auto b) { return key[a] < key[b]; });
  rows.resize(static_cast<std::size_t>(part * static_cast<double>(rows.size())));
  return rows;
}

Change LargeChange(const Input& input, double part, bool in_one_place, bool moves) {
  Change change;
  const auto chosen = Chosen(input, part, in_one_place);
  EditBatch back;
  if (moves) {
    Random random(5);
    for (const std::size_t i : chosen) {
      const Feature& p = input.features[i];
      const double step = 0.002 * input.ScaleAt(p);
      change.edits.push_back(
          MoveBy(p, step * (2 * random.Unit() - 1), step * (2 * random.Unit() - 1)));
      back.push_back(MoveBy(p, 0, 0));
    }
  } else {
    std::vector<bool> gone(input.features.size());
    for (const std::size_t i : chosen) {
      gone[i] = true;
      const auto at = input.segments_at.find(input.features[i].id);
      if (at == input.segments_at.end()) continue;
      for (const std::size_t s : at->second) gone[s] = true;
    }
    for (std::size_t i = 0; i < gone.size(); ++i) {
      if (!gone[i]) continue;
      change.edits.push_back(Edit::Remove(input.features[i].id));
      back.push_back(Edit::Add(input.features[i]));
    }
  }
  change.inverse = std::move(back);
  return change;
}

void PrintRebuild(const Input& input, double rho) {
  const auto propagated = Make(input, rho, Always(false)), rebuilt = Make(input, rho, Always(true)),
             chosen = Make(input, rho, {});
  if (propagated == nullptr || rebuilt == nullptr || chosen == nullptr) return;
  const std::size_t n = input.features.size();
  std::printf(
      "\n%s, rho %.4g, %zu features: propagated, rebuilt, what is chosen, seconds; there and "
      "back\n",
      input.name.c_str(), rho, n);
  const auto row = [&](const std::string& name, const Change& change) {
    Cost a[2], b[2];
    if (!AtOnce(*propagated, change, &a[0], &a[1]))
      return std::printf("%s refused\n", name.c_str());
    const double vertices = static_cast<double>(propagated->Stats().vertices);
    Cost c[2];
    if (!AtOnce(*rebuilt, change, &b[0], &b[1]) || !AtOnce(*chosen, change, &c[0], &c[1])) return 0;
    std::printf("%-28s %5.3f of n %5.3f of V", name.c_str(),
                static_cast<double>(change.edits.size()) / static_cast<double>(n),
                a[0].changed / vertices);
    for (int i = 0; i < 2; ++i) {
      std::printf(" | %8.4f %8.4f %8.4f, ratio %5.2f", a[i].microseconds * 1e-6,
                  b[i].microseconds * 1e-6, c[i].microseconds * 1e-6,
                  a[i].microseconds / b[i].microseconds);
    }
    return std::printf("\n");
  };
  for (const bool moves : {false, true}) {
    for (const bool in_one_place : {false, true}) {
      for (const double part : {0.03, 0.1, 0.2, 0.3, 0.5, 0.8}) {
        row(std::string(moves ? "move" : "remove, add") +
                (in_one_place ? ", in one place" : ", scattered"),
            LargeChange(input, part, in_one_place, moves));
      }
    }
  }
  // One feature that creates many vertices.
  for (const double fraction : {0.3, 1.0, 3.0, 10.0}) {
    const double area = input.width() * input.width() * 0.25;  // of a disc of this size below
    const double target = std::sqrt(area / (fraction * static_cast<double>(n)));
    Change change;
    change.edits = {Edit::Add(Feature::SizeDisc(FreshId(0), (input.box.lo[0] + input.box.hi[0]) / 2,
                                                (input.box.lo[1] + input.box.hi[1]) / 2,
                                                0.28 * input.width(), target))};
    change.inverse = {Edit::Remove(FreshId(0))};
    row("add, drop one disc", change);
  }
}

// `n` points, n / 10 segments between some of them, which cross a few edges but no other one: each
// is in a cell of its own of a lattice.
std::vector<Feature> ShortSegments(int n, Random& random) {
  std::vector<Feature> features;
  std::vector<Feature> segments;
  const int cells = static_cast<int>(std::ceil(std::sqrt(n / 10.0)));
  FeatureId id = 1;
  for (int i = 0; i < n / 10; ++i) {
    const double x = i % cells, y = i / cells;
    const double cx = x + 0.4 + 0.2 * random.Unit(), cy = y + 0.4 + 0.2 * random.Unit();
    for (const double side : {-0.35, 0.35}) {
      const double px = (cx + side * (0.3 + 0.7 * random.Unit())) / cells;
      const double py = (cy + side * (2 * random.Unit() - 1)) / cells;
      features.push_back(Feature::Point(id++, px, py));
    }
    segments.push_back(Feature::Segment(FreshId(static_cast<std::size_t>(i)), id - 2, id - 1));
  }
  while (id <= static_cast<FeatureId>(n)) {
    features.push_back(Feature::Point(id++, random.Unit(), random.Unit()));
  }
  features.insert(features.end(), segments.begin(), segments.end());
  return features;
}

void PrintTriangulations(int n) {
  Random random(1);
  const std::vector<Feature> features = ShortSegments(n, random);
  MeshOptions options;
  options.box = {{0, 0}, {1, 1}};
  options.kind = MeshKind::kTriangulation;
  LiveMesh<2> mesh(options);
  const double start = ThreadSeconds();
  const auto loaded = mesh.Apply(AddAll(features), ApplyOptions{});
  const double end = ThreadSeconds();
  if (!loaded.ok()) {
    std::fprintf(stderr, "%s\n", loaded.status().ToString().c_str());
    std::exit(1);
  }
  std::printf("\n%d points, %d segments: load %.3f s\n", n, n / 10, end - start);
  std::printf("%-22s %8s %8s %8s %8s | %9s\n", "edit", "p50 us", "p90", "p99", "max", "triangles");
  for (const bool of_points : {true, false}) {
    std::vector<double> gone, came, changed;
    while (gone.size() < 2000) {
      // A point that no segment has, or a segment.
      const int lone = n - n / 5;
      const Feature& f = features[static_cast<std::size_t>(of_points ? n / 5 + random.Below(lone)
                                                                     : n + random.Below(n / 10))];
      for (const auto& [edit, times] :
           {std::pair{Edit::Remove(f.id), &gone}, std::pair{Edit::Add(f), &came}}) {
        const EditBatch batch = {edit};
        const double before = ThreadSeconds();
        const auto diff = mesh.Apply(batch, ApplyOptions{});
        times->push_back(1e6 * (ThreadSeconds() - before));
        if (!diff.ok()) std::abort();
        changed.push_back(
            static_cast<double>(diff->added_simplex_count() + diff->removed_simplex_count()));
      }
    }
    for (const auto& [name, times] :
         {std::pair{of_points ? "a point goes" : "a segment goes", &gone},
          std::pair{of_points ? "a point comes" : "a segment comes", &came}}) {
      std::printf("%-22s %8.1f %8.1f %8.1f %8.1f | %9.0f\n", name, cli::Percentile(*times, 0.5),
                  cli::Percentile(*times, 0.9), cli::Percentile(*times, 0.99),
                  cli::Percentile(*times, 1), cli::Percentile(changed, 0.5));
    }
  }
}

}  // namespace
}  // namespace dynmesh

int main(int argc, char** argv) {
  dynmesh::SetUpMemory(dynmesh::MemoryUse::kCommand);  // as `dynmesh` does
  using namespace dynmesh;
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // tables take minutes
  const std::string_view mode = argc > 1 ? argv[1] : "";
  const std::span<char*> files(argv + std::min(argc, 2), argv + argc);
  if (mode == "edits") {
    for (const Input& input : Inputs(files, {10'000, 100'000})) {
      for (const double rho : {kRoot2, 2.0}) PrintEdits(input, rho);
    }
  } else if (mode == "batches") {
    for (const Input& input : Inputs(files, {100'000})) {
      for (const double rho : {kRoot2, 2.0}) PrintBatches(input, rho);
    }
  } else if (mode == "rebuild") {
    for (const Input& input : Inputs(files, {1'000, 10'000, 100'000})) PrintRebuild(input, kRoot2);
  } else if (mode == "triangulations") {
    const int most = argc > 2 ? std::atoi(argv[2]) : 100'000;
    for (const int n : {1'000, 100'000, 1'000'000}) {
      if (n <= most) PrintTriangulations(n);
    }
  } else {
    std::fprintf(stderr,
                 "usage: %s edits|batches|rebuild [FILE.poly ...]\n"
                 "       %s triangulations [MOST]\n",
                 argv[0], argv[0]);
    return 2;
  }
}
