// Options, features and edits between wire and library. Pure, thread-safe.
//
// Decoding checks only what the wire form can get wrong (a missing geometry, a z in
// the plane); whether features are legal is the library's business. Errors name the
// feature and the edit's index.
#ifndef DYNMESH_PROTO_CODEC_EDIT_CODEC_H_
#define DYNMESH_PROTO_CODEC_EDIT_CODEC_H_

#include <cstddef>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "dynmesh/feature.h"
#include "dynmesh/options.h"
#include "dynmesh/v1/geometry.pb.h"
#include "dynmesh/v1/mesh.pb.h"

namespace dynmesh::codec {

// Zeros become defaults; `max_vertices` is the default and the most of that limit. If it is the
// greatest number, `proto` is what was accepted once: then a limit above MostVertices becomes that.
// INVALID_ARGUMENT naming the field if no mesh can be made with them.
absl::StatusOr<MeshOptions> DecodeOptions(const v1::MeshOptions& proto, std::uint64_t max_vertices);
void EncodeOptions(const MeshOptions& options, v1::MeshOptions* out);

// Appends the decoded edits to `out`, whose size is the index of the first in its
// batch. On an error `out` is unspecified.
absl::Status DecodeEdits(const google::protobuf::RepeatedPtrField<v1::Edit>& proto, int dimension,
                         EditBatch* out);
// Features to add, as edits.
absl::Status DecodeAdds(const google::protobuf::RepeatedPtrField<v1::Feature>& proto, int dimension,
                        EditBatch* out);

// Points to add, as edits. INVALID_ARGUMENT (BAD_REQUEST or WRONG_DIMENSION) if there are not
// `dimension` coordinates for each id.
absl::Status DecodePointColumns(const v1::PointColumns& proto, int dimension, EditBatch* out);
// A row more of `out`.
void EncodePointRow(const Feature& point, int dimension, v1::PointColumns* out);

// What edits or features weigh in limits: one each, and one for 8 points of polygons, of which a
// ring counts as 3 more.
std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Edit>& proto);
std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Feature>& proto);
std::size_t Weight(const EditBatch& edits);

void EncodeFeature(const Feature& feature, int dimension, v1::Feature* out);
void EncodeEdit(const Edit& edit, int dimension, v1::Edit* out);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_EDIT_CODEC_H_
