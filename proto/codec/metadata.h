// Metadata of calls that clients and servers agree on.
#ifndef DYNMESH_PROTO_CODEC_METADATA_H_
#define DYNMESH_PROTO_CODEC_METADATA_H_

namespace dynmesh::codec {

// Sent by a client that follows NOT_OWNER: how often it was sent on with this call, in decimal.
inline constexpr char kRedirectsKey[] = "dynmesh-redirects";

}  // namespace dynmesh::codec

#endif  // DYNMESH_PROTO_CODEC_METADATA_H_
