// Maps the edits of a load's batch, or the features of a build, to the messages, so that an error
// names the path in the request instead of the index in the batch. 24 bytes per message. Not
// thread-safe.
#ifndef DYNMESH_SERVER_CALLS_LOAD_PARTS_H_
#define DYNMESH_SERVER_CALLS_LOAD_PARTS_H_

#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::server {

class LoadParts {
 public:
  // Adds the stream's next message, a LoadFeaturesRequest or BuildMeshRequest. Its edits begin at
  // index `first` of the batch.
  template <typename Message>
  void Add(const Message& message, std::size_t first) {
    Add(first, static_cast<std::size_t>(message.points().ids_size()),
        static_cast<std::size_t>(message.features_size()));
  }

  // If `status` is about an edit: the same with the field "points.ids[9]" or "features[9]", and in
  // the metadata "message" the index of the stream's message. Else `status` unchanged.
  absl::Status Locate(const absl::Status& status) const;

 private:
  void Add(std::size_t first, std::size_t points, std::size_t features);

  struct Part {
    std::size_t message;
    std::size_t first;   // index of its first edit
    std::size_t points;  // edits from columns; features follow
  };
  std::size_t messages_ = 0;
  std::vector<Part> parts_;  // messages with edits, by `first`
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_LOAD_PARTS_H_
