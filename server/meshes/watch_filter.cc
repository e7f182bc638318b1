#include "server/meshes/watch_filter.h"

#include <memory>
#include <variant>

namespace dynmesh::server {

WatchItem WatchFilter::Apply(const WatchItem& item) {
  if (const auto* mesh = std::get_if<std::shared_ptr<const Mesh>>(&item)) {
    auto part = std::make_shared<const Mesh>(mesh_data::SimplicesInside(**mesh, choice_));
    hidden_ = (*mesh)->hash;
    hidden_ -= part->hash;
    return part;
  }
  if (const auto* diff = std::get_if<std::shared_ptr<const MeshDiff>>(&item)) {
    return std::make_shared<const MeshDiff>(mesh_data::SimplicesInside(**diff, choice_, hidden_));
  }
  if (const auto* head = std::get_if<Head>(&item)) {
    Head part = *head;
    part.hash -= hidden_;
    return part;
  }
  return item;
}

}  // namespace dynmesh::server
