#include "tests/server/journal/failing_vfs.h"

#include <condition_variable>
#include <mutex>

namespace dynmesh::server {
namespace {

struct Plan {
  std::mutex mutex;
  bool armed = false;
  bool ever = false;
  int left = 0;  // operations until the one that fails
  int write_error = SQLITE_FULL;
  int failures = 0;
  bool holds = false;
  int held = 0;
  std::condition_variable healed;
};
Plan plan;

void WaitIfHeld() {
  std::unique_lock lock(plan.mutex);
  if (!plan.holds) return;
  ++plan.held;
  plan.healed.wait(lock, [] { return !plan.holds; });
  --plan.held;
}

// Should this operation fail?
bool Strikes() {
  const std::lock_guard lock(plan.mutex);
  if (!plan.armed) return false;
  if (plan.left > 0) --plan.left;
  if (plan.left > 0) return false;
  if (!plan.ever) plan.armed = false;
  ++plan.failures;
  return true;
}

// The real file follows it in memory.
struct File {
  sqlite3_file base;
};
sqlite3_file* Real(sqlite3_file* file) {
  return reinterpret_cast<sqlite3_file*>(reinterpret_cast<File*>(file) + 1);
}

int Close(sqlite3_file* f) { return Real(f)->pMethods->xClose(Real(f)); }
int Read(sqlite3_file* f, void* to, int n, sqlite3_int64 at) {
  return Real(f)->pMethods->xRead(Real(f), to, n, at);
}
int Write(sqlite3_file* f, const void* from, int n, sqlite3_int64 at) {
  if (!Strikes()) return Real(f)->pMethods->xWrite(Real(f), from, n, at);
  Real(f)->pMethods->xWrite(Real(f), from, n / 2, at);
  return plan.write_error;
}
int Truncate(sqlite3_file* f, sqlite3_int64 size) {
  return Strikes() ? SQLITE_IOERR_TRUNCATE : Real(f)->pMethods->xTruncate(Real(f), size);
}
int Sync(sqlite3_file* f, int flags) {
  WaitIfHeld();
  return Strikes() ? SQLITE_IOERR_FSYNC : Real(f)->pMethods->xSync(Real(f), flags);
}
int FileSize(sqlite3_file* f, sqlite3_int64* size) {
  return Real(f)->pMethods->xFileSize(Real(f), size);
}
int Lock(sqlite3_file* f, int level) { return Real(f)->pMethods->xLock(Real(f), level); }
int Unlock(sqlite3_file* f, int level) { return Real(f)->pMethods->xUnlock(Real(f), level); }
int CheckReservedLock(sqlite3_file* f, int* result) {
  return Real(f)->pMethods->xCheckReservedLock(Real(f), result);
}
int FileControl(sqlite3_file* f, int op, void* arg) {
  return Real(f)->pMethods->xFileControl(Real(f), op, arg);
}
int SectorSize(sqlite3_file* f) { return Real(f)->pMethods->xSectorSize(Real(f)); }
int DeviceCharacteristics(sqlite3_file* f) {
  return Real(f)->pMethods->xDeviceCharacteristics(Real(f));
}
int ShmMap(sqlite3_file* f, int page, int size, int extend, void volatile** to) {
  return Real(f)->pMethods->xShmMap(Real(f), page, size, extend, to);
}
int ShmLock(sqlite3_file* f, int offset, int n, int flags) {
  return Real(f)->pMethods->xShmLock(Real(f), offset, n, flags);
}
void ShmBarrier(sqlite3_file* f) { Real(f)->pMethods->xShmBarrier(Real(f)); }
int ShmUnmap(sqlite3_file* f, int remove) { return Real(f)->pMethods->xShmUnmap(Real(f), remove); }

sqlite3_io_methods MakeMethods() {
  sqlite3_io_methods m = {};
  m.iVersion = 2;  // no memory mapped reads: all goes through here
  m.xClose = Close, m.xRead = Read, m.xWrite = Write, m.xTruncate = Truncate, m.xSync = Sync;
  m.xFileSize = FileSize, m.xLock = Lock, m.xUnlock = Unlock;
  m.xCheckReservedLock = CheckReservedLock, m.xFileControl = FileControl;
  m.xSectorSize = SectorSize, m.xDeviceCharacteristics = DeviceCharacteristics;
  m.xShmMap = ShmMap, m.xShmLock = ShmLock, m.xShmBarrier = ShmBarrier, m.xShmUnmap = ShmUnmap;
  return m;
}
const sqlite3_io_methods kMethods = MakeMethods();

sqlite3_vfs* RealVfs(sqlite3_vfs* vfs) { return static_cast<sqlite3_vfs*>(vfs->pAppData); }

int Open(sqlite3_vfs* vfs, const char* name, sqlite3_file* f, int flags, int* out_flags) {
  f->pMethods = nullptr;
  const int code = RealVfs(vfs)->xOpen(RealVfs(vfs), name, Real(f), flags, out_flags);
  if (Real(f)->pMethods != nullptr) f->pMethods = &kMethods;
  return code;
}

sqlite3_vfs MakeVfs() {
  sqlite3_vfs* real = sqlite3_vfs_find(nullptr);
  sqlite3_vfs vfs = *real;  // its functions find what they need without the object
  vfs.szOsFile = static_cast<int>(sizeof(File)) + real->szOsFile;
  vfs.zName = "failing";
  vfs.pNext = nullptr;
  vfs.pAppData = real;
  vfs.xOpen = Open;
  vfs.xDelete = [](sqlite3_vfs* v, const char* name, int sync) {
    return RealVfs(v)->xDelete(RealVfs(v), name, sync);
  };
  vfs.xAccess = [](sqlite3_vfs* v, const char* name, int flags, int* result) {
    return RealVfs(v)->xAccess(RealVfs(v), name, flags, result);
  };
  vfs.xFullPathname = [](sqlite3_vfs* v, const char* name, int n, char* out) {
    return RealVfs(v)->xFullPathname(RealVfs(v), name, n, out);
  };
  return vfs;
}

}  // namespace

const char* FailingVfs::Name() {
  static sqlite3_vfs vfs = [] {
    sqlite3_initialize();
    return MakeVfs();
  }();
  static const int registered = sqlite3_vfs_register(&vfs, 0);
  return registered == SQLITE_OK ? vfs.zName : nullptr;
}

void FailingVfs::FailAt(int at, bool ever, int write_error) {
  const std::lock_guard lock(plan.mutex);
  plan.armed = true;
  plan.ever = ever;
  plan.left = at;
  plan.write_error = write_error;
  plan.failures = 0;
}

void FailingVfs::HoldSyncs() {
  const std::lock_guard lock(plan.mutex);
  plan.holds = true;
}

void FailingVfs::Heal() {
  const std::lock_guard lock(plan.mutex);
  plan.armed = plan.holds = false;
  plan.healed.notify_all();
}

int FailingVfs::held() {
  const std::lock_guard lock(plan.mutex);
  return plan.held;
}

int FailingVfs::failures() {
  const std::lock_guard lock(plan.mutex);
  return plan.failures;
}

}  // namespace dynmesh::server
