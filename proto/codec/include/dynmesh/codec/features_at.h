// The features of a mesh at a revision, as returned by MeshClient::GetFeatures.
//
//   auto at = client->GetFeatures("plate", 7);
//   auto mesh = dynmesh::BuildMesh(at->features, options);  // if at.ok()
#ifndef DYNMESH_CODEC_FEATURES_AT_H_
#define DYNMESH_CODEC_FEATURES_AT_H_

#include <cstdint>
#include <vector>

#include "dynmesh/feature.h"
#include "dynmesh/mesh.h"

namespace dynmesh::codec {

// The feature set of a mesh at a revision.
struct FeaturesAt {
  std::uint64_t revision = 0;     // the revision of the features
  MeshHash hash;                  // of the mesh at that revision
  std::vector<Feature> features;  // by id
};

}  // namespace dynmesh::codec

#endif  // DYNMESH_CODEC_FEATURES_AT_H_
