#include "client/cli/region_volumes.h"

#include <algorithm>
#include <array>
#include <vector>

#include "core/base/text.h"
#include "core/io/elements/size_limits.h"
#include "core/mesh_data/chambers.h"
#include "core/transfer/simplex.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

// The largest volume in each chamber of the mesh; 0: any.
absl::StatusOr<std::vector<double>> LimitsOf(const Mesh& mesh, const mesh_data::Chambers& chambers,
                                             const std::vector<const io::SeedRow*>& seeds,
                                             const std::string& file) {
  std::vector<std::array<double, 3>> positions;
  for (const io::SeedRow* const seed : seeds) positions.push_back(seed->position);
  const auto places = mesh_data::LocateInChambers(mesh, chambers, positions);
  std::vector<double> limits(chambers.count(), 0);
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i].is_between) {
      return absl::InvalidArgumentError(Concat(
          file, ":", seeds[i]->line, ": the place of a region is on a facet: move it to one side"));
    }
    const std::uint32_t c = places[i].chamber;
    const bool is_in = c != mesh_data::PlaceInChambers::kNone && !chambers.is_outside[c];
    if (is_in && limits[c] == 0) limits[c] = seeds[i]->more[1];
  }
  return limits;
}

}  // namespace

absl::StatusOr<Mesh> BuildWithinVolumes(const std::function<absl::StatusOr<Mesh>()>& build,
                                        Input& input) {
  std::vector<const io::SeedRow*> seeds;
  for (const io::SeedRow& row : input.regions) {
    if (row.more.size() > 1 && row.more[1] > 0) seeds.push_back(&row);
  }
  absl::StatusOr<Mesh> mesh = build();
  if (input.options.dimension != 3 || seeds.empty()) return mesh;
  FeatureId next_id = 0;
  for (const Feature& f : input.features) next_id = std::max(next_id, f.id);
  for (int round = 0; mesh.ok(); ++round) {
    const mesh_data::Chambers chambers = mesh_data::FindChambers(*mesh);
    const auto limits = LimitsOf(*mesh, chambers, seeds, input.seed_file);
    if (!limits.ok()) return limits.status();
    std::size_t added = 0;
    for (std::size_t i = 0; i < mesh->simplex_count(); ++i) {
      const double limit = (*limits)[chambers.of[i]];
      if (limit == 0) continue;
      transfer::Corners<3> corners;
      for (std::size_t k = 0; k < 4; ++k) {
        const auto row = static_cast<std::size_t>(chambers.corners[4 * i + k]);
        std::copy_n(&mesh->vertices.coordinates[3 * row], 3, corners[k].begin());
      }
      if (transfer::Measure<3>(corners) <= limit) continue;
      const io::InscribedBall ball = io::InscribedBallOf(corners);
      input.features.push_back(Feature::Size(
          ++next_id, ball.centre, {SizeShape::kDisc, io::TargetOfVolume(limit), ball.radius, {}}));
      ++added;
    }
    if (added == 0) return mesh;
    if (round == kMostVolumeRounds) {
      return absl::ResourceExhaustedError(
          Concat(input.seed_file, ": after ", round, " rounds ", added,
                 " tetrahedra are still larger than their region's volume; give --max-volume"));
    }
    mesh = build();
  }
  return mesh;
}

}  // namespace dynmesh::cli
