#include "core/dynamic_mesh/build_mesh.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "core/base/text.h"
#include "core/dynamic_mesh/diff_builder.h"
#include "core/dynamic_mesh/feature_table.h"
#include "core/dynamic_mesh/finest_place.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_mesh.h"
#include "core/meshing/refinement.h"
#include "core/svr/svr.h"

namespace dynmesh {
namespace {

// The meshers, alike: Add takes the input, Run refines until it is done or `interrupt()`.

// Reads neighbourhoods from one growing triangulation.
template <int D>
class DynamicMesher {
 public:
  DynamicMesher(const MeshOptions& options, const BuildOptions& build,
                typename DiffBuilder<D>::Triangulation* triangulation)
      : refinement_(options, triangulation) {
    if (build.only_inside) refinement_.OnlyInside();
  }

  void Add(const plc::Delta<D>& delta, FeatureTable<D>& table, Steps& steps) {
    refinement_.Reserve(delta.added_points.size());
    table.Apply(delta, refinement_, steps);
  }
  template <class Interrupt>
  void Run(Interrupt interrupt) {
    refinement_.Propagate(interrupt);
  }
  std::uint64_t executed() const { return refinement_.engine().executed(); }
  std::uint64_t waiting() const { return refinement_.engine().waiting(); }
  auto& result() { return refinement_; }

 private:
  meshing::Refinement<D, sac::UntracedEngine> refinement_;
};

template <int D>
class SvrMesher {
 public:
  SvrMesher(const MeshOptions& options, const BuildOptions& /*build*/,
            typename DiffBuilder<D>::Triangulation* triangulation)
      : input_(options), triangulation_(triangulation) {}

  void Add(const plc::Delta<D>& delta, FeatureTable<D>& table, Steps& steps) {
    table.Add(delta, input_, steps);
    if (!steps.stopped()) svr_.emplace(input_.options(), &input_, triangulation_);
  }
  template <class Interrupt>
  void Run(Interrupt interrupt) {
    svr_->Run([&] {
      if (interrupt()) return true;
      ++executed_;
      return false;
    });
  }
  std::uint64_t executed() const { return executed_; }
  std::uint64_t waiting() const { return svr_->waiting(); }
  auto& result() { return input_; }

 private:
  svr::PlcInput<D> input_;
  typename DiffBuilder<D>::Triangulation* triangulation_;
  std::optional<svr::Svr<D, svr::PlcInput<D>>> svr_;
  std::uint64_t executed_ = 0;
};

template <int D, template <int> class Mesher>
absl::StatusOr<Mesh> Build(std::span<const Feature> features, const MeshOptions& options,
                           const BuildOptions& build) {
  const Interrupt interrupt = InterruptOf(build.interrupted);
  const std::uint64_t most = MostOperations(build.max_operations);
  ProgressMeter meter(build.progress);
  plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta =
      CheckFeatures(plc, features, options, build.valid.get(), meter, interrupt);
  if (absl::IsCancelled(delta.status())) return GivenUpError();
  if (!delta.ok()) return delta.status();
  const bool is_empty = features.empty();
  if (build.features_read) build.features_read();

  meter.Begin(ApplyProgress::Stage::kRefine);
  Steps steps(interrupt);
  DiffBuilder<D> diffs(options.kind);
  FeatureTable<D> table;
  table.SetFixed();
  Mesher<D> mesher(options, build, &diffs.triangulation());
  mesher.Add(*delta, table, steps);
  if (steps.stopped()) return GivenUpError();
  const auto work = [&] {
    return ProgressMeter::Work{mesher.executed(), mesher.executed() + mesher.waiting()};
  };
  bool is_interrupted = false;
  mesher.Run([&] {
    meter.Step(work);
    is_interrupted = interrupt();
    return is_interrupted || mesher.executed() > most ||
           IsOverLimits(mesher.result(), options.limits.max_vertices);
  });
  if (is_interrupted) return GivenUpError();
  absl::Status within = LimitsStatus(mesher.result(), options);
  if (within.ok() && mesher.executed() > most) within = WorkLimitError(most);
  if (!within.ok()) return NameFinestPlace(std::move(within), *delta, plc, options);
  meter.End(work().done);

  meter.Begin(ApplyProgress::Stage::kDiff);
  Mesh mesh = diffs.Begin(mesher.result(), table, steps);
  if (steps.stopped()) return GivenUpError();
  if (absl::Status status = diffs.RegionStatus(); !status.ok()) return status;
  if (absl::Status status = diffs.NameStatus(mesher.result(), table); !status.ok()) return status;
  mesh.revision = is_empty ? 0 : 1;
  meter.End();
  return mesh;
}

absl::Status SvrError(const std::string& message) {
  return MakeError(absl::StatusCode::kInvalidArgument,
                   text::Concat("engine: svr ", message, "; choose engine dynamic"),
                   {reason::kBadOption, {}, {}});
}

}  // namespace

template <int D>
absl::StatusOr<Mesh> BuildDelaunay(std::span<const Feature> features, const MeshOptions& options,
                                   const BuildOptions& build) {
  if (build.engine == BuildEngine::kSvr &&
      std::ranges::any_of(features, [](const Feature& f) { return f.unsplit; })) {
    return SvrError("splits every segment that is encroached upon: leave none unsplit");
  }
  return build.engine == BuildEngine::kSvr ? Build<D, SvrMesher>(features, options, build)
                                           : Build<D, DynamicMesher>(features, options, build);
}

absl::Status CheckSvrOptions(const MeshOptions& options) {
  if (options.kind != MeshKind::kDelaunay) return SvrError("makes meshes of kind delaunay only");
  if (options.criterion != Criterion::kEdge) return SvrError("has no criterion but edge");
  const double least = DefaultQuality(options.dimension);
  if (options.quality < least) {
    return SvrError(
        text::Concat("may refine without end at quality ", options.quality, ", below ", least));
  }
  if (options.min_dihedral != 0) return SvrError("leaves slivers: leave min_dihedral 0");
  return absl::OkStatus();
}

template absl::StatusOr<Mesh> BuildDelaunay<2>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);
template absl::StatusOr<Mesh> BuildDelaunay<3>(std::span<const Feature>, const MeshOptions&,
                                               const BuildOptions&);

}  // namespace dynmesh
