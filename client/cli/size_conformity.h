// How well a mesh conforms to the sizes of its input: the local feature size at its vertices over
// the distance of each to its nearest neighbour (the local mesh size there). Small numbers: few
// vertices too many. Pure.
#ifndef DYNMESH_CLIENT_CLI_SIZE_CONFORMITY_H_
#define DYNMESH_CLIENT_CLI_SIZE_CONFORMITY_H_

#include <string>
#include <vector>

#include "client/cli/json.h"
#include "core/io/meshes/indexed_mesh.h"
#include "dynmesh/feature.h"

namespace dynmesh::cli {

// Of lfs / lms, over all vertices; NaN if no two features are disjoint.
struct SizeConformity {
  double least = 0, median = 0, p90 = 0, p99 = 0, greatest = 0;
};

// `features`: the input of `mesh`. Expected O(n lg n).
SizeConformity MeasureConformity(const io::IndexedMesh& mesh, const std::vector<Feature>& features);

// A line of text; a JSON object: min, p50, p90, p99, max.
std::string ConformityText(const SizeConformity& conformity);
JsonObject ConformityJson(const SizeConformity& conformity);

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_SIZE_CONFORMITY_H_
