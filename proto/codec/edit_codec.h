// Options, features and edits: messages <-> library types. Pure, thread-safe.
//
// Decoding checks only errors of the message's form (a missing geometry, a z in 2D). The library
// checks whether features are legal. Errors name the feature and the edit's index.
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

// Zeros become defaults. `max_vertices` is the default and the maximum of that limit. If it is the
// greatest number, `proto` was accepted before: then a limit above MostVertices becomes
// MostVertices. INVALID_ARGUMENT, naming the field, for options of which no mesh can be made.
absl::StatusOr<MeshOptions> DecodeOptions(const v1::MeshOptions& proto, std::uint64_t max_vertices);
void EncodeOptions(const MeshOptions& options, v1::MeshOptions* out);

// Appends the decoded edits to `out`; the first gets the index out->size(). On an error `out` is
// unspecified.
absl::Status DecodeEdits(const google::protobuf::RepeatedPtrField<v1::Edit>& proto, int dimension,
                         EditBatch* out);
// Decodes features as edits that add them.
absl::Status DecodeAdds(const google::protobuf::RepeatedPtrField<v1::Feature>& proto, int dimension,
                        EditBatch* out);

// Decodes points as edits that add them. INVALID_ARGUMENT (BAD_REQUEST or WRONG_DIMENSION) unless
// there are `dimension` coordinates for each id.
absl::Status DecodePointColumns(const v1::PointColumns& proto, int dimension, EditBatch* out);
// Appends a row to `out`.
void EncodePointRow(const Feature& point, int dimension, v1::PointColumns* out);

// Weight of edits or features for limits: 1 each, plus 1 for 8 points of polygons; each ring counts
// as 3 more points, a label as 5 and one for 8 bytes of its name.
std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Edit>& proto);
std::size_t Weight(const google::protobuf::RepeatedPtrField<v1::Feature>& proto);
std::size_t Weight(const EditBatch& edits);

void EncodeFeature(const Feature& feature, int dimension, v1::Feature* out);
void EncodeEdit(const Edit& edit, int dimension, v1::Edit* out);

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_EDIT_CODEC_H_
