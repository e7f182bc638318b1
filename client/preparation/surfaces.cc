// The public functions on surface files.
#include "dynmesh/surfaces.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "client/preparation/attempts.h"
#include "client/preparation/default_limit.h"
#include "client/preparation/prepare.h"
#include "core/io/api/file_input.h"
#include "core/io/formats/formats.h"

namespace dynmesh {
namespace {

// One of the surfaces that a file may become.
struct Surface : io::Geometry {
  std::optional<preparation::Report> preparation;
};

absl::StatusOr<Surface> Read(const std::string& path, const SurfaceChoices& choices) {
  io::GeometryOptions reading;
  reading.polygons = choices.polygons;
  reading.keep_facets = choices.keep_facets;
  absl::StatusOr<preparation::Prepared> prepared = preparation::Prepare(
      path, reading, {choices.within, choices.fill_holes, choices.mending_tolerance});
  if (!prepared.ok()) return prepared.status();
  return Surface{std::move(prepared->geometry), std::move(prepared->report)};
}

SurfaceReport ReportOf(preparation::Report report) {
  SurfaceReport told;
  told.larger_tolerance = preparation::LargerTolerance(report);
  told.seconds = report.seconds;
  told.mended = report.is_mended;
  told.thinned = report.is_thinned;
  told.found = std::move(report.found);
  told.unfilled = std::move(report.unfilled);
  told.within = report.within;
  told.tolerance = report.tolerance;
  told.farthest = report.farthest;
  told.least_tolerance = report.least_tolerance;
  told.triangles_read = report.triangles_read;
  told.triangles = report.triangles;
  told.open_edges_read = report.open_edges;
  told.open_edges = report.open_edges_after;
  for (preparation::OpenLoop& loop : report.open_loops) {
    told.open_loops.push_back({std::move(loop.corners), loop.length, loop.middle});
  }
  told.changes = std::move(report.changes);
  return told;
}

PreparedSurface PreparedOf(Surface surface) {
  SurfaceReport report = ReportOf(*std::move(surface.preparation));
  return {io::InputOf(std::move(surface)), std::move(report)};
}

}  // namespace

absl::StatusOr<PreparedSurface> PrepareSurface(const std::string& path,
                                               const SurfaceChoices& choices) {
  absl::StatusOr<Surface> surface = Read(path, choices);
  if (!surface.ok()) return surface.status();
  return PreparedOf(*std::move(surface));
}

absl::StatusOr<SurfaceMesh> BuildSurface(const std::string& path, const SurfaceChoices& choices,
                                         const BuildOptions& build) {
  absl::StatusOr<Surface> surface = Read(path, choices);
  if (!surface.ok()) return surface.status();
  SurfaceMesh result;
  absl::StatusOr<Mesh> mesh = Mesh();
  const auto make = [&](Surface& made_of, std::optional<std::uint64_t> most) {
    MeshOptions options = made_of.options;
    const std::uint64_t all = preparation::DefaultMostVertices(made_of.features, options);
    options.limits.max_vertices = std::min(all, most.value_or(all));
    BuildOptions how = build;
    how.valid = nullptr;
    if (made_of.verdict && made_of.verdict->ok()) how.valid = **made_of.verdict;
    mesh = BuildMesh(made_of.features, options, how);
    return mesh.status();
  };
  const auto prepare = [&](double tolerance) {
    SurfaceChoices larger = choices;
    larger.mending_tolerance = tolerance;
    return Read(path, larger);
  };
  const io::Format* const format = io::FindFormat(path);
  absl::Status made;
  if (format != nullptr && format->Is(io::kSurface)) {
    made = preparation::MakeOfSurface(*surface, make, prepare, [&](std::string why) {
      result.attempts.push_back(std::move(why));
    });
  } else {
    made = make(*surface, std::nullopt);
  }
  if (!made.ok()) return made;
  result.mesh = *std::move(mesh);
  result.surface = PreparedOf(*std::move(surface));
  return result;
}

}  // namespace dynmesh
