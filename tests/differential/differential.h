// Drives a dynamic mesh by a script and compares it, after every revision and to the
// bit, with a run from scratch: mesh hash, the hash of the complete trace, the static
// path's hash, and every invariant; and a replica that follows its diffs.
#ifndef DYNMESH_TESTS_DIFFERENTIAL_DIFFERENTIAL_H_
#define DYNMESH_TESTS_DIFFERENTIAL_DIFFERENTIAL_H_

#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "core/dynamic_mesh/live_mesh.h"
#include "dynmesh/slot_mesh.h"
#include "tests/support/workload.h"

namespace dynmesh::test {

struct Difference {
  bool found = false;
  std::string what;  // empty if there is none
};

// Tuning under which every batch is propagated, however large.
inline LiveMeshTuning AlwaysPropagate() {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = ~std::size_t{0};
  tuning.rebuild.at_least_work = ~std::uint64_t{0};
  return tuning;
}

// Calls f(dimension as a constant).
template <class F>
auto InDimension(int dimension, F f) {
  return dimension == 2 ? f(std::integral_constant<int, 2>()) : f(std::integral_constant<int, 3>());
}

// An empty one that propagates every batch.
inline std::unique_ptr<DynamicMesh> NewMesh(const MeshOptions& options) {
  return InDimension(options.dimension, [&](auto d) -> std::unique_ptr<DynamicMesh> {
    return std::make_unique<LiveMesh<d()>>(options, AlwaysPropagate());
  });
}

// The usual options in D dimensions.
template <int D>
MeshOptions DefaultsIn() {
  MeshOptions options;
  options.dimension = D;
  options.quality = D == 2 ? kDefaultQuality2D : kDefaultQuality3D;
  return options;
}

// Tuning under which every batch is made from scratch, in a new state. `local` selects the provider
// of neighbourhoods.
inline LiveMeshTuning AlwaysFromScratch(bool local) {
  LiveMeshTuning tuning;
  tuning.rebuild.at_least = 0;
  tuning.rebuild.features = -1;
  tuning.global_neighbourhoods = !local;
  return tuning;
}

// True if `mesh` equals one from scratch, which `fresh` makes: a mesh of the same options, of any
// features, that is made from scratch. Optionally the static path's mesh is compared as well.
template <int D>
Difference CompareWithFresh(const DynamicMesh& mesh, LiveMesh<D>& fresh, bool with_static) {
  const std::vector<Feature> features = mesh.Features();
  EditBatch batch;
  for (const Feature& f : fresh.Features()) batch.push_back(Edit::Remove(f.id));
  for (Edit& edit : AddAll(features)) batch.push_back(std::move(edit));
  if (!batch.empty()) {
    if (const auto diff = fresh.Apply(batch, ApplyOptions{}); !diff.ok()) {
      return {true, "from scratch: " + diff.status().ToString()};
    }
  }
  // Names the first operation that differs, which is where to look.
  const auto differs = [&](const std::string& what, const MeshHash& ours, const MeshHash& theirs) {
    const auto* live = dynamic_cast<const LiveMesh<D>*>(&mesh);
    return Difference{true, what + " differs: " + ours.ToHex() + " but from scratch " +
                                theirs.ToHex() + ", first in " +
                                (live == nullptr ? "" : live->FirstDifference(fresh))};
  };
  if (!(fresh.hash() == mesh.hash())) return differs("mesh", mesh.hash(), fresh.hash());
  const AuditReport ours = mesh.Audit(), theirs = fresh.Audit();
  if (!ours.problems.empty()) return {true, "dynamic: " + ours.problems.front()};
  if (!theirs.problems.empty()) return {true, "from scratch: " + theirs.problems.front()};
  if (!(ours.trace == theirs.trace)) return differs("trace", ours.trace, theirs.trace);
  if (!with_static) return {};
  const auto built = BuildMesh(features, mesh.options());
  if (!built.ok()) return {true, "static: " + built.status().ToString()};
  if (!(built->hash == mesh.hash())) return {true, "static mesh differs"};
  return {};
}

// The same with a new mesh.
template <int D>
Difference CompareWithScratchIn(const DynamicMesh& mesh, bool local, bool with_static) {
  LiveMesh<D> fresh(mesh.options(), AlwaysFromScratch(local));
  return CompareWithFresh(mesh, fresh, with_static);
}

inline Difference CompareWithScratch(const DynamicMesh& mesh, bool local, bool with_static = true) {
  return InDimension(mesh.options().dimension,
                     [&](auto d) { return CompareWithScratchIn<d()>(mesh, local, with_static); });
}

// A mesh that follows another by its diffs alone.
class Replica {
 public:
  explicit Replica(const DynamicMesh& mesh) : store_(*SlotMesh::FromMesh(mesh.Snapshot())) {}

  // True if it equals `mesh`, row by row, after `diff`.
  Difference Follow(const MeshDiff& diff, const DynamicMesh& mesh) {
    if (const absl::Status s = store_.Apply(diff); !s.ok()) return {true, s.ToString()};
    Mesh ours = store_.ToMesh(), theirs = mesh.Snapshot();
    Canonicalize(ours);
    Canonicalize(theirs);
    const bool same = ours.vertices == theirs.vertices && ours.simplices == theirs.simplices &&
                      ours.regions == theirs.regions && ours.region_sets == theirs.region_sets &&
                      ours.subsegments == theirs.subsegments &&
                      ours.subfacets == theirs.subfacets && ours.hash == theirs.hash &&
                      ours.dimension == theirs.dimension;
    return {!same, same ? "" : "the replica differs"};
  }

 private:
  SlotMesh store_;
};

struct RunReport {
  int revisions = 0;
  int refused = 0;
  Difference difference;
  std::vector<EditBatch> script;  // up to the difference
};

// How a script is run: `revisions` applied batches, compared after each `every`, with the static
// path after each `every_static`; after each `every_judged` and the last one `judge` checks the
// mesh and returns its faults.
struct RunPlan {
  int revisions = 1;
  int every = 1, every_static = 1, every_judged = 50;
  int most_operations = 1'000'000;  // of a batch
  bool from_scratch = true;         // compare with runs from scratch
  std::function<std::string(const DynamicMesh&)> judge;
};

// After so many revisions.
inline Difference CheckByPlan(const DynamicMesh& mesh, int revisions, const RunPlan& plan) {
  if (plan.from_scratch && revisions % plan.every == 0) {
    const Difference d =
        CompareWithScratch(mesh, revisions % 2 == 0, revisions % plan.every_static == 0);
    if (d.found) return d;
  }
  if (plan.judge && (revisions % plan.every_judged == 0 || revisions == plan.revisions)) {
    const std::string problem = plan.judge(mesh);
    return {!problem.empty(), problem};
  }
  return {};
}

// A random script.
template <int D, class Generator>
RunReport RunScriptOf(Generator generator, const MeshOptions& options, const RunPlan& plan) {
  LiveMesh<D> mesh(options, AlwaysPropagate());
  Replica replica(mesh);
  RunReport report;
  while (report.revisions < plan.revisions && report.refused < 50 * plan.revisions) {
    const EditBatch batch = generator.Next(mesh.Features());
    if (batch.empty()) continue;
    const MeshHash before = mesh.hash();
    report.script.push_back(batch);
    // A propagation that does not end is a difference as well (the mesh is abandoned as it is, so
    // the exception may pass through it).
    struct NeverEnds {};
    int operations = 0;
    absl::StatusOr<MeshDiff> diff;
    try {
      diff = mesh.Apply(batch, {.interrupted = [&] {
                          if (++operations > plan.most_operations) throw NeverEnds{};
                          return false;
                        }});
    } catch (NeverEnds) {
      report.difference = {true, "the propagation does not end"};
      return report;
    }
    if (!diff.ok()) {
      report.script.pop_back();
      ++report.refused;
      if (!(mesh.hash() == before)) {
        report.difference = {true, "a refused batch changed the mesh"};
        return report;
      }
      continue;
    }
    ++report.revisions;
    report.difference = replica.Follow(*diff, mesh);
    if (!report.difference.found) report.difference = CheckByPlan(mesh, report.revisions, plan);
    if (report.difference.found) return report;
  }
  return report;
}

inline RunReport RunScript(Distribution d, int n, const MeshOptions& options, std::uint64_t seed,
                           int revisions, int every = 1, int most_operations = 1'000'000) {
  RunPlan plan;
  plan.revisions = revisions;
  plan.every = every;
  plan.most_operations = most_operations;
  return InDimension(options.dimension, [&](auto dimension) {
    return RunScriptOf<dimension()>(ScriptGenerator(d, n, seed), options, plan);
  });
}

inline RunReport RunScript(Distribution d, int n, double quality, std::uint64_t seed, int revisions,
                           int every = 1, int most_operations = 1'000'000) {
  MeshOptions options;
  options.dimension = DimensionOf(d);
  options.quality = quality;
  return RunScript(d, n, options, seed, revisions, every, most_operations);
}

// True if the script leads to a difference at its end or before.
inline Difference Replay(const std::vector<EditBatch>& script, const MeshOptions& options,
                         const RunPlan& plan = {}) {
  const auto mesh = NewMesh(options);
  Replica replica(*mesh);
  for (const EditBatch& batch : script) {
    const auto diff = mesh->Apply(batch);
    if (!diff.ok()) continue;
    if (const Difference d = replica.Follow(*diff, *mesh); d.found) return d;
    for (const bool local : {false, true}) {
      if (!plan.from_scratch) break;
      if (const Difference d = CompareWithScratch(*mesh, local); d.found) return d;
    }
    if (!plan.judge) continue;
    if (const std::string problem = plan.judge(*mesh); !problem.empty()) return {true, problem};
  }
  return {};
}

// Leaves out batches and edits as long as a difference stays.
inline std::vector<EditBatch> Shrink(std::vector<EditBatch> script, const MeshOptions& options,
                                     const RunPlan& plan = {}) {
#ifdef DYNMESH_MUTATE
  return script;  // a mutant's difference is of no interest
#endif
  for (bool smaller = true; smaller;) {
    smaller = false;
    for (std::size_t i = script.size(); i-- > 0;) {
      std::vector<EditBatch> less = script;
      less.erase(less.begin() + static_cast<std::ptrdiff_t>(i));
      if (Replay(less, options, plan).found) {
        script = std::move(less);
        smaller = true;
      }
    }
    for (std::size_t i = 0; i < script.size(); ++i) {
      for (std::size_t chunk = script[i].size() / 2; chunk > 0; chunk /= 2) {
        for (std::size_t j = 0; j + chunk <= script[i].size() && script[i].size() > chunk;) {
          std::vector<EditBatch> less = script;
          less[i].erase(less[i].begin() + static_cast<std::ptrdiff_t>(j),
                        less[i].begin() + static_cast<std::ptrdiff_t>(j + chunk));
          if (Replay(less, options, plan).found) {
            script = std::move(less);
            smaller = true;
          } else {
            j += chunk;
          }
        }
      }
    }
  }
  return script;
}

}  // namespace dynmesh::test

#endif  // DYNMESH_TESTS_DIFFERENTIAL_DIFFERENTIAL_H_
