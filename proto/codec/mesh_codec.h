// Meshes and diffs: messages <-> library types, in fragments below 1 MB.
//
// A Fragmenter shares a value and cuts it into messages, one at a time, so that a slow receiver
// costs the memory of one message, not of a second mesh. An Assembler joins the messages and
// validates all of them. Thread-compatible.
#ifndef DYNMESH_PROTO_CODEC_MESH_CODEC_H_
#define DYNMESH_PROTO_CODEC_MESH_CODEC_H_

#include <cstddef>
#include <memory>
#include <optional>

#include "absl/status/statusor.h"
#include "absl/time/time.h"
#include "dynmesh/mesh.h"
#include "dynmesh/v1/mesh.pb.h"

namespace dynmesh::codec {

// Size limit of a fragment's columns, by an estimate per row that is never too low. Real messages
// have 70 to 100 % of it.
inline constexpr std::size_t kFragmentBytes = 640'000;

void EncodeWork(const WorkCounters& work, v1::WorkCounters* out);
WorkCounters DecodeWork(const v1::WorkCounters& work);
void EncodeTime(absl::Time time, google::protobuf::Timestamp* out);

class DiffFragmenter {
 public:
  // With `omit_columns` there is one fragment, with revisions, work and hash.
  explicit DiffFragmenter(std::shared_ptr<const MeshDiff> diff, bool omit_columns = false,
                          std::size_t fragment_bytes = kFragmentBytes);

  // Fills `out` (cleared first) with the next fragment. False if none is left.
  bool Next(v1::MeshDiff* out);
  bool done() const { return done_; }

 private:
  std::shared_ptr<const MeshDiff> diff_;
  std::size_t fragment_bytes_;
  bool omit_columns_;
  bool done_ = false;
  std::size_t section_ = 0;  // index of the current column
  std::size_t row_ = 0;      // its first row not sent
};

class SnapshotFragmenter {
 public:
  explicit SnapshotFragmenter(std::shared_ptr<const Mesh> mesh,
                              std::size_t fragment_bytes = kFragmentBytes);
  bool Next(v1::SnapshotChunk* out);
  bool done() const { return done_; }

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::size_t fragment_bytes_;
  bool done_ = false;
  std::uint32_t index_ = 0;
  std::size_t section_ = 0;
  std::size_t row_ = 0;
};

class DiffAssembler {
 public:
  // The whole diff after its last fragment, nullopt before. DATA_LOSS if the fragments do not fit
  // together; then the assembler is empty again.
  absl::StatusOr<std::optional<MeshDiff>> Add(const v1::MeshDiff& fragment);
  bool empty() const { return !diff_.has_value(); }
  void Reset() { diff_.reset(); }

 private:
  std::optional<MeshDiff> diff_;
};

class SnapshotAssembler {
 public:
  // As DiffAssembler::Add. A chunk with index 0 begins a new mesh.
  absl::StatusOr<std::optional<Mesh>> Add(const v1::SnapshotChunk& chunk);
  bool empty() const { return !mesh_.has_value(); }
  void Reset() { mesh_.reset(); }

 private:
  std::optional<Mesh> mesh_;
  std::uint32_t next_index_ = 0;
};

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_MESH_CODEC_H_
