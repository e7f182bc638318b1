// Figures that are computed per request: of each mesh, of the journal, of the process. Thread-safe;
// O(meshes).
#ifndef DYNMESH_SERVER_COLLECT_H_
#define DYNMESH_SERVER_COLLECT_H_

#include "absl/time/time.h"
#include "server/access/client_quotas.h"
#include "server/access/connection_table.h"
#include "server/access/tls.h"
#include "server/base/memory_guard.h"
#include "server/cluster/lease_keeper.h"
#include "server/http/http_server.h"
#include "server/journal/journal.h"
#include "server/meshes/mesh_registry.h"
#include "server/metrics/metrics.h"

namespace dynmesh::server {

void WriteMeshes(const MeshRegistry& meshes, MetricsText& out);
void WriteJournal(const Journal& journal, MetricsText& out);
// Of a server that shares the journal's meshes with others: its leases, of that length, and epochs.
void WriteNode(const MeshRegistry& meshes, const LeaseKeeper& keeper, absl::Duration lease,
               MetricsText& out);
// The memory limit, and the end of the certificate, if there is one.
void WriteLimits(const MemoryGuard& memory, const TlsFiles& tls, MetricsText& out);
// The number of clients' open streams, and its limit.
void WriteStreams(const ClientQuotas& streams, MetricsText& out);
// Connections, and what their addresses' limits did.
void WriteConnections(const ConnectionTable::Counts& counts, MetricsText& out);
void WriteHttp(const HttpServer::Counts& counts, MetricsText& out);
// Figures from /proc, and the version of dynmeshd.
void WriteProcess(MetricsText& out);

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_COLLECT_H_
