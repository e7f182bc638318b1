// The features of a mesh at a revision, as a server tells them.
#ifndef DYNMESH_CODEC_FEATURES_AT_H_
#define DYNMESH_CODEC_FEATURES_AT_H_

#include <cstdint>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::codec {

// What was put into a mesh until a revision.
struct FeaturesAt {
  std::uint64_t revision = 0;     // whose features these are
  MeshHash hash;                  // of the mesh with them
  std::vector<Feature> features;  // by id
};

}  // namespace dynmesh::codec

#endif  // DYNMESH_CODEC_FEATURES_AT_H_
