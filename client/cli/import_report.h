// What `dynmesh import` reports of maps and surfaces alike: changes, and a summary.
#ifndef DYNMESH_CLIENT_CLI_IMPORT_REPORT_H_
#define DYNMESH_CLIENT_CLI_IMPORT_REPORT_H_

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "client/cli/json.h"
#include "core/io/formats/geometry.h"
#include "core/io/maps/mended_rings.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

// The tolerance of cleaning: `given`, or the default. Both limits are in units of the distance
// below which a mesh with these options refuses features as too close. INVALID_ARGUMENT for bad
// options, or a tolerance that is not finite or below the least one.
absl::StatusOr<double> ToleranceOf(std::optional<double> given, const MeshOptions& options,
                                   double default_limits, double least_limits);

// INVALID_ARGUMENT, naming -o, unless features of this dimension are written to such a path.
absl::Status CheckOutput(int dimension, const std::string& path);

// A change as a line of JSON. `from` and `to` have as many coordinates as dimensions.
std::string ChangeLine(const char* name, const std::vector<FeatureId>& ids,
                       std::span<const double> from, std::span<const double> to);

// NameOf each of the first `kinds`, for ImportSummary.
template <class Kind>
std::vector<std::string> NamesOf(int kinds) {
  std::vector<std::string> names;
  for (int k = 0; k < kinds; ++k) names.emplace_back(NameOf(static_cast<Kind>(k)));
  return names;
}

class ImportSummary {
 public:
  // Features by kind, before and after.
  void AddCounts(const std::vector<Feature>& before, const std::vector<Feature>& after);
  // The input was cleaned. Changes are counted under `names`, by their kind.
  void AddCleaning(std::vector<std::string> names, double tolerance, int rounds, double seconds);
  // Rings of a map that were mended when it was read.
  void AddRings(const io::MendedRings& rings) { rings_ = rings; }
  // Faces of a surface file were joined when it was read.
  void AddSurface(const io::SurfaceCounts& surface) { surface_ = surface; }
  // `step`: how far something moved.
  void AddChange(std::size_t kind, double step);

  bool is_cleaned() const { return !changes_.empty(); }
  JsonObject ToJson() const;
  std::string ToText() const;  // lines

 private:
  struct Count {
    const char* what;
    std::size_t before, after;
  };
  struct Changes {
    std::string name;
    std::size_t count = 0;
  };

  std::vector<Count> counts_;
  std::vector<Changes> changes_;  // by kind
  io::MendedRings rings_;
  std::optional<io::SurfaceCounts> surface_;
  double largest_step_ = 0;
  double tolerance_ = 0;
  int rounds_ = 0;
  double seconds_ = 0;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_IMPORT_REPORT_H_
