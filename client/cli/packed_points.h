// Points without labels take a fifth of their memory while a mesh is made of them.
// Thread-compatible.
#ifndef DYNMESH_CLIENT_CLI_PACKED_POINTS_H_
#define DYNMESH_CLIENT_CLI_PACKED_POINTS_H_

#include <array>
#include <utility>
#include <vector>

#include "dynmesh/feature.h"

namespace dynmesh::cli {

class PackedPoints {
 public:
  // Takes `features` if they are many and nothing but points without labels: they are empty then.
  void Pack(std::vector<Feature>& features);
  // Puts them back, if they were taken.
  void Unpack(std::vector<Feature>& features);

 private:
  std::vector<std::pair<FeatureId, std::array<double, 3>>> points_;
};

}  // namespace dynmesh::cli

#endif  // DYNMESH_CLIENT_CLI_PACKED_POINTS_H_
