// Sparse Voronoi Refinement as BuildMesh: input checked, and the result reported, as of all meshes.
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "core/base/text.h"
#include "core/dynamic_mesh/build_mesh.h"
#include "core/dynamic_mesh/limits.h"
#include "core/dynamic_mesh/live_features.h"
#include "core/dynamic_mesh/vertex_id_error.h"
#include "core/dynamic_mesh/vertex_names.h"
#include "core/mesh_data/canonical_order.h"
#include "core/mesh_data/constraints.h"
#include "core/svr/svr.h"

namespace dynmesh {
namespace {

using geometry::Point;

absl::Status BadOption(std::string message, std::vector<FeatureId> features = {}) {
  return MakeError(absl::StatusCode::kInvalidArgument, std::move(message),
                   {reason::kBadOption, std::move(features), {}});
}

// Of features that SVR does not support.
template <int D>
absl::Status CheckFeatures(const plc::Delta<D>& delta) {
  const auto refuse = [](FeatureId id, const char* kind) {
    return BadOption(text::Concat("engine: svr is for points, and feature ", id, " is a ", kind,
                                  "; leave it out, or choose engine dynamic"),
                     {id});
  };
  if (!delta.added_polygons.empty()) return refuse(delta.added_polygons.front().id, "polygon");
  if (!delta.added_segments.empty()) return refuse(delta.added_segments.front().id, "segment");
  if (!delta.added_sizes.empty()) return refuse(delta.added_sizes.front().id, "sizing feature");
  return absl::OkStatus();
}

template <int D>
svr::Options<D> SvrOptionsOf(const MeshOptions& options) {
  svr::Options<D> of;
  const Box domain = DomainBox(options);
  for (int k = 0; k < D; ++k) of.lo[k] = domain.lo[k], of.hi[k] = domain.hi[k];
  of.border_cells = BorderVertices(options) - 1;
  of.quality = options.quality;
  return of;
}

// The result as columns.
template <int D>
class Reporter {
 public:
  Reporter(const svr::Svr<D>& svr, const std::vector<plc::PointFeature<D>>& points)
      : svr_(svr), by_position_(points) {
    std::sort(by_position_.begin(), by_position_.end(),
              [](const auto& a, const auto& b) { return a.p < b.p; });
  }

  absl::StatusOr<Mesh> Run(Steps& steps) {
    const auto& mesh = svr_.mesh();
    const auto position = [&](std::uint32_t v) -> const Point<D>& { return mesh.position(v); };
    std::vector<std::uint32_t> vertices(mesh.vertex_count());
    std::iota(vertices.begin(), vertices.end(), 0);
    names_.Reserve(vertices.size());
    names_.AddAll(vertices, position);
    if (const auto clash = names_.Clash(position)) {
      std::array<NamedVertex, 2> named;
      for (std::size_t i = 0; i < 2; ++i) {
        const Point<D>& p = position((*clash)[i]);
        named[i] = {{p.c.begin(), p.c.end()}, OwnerOf((*clash)[i])};
      }
      return VertexIdError(named);
    }
    mesh_.dimension = D;
    for (const std::uint32_t v : vertices) {
      if (steps.Stop()) return GivenUpError();
      ReportVertex(v);
    }
    mesh.ForEachSimplex([&](std::uint32_t s) {
      if (!steps.Stop()) ReportSimplex(s);
    });
    if (steps.stopped()) return GivenUpError();
    if constexpr (D == 2) ReportBorder();
    return std::move(mesh_);
  }

 private:
  bool IsOfBorder(std::uint32_t v) const { return v < svr_.border_count(); }
  FeatureId OwnerOf(std::uint32_t v) const {
    if (IsOfBorder(v)) return kBoxFeature;
    if (svr_.InputOf(v) == svr::kNone) return kNoFeature;
    const Point<D>& p = svr_.mesh().position(v);
    return std::lower_bound(by_position_.begin(), by_position_.end(), p,
                            [](const auto& a, const Point<D>& b) { return a.p < b; })
        ->id;
  }

  void ReportVertex(std::uint32_t v) {
    VertexColumns& to = mesh_.vertices;
    const Point<D>& p = svr_.mesh().position(v);
    const FeatureId owner = OwnerOf(v);
    const int dimension = owner == kNoFeature ? D : 0;
    to.ids.push_back(names_.at(v));
    to.coordinates.insert(to.coordinates.end(), p.c.begin(), p.c.end());
    to.containing_dimensions.push_back(static_cast<std::uint8_t>(dimension));
    to.owners.push_back(owner);
    mesh_.hash += HashVertex(p.c.data(), D, dimension, owner);
  }
  void ReportSimplex(std::uint32_t s) {
    std::array<VertexId, D + 1> ids;
    for (std::size_t i = 0; i <= D; ++i) ids[i] = names_.at(svr_.mesh().vertices(s)[i]);
    ids = mesh_data::InCanonicalOrder(ids);
    mesh_.simplices.insert(mesh_.simplices.end(), ids.begin(), ids.end());
    mesh_.hash += HashSimplex(ids.data(), D + 1);
  }
  // The sides of the square, between neighbours of its grid.
  void ReportBorder() {
    const std::vector<std::uint32_t> around = svr_.BorderAround();
    for (std::size_t i = 0; i < around.size(); ++i) {
      mesh_data::ConstraintRow<2> row = {names_.at(around[i]),
                                         names_.at(around[(i + 1) % around.size()]), kBoxFeature};
      std::sort(row.begin(), row.end() - 1);
      mesh_data::Append(mesh_.subsegments, row);
      mesh_.hash += mesh_data::HashOf(row);
    }
  }

  const svr::Svr<D>& svr_;
  std::vector<plc::PointFeature<D>> by_position_;
  VertexNames<D> names_;
  Mesh mesh_;
};

}  // namespace

absl::Status CheckSvrOptions(const MeshOptions& options) {
  const char* const instead = "; choose engine dynamic";
  if (options.kind != MeshKind::kDelaunay) {
    return BadOption(text::Concat("engine: svr makes no quadtrees", instead));
  }
  if (options.criterion != Criterion::kEdge) {
    return BadOption(text::Concat("engine: svr has no criterion but edge", instead));
  }
  const double least = options.dimension == 2 ? kDefaultQuality2D : kDefaultQuality3D;
  if (options.quality < least) {
    return BadOption(text::Concat("engine: svr may refine without end at quality ", options.quality,
                                  ", below ", least, instead));
  }
  if (options.max_edge != 0) {
    return BadOption(text::Concat("engine: svr has no max_edge yet", instead));
  }
  if (options.min_dihedral != 0) {
    return BadOption(
        text::Concat("engine: svr leaves slivers; leave min_dihedral 0, or choose "
                     "engine dynamic"));
  }
  return absl::OkStatus();
}

template <int D>
absl::StatusOr<Mesh> BuildBySvr(std::span<const Feature> features, const MeshOptions& options,
                                const BuildOptions& build) {
  const Interrupt interrupt = InterruptOf(build.interrupted);
  const std::uint64_t most = MostOperations(build.max_operations);
  ProgressMeter meter(build.progress);
  const plc::Plc<D> plc(options);
  const absl::StatusOr<plc::Delta<D>> delta =
      CheckBatch(plc, plc::Edits::Adding(features), options, meter, interrupt);
  if (absl::IsCancelled(delta.status())) return GivenUpError();
  if (!delta.ok()) return delta.status();
  if (absl::Status status = CheckFeatures(*delta); !status.ok()) return status;

  meter.Begin(ApplyProgress::Stage::kRefine);
  std::vector<Point<D>> points;
  for (const plc::PointFeature<D>& p : delta->added_points) points.push_back(p.p);
  svr::Svr<D> svr(SvrOptionsOf<D>(options), std::move(points));
  std::uint64_t taken = 0;
  const auto work = [&] { return ProgressMeter::Work{taken, taken + svr.waiting()}; };
  enum class Stop { kNot, kCancelled, kOverWork, kOverLimit } stop = Stop::kNot;
  svr.Run([&] {
    meter.Step(work);
    stop = interrupt()                                               ? Stop::kCancelled
           : svr.mesh().vertex_count() > options.limits.max_vertices ? Stop::kOverLimit
           : taken >= most                                           ? Stop::kOverWork
                                                                     : Stop::kNot;
    ++taken;
    return stop != Stop::kNot;
  });
  if (stop == Stop::kCancelled) return GivenUpError();
  if (svr.mesh().vertex_count() > options.limits.max_vertices) return VertexLimitError(options);
  if (stop == Stop::kOverWork) return WorkLimitError(most);
  meter.End(taken);

  meter.Begin(ApplyProgress::Stage::kDiff);
  Steps steps(interrupt);
  absl::StatusOr<Mesh> mesh = Reporter<D>(svr, delta->added_points).Run(steps);
  if (!mesh.ok()) return mesh;
  mesh->revision = features.empty() ? 0 : 1;
  meter.End();
  return mesh;
}

template absl::StatusOr<Mesh> BuildBySvr<2>(std::span<const Feature>, const MeshOptions&,
                                            const BuildOptions&);
template absl::StatusOr<Mesh> BuildBySvr<3>(std::span<const Feature>, const MeshOptions&,
                                            const BuildOptions&);

}  // namespace dynmesh
