// A library to be loaded before others (LD_PRELOAD): while the file that DYNMESH_HANG_FILE names is
// there, each sync of a file hangs, as on a disk that does not answer.
#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>

namespace {

int SyncBy(const char* name, int file) {
  const char* const hang = std::getenv("DYNMESH_HANG_FILE");
  while (hang != nullptr && access(hang, F_OK) == 0) usleep(1'000);
  using Sync = int (*)(int);
  return reinterpret_cast<Sync>(dlsym(RTLD_NEXT, name))(file);
}

}  // namespace

extern "C" int fsync(int file) { return SyncBy("fsync", file); }
extern "C" int fdatasync(int file) { return SyncBy("fdatasync", file); }
