#include "core/dynamic_mesh/live_quadtree.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/feature_kinds.h"
#include "core/base/text.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/stopwatch.h"
#include "core/plc/messages.h"
#include "dynmesh/error.h"

namespace dynmesh {
namespace {

template <int D>
quadtree::Grid<D> GridOf(const MeshOptions& options) {
  geometry::Point<D> lo, hi;
  for (int k = 0; k < D; ++k) lo[k] = options.box.lo[k], hi[k] = options.box.hi[k];
  return {lo, hi};
}

absl::Status IdCollisionError(VertexId id) {
  return MakeError(absl::StatusCode::kFailedPrecondition,
                   "two leaves of the quadtree would have the id " + text::Hex(id) +
                       ", a hash of their centres; move a feature a little",
                   {reason::kIdCollision, {}, {}});
}

}  // namespace

template <int D>
LiveQuadtree<D>::LiveQuadtree(const MeshOptions& options, VertexHash id_of)
    : options_(options),
      plc_(options),
      grid_(GridOf<D>(options)),
      state_(std::make_unique<State>(grid_)),
      leaves_(grid_, id_of) {
  state_->tree.Propagate();
  VertexColumns root;
  leaves_.AddAll(
      1, [](auto add) { add(quadtree::Cell<D>()); }, root);
}

// Polls before each operation. A batch has more leaves than it may have in the end if it has more
// than twice as many on the way: these are the ones before, the ones after, or both.
template <int D>
absl::Status LiveQuadtree<D>::Propagate(const typename LiveFeatures<D>::Batch& batch) {
  const Tree& tree = state_->tree;
  const sac::Counters& counters = tree.engine().counters();
  const std::uint64_t most = options_.limits.max_vertices;
  std::uint64_t taken = 0;
  const auto work = [&] { return ProgressMeter::Work{taken, taken + tree.engine().waiting()}; };
  enum class Stop { kNot, kCancelled, kOverWork, kOverLimit } stop = Stop::kNot;
  state_->tree.Propagate([&] {
    batch.meter.Step(work);
    ++taken;
    stop = batch.interrupt()                           ? Stop::kCancelled
           : counters.executed > batch.most_operations ? Stop::kOverWork
           : tree.leaf_count() > 2 * most              ? Stop::kOverLimit
                                                       : Stop::kNot;
    return stop != Stop::kNot;
  });
  if (stop == Stop::kCancelled) return plc::InterruptedError();
  if (counters.executed > batch.most_operations) return WorkLimitError(batch.most_operations);
  if (stop == Stop::kOverLimit || tree.leaf_count() > most) return VertexLimitError(options_);
  batch.meter.End(work().done);
  return absl::OkStatus();
}

template <int D>
MeshDiff LiveQuadtree<D>::TakeChanges() {
  MeshDiff diff;
  diff.dimension = D;
  const quadtree::LeafDiff<D> changes = state_->tree.TakeChanges();
  diff.removed_vertices.reserve(changes.removed.size());
  for (const quadtree::Cell<D>& leaf : changes.removed) {
    diff.removed_vertices.push_back(leaves_.Remove(leaf));
  }
  const auto for_each = [&](auto add) { std::ranges::for_each(changes.added, add); };
  leaves_.AddAll(changes.added.size(), for_each, diff.added_vertices);
  return diff;
}

template <int D>
absl::Status LiveQuadtree<D>::StatusOfIds() const {
  const auto clash = leaves_.Clash();
  return clash.has_value() ? IdCollisionError(*clash) : absl::OkStatus();
}

// What a quadtree is told of (ShapeTable).
static_assert(kAreAllKinds<APoint, ASegment, APolygon, ASize>);

template <int D>
absl::StatusOr<MeshDiff> LiveQuadtree<D>::Run(const plc::Delta<D>& delta,
                                              const typename LiveFeatures<D>::Batch& batch,
                                              Commit commit) {
  constexpr std::size_t kAtOnce = 256;  // features between polls
  state_->tree.engine().ResetCounters();
  batch.meter.Begin(ApplyProgress::Stage::kRefine);
  std::size_t applied = 0;
  const auto refuse = [&](absl::Status status) {
    Undo(applied == delta.size() ? delta : delta.Part(0, applied));
    return status;
  };
  while (applied < delta.size()) {
    if (batch.interrupt()) return refuse(plc::InterruptedError());
    const std::size_t next = std::min(delta.size(), applied + kAtOnce);
    state_->shapes.Apply(delta.size() <= kAtOnce ? delta : delta.Part(applied, next), state_->tree);
    applied = next;
  }
  if (absl::Status status = Propagate(batch); !status.ok()) return refuse(std::move(status));

  const Stopwatch watch;
  batch.meter.Begin(ApplyProgress::Stage::kDiff);
  MeshDiff diff = TakeChanges();
  if (absl::Status status = StatusOfIds(); !status.ok()) return refuse(std::move(status));
  Canonicalize(diff);
  diff.hash = leaves_.hash();
  const sac::Counters& counters = state_->tree.engine().counters();
  diff.work.executed = counters.executed;
  diff.work.created = counters.created;
  diff.work.dropped = counters.dropped;
  diff.work.diff_microseconds = watch.microseconds();
  batch.meter.End();
  if (absl::Status status = commit(diff); !status.ok()) return refuse(std::move(status));
  plc_.Apply(delta);
  return diff;
}

template <int D>
void LiveQuadtree<D>::Undo(const plc::Delta<D>& delta) {
  state_->shapes.Apply(delta.Inverse(), state_->tree);
  state_->tree.Propagate();
  TakeChanges();
}

template <int D>
void LiveQuadtree<D>::GiveMemoryBack(Interrupt interrupt) {
  constexpr double kPart = 0.25;
  if (!state_->tree.engine().IsMostlyRoom(kPart)) return;
  auto fresh = std::make_unique<State>(grid_);
  fresh->shapes.Apply(plc_.FromNothing(), fresh->tree);
  if (!fresh->tree.Propagate(interrupt)) return;
  fresh->tree.TakeChanges();
  state_ = std::move(fresh);
}

template <int D>
Mesh LiveQuadtree<D>::Snapshot() const {
  Mesh mesh;
  mesh.dimension = D;
  state_->tree.ForEachLeaf(
      [&](const quadtree::Cell<D>& leaf) { leaves_.AppendTo(mesh.vertices, leaf); });
  mesh.hash = leaves_.hash();
  mesh.revision = this->revision();
  mesh.labels = this->labels().All();
  return mesh;
}

template <int D>
template <class F>
void LiveQuadtree<D>::ForEachLeafAt(std::span<const double> points, F f) const {
  const quadtree::Box<D> root = grid_.BoxOf(quadtree::Cell<D>());
  for (; points.size() >= D; points = points.subspan(D)) {
    geometry::Point<D> p;
    std::copy_n(points.begin(), D, p.c.begin());
    std::optional<quadtree::Cell<D>> leaf;
    if (root.Holds(p)) leaf = state_->tree.LeafAt(p);
    f(leaf);
  }
}

template <int D>
SimplexColumn LiveQuadtree<D>::Locate(std::span<const double> points) const {
  SimplexColumn result;
  result.reserve(points.size() / D * (D + 1));
  ForEachLeafAt(points, [&](const std::optional<quadtree::Cell<D>>& leaf) {
    result.push_back(leaf.has_value() ? leaves_.IdOf(*leaf) : 0);
    result.insert(result.end(), D, 0);
  });
  return result;
}

template <int D>
std::vector<double> LiveQuadtree<D>::LeafSides(std::span<const double> points) const {
  std::vector<double> sides;
  ForEachLeafAt(points, [&](const std::optional<quadtree::Cell<D>>& leaf) {
    sides.push_back(leaf.has_value() ? grid_.Side(leaf->level) : 0);
  });
  return sides;
}

template <int D>
MeshStats LiveQuadtree<D>::Stats() const {
  const Tree& tree = state_->tree;
  MeshStats stats;
  stats.revision = this->revision();
  stats.features = plc_.size();
  stats.vertices = tree.leaf_count();
  stats.operations = tree.engine().operation_count();
  stats.trace_bytes = tree.engine().bytes();
  stats.mesh_bytes = tree.bytes() - stats.trace_bytes + state_->shapes.bytes() + leaves_.bytes() +
                     plc_.bytes() + this->labels().bytes();
  return stats;
}

template <int D>
AuditReport LiveQuadtree<D>::Audit() const {
  AuditReport report;
  const Tree& tree = state_->tree;
  report.trace = {tree.Audit(&report.problems), tree.engine().operation_count()};
  const Mesh mesh = Snapshot();
  if (!(ComputeHash(mesh) == mesh.hash)) {
    report.problems.push_back("the hash kept is not that of the mesh");
  }
  if (mesh.vertices.size() != leaves_.size() || mesh.vertices.size() != tree.leaf_count()) {
    report.problems.push_back("the ids kept are not those of the leaves");
  }
  return report;
}

template <int D>
absl::StatusOr<Mesh> BuildQuadtree(std::span<const Feature> features, const MeshOptions& options,
                                   const BuildOptions& build) {
  const Interrupt interrupt = InterruptOf(build.interrupted);
  const std::uint64_t most = MostOperations(build.max_operations);
  ProgressMeter meter(build.progress);
  const plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta =
      CheckFeatures(plc, features, options, build.valid.get(), meter, interrupt);
  if (absl::IsCancelled(delta.status())) return GivenUpError();
  if (!delta.ok()) return delta.status();
  meter.Begin(ApplyProgress::Stage::kRefine);
  const quadtree::Grid<D> grid = GridOf<D>(options);
  quadtree::BuildQt<D, sac::UntracedEngine> tree(grid);
  ShapeTable<D> shapes;
  shapes.Apply(*delta, tree);
  const auto& engine = tree.engine();
  const auto work = [&] {
    return ProgressMeter::Work{engine.executed(), engine.executed() + engine.waiting()};
  };
  bool is_interrupted = false;
  tree.Propagate([&] {
    meter.Step(work);
    is_interrupted = interrupt();
    return is_interrupted || engine.executed() > most ||
           tree.leaf_count() > options.limits.max_vertices;
  });
  if (is_interrupted) return GivenUpError();
  if (tree.leaf_count() > options.limits.max_vertices) return VertexLimitError(options);
  if (engine.executed() > most) return WorkLimitError(most);
  meter.End(engine.executed());
  meter.Begin(ApplyProgress::Stage::kDiff);
  LeafIds<D> ids(grid, &VertexIdAt);
  Mesh mesh;
  mesh.dimension = D;
  ids.AddAll(
      tree.leaf_count(), [&](auto add) { tree.ForEachLeaf(add); }, mesh.vertices);
  if (const auto clash = ids.Clash(); clash.has_value()) return IdCollisionError(*clash);
  mesh.hash = ids.hash();
  mesh.revision = features.empty() ? 0 : 1;
  meter.End();
  return mesh;
}

template class LiveQuadtree<2>;
template class LiveQuadtree<3>;
template absl::StatusOr<Mesh> BuildQuadtree<2>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);
template absl::StatusOr<Mesh> BuildQuadtree<3>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);

}  // namespace dynmesh
