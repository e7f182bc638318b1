// The same mesh on a server: ADDRESS. Prints the hash that a watcher's replica has.
#include <cstdint>
#include <cstdio>

#include "dynmesh/client/mesh_client.h"
#include "dynmesh/codec/service_error.h"
#include "plate.h"

int main(int count, char** arguments) {
  if (count != 2) return 2;
  const auto client = dynmesh::client::MeshClient::Connect(arguments[1]);
  const auto missing = client->GetMesh("plate");
  const auto error = dynmesh::codec::GetServiceError(missing.status());
  if (!error.has_value() || error->reason != dynmesh::codec::reason::kMeshNotFound) return 3;
  if (!client->CreateMesh("plate", PlateOptions()).ok()) return 1;
  const auto watch = client->Watch("plate", {}, nullptr);
  std::uint64_t revision = 0;
  for (const dynmesh::EditBatch& batch : {Plate(), Cut()}) {
    const auto result = client->Apply("plate", batch);
    if (!result.ok()) return std::puts(result.status().ToString().c_str()), 1;
    revision = result->diff.to_revision;
  }
  if (!watch->WaitForRevision(revision, absl::Seconds(20))) return 4;
  watch->Read([](const dynmesh::client::MeshReplica& replica) {
    std::printf("%s\n", replica.hash().ToHex().c_str());
  });
}
