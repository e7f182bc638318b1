// What a watcher gets who asked for some polygons only: of each item of its subscription
// the part inside, with the hash of that part.
//
// Invariant: hidden_ is the sum of the hashes of the simplices that were left out of the mesh
// which the watcher has. Begins with a snapshot. Thread-compatible.
#ifndef DYNMESH_SERVER_MESHES_WATCH_FILTER_H_
#define DYNMESH_SERVER_MESHES_WATCH_FILTER_H_

#include <utility>

#include "core/data/region_filter.h"
#include "dynmesh/mesh.h"
#include "server/meshes/watch_hub.h"

namespace dynmesh::server {

class WatchFilter {
 public:
  explicit WatchFilter(data::RegionChoice choice) : choice_(std::move(choice)) {}

  // Items in the order in which they are sent. O(item): a mesh is copied.
  WatchItem Apply(const WatchItem& item);

 private:
  const data::RegionChoice choice_;
  MeshHash hidden_;
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_MESHES_WATCH_FILTER_H_
