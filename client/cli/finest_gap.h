// Where features are so near to each other that a mesh of them is too large.
#ifndef DYNMESH_CLIENT_CLI_FINEST_GAP_H_
#define DYNMESH_CLIENT_CLI_FINEST_GAP_H_

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/options.h"

namespace dynmesh::cli {

struct FinestGap {
  std::array<FeatureId, 2> features = {kNoFeature, kNoFeature};
  std::array<double, 3> place = {0, 0, 0};
  double distance = 0;   // of the two
  double vertices = 0;   // that all gaps cause, at least
  double tolerance = 0;  // of cleaning, that joins enough of the nearest features
};

// The gap that causes most vertices of a mesh with these options, if gaps cause a share of
// max_vertices at all. None if the features are refused, or of a quadtree. Expected O(n lg n).
std::optional<FinestGap> FindFinestGap(const std::vector<Feature>& features,
                                       const MeshOptions& options);

// "it is finest at (1, 2), where features 3 and 4 are 1.2e-07 apart (a.poly:7, a.poly:9)".
std::string TextOf(const FinestGap& gap, int dimension,
                   const std::function<std::string(FeatureId)>& where);
// "`dynmesh import INPUT --clean --tolerance 3e-07 ...` joins what is so near".
std::string AdviceFor(const FinestGap& gap);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_FINEST_GAP_H_
