"""The protocol's messages, which protoc makes of proto/dynmesh/v1."""
