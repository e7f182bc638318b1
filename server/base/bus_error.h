// Tells, before the process ends, that a file was cut while it is mapped into memory (SIGBUS).
// SQLite maps the index of its log, `-shm`, which is shared with other processes that read the
// journal; the system maps programs and libraries. Such an access cannot go on, and what was
// acknowledged is on the disk; so the process ends as it would without this, by the signal.
#ifndef DYNMESH_SERVER_BASE_BUS_ERROR_H_
#define DYNMESH_SERVER_BASE_BUS_ERROR_H_

namespace dynmesh::server {

// For the whole process. Logs `mapped_file_cut`, level error, with the file's name.
void TellBusErrors();

}  // namespace dynmesh::server

#endif  // DYNMESH_SERVER_BASE_BUS_ERROR_H_
