// Filters a watch by polygons: of each item of the subscription, the part inside them, with that
// part's hash.
//
// Invariant: hidden_ is the sum of the hashes of the simplices left out of the watcher's mesh. The
// first item is a snapshot. Thread-compatible.
#ifndef DYNMESH_SERVER_MESHES_WATCH_FILTER_H_
#define DYNMESH_SERVER_MESHES_WATCH_FILTER_H_

#include <utility>

#include "core/mesh_data/region_filter.h"
#include "dynmesh/mesh.h"
#include "server/meshes/watch_hub.h"

namespace dynmesh::server {

class WatchFilter {
 public:
  explicit WatchFilter(mesh_data::RegionChoice choice) : choice_(std::move(choice)) {}

  // To be called with the items in order. O(item): a mesh is copied.
  WatchItem Apply(const WatchItem& item);

 private:
  const mesh_data::RegionChoice choice_;
  MeshHash hidden_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_WATCH_FILTER_H_
