// Which message of a load brought which edits of its batch, so that an error names what is wrong by
// its path in the request and not by its index in the batch. 24 bytes a message. Not thread-safe.
#ifndef DYNMESH_SERVER_CALLS_LOAD_PIECES_H_
#define DYNMESH_SERVER_CALLS_LOAD_PIECES_H_

#include <cstddef>
#include <vector>

#include "absl/status/status.h"
#include "dynmesh/v1/mesh_service.pb.h"

namespace dynmesh::server {

class LoadPieces {
 public:
  // The stream's next message, whose edits begin at `first` in the batch.
  void Add(const v1::LoadFeaturesRequest& message, std::size_t first);

  // `status` with the field "points.ids[9]" or "features[9]", and in metadata "message" the index
  // of the stream's message that has it, if it blames an edit; else as it is.
  absl::Status Locate(const absl::Status& status) const;

 private:
  struct Piece {
    std::size_t message;
    std::size_t first;   // edit
    std::size_t points;  // edits from columns; features follow
  };
  std::size_t messages_ = 0;
  std::vector<Piece> pieces_;  // those that brought something, by `first`
};

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_CALLS_LOAD_PIECES_H_
