// Converts holes and regions of a .poly to polygons: the core has no seeds.
#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "client/cleaning/seed_faces.h"
#include "client/cli/input.h"
#include "core/base/text.h"
#include "core/io/elements/size_limits.h"

namespace dynmesh::cli {
namespace {

using text::Concat;

struct Seed {
  const char* kind;
  const io::SeedRow* row;
};

std::string WhereOf(const Input& input, const Seed& seed) {
  return Concat(input.seed_file, ":", seed.row->line);
}

}  // namespace

absl::Status AddSeedPolygons(Input& input) {
  std::vector<Seed> seeds;
  for (const io::SeedRow& row : input.holes) seeds.push_back({"hole", &row});
  for (const io::SeedRow& row : input.regions) seeds.push_back({"region", &row});
  if (seeds.empty() || input.options.dimension == 3) return absl::OkStatus();
  std::vector<cleaning::Point> positions;
  for (const Seed& seed : seeds) {
    positions.push_back({seed.row->position[0], seed.row->position[1]});
  }
  const std::vector<cleaning::SeedFace> faces = cleaning::FindSeedFaces(input.features, positions);
  FeatureId next_id = 0;
  for (const Feature& f : input.features) next_id = std::max(next_id, f.id);
  struct Limit {
    Rings rings;
    double target;
    std::string where;
  };
  std::vector<Limit> limits;
  auto lines = std::make_shared<std::map<FeatureId, std::string>>();
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    ++next_id;
    const std::string where = WhereOf(input, seeds[i]);
    const std::string start = Concat(where, ": the place of a ", seeds[i].kind);
    const bool is_guess = seeds[i].row->line == 0;  // a hole that may be none
    if (is_guess && (faces[i].same_as || faces[i].rings.empty())) continue;
    if (faces[i].on != kNoFeature) {
      return absl::InvalidArgumentError(
          Concat(start, " is on segment ", faces[i].on, ": move it to one side"));
    }
    if (faces[i].same_as) {
      const Seed& first = seeds[*faces[i].same_as];
      input.warnings.push_back(Concat(start, " is in the same face as the ", first.kind, " at ",
                                      WhereOf(input, first), ", and is ignored"));
    } else if (faces[i].rings.empty()) {
      input.warnings.push_back(Concat(start, " is outside everything, and is ignored"));
    } else {
      input.features.push_back(Feature::Polygon(next_id, faces[i].rings));
      if (i < input.holes.size()) input.hole_polygons.push_back(next_id);
      lines->emplace(next_id, where);
      if (seeds[i].row->more.size() > 1 && seeds[i].row->more[1] > 0) {
        limits.push_back({faces[i].rings, io::TargetOfArea(seeds[i].row->more[1]), where});
      }
    }
  }
  for (Limit& limit : limits) {
    input.features.push_back(Feature::SizePolygon(++next_id, std::move(limit.rings), limit.target));
    lines->emplace(next_id, limit.where);
  }
  input.where = [lines, others = std::move(input.where)](FeatureId id) {
    const auto it = lines->find(id);
    return it == lines->end() ? others(id) : it->second;
  };
  return absl::OkStatus();
}

}  // namespace dynmesh::cli
