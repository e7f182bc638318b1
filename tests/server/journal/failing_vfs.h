// SQLite's files on a disk with scripted failures: counts writes, syncs and truncations of all
// files opened through it; one of them, or all from one on, fail. Or each sync hangs. Thread-safe.
#ifndef DYNMESH_TESTS_SERVER_JOURNAL_FAILING_VFS_H_
#define DYNMESH_TESTS_SERVER_JOURNAL_FAILING_VFS_H_

#include <sqlite3.h>

namespace dynmesh::server {

class FailingVfs {
 public:
  // The one, registered with SQLite on first use.
  static const char* Name();

  // The operation number `at` (1 is the next) fails, and with `ever` all after it. Writes fail with
  // `write_error` after half of their bytes were written, syncs with SQLITE_IOERR_FSYNC.
  static void FailAt(int at, bool ever, int write_error = SQLITE_FULL);
  // From the next sync on each one waits for Heal, and then succeeds.
  static void HoldSyncs();
  static void Heal();
  static int failures();  // since FailAt
  static int held();      // syncs that wait
};

}  // namespace dynmesh::server

#endif  // DYNMESH_TESTS_SERVER_JOURNAL_FAILING_VFS_H_
